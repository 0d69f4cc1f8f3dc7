/* HTTP on sockets: requests become exchanges, answered exchanges become bytes. The only file that knows libmicrohttpd.
 * Leaves to others: the form of a request (front), its meaning (message, router), computing (compute), slow and absent
 * clients (watch).
 * Invariant: its one thread never computes and never waits for anything but sockets; an exchange that is with a worker
 * has its connection suspended. */
#ifndef SRV_HTTP_H
#define SRV_HTTP_H

#include "server/service.h"
#include "server/watch.h"

struct srv_http;

/**
 * Serves on a listening socket.
 *
 * service, watch  outlive it.
 * fd              from srv_listen_open; taken, also on failure.
 *
 * PEND_NO_MEMORY, PEND_INVALID  error says what could not be started.
 */
PEND_MUST_CHECK enum pend_status srv_http_new(struct srv_http **http, struct srv_service *service,
                                              struct srv_watch *watch, int fd, struct pend_error *error);

/** Stops listening, after taking in who has connected already. Later calls do nothing. */
void srv_http_quiesce(struct srv_http *http);

/** Closes every connection and ends the thread; no exchange may be with a worker any more. */
void srv_http_free(struct srv_http **http);

#endif
