#include "server/sandbox/sandbox_landlock.h"

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
    RIGHT_REFER = 1 << 13,
    RIGHT_TRUNCATE = 1 << 14,
    RIGHT_BIND = 1 << 0,
    RIGHT_CONNECT = 1 << 1,
    RIGHT_FIRST = (1 << 13) - 1 /* all rights of Landlock 1 */
};

enum {
    RIGHT_READING = LANDLOCK_ACCESS_FS_READ_FILE | LANDLOCK_ACCESS_FS_READ_DIR,
    RIGHT_WRITING = RIGHT_READING | LANDLOCK_ACCESS_FS_WRITE_FILE | LANDLOCK_ACCESS_FS_REMOVE_FILE |
                    LANDLOCK_ACCESS_FS_REMOVE_DIR | LANDLOCK_ACCESS_FS_MAKE_REG |
                    LANDLOCK_ACCESS_FS_MAKE_DIR | RIGHT_REFER | RIGHT_TRUNCATE,
    /* the rights that apply to files */
    RIGHT_OF_FILE = LANDLOCK_ACCESS_FS_READ_FILE | LANDLOCK_ACCESS_FS_WRITE_FILE | RIGHT_TRUNCATE
};

/* struct landlock_ruleset_attr of Landlock 4 */
struct landlock_handled {
    uint64_t files, ports;
};

void srv_sandbox_add(struct srv_sandbox_files *files, enum srv_sandbox_use use, const char *path) {
    assert(files->count >= 0 && files->count <= SRV_SANDBOX_PLACES);
    if (files->count == SRV_SANDBOX_PLACES || !path[0] || strlen(path) >= SRV_SANDBOX_PATH) return;
    struct srv_sandbox_place *place = &files->place[files->count++];
    place->use = use;
    snprintf(place->path, sizeof place->path, "%s", path);
}

void srv_sandbox_add_around(struct srv_sandbox_files *files, enum srv_sandbox_use use,
                            const char *file) {
    char path[SRV_SANDBOX_PATH];
    const char *slash = strrchr(file, '/');
    size_t bytes = slash ? (size_t)(slash - file) : 0;
    if (!slash)
        srv_sandbox_add(files, use, ".");
    else if (!bytes)
        srv_sandbox_add(files, use, "/");
    else if (snprintf(path, sizeof path, "%.*s", (int)bytes, file) < SRV_SANDBOX_PATH)
        srv_sandbox_add(files, use, path);
}

/* allows access to a place; returns 0 if the kernel refuses, with errno set */
static int landlock_allow(int rules, const struct srv_sandbox_place *place, uint64_t known) {
    struct stat file;
    int fd = open(place->path, O_PATH | O_CLOEXEC);
    if (fd < 0) return 1;
    uint64_t rights = known & (place->use == SRV_SANDBOX_WRITE ? RIGHT_WRITING : RIGHT_READING);
    if (fstat(fd, &file) || !S_ISDIR(file.st_mode)) rights &= RIGHT_OF_FILE;
    struct landlock_path_beneath_attr below = {.allowed_access = rights, .parent_fd = fd};
    long failed = syscall(SYS_landlock_add_rule, rules, LANDLOCK_RULE_PATH_BENEATH, &below, 0);
    int reason = errno;
    close(fd);
    errno = reason;
    return !failed;
}

enum pend_status srv_sandbox_landlock(const struct srv_sandbox_files *files,
                                      struct pend_error *error) {
    long version = syscall(SYS_landlock_create_ruleset, NULL, 0, LANDLOCK_CREATE_RULESET_VERSION);
    if (version < 1)
        return pend_fail(error, PEND_INVALID, -1, 0, "the kernel has no Landlock: %s",
                         strerror(errno));
    struct landlock_handled handled = {.files = RIGHT_FIRST};
    if (version >= 2) handled.files |= RIGHT_REFER;
    if (version >= 3) handled.files |= RIGHT_TRUNCATE;
    if (version >= 4) handled.ports = files->connects ? RIGHT_BIND : RIGHT_BIND | RIGHT_CONNECT;
    size_t bytes = version >= 4 ? sizeof handled : sizeof handled.files;
    int rules = (int)syscall(SYS_landlock_create_ruleset, &handled, bytes, 0), good = rules >= 0;
    for (int i = 0; good && i < files->count; i++)
        good = landlock_allow(rules, &files->place[i], handled.files);
    if (good) good = !syscall(SYS_landlock_restrict_self, rules, 0);
    int reason = errno;
    if (rules >= 0) close(rules);
    if (good) return PEND_OK;
    return pend_fail(error, PEND_INVALID, -1, 0, "Landlock cannot be used: %s", strerror(reason));
}
