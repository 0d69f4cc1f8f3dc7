#include "server/http/connection.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include "server/base/clock.h"
#include "server/http/access_log.h"
#include "server/http/connection_share.h"
#include "server/http/request_head.h"
#include "server/http/response.h"
#include "server/http/router.h"
#include "server/jobs/events.h"
#include "server/work/compute.h"
#include "server/work/exchange.h"

enum {
    CONNECTION_UNREAD = 65536, /* largest body that is read just to keep the connection */
    CONNECTION_BYTES = 3 << 13 /* memory that libmicrohttpd uses per connection */
};

static_assert((int)SRV_STRICT_TARGET < (int)SRV_TARGET_BYTES,
              "a target that the front lets pass fits into an exchange");

enum connection_state {
    CONNECTION_NONE,    /* libmicrohttpd has not reported a request line */
    CONNECTION_HEAD,    /* the target is known */
    CONNECTION_BODY,    /* the head was checked; the body is being received */
    CONNECTION_WAITING, /* passed to a worker; the connection is suspended */
    CONNECTION_SENDING  /* libmicrohttpd sends the response */
};

struct connection {
    struct srv_exchange exchange; /* first: the exchange of a socket converts to its connection */
    struct srv_watched watched;
    struct srv_recv_hook hook;
    struct srv_connections *all;
    struct MHD_Connection *mhd;
    enum connection_state state;
    long done;                 /* the number of requests that have ended */
    enum srv_surplus surplus;  /* the limit that the connection exceeds */
    struct srv_client *client; /* client record of its address; NULL for a trusted proxy, or if
                                * memory is short */
    struct srv_hold hold;
    int refused; /* the request was refused after its head; its body is still read */
    int64_t body_began;
    struct srv_response_stream stream;
    int64_t paused, pauses; /* ns: start of the current pause, and total time of pauses, during
                             * which there was nothing to send */
};

/* Returns the seconds that a client has for a number of bytes. */
static double connection_patience(const struct connection *connection, double seconds,
                                  size_t bytes) {
    return seconds + (double)bytes / srv_service_config(connection->all->service)->least_rate;
}

static int64_t connection_deadline(double seconds) {
    return srv_clock_now() + srv_clock_span(seconds);
}

/* --- answers --- */

/* Sets the deadline for the next bytes of a stream to be received. Time in which the stream had
 * nothing to send does not count. */
static void connection_moved(struct srv_exchange *exchange, uint64_t bytes) {
    struct connection *connection = (struct connection *)exchange;
    struct srv_watch *watch = connection->all->watch;
    int64_t now = srv_clock_now();
    if (!bytes) {
        connection->paused = now;
        srv_watch_phase(watch, &connection->watched,
                        exchange->listens ? SRV_WATCH_LISTENING : SRV_WATCH_WAITING, 0);
        return;
    }
    exchange->bytes = bytes;
    if (connection->paused) connection->pauses += now - connection->paused;
    connection->paused = 0;
    double seconds =
        connection_patience(connection, srv_service_config(exchange->service)->send_seconds, bytes);
    srv_watch_phase(watch, &connection->watched, SRV_WATCH_STREAMING,
                    exchange->sending + connection->pauses + srv_clock_span(seconds));
}

static void connection_pause(struct srv_exchange *exchange) {
    MHD_suspend_connection(((struct connection *)exchange)->mhd);
}

static enum MHD_Result connection_answer(struct connection *connection) {
    struct srv_exchange *exchange = &connection->exchange;
    struct srv_service *service = connection->all->service;
    assert(connection->state != CONNECTION_SENDING && exchange->status);
    srv_exchange_settle(exchange);
    if (atomic_load(&service->draining)) exchange->close = 1;
    connection->stream = (struct srv_response_stream){
        .exchange = exchange, .moved = connection_moved, .pause = connection_pause};
    connection->paused = connection->pauses = 0;
    struct MHD_Response *response = srv_response_new(exchange, &connection->stream);
    if (!response) return MHD_NO;
    connection->state = CONNECTION_SENDING;
    exchange->sending = srv_clock_now();
    double seconds =
        connection_patience(connection, srv_service_config(service)->send_seconds, exchange->bytes);
    srv_watch_phase(connection->all->watch, &connection->watched,
                    exchange->streams ? SRV_WATCH_STREAMING : SRV_WATCH_SENDING,
                    exchange->sending + srv_clock_span(seconds));
    enum MHD_Result queued =
        MHD_queue_response(connection->mhd, (unsigned)exchange->status, response);
    MHD_destroy_response(response);
    return queued;
}

