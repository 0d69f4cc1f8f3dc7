/* The callbacks of libmicrohttpd: each request becomes an exchange, and each answered exchange a
 * response.
 * Leaves to others: listening and libmicrohttpd's options (http), the fields of a response
 * (response), reading from sockets (recv_hook).
 * Invariant: nothing here computes or waits; while a worker has an exchange its connection is
 * suspended, and the exchange is not used here. */
#pragma once

#include <microhttpd.h>

#include "server/work/service.h"
#include "server/http/watch.h"
#include "server/http/recv_hook.h"

/* State shared by all connections; each callback's first argument. */
struct srv_connections {
    struct srv_service *service;
    struct srv_watch *watch;
    struct srv_recv_hooks hooks;
    int probes; /* serves only probes and metrics, without limits */
    int wake;   /* an eventfd: readable when the thread of the sockets has something to do */
};

/** For MHD_start_daemon: decides whether to accept a connection. A client far above its share is
 * disconnected without an answer. */
enum MHD_Result srv_connection_allow(void *connections, const struct sockaddr *address,
                                     socklen_t bytes);

/** MHD_OPTION_NOTIFY_CONNECTION: a connection starts or has ended. */
void srv_connection_notify(void *connections, struct MHD_Connection *mhd, void **socket,
                           enum MHD_ConnectionNotificationCode code);

/** MHD_OPTION_URI_LOG_CALLBACK: a request starts. Returns the connection, NULL if the request is
 * not served. */
void *srv_connection_target(void *connections, const char *target, struct MHD_Connection *mhd);

/** The handler of MHD_start_daemon, called for a request's head, each piece of its body, its end,
 * and for the answer. */
enum MHD_Result srv_connection_request(void *connections, struct MHD_Connection *mhd,
                                       const char *url, const char *method, const char *version,
                                       const char *data, size_t *bytes, void **state);

/** MHD_OPTION_NOTIFY_COMPLETED: a request has ended, in any way. */
void srv_connection_completed(void *connections, struct MHD_Connection *mhd, void **state,
                              enum MHD_RequestTerminationCode code);
