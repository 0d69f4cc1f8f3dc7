/* The callbacks of libmicrohttpd for connections and requests: each request becomes an exchange,
 * and each answered exchange a response.
 * Leaves to others: listening and libmicrohttpd's options (http), the fields of a response
 * (response), reading from sockets (recv_hook).
 * Invariant: nothing here computes or waits; while a worker has an exchange its connection is
 * suspended, and the exchange is not used here. */
#ifndef SRV_CONNECTION_H
#define SRV_CONNECTION_H

#include <microhttpd.h>

#include "server/work/service.h"
#include "server/http/watch.h"
#include "server/http/recv_hook.h"

/* What all connections share; each callback's first argument. */
struct srv_connections {
    struct srv_service *service;
    struct srv_watch *watch;
    struct srv_recv_hooks hooks;
    int probes; /* only probes and metrics are answered here, without limits */
    int wake;   /* an eventfd: readable when the thread of the sockets is to look again */
};

/** Of MHD_start_daemon: whether a connection is accepted. A client that has far more than its share
 * is closed without an answer. */
enum MHD_Result srv_connection_allow(void *connections, const struct sockaddr *address,
                                     socklen_t bytes);

/** MHD_OPTION_NOTIFY_CONNECTION: a connection begins or has ended. */
void srv_connection_notify(void *connections, struct MHD_Connection *mhd, void **socket,
                           enum MHD_ConnectionNotificationCode code);

/** MHD_OPTION_URI_LOG_CALLBACK: a request begins. Returns the connection, NULL if the request is
 * not served. */
void *srv_connection_target(void *connections, const char *target, struct MHD_Connection *mhd);

/** What MHD_start_daemon calls for a request's head, each piece of its body, its end, and once
 * more with the answer. */
enum MHD_Result srv_connection_request(void *connections, struct MHD_Connection *mhd,
                                       const char *url, const char *method, const char *version,
                                       const char *data, size_t *bytes, void **state);

/** MHD_OPTION_NOTIFY_COMPLETED: a request has ended, in any way. */
void srv_connection_completed(void *connections, struct MHD_Connection *mhd, void **state,
                              enum MHD_RequestTerminationCode code);

#endif