/* --- the way to a worker and back --- */

/* Resumes the connection of an exchange. The thread of the sockets may end both before this
 * returns. */
static void connection_finish(struct srv_exchange *exchange) {
    struct connection *connection = (struct connection *)exchange;
    int wake = connection->all->wake;
    MHD_resume_connection(connection->mhd);
    eventfd_write(wake, 1);
}

static void connection_leave(struct connection *connection, enum srv_stop why) {
    if (connection->exchange.listens)
        srv_events_leave(&connection->exchange, why);
    else
        srv_compute_leave(&connection->exchange, why);
}

static void connection_left(struct srv_watched *watched) {
    struct connection *connection = SRV_CONTAINER_OF(watched, struct connection, watched);
    connection_leave(connection, atomic_load(&connection->all->service->draining)
                                     ? SRV_STOP_SHUTDOWN
                                     : SRV_STOP_LEFT);
}

/* Passes the exchange to its route. A worker may answer it before this returns. */
static enum MHD_Result connection_hand_over(struct connection *connection) {
    assert(connection->state == CONNECTION_BODY && !connection->refused);
    connection->state = CONNECTION_WAITING;
    srv_watch_key(connection->all->watch, &connection->watched, connection->all->service->keys,
                  connection->exchange.identity.issued);
    MHD_suspend_connection(connection->mhd);
    srv_router_hand(&connection->exchange);
    srv_watch_phase(connection->all->watch, &connection->watched, SRV_WATCH_WAITING, 0);
    return MHD_YES;
}

/* --- the request --- */

static enum MHD_Result connection_field(void *context, enum MHD_ValueKind kind, const char *name,
                                        const char *value) {
    struct connection *connection = context;
    (void)kind;
    if (srv_request_head_relayed(name)) atomic_store(&connection->watched.relayed, 1);
    return srv_request_head_field(&connection->exchange, name, value ? value : "") ? MHD_YES
                                                                                   : MHD_NO;
}

/* Reads the head. Returns 1 if the exchange goes on, 0 if it is answered. */
static int connection_check_head(struct connection *connection, const char *method) {
    struct srv_exchange *exchange = &connection->exchange;
    exchange->method = method;
    MHD_get_connection_values(connection->mhd, MHD_HEADER_KIND, connection_field, exchange);
    srv_response_identify(exchange);
    exchange->coding = srv_coding_choose(exchange->field[SRV_ACCEPT_ENCODING]);
    if (!exchange->status && connection->surplus) {
        srv_connection_share_refuse(exchange, connection->surplus);
        exchange->close = 1;
    }
    return srv_router_head(exchange);
}

static void connection_body_deadline(struct connection *connection) {
    double seconds =
        connection_patience(connection, srv_service_config(connection->all->service)->body_seconds,
                            connection->exchange.body.bytes);
    srv_watch_phase(connection->all->watch, &connection->watched, SRV_WATCH_READING,
                    connection->body_began + srv_clock_span(seconds));
}

/* The first call of libmicrohttpd for a request: the head is complete. */
static enum MHD_Result connection_head(struct connection *connection, const char *method) {
    struct srv_exchange *exchange = &connection->exchange;
    connection->state = CONNECTION_BODY;
    connection->refused = !connection_check_head(connection, method);
    if (connection->refused) {
        /* Refusing here would close the connection. If the body is short, it is read first, so that
         * the connection stays open. */
        int keep = exchange->length >= 0 && exchange->length <= CONNECTION_UNREAD &&
                   !exchange->field[SRV_EXPECT];
        if (keep && !exchange->close) return MHD_YES;
        exchange->close = 1;
        return connection_answer(connection);
    }
    if (!exchange->length) return MHD_YES;
    connection->body_began = srv_clock_now();
    connection_body_deadline(connection);
    return MHD_YES;
}

