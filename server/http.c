#include "server/http.h"

#include <assert.h>
#include <microhttpd.h>
#include <netdb.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "server/admission.h"
#include "server/clock.h"
#include "server/compute.h"
#include "server/events.h"
#include "server/exchange.h"
#include "server/ledger.h"
#include "server/listen.h"
#include "server/message.h"
#include "server/reply.h"
#include "server/router.h"
#include "server/wire.h"

enum {
    HTTP_POOL = 24576,  /* bytes of libmicrohttpd's memory a connection: holds what the front lets pass */
    HTTP_SPARE = 64,    /* connections beyond the cap that are told so */
    HTTP_UNREAD = 65536 /* largest body that is read only to keep the connection after a refusal */
};

_Static_assert((int)SRV_FRONT_TARGET < (int)SRV_TARGET_BYTES,
               "a target that the front lets pass fits into an exchange");

/* How far the exchange of a connection is. */
enum http_state {
    HTTP_NONE,    /* no request line yet, for all that libmicrohttpd says */
    HTTP_HEAD,    /* the target is known */
    HTTP_BODY,    /* the head is checked and the body is coming */
    HTTP_WAITING, /* handed over; the connection is suspended */
    HTTP_SENDING  /* the answer is libmicrohttpd's */
};

struct srv_http {
    struct srv_service *service;
    struct srv_watch *watch;
    struct MHD_Daemon *daemon;
    int fd;           /* that it listens on; -1 = no more */
    int64_t settling; /* since when nobody new is let in */
    struct srv_wires wires;
};

/* A connection and its one exchange at a time. */
struct http_connection {
    struct srv_exchange exchange; /* first: an exchange of http is its connection */
    struct srv_watched watched;
    struct srv_wire wire;
    struct srv_http *http;
    struct MHD_Connection *mhd;
    enum http_state state;
    long done;   /* requests that are over */
    int surplus; /* beyond the cap of connections */
    int refused; /* answered at the head, while the body is still read */
    int64_t body_began;
    struct srv_reply_stream stream;
    int64_t paused, pauses; /* ns: since when a stream has nothing to send, how long it had nothing before */
};

static struct http_connection *http_of_watched(struct srv_watched *watched) {
    return (struct http_connection *)((char *)watched - offsetof(struct http_connection, watched));
}

/* the seconds that a client has for so many bytes */
static double http_patience(const struct http_connection *connection, double seconds, size_t bytes) {
    return seconds + (double)bytes / connection->http->service->config.least_rate;
}

static int64_t http_deadline(double seconds) { return srv_clock_now() + srv_clock_span(seconds); }

/* --- answers --- */

/* how long the client has for what it got of a stream, not counting the time that it had to wait for more */
static void http_moved(struct srv_exchange *exchange, uint64_t bytes) {
    struct http_connection *connection = (struct http_connection *)exchange;
    struct srv_watch *watch = connection->http->watch;
    int64_t now = srv_clock_now();
    if (!bytes) {
        connection->paused = now;
        srv_watch_phase(watch, &connection->watched, exchange->listens ? SRV_WATCH_LISTENING : SRV_WATCH_WAITING, 0);
        return;
    }
    exchange->bytes = bytes;
    if (connection->paused) connection->pauses += now - connection->paused;
    connection->paused = 0;
    double seconds = http_patience(connection, exchange->service->config.send_seconds, bytes);
    srv_watch_phase(watch, &connection->watched, SRV_WATCH_STREAMING,
                    exchange->sending + connection->pauses + srv_clock_span(seconds));
}

static void http_pause(struct srv_exchange *exchange) {
    MHD_suspend_connection(((struct http_connection *)exchange)->mhd);
}

/* gives the answer to libmicrohttpd */
static enum MHD_Result http_answer(struct http_connection *connection) {
    struct srv_exchange *exchange = &connection->exchange;
    struct srv_service *service = connection->http->service;
    if (atomic_load(&service->draining)) exchange->close = 1;
    connection->stream = (struct srv_reply_stream){.exchange = exchange, .moved = http_moved, .pause = http_pause};
    connection->paused = connection->pauses = 0;
    struct MHD_Response *response = srv_reply_new(exchange, &connection->stream);
    if (!response) return MHD_NO;
    connection->state = HTTP_SENDING;
    exchange->sending = srv_clock_now();
    double seconds = http_patience(connection, service->config.send_seconds, exchange->bytes);
    srv_watch_phase(connection->http->watch, &connection->watched,
                    exchange->streams ? SRV_WATCH_STREAMING : SRV_WATCH_SENDING,
                    exchange->sending + srv_clock_span(seconds));
    enum MHD_Result queued = MHD_queue_response(connection->mhd, (unsigned)exchange->status, response);
    MHD_destroy_response(response);
    return queued;
}

