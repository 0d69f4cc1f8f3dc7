#include "server/sandbox/fence.h"

#include <assert.h>
#include <errno.h>
#include <fcntl.h>
#include <linux/landlock.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

/* Newer than the headers of Debian 12: Landlock 2, 3 and 4. */
enum {
    FENCE_REFER = 1 << 13,
    FENCE_TRUNCATE = 1 << 14,
    FENCE_BIND = 1 << 0,
    FENCE_CONNECT = 1 << 1,
    FENCE_FIRST = (1 << 13) - 1 /* all rights of Landlock 1 */
};

enum {
    FENCE_READING = LANDLOCK_ACCESS_FS_READ_FILE | LANDLOCK_ACCESS_FS_READ_DIR,
    FENCE_WRITING = FENCE_READING | LANDLOCK_ACCESS_FS_WRITE_FILE | LANDLOCK_ACCESS_FS_REMOVE_FILE |
                    LANDLOCK_ACCESS_FS_REMOVE_DIR | LANDLOCK_ACCESS_FS_MAKE_REG |
                    LANDLOCK_ACCESS_FS_MAKE_DIR | FENCE_REFER | FENCE_TRUNCATE,
    /* what means something for a file that is no directory */
    FENCE_OF_FILE = LANDLOCK_ACCESS_FS_READ_FILE | LANDLOCK_ACCESS_FS_WRITE_FILE | FENCE_TRUNCATE
};

/* struct landlock_ruleset_attr of Landlock 4 */
struct fence_handled {
    uint64_t files, ports;
};

void srv_fence_add(struct srv_fence *fence, enum srv_fence_use use, const char *path) {
    assert(fence->count >= 0 && fence->count <= SRV_FENCE_PLACES);
    if (fence->count == SRV_FENCE_PLACES || !path[0] || strlen(path) >= SRV_FENCE_PATH) return;
    struct srv_fence_place *place = &fence->place[fence->count++];
    place->use = use;
    snprintf(place->path, sizeof place->path, "%s", path);
}

void srv_fence_add_around(struct srv_fence *fence, enum srv_fence_use use, const char *file) {
    char path[SRV_FENCE_PATH];
    const char *slash = strrchr(file, '/');
    size_t bytes = slash ? (size_t)(slash - file) : 0;
    if (!slash)
        srv_fence_add(fence, use, ".");
    else if (!bytes)
        srv_fence_add(fence, use, "/");
    else if (snprintf(path, sizeof path, "%.*s", (int)bytes, file) < SRV_FENCE_PATH)
        srv_fence_add(fence, use, path);
}

/* opens a place in the fence; returns 0 where the kernel refuses, with errno set */
static int fence_allow(int rules, const struct srv_fence_place *place, uint64_t known) {
    struct stat file;
    int fd = open(place->path, O_PATH | O_CLOEXEC);
    if (fd < 0) return 1;
    uint64_t rights = known & (place->use == SRV_FENCE_WRITE ? FENCE_WRITING : FENCE_READING);
    if (fstat(fd, &file) || !S_ISDIR(file.st_mode)) rights &= FENCE_OF_FILE;
    struct landlock_path_beneath_attr below = {.allowed_access = rights, .parent_fd = fd};
    long failed = syscall(SYS_landlock_add_rule, rules, LANDLOCK_RULE_PATH_BENEATH, &below, 0);
    int reason = errno;
    close(fd);
    errno = reason;
    return !failed;
}

enum pend_status srv_fence_close(const struct srv_fence *fence, struct pend_error *error) {
    long version = syscall(SYS_landlock_create_ruleset, NULL, 0, LANDLOCK_CREATE_RULESET_VERSION);
    if (version < 1)
        return pend_fail(error, PEND_INVALID, -1, 0, "the kernel has no Landlock: %s",
                         strerror(errno));
    struct fence_handled handled = {.files = FENCE_FIRST};
    if (version >= 2) handled.files |= FENCE_REFER;
    if (version >= 3) handled.files |= FENCE_TRUNCATE;
    if (version >= 4) handled.ports = fence->connects ? FENCE_BIND : FENCE_BIND | FENCE_CONNECT;
    size_t bytes = version >= 4 ? sizeof handled : sizeof handled.files;
    int rules = (int)syscall(SYS_landlock_create_ruleset, &handled, bytes, 0), good = rules >= 0;
    for (int i = 0; good && i < fence->count; i++)
        good = fence_allow(rules, &fence->place[i], handled.files);
    if (good) good = !syscall(SYS_landlock_restrict_self, rules, 0);
    int reason = errno;
    if (rules >= 0) close(rules);
    if (good) return PEND_OK;
    return pend_fail(error, PEND_INVALID, -1, 0, "Landlock cannot be used: %s", strerror(reason));
}