static enum MHD_Result connection_body(struct connection *connection, const char *data,
                                       size_t bytes) {
    struct srv_exchange *exchange = &connection->exchange;
    if (connection->refused) return MHD_YES;
    enum pend_status status = api_buffer_add(&exchange->body, data, bytes);
    if (status == PEND_LIMIT)
        srv_exchange_problem(exchange, 413,
                             API_TYPE_LIMIT
                             "the body has more bytes than the limit max-body-bytes of %.0f",
                             srv_service_config(exchange->service)->limits.body_bytes);
    else if (status != PEND_OK)
        srv_exchange_busy(exchange, 1, "no memory is left for the body");
    else {
        enum srv_room room = srv_exchange_hold(exchange, exchange->body.cap);
        if (room != SRV_ROOM) srv_exchange_crowded(exchange, room, "the body");
    }
    if (exchange->status) {
        srv_response_refuse(&connection->exchange, connection->watched.fd);
        return MHD_NO;
    }
    connection_body_deadline(connection);
    return MHD_YES;
}

static enum MHD_Result connection_whole(struct connection *connection) {
    if (connection->refused || !srv_router_body(&connection->exchange))
        return connection_answer(connection);
    return connection_hand_over(connection);
}

enum MHD_Result srv_connection_request(void *context, struct MHD_Connection *mhd, const char *url,
                                       const char *method, const char *version, const char *data,
                                       size_t *bytes, void **state) {
    (void)context, (void)mhd, (void)url, (void)version;
    struct connection *connection = *state;
    if (!connection) return MHD_NO;
    assert(srv_exchange_valid(&connection->exchange));
    if (connection->state == CONNECTION_HEAD) return connection_head(connection, method);
    if (connection->state == CONNECTION_BODY && *bytes) {
        size_t got = *bytes;
        *bytes = 0;
        return connection_body(connection, data, got);
    }
    if (connection->state == CONNECTION_BODY) return connection_whole(connection);
    return connection->state == CONNECTION_WAITING ? connection_answer(connection) : MHD_NO;
}

/* Called when libmicrohttpd has read a request line; begins a request. */
void *srv_connection_target(void *context, const char *target, struct MHD_Connection *mhd) {
    const union MHD_ConnectionInfo *info =
        MHD_get_connection_info(mhd, MHD_CONNECTION_INFO_SOCKET_CONTEXT);
    struct connection *connection = info ? info->socket_context : NULL;
    struct srv_connections *all = context;
    if (!connection) return NULL;
    if (connection->hook.strict.requests <= connection->done) {
        srv_log_message(all->service->log,
                        "a request bypassed the parser: this libmicrohttpd does not call recv");
        return NULL;
    }
    size_t bytes = strnlen(target, SRV_TARGET_BYTES - 1);
    memcpy(connection->exchange.target, target, bytes);
    connection->exchange.target[bytes] = 0;
    connection->exchange.received = srv_clock_now();
    connection->state = CONNECTION_HEAD;
    connection->refused = 0;
    return connection;
}

/* --- the end of a request --- */

static const char *connection_outcome(const struct connection *connection,
                                      enum MHD_RequestTerminationCode code) {
    if (connection->exchange.stop == SRV_STOP_LEFT) return "left";
    if (connection->state == CONNECTION_SENDING && code == MHD_REQUEST_TERMINATED_COMPLETED_OK)
        return "answered";
    if (connection->state == CONNECTION_SENDING)
        return connection->stream.broken ? "broken" : "cut";
    if (atomic_load(&connection->watched.late)) return "late";
    return connection->exchange.status ? "refused" : "incomplete";
}

static void connection_log(const struct connection *connection, const char *outcome) {
    int told = connection->exchange.status, late = atomic_load(&connection->watched.late);
    srv_access_log_enter(&connection->exchange, outcome, told ? told : late ? 408 : 0);
}

/* Delays the close while the client sends: unread bytes would turn the response into a reset. */
static void connection_linger(struct connection *connection) {
    int fd = dup(connection->watched.fd);
    if (fd >= 0) srv_watch_linger(connection->all->watch, fd);
}