/* --- the way to a worker and back --- */

static void http_finish(struct srv_exchange *exchange) {
    MHD_resume_connection(((struct http_connection *)exchange)->mhd);
}

/* whoever works on an exchange's answer need not go on */
static void http_leave(struct http_connection *connection, enum srv_stop why) {
    if (connection->exchange.listens)
        srv_events_leave(&connection->exchange, why);
    else
        srv_compute_leave(&connection->exchange, why);
}

static void http_left(struct srv_watched *watched) {
    struct http_connection *connection = http_of_watched(watched);
    http_leave(connection, atomic_load(&connection->http->service->draining) ? SRV_STOP_SHUTDOWN : SRV_STOP_LEFT);
}

/* it may be answered, and the connection resumed, before this returns: that takes effect after it */
static enum MHD_Result http_hand_over(struct http_connection *connection) {
    connection->state = HTTP_WAITING;
    MHD_suspend_connection(connection->mhd);
    srv_router_hand(&connection->exchange);
    srv_watch_phase(connection->http->watch, &connection->watched, SRV_WATCH_WAITING, 0);
    return MHD_YES;
}

/* --- the request --- */

static enum MHD_Result http_field(void *context, enum MHD_ValueKind kind, const char *name, const char *value) {
    (void)kind;
    return srv_message_field(context, name, value ? value : "") ? MHD_YES : MHD_NO;
}

/* reads the head; returns 1 when the exchange is to go on, 0 when it is answered */
static int http_check_head(struct http_connection *connection, const char *method) {
    struct srv_exchange *exchange = &connection->exchange;
    exchange->method = method;
    MHD_get_connection_values(connection->mhd, MHD_HEADER_KIND, http_field, exchange);
    srv_reply_identify(exchange);
    srv_admission_client(exchange);
    exchange->coding = srv_coding_choose(exchange->field[SRV_ACCEPT_ENCODING]);
    if (exchange->status) return 0;
    if (!connection->surplus) return srv_message_head(exchange) && srv_router_find(exchange);
    srv_metrics_count(&exchange->service->metrics.refused_connections, 1);
    srv_exchange_busy(exchange, 1, "too many connections are open: max-connections");
    exchange->close = 1;
    return 0;
}

/* until when the body must be there, seeing what came of it */
static void http_body_deadline(struct http_connection *connection) {
    double seconds =
        http_patience(connection, connection->http->service->config.body_seconds, connection->exchange.body.bytes);
    srv_watch_phase(connection->http->watch, &connection->watched, SRV_WATCH_READING,
                    connection->body_began + srv_clock_span(seconds));
}

/* the first call of libmicrohttpd for a request: its head is there */
static enum MHD_Result http_head(struct http_connection *connection, const char *method) {
    struct srv_exchange *exchange = &connection->exchange;
    connection->state = HTTP_BODY;
    connection->refused = !http_check_head(connection, method);
    if (connection->refused) {
        /* an answer at this point ends the connection; where nothing speaks for that, the body is read first */
        int keep = exchange->length >= 0 && exchange->length <= HTTP_UNREAD && !exchange->field[SRV_EXPECT];
        if (keep && !exchange->close) return MHD_YES;
        exchange->close = 1;
        return http_answer(connection);
    }
    if (!exchange->length) return MHD_YES;
    connection->body_began = srv_clock_now();
    http_body_deadline(connection);
    return MHD_YES;
}

/* a piece of the body */
static enum MHD_Result http_body(struct http_connection *connection, const char *data, size_t bytes) {
    struct srv_exchange *exchange = &connection->exchange;
    if (connection->refused) return MHD_YES;
    enum pend_status status = api_buffer_add(&exchange->body, data, bytes);
    if (status == PEND_LIMIT)
        srv_exchange_problem(exchange, 413, "the body has more bytes than the limit max-body-bytes of %.0f",
                             exchange->service->config.limits.body_bytes);
    else if (status != PEND_OK || !srv_exchange_hold(exchange, exchange->body.bytes)) {
        srv_metrics_count(&exchange->service->metrics.refused_held, 1);
        srv_exchange_busy(exchange, 1, "there is no memory left for the body: max-held-bytes");
    }
    if (exchange->status) {
        srv_reply_refuse(&connection->exchange, connection->watched.fd);
        return MHD_NO;
    }
    http_body_deadline(connection);
    return MHD_YES;
}

