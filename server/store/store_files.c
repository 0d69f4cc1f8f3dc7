#include "server/store/store_files.h"

#include <assert.h>
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "api/call/digest.h"
#include "server/base/clock.h"

/* DROPPED: most files that a step of a sweep deletes; LOOKED: most folders that it examines;
 * ROUND_S: s between two rounds over all folders */
enum { FILES_DROPPED = 64, FILES_LOOKED = 64, FILES_ROUND_S = 3600 };

enum pend_status srv_files_check(const struct srv_files *files, struct pend_error *error) {
    const char *path = files->url + strlen("file://");
    struct stat found;
    if (!strncmp(files->url, "file:///", 8) && !strpbrk(path, " %?#\"\\") && !stat(path, &found) &&
        S_ISDIR(found.st_mode) && !access(path, W_OK | X_OK))
        return PEND_OK;
    return pend_fail(error, PEND_INVALID, -1, 0,
                     "--results must be none or file:///PATH, a folder that this user may write "
                     "to, without a space or any of %%?#\"\\ in its path; got %.100s",
                     files->url);
}

/* the result of a call, from errno if it failed; logs when the folder becomes unreachable. A file
 * that is missing because the folder is gone is not lost. */
static enum srv_stored files_result(struct srv_files *files, int failed) {
    int number = failed ? errno : 0, full = number == ENOSPC || number == EDQUOT;
    if (number == ENOENT && access(files->url + 7, X_OK)) number = ESTALE;
    int away = failed && !full && number != ENOENT;
    if (away != atomic_exchange(&files->away, away))
        srv_log_message(files->log, "the folder of --results: %s",
                        away ? strerror(number) : "it can be used again");
    return !failed ? SRV_STORED : full ? SRV_STORED_FULL : away ? SRV_STORED_AWAY : SRV_STORED_NONE;
}

void srv_files_link(const struct srv_files *files, const char *job, long part,
                    const struct api_raw_file *file, char link[SRV_FILES_LINK]) {
    /* an altered row of the store must not lead out of the folder */
    int used =
        snprintf(link, SRV_FILES_LINK, "%s/job=%.*s", files->url, (int)strcspn(job, "/"), job);
    assert(used < SRV_FILES_LINK - 64 && part >= 0);
    if (file) sprintf(link + used, "/part-%05ld-%.16s.parquet", part + 1, file->digest);
}