/* Ends the connection of a broken stream. An HTTP/1.0 client would take the end of the connection
 * for the end of the response, so it receives a reset. libmicrohttpd would end it too, but only
 * when something happens on another connection. */
static void connection_cut(struct connection *connection) {
    if (connection->hook.strict.old)
        connect(connection->watched.fd, &(struct sockaddr){.sa_family = AF_UNSPEC},
                sizeof(struct sockaddr));
    else
        shutdown(connection->watched.fd, SHUT_RDWR);
}

/* The strict reader has found a byte that no request may have, and all requests before it have
 * ended. From here on libmicrohttpd sees the end of the stream. */
static void connection_refuse_stream(struct connection *connection) {
    struct srv_exchange *exchange = &connection->exchange;
    if (!exchange->id) srv_response_identify(exchange);
    srv_exchange_problem(exchange, connection->hook.strict.status, "%s",
                         connection->hook.strict.detail);
    srv_response_refuse(&connection->exchange, connection->watched.fd);
    if (connection->state != CONNECTION_NONE) return;
    exchange->received = srv_clock_now();
    connection_log(connection, "refused");
    connection_linger(connection);
    srv_exchange_reset(exchange);
}

/* Called when a request has ended for any reason; releases its texts and its response. */
void srv_connection_completed(void *context, struct MHD_Connection *mhd, void **state,
                              enum MHD_RequestTerminationCode code) {
    struct srv_connections *all = context;
    struct connection *connection = *state;
    if (!connection) return;
    const char *outcome = connection_outcome(connection, code);
    /* The computation of a stream that was cut stops. The watch may be reporting the connection at
     * this instant; afterwards it does not. */
    if (connection->exchange.streams) {
        srv_watch_phase(all->watch, &connection->watched, SRV_WATCH_SENDING, 0);
        connection_leave(connection, SRV_STOP_LEFT);
    }
    connection_log(connection, outcome);
    if (connection->stream.broken)
        connection_cut(connection);
    else if (connection->exchange.close)
        connection_linger(connection);
    srv_exchange_reset(&connection->exchange);
    connection->state = CONNECTION_NONE;
    connection->done++;
    int more = connection->hook.strict.requests > connection->done;
    srv_watch_phase(all->watch, &connection->watched, more ? SRV_WATCH_READING : SRV_WATCH_IDLE,
                    more ? connection_deadline(srv_service_config(all->service)->header_seconds)
                         : 0);
    if (!connection->hook.strict.status || connection->hook.strict.complete != connection->done)
        return;
    connection_refuse_stream(connection);
    /* The connection has nothing to read, so only the timeout can close it. */
    MHD_set_connection_option(mhd, MHD_CONNECTION_OPTION_TIMEOUT, 1u);
}

/* --- bytes and events from the network --- */

static struct connection *connection_of_hook(struct srv_recv_hook *hook) {
    return SRV_CONTAINER_OF(hook, struct connection, hook);
}

static void connection_refuses(struct srv_recv_hook *hook) {
    connection_refuse_stream(connection_of_hook(hook));
}

static void connection_begins(struct srv_recv_hook *hook) {
    struct connection *connection = connection_of_hook(hook);
    if (connection->state == CONNECTION_NONE)
        srv_watch_phase(
            connection->all->watch, &connection->watched, SRV_WATCH_READING,
            connection_deadline(srv_service_config(connection->all->service)->header_seconds));
}

/* --- connections --- */

enum MHD_Result srv_connection_allow(void *context, const struct sockaddr *address,
                                     socklen_t bytes) {
    const struct srv_connections *all = context;
    struct srv_service *service = all->service;
    (void)bytes;
    if (all->probes || !srv_connection_share_passed(service, address)) return MHD_YES;
    srv_metrics_count(&service->metrics.refused_own_connections, 1);
    return MHD_NO;
}

/* Counts a new connection. If there are too many, an idle one is closed, or the exceeded limit is
 * recorded. */