/* the request is complete */
static enum MHD_Result http_whole(struct http_connection *connection) {
    if (connection->refused || srv_router_begin(&connection->exchange)) return http_answer(connection);
    return http_hand_over(connection);
}

static enum MHD_Result http_request(void *context, struct MHD_Connection *mhd, const char *url, const char *method,
                                    const char *version, const char *data, size_t *bytes, void **state) {
    (void)context, (void)mhd, (void)url, (void)version;
    struct http_connection *connection = *state;
    if (!connection) return MHD_NO;
    assert(srv_exchange_valid(&connection->exchange));
    if (connection->state == HTTP_HEAD) return http_head(connection, method);
    if (connection->state == HTTP_BODY && *bytes) {
        size_t got = *bytes;
        *bytes = 0;
        return http_body(connection, data, got);
    }
    if (connection->state == HTTP_BODY) return http_whole(connection);
    return connection->state == HTTP_WAITING ? http_answer(connection) : MHD_NO;
}

/* the request line is there: a request begins */
static void *http_target(void *context, const char *target, struct MHD_Connection *mhd) {
    const union MHD_ConnectionInfo *info = MHD_get_connection_info(mhd, MHD_CONNECTION_INFO_SOCKET_CONTEXT);
    struct http_connection *connection = info ? info->socket_context : NULL;
    struct srv_http *http = context;
    if (!connection) return NULL;
    if (connection->wire.front.requests <= connection->done) {
        srv_log_message(http->service->log, "a request came past the front: this libmicrohttpd does not call recv");
        return NULL;
    }
    size_t bytes = strnlen(target, SRV_TARGET_BYTES - 1);
    memcpy(connection->exchange.target, target, bytes);
    connection->exchange.target[bytes] = 0;
    connection->exchange.received = srv_clock_now();
    connection->state = HTTP_HEAD;
    connection->refused = 0;
    return connection;
}

/* --- the end of a request --- */

static const char *http_outcome(const struct http_connection *connection, enum MHD_RequestTerminationCode code) {
    const struct srv_exchange *exchange = &connection->exchange;
    int left = exchange->stop == SRV_STOP_LEFT;
    if (left) return "left";
    if (connection->state == HTTP_SENDING && code == MHD_REQUEST_TERMINATED_COMPLETED_OK) return "answered";
    if (connection->state == HTTP_SENDING) return connection->stream.broken ? "broken" : "cut";
    if (atomic_load(&connection->watched.late)) return "late";
    return exchange->status ? "refused" : "incomplete";
}

static void http_log(const struct http_connection *connection, const char *outcome) {
    const struct srv_exchange *exchange = &connection->exchange;
    int late = atomic_load(&connection->watched.late);
    srv_ledger_enter(exchange, outcome, exchange->status ? exchange->status : late ? 408 : 0);
}

/* the client may still be sending: its unread bytes must not turn the answer into a reset */
static void http_linger(struct http_connection *connection) {
    int fd = dup(connection->watched.fd);
    if (fd >= 0) srv_watch_linger(connection->http->watch, fd);
}

/* Ends the connection under a broken stream. An HTTP/1.0 client would take its end for the end of the answer, and gets
 * a reset. libmicrohttpd would do it too, but only when something happens on another connection. */
static void http_cut(struct http_connection *connection) {
    if (connection->wire.front.old)
        connect(connection->watched.fd, &(struct sockaddr){.sa_family = AF_UNSPEC}, sizeof(struct sockaddr));
    else
        shutdown(connection->watched.fd, SHUT_RDWR);
}

/* The front has found a byte that no request may have, and all requests before it are over. From now on libmicrohttpd
 * sees the end of the stream. */
static void http_refuse_stream(struct http_connection *connection) {
    struct srv_exchange *exchange = &connection->exchange;
    if (!exchange->id) srv_reply_identify(exchange);
    srv_exchange_problem(exchange, connection->wire.front.status, "%s", connection->wire.front.detail);
    srv_reply_refuse(&connection->exchange, connection->watched.fd);
    if (connection->state != HTTP_NONE) return;
    exchange->received = srv_clock_now();
    http_log(connection, "refused");
    http_linger(connection);
    srv_exchange_reset(exchange);
}

