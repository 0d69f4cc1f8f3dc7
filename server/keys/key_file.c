#include "server/keys/key_file.h"

#include <assert.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/file.h>
#include <unistd.h>

#include "server/sandbox/secret.h"

enum { KEY_FILE_PATH = 4096 };

enum pend_status srv_key_file_read(const char *path, struct srv_keys *keys, struct stat *seen,
                                   struct pend_error *error) {
    struct api_buffer text;
    struct pend_error why = {.text = ""};
    api_buffer_init(&text, SRV_KEYS_BYTES);
    enum pend_status status = srv_secret_read(path, &text, seen, error);
    if (status == PEND_OK) {
        status = srv_keys_read(keys, text.data ? text.data : "", text.bytes, &why);
        if (status != PEND_OK)
            status = pend_fail(error, status, -1, 0, "%.100s, %.130s", path, why.text);
    }
    api_buffer_clear(&text);
    return status;
}

static enum pend_status key_file_world(const char *what, const char *path,
                                       struct pend_error *error) {
    return pend_fail(error, PEND_INVALID, -1, 0, "%s %.150s: %s", what, path, strerror(errno));
}

/* Locks the directory of the file. Returns its descriptor, -1 with the error set. */
static int key_file_lock(const char *path, struct pend_error *error) {
    char directory[KEY_FILE_PATH];
    const char *slash = strrchr(path, '/');
    snprintf(directory, sizeof directory, "%.*s", slash ? (int)(slash - path) + 1 : 1,
             slash ? path : ".");
    int fd = open(directory, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (fd >= 0 && !flock(fd, LOCK_EX)) return fd;
    (void)key_file_world("the directory", directory, error);
    if (fd >= 0) close(fd);
    return -1;
}

static int key_file_fill(int fd, const struct api_buffer *text) {
    size_t done = 0;
    while (done < text->bytes) {
        ssize_t wrote = write(fd, text->data + done, text->bytes - done);
        if (wrote < 0 && errno == EINTR) continue;
        if (wrote <= 0) return 0;
        done += (size_t)wrote;
    }
    return !fsync(fd);
}

/* Gives the new file the owner of the old one. If root creates the first file, its owner becomes
 * that of the directory, so that the server can read it. */
static int key_file_give(int fd, const struct stat *old, int directory) {
    struct stat owner = *old;
    if (!old->st_nlink && geteuid()) return 1;
    if (!old->st_nlink && fstat(directory, &owner)) return 0;
    if (owner.st_uid == geteuid() && owner.st_gid == getegid()) return 1;
    return !fchown(fd, owner.st_uid, owner.st_gid) || owner.st_uid == geteuid();
}

/* true if the locked directory still has the file that was read (or still has none) */
static int key_file_same(const char *name, const struct stat *old, int directory) {
    struct stat now;
    int there = !fstatat(directory, name, &now, 0);
    if (!old->st_nlink) return !there;
    return there && now.st_dev == old->st_dev && now.st_ino == old->st_ino;
}

/* Replaces the file. old->st_nlink is 0 if there was no file. All operations use the descriptor of
 * the locked directory: otherwise the owner of a parent directory could swap it and make root write
 * files elsewhere. */
static enum pend_status key_file_replace(const char *path, const struct stat *old,
                                         const struct api_buffer *text, int directory,
                                         struct pend_error *error) {
    char fresh[KEY_FILE_PATH];
    const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path;
    if ((size_t)snprintf(fresh, sizeof fresh, "%s.new", name) >= sizeof fresh)
        return pend_fail(error, PEND_INVALID, -1, 0, "the path of the keys is too long");
    if (!key_file_same(name, old, directory))
        return pend_fail(error, PEND_INVALID, -1, 0, "%.150s was moved in the meantime", path);
    /* We hold the lock, so an existing temporary file was left by a process that died. */
    unlinkat(directory, fresh, 0);
    int fd = openat(directory, fresh, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0600);
    if (fd < 0) return key_file_world("cannot write", fresh, error);
    int good = !fchmod(fd, 0600) && key_file_give(fd, old, directory) && key_file_fill(fd, text);
    enum pend_status status = good ? PEND_OK : key_file_world("cannot write", fresh, error);
    close(fd);
    if (status == PEND_OK && renameat(directory, fresh, directory, name))
        status = key_file_world("cannot replace", path, error);
    if (status == PEND_OK)
        fsync(directory);
    else
        unlinkat(directory, fresh, 0);
    return status;
}

enum pend_status srv_key_file_change(const char *path, int make,
                                     enum pend_status (*change)(struct srv_keys *keys,
                                                                void *context,
                                                                struct pend_error *error),
                                     void *context, struct pend_error *error) {
    struct srv_keys keys;
    struct api_buffer text;
    struct stat old = {0};
    assert(path && change);
    int directory = key_file_lock(path, error);
    if (directory < 0) return PEND_INVALID;
    srv_keys_init(&keys);
    api_buffer_init(&text, SRV_KEYS_BYTES);
    enum pend_status status = PEND_OK;
    if (!make || !access(path, F_OK) || errno != ENOENT)
        status = srv_key_file_read(path, &keys, &old, error);
    if (status == PEND_OK) status = change(&keys, context, error);
    if (status == PEND_OK) {
        status = srv_keys_write(&keys, &text);
        if (status != PEND_OK)
            status = pend_fail(error, status, -1, 0, "out of memory for the keys");
    }
    if (status == PEND_OK) status = key_file_replace(path, &old, &text, directory, error);
    api_buffer_clear(&text);
    srv_keys_clear(&keys);
    close(directory);
    return status;
}
