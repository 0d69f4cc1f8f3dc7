/* What libmicrohttpd reads goes through here: the strict reader sees every byte first.
 * Leaves to others: libmicrohttpd itself and what a connection is (http), the bytes (http_strict).
 * Invariant: on a thread that has not said that it reads here, recv is the C library's. */
#ifndef SRV_RECV_HOOK_H
#define SRV_RECV_HOOK_H

#include "server/protocol/http_strict.h"

/* A connection as its bytes come. */
struct srv_recv_hook {
    struct srv_http_strict strict;
    void (*begins)(struct srv_recv_hook *hook);  /* the first bytes of a request have come */
    void (*refuses)(struct srv_recv_hook *hook); /* the strict reader has refused the stream, and
                                                    all before that was handed on */
};

/* All of them, by their sockets. */
struct srv_recv_hooks {
    struct srv_recv_hook **by_fd;
    int fds; /* room in by_fd */
};

void srv_recv_hooks_init(struct srv_recv_hooks *hooks);

void srv_recv_hooks_clear(struct srv_recv_hooks *hooks);

/** From now on the calling thread reads through these. */
void srv_recv_hooks_here(struct srv_recv_hooks *hooks);

/** Adds a connection; returns 0 without memory. */
int srv_recv_hooks_add(struct srv_recv_hooks *hooks, int fd, struct srv_recv_hook *hook);

void srv_recv_hooks_remove(struct srv_recv_hooks *hooks, int fd);

#endif
