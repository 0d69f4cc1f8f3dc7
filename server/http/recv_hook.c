#include "server/http/recv_hook.h"

#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/socket.h>

static _Thread_local struct srv_wires *wires_here;

void srv_wires_init(struct srv_wires *wires, struct srv_intake *intake) {
    *wires = (struct srv_wires){.intake = intake};
}

void srv_wires_clear(struct srv_wires *wires) {
    free(wires->by_fd);
    *wires = (struct srv_wires){0};
}

void srv_wires_here(struct srv_wires *wires) { wires_here = wires; }

int srv_wires_add(struct srv_wires *wires, int fd, struct srv_wire *wire) {
    if (fd >= wires->fds) {
        int fds = fd < 512 ? 1024 : 2 * fd;
        struct srv_wire **by_fd = realloc(wires->by_fd, (size_t)fds * sizeof *by_fd);
        if (!by_fd) return 0;
        memset(by_fd + wires->fds, 0, (size_t)(fds - wires->fds) * sizeof *by_fd);
        wires->by_fd = by_fd;
        wires->fds = fds;
    }
    wires->by_fd[fd] = wire;
    return 1;
}

void srv_wires_remove(struct srv_wires *wires, int fd) { wires->by_fd[fd] = NULL; }

static struct srv_wire *wires_find(int fd) {
    return wires_here && fd >= 0 && fd < wires_here->fds ? wires_here->by_fd[fd] : NULL;
}

/* shows the front what came; returns what libmicrohttpd may see of it */
static size_t wire_show(struct srv_wire *wire, char *data, size_t bytes) {
    struct srv_front *front = &wire->front;
    int within = srv_front_within(front);
    bytes = srv_front_read(front, data, bytes);
    if (front->status && !bytes) wire->refuses(wire);
    if (!within && srv_front_within(front)) wire->begins(wire);
    return bytes;
}

/* libmicrohttpd forgives what it should refuse, and does not show the bytes of a message. So its reading goes through
 * here: a recv in the program comes before the C library's for every shared library. That of a refused stream says that
 * the client has ended it. */
ssize_t wire_recv(int fd, void *data, size_t bytes, int flags) __asm__("recv");

ssize_t wire_recv(int fd, void *data, size_t bytes, int flags) {
    struct srv_wire *wire = wires_find(fd);
    if (wire && wire->front.status) return 0;
    size_t held = 0, asked, shown;
    ssize_t got;
    /* where the front took something out, the room is filled up: less than was asked for says that there is no more */
    do {
        asked = bytes - held;
        got = recvfrom(fd, (char *)data + held, asked, flags, NULL, NULL);
        if (!wire || got <= 0) return held ? (ssize_t)held : got;
        shown = wire_show(wire, (char *)data + held, (size_t)got);
        held += shown;
    } while (!wire->front.status && (!held || (shown < (size_t)got && (size_t)got == asked)));
    return (ssize_t)held;
}

/* libmicrohttpd (0.9.75 to 1.0.1) asks for 128 events, and when it gets as many it asks for more before it looks at any
 * of them, with the same timeout: it falls asleep over 128 requests until a 129th comes. So its waiting goes through
 * here too, and never gets as many as it asks for; what is left out comes the next time. */
int wire_epoll_wait(int fd, struct epoll_event *events, int most, int timeout) __asm__("epoll_wait");

int wire_epoll_wait(int fd, struct epoll_event *events, int most, int timeout) {
    if (wires_here && timeout) srv_intake_nap(wires_here->intake, fd);
    return epoll_pwait(fd, events, most > 1 ? most - 1 : most, timeout, NULL);
}
