/* What libmicrohttpd reads and waits for goes through here: the front sees every byte first, and the workers get their
 * turn. Leaves to others: libmicrohttpd itself and what a connection is (http), the bytes (front), who goes first
 * (intake). Invariant: on a thread that has not said that it reads here, recv and epoll_wait are the C library's. */
#ifndef SRV_RECV_HOOK_H
#define SRV_RECV_HOOK_H

#include "server/protocol/http_strict.h"
#include "server/work/fairness.h"

/* A connection as its bytes come. */
struct srv_wire {
    struct srv_front front;
    void (*begins)(struct srv_wire *wire);  /* the first bytes of a request have come */
    void (*refuses)(struct srv_wire *wire); /* the front has refused the stream, and all before that was handed on */
};

/* All of them, by their sockets. */
struct srv_wires {
    struct srv_intake *intake;
    struct srv_wire **by_fd;
    int fds; /* room in by_fd */
};

void srv_wires_init(struct srv_wires *wires, struct srv_intake *intake);

void srv_wires_clear(struct srv_wires *wires);

/** From now on the calling thread reads through these. */
void srv_wires_here(struct srv_wires *wires);

/** Adds a connection; returns 0 without memory. */
int srv_wires_add(struct srv_wires *wires, int fd, struct srv_wire *wire);

void srv_wires_remove(struct srv_wires *wires, int fd);

#endif
