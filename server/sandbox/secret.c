#include "server/sandbox/secret.h"

#include <assert.h>
#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <unistd.h>

enum { SECRET_PIECE = 4096 };

/* Checks that the open file can be read by this user only. Root, which reads all files, may use a
 * file of any owner: it makes keys for a server that runs as another user. */
static enum pend_status secret_private(const char *path, const struct stat *file,
                                       struct pend_error *error) {
    uid_t self = geteuid();
    if (!S_ISREG(file->st_mode))
        return pend_fail(error, PEND_INVALID, -1, 0, "%.150s is not a regular file", path);
    if (self && file->st_uid != self && file->st_uid != 0)
        return pend_fail(error, PEND_INVALID, -1, 0,
                         "%.150s belongs to another user: its owner must be this user or root",
                         path);
    int open = file->st_mode & 077, handed = !file->st_uid && self && !(file->st_mode & 037);
    if (open && !handed)
        return pend_fail(error, PEND_INVALID, -1, 0,
                         "%.150s has mode %04o, so others can read it: it must have 0600", path,
                         (unsigned)(file->st_mode & 07777));
    return PEND_OK;
}

static enum pend_status secret_take(int fd, const char *path, struct api_buffer *out,
                                    struct pend_error *error) {
    char piece[SECRET_PIECE];
    for (;;) {
        ssize_t got = read(fd, piece, sizeof piece);
        if (got < 0 && errno == EINTR) continue;
        if (got < 0)
            return pend_fail(error, PEND_INVALID, -1, 0, "%.150s: %s", path, strerror(errno));
        enum pend_status status = api_buffer_add(out, piece, (size_t)got);
        explicit_bzero(piece, sizeof piece);
        if (status == PEND_LIMIT)
            return pend_fail(error, PEND_INVALID, -1, 0, "%.150s is longer than %zu bytes", path,
                             out->limit);
        if (status != PEND_OK) return pend_fail(error, status, -1, 0, "out of memory");
        if (!got) return PEND_OK;
    }
}

enum pend_status srv_secret_read(const char *path, struct api_buffer *out, struct stat *seen,
                                 struct pend_error *error) {
    struct stat file;
    assert(path && out->limit);
    int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (fd < 0) return pend_fail(error, PEND_INVALID, -1, 0, "%.150s: %s", path, strerror(errno));
    enum pend_status status = fstat(fd, &file) ? pend_fail(error, PEND_INVALID, -1, 0, "%.150s: %s",
                                                           path, strerror(errno))
                                               : secret_private(path, &file, error);
    if (status == PEND_OK) status = secret_take(fd, path, out, error);
    close(fd);
    if (seen && status == PEND_OK) *seen = file;
    return status;
}
