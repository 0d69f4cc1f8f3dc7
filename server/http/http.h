/* Serves HTTP on a listening socket by libmicrohttpd.
 * Leaves to others: connections and their requests (connection), slow and absent clients (watch).
 * Invariant: its one thread never computes, and waits for sockets only. */
#pragma once

#include "server/work/service.h"
#include "server/http/watch.h"

enum { SRV_HTTP_SETTLE_MS = 50 };

struct srv_http;

/**
 * Serves on a listening socket.
 *
 * service, watch  outlive it.
 * fd              from srv_listen_open; closed by this, also on failure.
 * probes          non-zero: serves only probes and metrics, to any client.
 *
 * PEND_NO_MEMORY, PEND_INVALID  error names what could not be started.
 */
PEND_MUST_CHECK enum pend_status srv_http_new(struct srv_http **http, struct srv_service *service,
                                              struct srv_watch *watch, int fd, int probes,
                                              struct pend_error *error);

/**
 * Stops listening, in steps; connections in the backlog are still accepted.
 *
 * Returns 1 once the socket is closed and every accepted connection is served: twice
 * SRV_HTTP_SETTLE_MS after the first call.
 */
int srv_http_quiesce(struct srv_http *http);

/** Closes every connection and ends the thread; no worker may have an exchange. */
void srv_http_free(struct srv_http **http);
