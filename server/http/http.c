#include "server/http/http.h"

#include <microhttpd.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include "server/base/clock.h"
#include "server/config/listen.h"
#include "server/http/connection.h"

enum {
    HTTP_POOL = 24576,    /* libmicrohttpd's memory for a connection in bytes: enough for every head
                           * that the strict reader accepts */
    HTTP_WAIT_MS = 60000, /* longest wait in ms: a safety net, since every event wakes the thread */
    HTTP_SPARE = 64       /* connections above the limit that get an answer */
};

struct srv_http {
    struct srv_connections all;
    struct MHD_Daemon *daemon;
    pthread_t thread;
    int events; /* an epoll descriptor: readable while libmicrohttpd has work or `wake` is set */
    int fd;     /* the listening socket; it belongs to the thread once `listen` is 0 */
    atomic_int
        listen; /* 1 = listening, 0 = the thread should stop listening, -1 = it has stopped */
    atomic_int end;
    int64_t settling; /* ns: when accepting stopped; later, when listening stopped */
};

/* The strict reader decodes paths, so libmicrohttpd must not. */
static size_t http_unescape(void *context, struct MHD_Connection *mhd, char *text) {
    (void)context, (void)mhd;
    return strlen(text);
}

/* Accepts the connections whose handshake is complete, and stops listening. */

/* Accepts the connections that are complete already, and stops listening. */
static void http_close(struct srv_http *http) {
    struct sockaddr_storage address;
    socklen_t bytes = sizeof address;
    MHD_quiesce_daemon(http->daemon);
    for (int fd; (fd = accept4(http->fd, (struct sockaddr *)&address, &bytes,
                               SOCK_CLOEXEC | SOCK_NONBLOCK)) >= 0;) {
        MHD_add_connection(http->daemon, fd, (struct sockaddr *)&address, bytes);
        bytes = sizeof address;
    }
    close(http->fd);
    atomic_store(&http->listen, -1);
}

/* Waits until libmicrohttpd has work, a connection times out, or the thread is woken. While every
 * worker has a short task, it first sleeps briefly, so that events can gather. */
static void http_wait(struct srv_http *http) {
    MHD_UNSIGNED_LONG_LONG ms;
    int most = -1;
    if (MHD_get_timeout(http->daemon, &ms) == MHD_YES)
        most = ms < HTTP_WAIT_MS ? (int)ms : HTTP_WAIT_MS;
    if (!most) return;
    if (!http->all.probes) srv_fairness_nap(&http->all.service->fairness, http->events);
    struct epoll_event events[2];
    int count = epoll_wait(http->events, events, 2, most);
    for (int i = 0; i < count; i++) {
        eventfd_t times;
        if (events[i].data.fd == http->all.wake) eventfd_read(http->all.wake, &times);
    }
}

/* libmicrohttpd is polled for events and never waits itself: with 128 events at once, its versions
 * 0.9.75 to 1.0.1 request more before they handle any, and sleep meanwhile. */
static void *http_main(void *context) {
    struct srv_http *http = context;
    srv_recv_hooks_here(&http->all.hooks);
    while (!atomic_load(&http->end)) {
        http_wait(http);
        MHD_run(http->daemon);
        if (!atomic_load(&http->listen)) http_close(http);
    }
    return NULL;
}

/* --- start and end --- */

/* Adds a descriptor to those on which the thread waits. */
static int http_listen_for(struct srv_http *http, int fd) {
    struct epoll_event event = {.events = EPOLLIN, .data.fd = fd};
    return !epoll_ctl(http->events, EPOLL_CTL_ADD, fd, &event);
}

/* Releases everything but the listening socket. The thread has ended before. */
static void http_drop(struct srv_http *http) {
    if (http->daemon) MHD_stop_daemon(http->daemon);
    if (http->all.wake >= 0) close(http->all.wake);
    if (http->events >= 0) close(http->events);
    free(http->all.hooks.by_fd);
    free(http);
}

enum pend_status srv_http_new(struct srv_http **http, struct srv_service *service,
                              struct srv_watch *watch, int fd, int probes,
                              struct pend_error *error) {
    const struct srv_config *config = &service->config;
    struct srv_http *made = *http = calloc(1, sizeof *made);
    if (!made) {
        close(fd);
        return pend_fail(error, PEND_NO_MEMORY, -1, 0, "out of memory");
    }
    *made = (struct srv_http){
        .all = {.service = service, .watch = watch, .probes = probes}, .fd = fd, .listen = 1};
    made->all.wake = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    made->events = epoll_create1(EPOLL_CLOEXEC);
    struct MHD_OptionItem options[] = {
        {MHD_OPTION_LISTEN_SOCKET, fd, NULL},
        {MHD_OPTION_CONNECTION_LIMIT, (intptr_t)config->connections + HTTP_SPARE, NULL},
        {MHD_OPTION_CONNECTION_TIMEOUT, (intptr_t)config->idle_seconds, NULL},
        {MHD_OPTION_CONNECTION_MEMORY_LIMIT, HTTP_POOL, NULL},
        {MHD_OPTION_NOTIFY_COMPLETED, (intptr_t)srv_connection_completed, &made->all},
        {MHD_OPTION_NOTIFY_CONNECTION, (intptr_t)srv_connection_notify, &made->all},
        {MHD_OPTION_URI_LOG_CALLBACK, (intptr_t)srv_connection_target, &made->all},
        {MHD_OPTION_UNESCAPE_CALLBACK, (intptr_t)http_unescape, made},
        {MHD_OPTION_SIGPIPE_HANDLED_BY_APP, 1, NULL},
        {MHD_OPTION_END, 0, NULL},
    };
    made->daemon = MHD_start_daemon(MHD_USE_EPOLL | MHD_ALLOW_SUSPEND_RESUME | MHD_USE_TURBO, 0,
                                    srv_connection_allow, &made->all, srv_connection_request,
                                    &made->all, MHD_OPTION_ARRAY, options, MHD_OPTION_END);
    if (made->daemon && http_listen_for(made, made->all.wake) &&
        http_listen_for(made,
                        MHD_get_daemon_info(made->daemon, MHD_DAEMON_INFO_EPOLL_FD)->epoll_fd) &&
        !pthread_create(&made->thread, NULL, http_main, made))
        return PEND_OK;
    *http = NULL;
    if (!made->daemon) close(fd); /* Otherwise libmicrohttpd closes the socket. */
    http_drop(made);
    return pend_fail(error, PEND_NO_MEMORY, -1, 0, "libmicrohttpd cannot be started");
}

int srv_http_quiesce(struct srv_http *http) {
    int64_t now = srv_clock_now();
    if (!http->settling) {
        srv_listen_settle(http->fd);
        http->settling = now;
    }
    if (now - http->settling < (int64_t)SRV_HTTP_SETTLE_MS * 1000000) return 0;
    int listen = atomic_load(&http->listen);
    if (listen < 0) return 1;
    if (listen > 0) {
        atomic_store(&http->listen, 0);
        eventfd_write(http->all.wake, 1);
    }
    http->settling = now;
    return 0;
}

void srv_http_free(struct srv_http **http) {
    struct srv_http *gone = *http;
    *http = NULL;
    if (!gone) return;
    if (atomic_load(&gone->listen) > 0) atomic_store(&gone->listen, 0);
    atomic_store(&gone->end, 1);
    eventfd_write(gone->all.wake, 1);
    pthread_join(gone->thread, NULL);
    if (!atomic_load(&gone->listen)) http_close(gone);
    http_drop(gone);
}
