/* The recv that libmicrohttpd calls: the strict reader sees every byte before libmicrohttpd does.
 * Leaves to others: libmicrohttpd and connections (http), the bytes (http_strict).
 * Invariant: on a thread that has not called srv_recv_hooks_here, recv is the C library's. */
#pragma once

#include "server/protocol/http_strict.h"

/* One connection. */
struct srv_recv_hook {
    struct srv_http_strict strict;
    void (*begins)(struct srv_recv_hook *hook);  /* called at the first bytes of a request */
    void (*refuses)(struct srv_recv_hook *hook); /* called when the strict reader has refused the
                                                  * stream, after all earlier bytes were passed
                                                  * on */
};

/* All connections, by their sockets. */
struct srv_recv_hooks {
    struct srv_recv_hook **by_fd;
    int fds; /* capacity of by_fd */
};

/** Makes the calling thread read through these hooks. */
void srv_recv_hooks_here(struct srv_recv_hooks *hooks);

/** Adds a connection; returns 0 if memory is short. */
int srv_recv_hooks_add(struct srv_recv_hooks *hooks, int fd, struct srv_recv_hook *hook);