/* opens a file; a link is refused, and a pipe, which would block, is read as empty */
static int files_open(const char *path) {
    return open(path, O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
}

/* true if a file exists and has these bytes */
static int files_same(const char *path, const char *data, size_t bytes) {
    char piece[1 << 14];
    int fd = files_open(path);
    size_t at = 0;
    ssize_t got = -1;
    while (fd >= 0 && (got = read(fd, piece, sizeof piece)) > 0 && (size_t)got <= bytes - at &&
           !memcmp(piece, data + at, (size_t)got))
        at += (size_t)got;
    if (fd >= 0) close(fd);
    return !got && at == bytes;
}

/* makes the names in a folder durable */
static int files_sync(const char *folder) {
    int fd = open(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    int failed = fd < 0 || (fsync(fd) && errno != EINVAL), number = errno;
    if (fd >= 0) close(fd);
    errno = number;
    return failed;
}

/* writes a new file and gives it its name. A network file system may report a failure of a rename
 * that it has repeated, or refuse to replace a file: if the name exists, the file is complete. */
static int files_write(char *path, const char *data, size_t bytes) {
    char temporary[SRV_FILES_LINK + 8];
    snprintf(temporary, sizeof temporary, "%s.XXXXXX", path);
    int fd = mkostemp(temporary, O_CLOEXEC), failed = fd < 0;
    for (size_t at = 0; !failed && at < bytes;) {
        ssize_t wrote = write(fd, data + at, bytes - at);
        failed = wrote < 0 && errno != EINTR;
        at += wrote > 0 ? (size_t)wrote : 0;
    }
    failed = failed || fchmod(fd, 0640) || fsync(fd);
    if (fd >= 0) failed |= close(fd) != 0;
    if (!failed) failed = rename(temporary, path) && access(path, F_OK);
    int number = errno;
    if (fd >= 0) unlink(temporary);
    errno = number;
    return failed;
}

enum srv_stored srv_files_put(struct srv_files *files, const char *job, long part,
                              const struct api_raw_file *file, const void *data) {
    char link[SRV_FILES_LINK], folder[SRV_FILES_LINK];
    srv_files_link(files, job, 0, NULL, folder);
    srv_files_link(files, job, part, file, link);
    int failed = mkdir(folder + 7, 0750) && errno != EEXIST;
    /* a file of another attempt stays: its readers are not disturbed */
    failed = failed ||
             (!files_same(link + 7, data, file->bytes) && files_write(link + 7, data, file->bytes));
    failed = failed || files_sync(folder + 7) || files_sync(files->url + 7);
    enum srv_stored stored = files_result(files, failed);
    /* the job may have ended meanwhile, and nothing else would remove an empty folder */
    if (stored != SRV_STORED) rmdir(folder + 7);
    return stored == SRV_STORED_NONE ? SRV_STORED_AGAIN : stored;
}

/* reads a file of known length; SRV_STORED_DAMAGED if it has another length */
static enum srv_stored files_read(struct srv_files *files, const char *path, char *data,
                                  size_t bytes) {
    struct stat found = {0};
    int fd = files_open(path), failed = fd < 0 ? errno != ELOOP : fstat(fd, &found);
    int whole = fd >= 0 && !failed && S_ISREG(found.st_mode) && (size_t)found.st_size == bytes;
    ssize_t got = 1;
    for (size_t at = 0; whole && !failed && at < bytes && got; at += (size_t)got) {
        got = read(fd, data + at, bytes - at);
        failed = got < 0;
        whole = got > 0;
    }
    enum srv_stored stored = files_result(files, failed);
    if (fd >= 0) close(fd);
    return stored == SRV_STORED && !whole ? SRV_STORED_DAMAGED : stored;
}

enum srv_stored srv_files_get(struct srv_files *files, const char *job, long part,
                              const struct api_raw_file *file, struct api_buffer *out) {
    char link[SRV_FILES_LINK], digest[API_DIGEST_BYTES], *data = malloc(file->bytes + 1);
    if (!data) return SRV_STORED_BROKEN;
    srv_files_link(files, job, part, file, link);
    enum srv_stored stored = files_read(files, link + 7, data, file->bytes);
    if (stored == SRV_STORED) api_digest_bytes(digest, data, file->bytes);
    if (stored == SRV_STORED && strcmp(digest, file->digest) != 0) stored = SRV_STORED_DAMAGED;
    if (stored == SRV_STORED) {
        enum pend_status status = api_raw_from_parquet(data, file, out);
        if (status != PEND_OK) stored = status == PEND_BUG ? SRV_STORED_DAMAGED : SRV_STORED_BROKEN;
    }
    if (stored == SRV_STORED_NONE || stored == SRV_STORED_DAMAGED)
        srv_log_message(files->log, "%s is %s", link,
                        stored == SRV_STORED_NONE ? "lost" : "damaged");
    free(data);
    return stored;
}

/* deletes files of a folder up to the limit of this step; folders stay */
static int files_empty(DIR *opened, int *left) {
    struct dirent *entry;
    int failed = 0;
    while (!failed && *left && (entry = readdir(opened)))
        if (entry->d_name[0] != '.')
            failed = (*left)-- && unlinkat(dirfd(opened), entry->d_name, 0) && errno != ENOENT &&
                     errno != EISDIR;
    return failed;
}

enum srv_stored srv_files_drop(struct srv_files *files, const char *job) {
    char folder[SRV_FILES_LINK];
    int left = FILES_DROPPED;
    srv_files_link(files, job, 0, NULL, folder);
    DIR *opened = opendir(folder + 7);
    int failed = opened && files_empty(opened, &left), number = errno;
    if (opened) closedir(opened);
    errno = number;
    if (!failed && !left) return SRV_STORED_AGAIN;
    if (!failed) failed = rmdir(folder + 7);
    /* files of others, or files still open over a network, do not delay other jobs */
    if (failed && (errno == ENOTEMPTY || errno == EEXIST || errno == ENOTDIR)) failed = 0;
    enum srv_stored stored = files_result(files, failed);
    return stored == SRV_STORED_NONE ? SRV_STORED : stored;
}

int srv_files_old(struct srv_files *files, int64_t seconds, char job[SRV_ID_BYTES]) {
    static const char begin[] = "job=";
    int64_t now = srv_clock_now();
    struct dirent *entry = NULL;
    struct stat found;
    if (!files->walk && now < files->walk_ns) return 0;
    if (!files->walk) files->walk = opendir(files->url + 7);
    files->walk_ns = now + (int64_t)FILES_ROUND_S * 1000000000;
    for (int i = 0; files->walk && i < FILES_LOOKED && (entry = readdir(files->walk)); i++) {
        const char *id = entry->d_name + strlen(begin);
        if (strncmp(entry->d_name, begin, strlen(begin)) || strlen(id) != SRV_ID_BYTES - 1 ||
            fstatat(dirfd(files->walk), entry->d_name, &found, AT_SYMLINK_NOFOLLOW) ||
            found.st_mtime > time(NULL) - seconds)
            continue;
        memcpy(job, id, SRV_ID_BYTES);
        return 1;
    }
    if (files->walk && !entry) {
        closedir(files->walk);
        files->walk = NULL;
    }
    return 0;
}
