#include "tests/harness/fence.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "tests/harness/server.h"
#include "tests/harness/test.h"

/* reads a file of the group; returns the number of bytes, -1 if it cannot be read */
static int fence_read(const char *path, const char *name, char text[], int cap) {
    char file[TEST_FENCE_PATH + 40];
    snprintf(file, sizeof file, "%s/%s", path, name);
    int fd = open(file, O_RDONLY | O_CLOEXEC);
    int got = fd < 0 ? -1 : (int)read(fd, text, (size_t)cap - 1);
    text[got > 0 ? got : 0] = 0;
    if (fd >= 0) close(fd);
    return got;
}

static int fence_write(const char *path, const char *name, const char *text) {
    char file[TEST_FENCE_PATH + 40];
    snprintf(file, sizeof file, "%s/%s", path, name);
    int fd = open(file, O_WRONLY | O_CLOEXEC),
        good = fd >= 0 && write(fd, text, strlen(text)) == (ssize_t)strlen(text);
    if (fd >= 0) close(fd);
    return good;
}

/* the mount point of cgroup v2, followed by the path of this program's group; returns the length of
 * the mount point, 0 if there is none */
static size_t fence_own(char path[TEST_FENCE_PATH]) {
    char line[1024], mount[256] = "", group[256] = "";
    FILE *mounts = fopen("/proc/self/mounts", "re");
    while (mounts && fgets(line, sizeof line, mounts))
        if (!mount[0] && strstr(line, " cgroup2 ")) sscanf(line, "%*s %255s", mount);
    if (mounts) fclose(mounts);
    FILE *groups = fopen("/proc/self/cgroup", "re");
    while (groups && fgets(line, sizeof line, groups)) sscanf(line, "0::%255s", group);
    if (groups) fclose(groups);
    if (!mount[0] || !group[0]) return 0;
    snprintf(path, TEST_FENCE_PATH, "%s%s", mount, strcmp(group, "/") ? group : "");
    return strlen(mount);
}

/* creates a group below `parent`; it works if the parent delegates memory */
static int fence_make(struct test_fence *fence, const char *parent, const char *most,
                      char reason[200]) {
    static int number;
    int bytes = snprintf(fence->path, sizeof fence->path, "%s/pendulumd-test-%d-%d", parent,
                         (int)getpid(), ++number);
    if (bytes < (int)sizeof fence->path && !mkdir(fence->path, 0755)) {
        if (fence_write(fence->path, "memory.max", most)) {
            /* without the file there is no swap */
            (void)fence_write(fence->path, "memory.swap.max", "0");
            return 1;
        }
        snprintf(reason, 200, "%.150s hands no memory on", parent);
        rmdir(fence->path);
    } else {
        snprintf(reason, 200, "%.120s: %s", parent, strerror(errno));
    }
    fence->path[0] = 0;
    return 0;
}

int test_fence_open(struct test_fence *fence, long long bytes, char reason[200]) {
    char parent[TEST_FENCE_PATH], most[32];
    size_t mount = fence_own(parent);
    fence->path[0] = 0;
    snprintf(reason, 200, "cgroup v2 is not mounted here");
    snprintf(most, sizeof most, "%lld", bytes);
    while (mount && strlen(parent) >= mount) {
        if (fence_make(fence, parent, most, reason)) return 1;
        *strrchr(parent, '/') = 0;
    }
    return 0;
}

int test_fence_enter(const struct test_fence *fence, int pid) {
    char number[16];
    snprintf(number, sizeof number, "%d", pid);
    return CHECK_SAYING(fence_write(fence->path, "cgroup.procs", number),
                        "process %d does not get into %s: %s", pid, fence->path, strerror(errno));
}

double test_fence_peak(const struct test_fence *fence) {
    char text[64];
    return fence_read(fence->path, "memory.peak", text, sizeof text) > 0 ? atof(text) : 0;
}

void test_fence_close(struct test_fence *fence) {
    char text[512];
    if (!fence->path[0]) return;
    int got = fence_read(fence->path, "memory.events", text, sizeof text);
    const char *killed = got > 0 ? strstr(text, "\noom_kill ") : NULL;
    CHECK_SAYING(!killed || !atoi(killed + 10), "the system has killed for want of memory: %s",
                 text);
    /* a process that has ended may still be leaving the group */
    int removed = 0;
    for (double end = test_clock() + TEST_PATIENCE; !removed && test_clock() < end;
         test_sleep(0.002))
        removed = !rmdir(fence->path);
    CHECK_SAYING(removed, "%s cannot be removed: %s", fence->path, strerror(errno));
    fence->path[0] = 0;
}