/* a request is over, in whatever way; its texts and its answer are not needed any more */
static void http_completed(void *context, struct MHD_Connection *mhd, void **state,
                           enum MHD_RequestTerminationCode code) {
    struct srv_http *http = context;
    struct http_connection *connection = *state;
    if (!connection) return;
    const char *outcome = http_outcome(connection, code);
    /* a stream that was cut is not computed on */
    if (connection->exchange.streams) http_leave(connection, SRV_STOP_LEFT);
    http_log(connection, outcome);
    if (connection->stream.broken)
        http_cut(connection);
    else if (connection->exchange.close)
        http_linger(connection);
    srv_exchange_reset(&connection->exchange);
    connection->state = HTTP_NONE;
    connection->done++;
    int more = connection->wire.front.requests > connection->done;
    srv_watch_phase(http->watch, &connection->watched, more ? SRV_WATCH_READING : SRV_WATCH_IDLE,
                    more ? http_deadline(http->service->config.header_seconds) : 0);
    if (!connection->wire.front.status || connection->wire.front.complete != connection->done) return;
    http_refuse_stream(connection);
    /* it has nothing to read, and so nothing that would end it but time */
    MHD_set_connection_option(mhd, MHD_CONNECTION_OPTION_TIMEOUT, 1u);
}

/* --- what the wire tells --- */

static struct http_connection *http_of_wire(struct srv_wire *wire) {
    return (struct http_connection *)((char *)wire - offsetof(struct http_connection, wire));
}

static void http_refuses(struct srv_wire *wire) { http_refuse_stream(http_of_wire(wire)); }

static void http_begins(struct srv_wire *wire) {
    struct http_connection *connection = http_of_wire(wire);
    if (connection->state == HTTP_NONE)
        srv_watch_phase(connection->http->watch, &connection->watched, SRV_WATCH_READING,
                        http_deadline(connection->http->service->config.header_seconds));
}

/* --- connections --- */

static void http_peer(struct MHD_Connection *mhd, char peer[SRV_PEER_BYTES]) {
    const union MHD_ConnectionInfo *info = MHD_get_connection_info(mhd, MHD_CONNECTION_INFO_CLIENT_ADDRESS);
    const struct sockaddr *address = info ? info->client_addr : NULL;
    char text[64] = "";
    socklen_t bytes = address && address->sa_family == AF_INET6 ? 28 : 16;
    if (address) getnameinfo(address, bytes, text, sizeof text, NULL, 0, NI_NUMERICHOST);
    snprintf(peer, SRV_PEER_BYTES, "%.*s", SRV_PEER_BYTES - 1, strncmp(text, "::ffff:", 7) ? text : text + 7);
}

static void http_connect(struct srv_http *http, struct MHD_Connection *mhd, void **socket) {
    /* read at once: from 1.0 on the next question overwrites the answer */
    int fd = MHD_get_connection_info(mhd, MHD_CONNECTION_INFO_CONNECTION_FD)->connect_fd;
    srv_wires_here(&http->wires);
    int connections = 1 + atomic_fetch_add(&http->service->connections, 1);
    struct http_connection *connection = calloc(1, sizeof *connection);
    if (connection && !srv_wires_add(&http->wires, fd, &connection->wire)) {
        free(connection);
        connection = NULL;
    }
    *socket = connection;
    if (!connection) return;
    srv_exchange_init(&connection->exchange, http->service);
    srv_front_init(&connection->wire.front);
    connection->exchange.finish = http_finish;
    http_peer(mhd, connection->exchange.peer);
    connection->http = http;
    connection->mhd = mhd;
    connection->surplus = connections > (int)http->service->config.connections;
    connection->watched.fd = fd;
    connection->watched.left = http_left;
    srv_watch_add(http->watch, &connection->watched, connection->surplus ? http_deadline(1) : 0);
    connection->wire.begins = http_begins;
    connection->wire.refuses = http_refuses;
}

