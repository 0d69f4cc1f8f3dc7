#include "server/base/notify.h"

#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "tests/harness/test.h"

/* a supervisor's socket at a path, @ first for an abstract one */
static int notify_supervisor(const char *path) {
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    strcpy(address.sun_path, path);
    if (path[0] == '@') address.sun_path[0] = 0;
    int fd = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    int bad = bind(fd, (struct sockaddr *)&address,
                   (socklen_t)(offsetof(struct sockaddr_un, sun_path) + strlen(path)));
    CHECK(fd >= 0 && !bad);
    return fd;
}

TEST(a_supervisor_is_told_by_path_or_by_name) {
    char path[2][64], text[64];
    snprintf(path[0], sizeof path[0], "/tmp/pendulumd-notify-%d", (int)getpid());
    snprintf(path[1], sizeof path[1], "@pendulumd-notify-%d", (int)getpid());
    for (int i = 0; i < 2; i++) {
        int fd = notify_supervisor(path[i]);
        setenv("NOTIFY_SOCKET", path[i], 1);
        CHECK_INT(srv_notify("READY=1"), 1);
        ssize_t got = recvfrom(fd, text, sizeof text - 1, 0, NULL, NULL);
        text[got > 0 ? got : 0] = 0;
        CHECK_TEXT(text, "READY=1");
        close(fd);
        CHECK_INT(srv_notify("STOPPING=1"), 0);
    }
    unlink(path[0]);
    unsetenv("NOTIFY_SOCKET");
}

TEST(without_a_supervisor_nothing_is_told) {
    char large[300];
    memset(large, 'a', sizeof large - 1);
    large[0] = '/';
    large[sizeof large - 1] = 0;
    const char *const none[] = {"", "relative", "/nonexistent/socket", large};
    unsetenv("NOTIFY_SOCKET");
    CHECK_INT(srv_notify("READY=1"), 0);
    for (int i = 0; i < 4; i++) {
        setenv("NOTIFY_SOCKET", none[i], 1);
        CHECK_INT(srv_notify("READY=1"), 0);
    }
    unsetenv("NOTIFY_SOCKET");
}
