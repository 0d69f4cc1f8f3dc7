#include "server/sandbox/spawn.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

enum { SPAWN_VARIABLES = 8, SPAWN_PATIENCE_S = 60 };

extern char **environ;

/* becomes the other program: nothing of this process' memory, environment and descriptors stays */
static _Noreturn void spawn_become(const char *what, int fd) {
    char name[] = "pendulumd", word[32];
    char *const words[] = {name, word, NULL};
    char *kept[SPAWN_VARIABLES + 1] = {NULL};
    int count = 0, nowhere = open("/dev/null", O_RDWR);
    snprintf(word, sizeof word, "%s", what);
    for (char **variable = environ; *variable && count < SPAWN_VARIABLES; variable++) {
        const char *value = strchr(*variable, '=');
        if (value && ((value - *variable > 12 && !strncmp(value - 12, "SAN_OPTIONS", 11)) ||
                      !strncmp(*variable, "LD_LIBRARY_PATH=", 16)))
            kept[count++] = *variable;
    }
    if (nowhere < 0 || dup2(nowhere, STDIN_FILENO) < 0 || dup2(nowhere, STDOUT_FILENO) < 0 ||
        dup2(fd, SRV_SPAWN_FD) < 0)
        _exit(1);
    if (fd == SRV_SPAWN_FD) fcntl(fd, F_SETFD, 0);
    close_range(SRV_SPAWN_FD + 1, ~0U, 0);
    execve("/proc/self/exe", words, kept);
    _exit(1);
}

int srv_spawn(const char *word, int *fd) {
    int ends[2];
    *fd = -1;
    if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends)) return -1;
    int pid = (int)fork(), reason = errno;
    if (!pid) spawn_become(word, ends[1]);
    close(ends[1]);
    if (pid < 0)
        close(ends[0]);
    else
        *fd = ends[0];
    errno = reason;
    return pid;
}

ssize_t srv_spawn_hear(int fd, struct msghdr *message) {
    struct pollfd ear = {.fd = fd, .events = POLLIN};
    int ready;
    while ((ready = poll(&ear, 1, 1000 * SPAWN_PATIENCE_S)) < 0 && errno == EINTR) continue;
    return ready > 0 ? recvmsg(fd, message, MSG_CMSG_CLOEXEC) : -1;
}

int srv_spawned(void) {
    int type = 0;
    socklen_t bytes = sizeof type;
    return !getsockopt(SRV_SPAWN_FD, SOL_SOCKET, SO_TYPE, &type, &bytes) && type == SOCK_SEQPACKET;
}