static void connection_count(struct connection *connection, int connections) {
    struct srv_service *service = connection->all->service;
    connection->client = srv_connection_share_client(service, connection->exchange.peer);
    int own = connection->client ? 1 + atomic_fetch_add(&connection->client->connections, 1) : 0;
    connection->hold = (struct srv_hold){.service = service, .kind = SRV_MEMORY_CONNECTIONS};
    size_t bytes = sizeof *connection + CONNECTION_BYTES;
    if (connection->all->probes)
        connection->surplus = SRV_SURPLUS_NONE;
    else if (own > srv_connection_share(srv_service_config(service)))
        connection->surplus = SRV_SURPLUS_OWN;
    else if (connections > (int)srv_service_config(service)->connections &&
             !srv_watch_crowd_out(connection->all->watch))
        connection->surplus = SRV_SURPLUS_ALL;
    else if (srv_hold_try(&connection->hold, bytes) != SRV_ROOM)
        connection->surplus = SRV_SURPLUS_HELD;
    srv_hold_set(&connection->hold, bytes);
}

/* Returns the deadline, in ns, for the first request of a new connection: soon if it exceeds a
 * limit, after header-seconds if half of all connections are in use. */
static int64_t connection_begin_deadline(const struct connection *connection) {
    const struct srv_config *config = srv_service_config(connection->all->service);
    int crowded = 2 * atomic_load(&connection->all->service->connections) > config->connections;
    if (connection->surplus) return connection_deadline(1);
    return crowded && connection->watched.siblings ? connection_deadline(config->header_seconds)
                                                   : 0;
}

static void connection_begin(struct srv_connections *all, struct MHD_Connection *mhd,
                             void **socket) {
    /* The value is copied at once: from libmicrohttpd 1.0 on the next call overwrites it. */
    int fd = MHD_get_connection_info(mhd, MHD_CONNECTION_INFO_CONNECTION_FD)->connect_fd;
    int connections = 1 + atomic_fetch_add(&all->service->connections, 1);
    struct connection *connection = calloc(1, sizeof *connection);
    if (connection && !srv_recv_hooks_add(&all->hooks, fd, &connection->hook)) {
        free(connection);
        connection = NULL;
    }
    *socket = connection;
    if (!connection) return;
    srv_exchange_init(&connection->exchange, all->service);
    srv_http_strict_init(&connection->hook.strict);
    connection->exchange.probes = all->probes;
    connection->exchange.finish = connection_finish;
    const union MHD_ConnectionInfo *info =
        MHD_get_connection_info(mhd, MHD_CONNECTION_INFO_CLIENT_ADDRESS);
    srv_connection_share_peer(info ? info->client_addr : NULL, connection->exchange.peer);
    connection->all = all;
    connection->mhd = mhd;
    connection_count(connection, connections);
    connection->watched.fd = fd;
    connection->watched.left = connection_left;
    if (connection->client && !connection->all->probes)
        connection->watched.siblings = &connection->client->connections;
    atomic_store(&connection->watched.relayed,
                 srv_peer_trusted(srv_service_trusted(all->service), connection->exchange.peer));
    srv_watch_add(all->watch, &connection->watched, connection_begin_deadline(connection));
    connection->hook.begins = connection_begins;
    connection->hook.refuses = connection_refuses;
}

static void connection_end(struct srv_connections *all, void **socket) {
    struct connection *connection = *socket;
    atomic_fetch_sub(&all->service->connections, 1);
    *socket = NULL;
    if (!connection) return;
    /* The request was late before libmicrohttpd saw its first line. */
    if (atomic_load(&connection->watched.late) &&
        connection->hook.strict.requests > connection->done)
        connection_log(connection, "late");
    all->hooks.by_fd[connection->watched.fd] = NULL; /* before its socket is closed */
    srv_watch_remove(all->watch, &connection->watched);
    srv_exchange_clear(&connection->exchange);
    srv_hold_set(&connection->hold, 0);
    if (connection->client) {
        atomic_fetch_sub(&connection->client->connections, 1);
        srv_clients_give(all->service->clients, connection->client);
    }
    free(connection);
}

void srv_connection_notify(void *context, struct MHD_Connection *mhd, void **socket,
                           enum MHD_ConnectionNotificationCode code) {
    if (code == MHD_CONNECTION_NOTIFY_STARTED)
        connection_begin(context, mhd, socket);
    else
        connection_end(context, socket);
}