static void http_disconnect(struct srv_http *http, void **socket) {
    struct http_connection *connection = *socket;
    atomic_fetch_sub(&http->service->connections, 1);
    *socket = NULL;
    if (!connection) return;
    /* a request that was late before libmicrohttpd saw its first line */
    if (atomic_load(&connection->watched.late) && connection->wire.front.requests > connection->done)
        http_log(connection, "late");
    srv_wires_remove(&http->wires, connection->watched.fd);
    srv_watch_remove(http->watch, &connection->watched);
    srv_exchange_clear(&connection->exchange);
    free(connection);
}

static void http_connection(void *context, struct MHD_Connection *mhd, void **socket,
                            enum MHD_ConnectionNotificationCode code) {
    if (code == MHD_CONNECTION_NOTIFY_STARTED)
        http_connect(context, mhd, socket);
    else
        http_disconnect(context, socket);
}

/* paths are decoded by message, strictly */
static size_t http_unescape(void *context, struct MHD_Connection *mhd, char *text) {
    (void)context, (void)mhd;
    return strlen(text);
}

/* --- start and end --- */

enum pend_status srv_http_new(struct srv_http **http, struct srv_service *service, struct srv_watch *watch, int fd,
                              struct pend_error *error) {
    const struct srv_config *config = &service->config;
    struct srv_http *made = *http = calloc(1, sizeof *made);
    if (!made) {
        close(fd);
        return pend_fail(error, PEND_NO_MEMORY, -1, 0, "out of memory");
    }
    *made = (struct srv_http){.service = service, .watch = watch, .fd = fd};
    srv_wires_init(&made->wires, &service->intake);
    struct MHD_OptionItem options[] = {
        {MHD_OPTION_LISTEN_SOCKET, fd, NULL},
        {MHD_OPTION_CONNECTION_LIMIT, (intptr_t)config->connections + HTTP_SPARE, NULL},
        {MHD_OPTION_CONNECTION_TIMEOUT, (intptr_t)config->idle_seconds, NULL},
        {MHD_OPTION_CONNECTION_MEMORY_LIMIT, HTTP_POOL, NULL},
        {MHD_OPTION_NOTIFY_COMPLETED, (intptr_t)http_completed, made},
        {MHD_OPTION_NOTIFY_CONNECTION, (intptr_t)http_connection, made},
        {MHD_OPTION_URI_LOG_CALLBACK, (intptr_t)http_target, made},
        {MHD_OPTION_UNESCAPE_CALLBACK, (intptr_t)http_unescape, made},
        {MHD_OPTION_SIGPIPE_HANDLED_BY_APP, 1, NULL},
        {MHD_OPTION_END, 0, NULL},
    };
    unsigned flags = MHD_USE_EPOLL_INTERNAL_THREAD | MHD_ALLOW_SUSPEND_RESUME | MHD_USE_ITC | MHD_USE_TURBO;
    made->daemon =
        MHD_start_daemon(flags, 0, NULL, NULL, http_request, made, MHD_OPTION_ARRAY, options, MHD_OPTION_END);
    if (made->daemon) return PEND_OK;
    close(fd);
    free(made);
    *http = NULL;
    return pend_fail(error, PEND_NO_MEMORY, -1, 0, "libmicrohttpd does not start");
}

/* takes in who has connected already, and listens no more */
static void http_close(struct srv_http *http) {
    struct sockaddr_storage address;
    socklen_t bytes = sizeof address;
    MHD_quiesce_daemon(http->daemon);
    for (int fd; (fd = accept4(http->fd, (struct sockaddr *)&address, &bytes, SOCK_CLOEXEC | SOCK_NONBLOCK)) >= 0;) {
        MHD_add_connection(http->daemon, fd, (struct sockaddr *)&address, bytes);
        bytes = sizeof address;
    }
    close(http->fd);
    http->fd = -1;
}

int srv_http_quiesce(struct srv_http *http) {
    int64_t now = srv_clock_now();
    if (http->fd < 0) return 1;
    if (!http->settling) {
        srv_listen_settle(http->fd);
        http->settling = now;
    }
    if (now - http->settling < (int64_t)SRV_HTTP_SETTLE_MS * 1000000) return 0;
    http_close(http);
    return 1;
}

void srv_http_free(struct srv_http **http) {
    struct srv_http *gone = *http;
    *http = NULL;
    if (!gone) return;
    if (gone->fd >= 0) http_close(gone);
    MHD_stop_daemon(gone->daemon);
    srv_wires_clear(&gone->wires);
    free(gone);
}
