#include "server/http/http.h"

#include <microhttpd.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "server/base/clock.h"
#include "server/http/connection.h"
#include "server/base/listen.h"

enum {
    HTTP_POOL = 24576, /* bytes of libmicrohttpd's memory a connection: holds what the strict reader
                          lets pass */
    HTTP_SPARE = 64    /* connections beyond the cap that are told so */
};

struct srv_http {
    struct srv_connections all;
    struct MHD_Daemon *daemon;
    int fd;           /* that it listens on; -1 = no more */
    int64_t settling; /* ns: since when nobody new is let in, then since when it does not listen */
};

/* paths are decoded by message, strictly */
static size_t http_unescape(void *context, struct MHD_Connection *mhd, char *text) {
    (void)context, (void)mhd;
    return strlen(text);
}

/* --- start and end --- */

enum pend_status srv_http_new(struct srv_http **http, struct srv_service *service,
                              struct srv_watch *watch, int fd, struct pend_error *error) {
    const struct srv_config *config = &service->config;
    struct srv_http *made = *http = calloc(1, sizeof *made);
    if (!made) {
        close(fd);
        return pend_fail(error, PEND_NO_MEMORY, -1, 0, "out of memory");
    }
    *made = (struct srv_http){.all = {.service = service, .watch = watch}, .fd = fd};
    srv_recv_hooks_init(&made->all.hooks, &service->fairness);
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
    unsigned flags =
        MHD_USE_EPOLL_INTERNAL_THREAD | MHD_ALLOW_SUSPEND_RESUME | MHD_USE_ITC | MHD_USE_TURBO;
    made->daemon =
        MHD_start_daemon(flags, 0, srv_connection_allow, &made->all, srv_connection_request,
                         &made->all, MHD_OPTION_ARRAY, options, MHD_OPTION_END);
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
    for (int fd; (fd = accept4(http->fd, (struct sockaddr *)&address, &bytes,
                               SOCK_CLOEXEC | SOCK_NONBLOCK)) >= 0;) {
        MHD_add_connection(http->daemon, fd, (struct sockaddr *)&address, bytes);
        bytes = sizeof address;
    }
    close(http->fd);
    http->fd = -1;
}

int srv_http_quiesce(struct srv_http *http) {
    int64_t now = srv_clock_now();
    if (!http->settling) {
        srv_listen_settle(http->fd);
        http->settling = now;
    }
    if (now - http->settling < (int64_t)SRV_HTTP_SETTLE_MS * 1000000) return 0;
    if (http->fd < 0) return 1;
    http_close(http);
    http->settling = now;
    return 0;
}

void srv_http_free(struct srv_http **http) {
    struct srv_http *gone = *http;
    *http = NULL;
    if (!gone) return;
    if (gone->fd >= 0) http_close(gone);
    MHD_stop_daemon(gone->daemon);
    srv_recv_hooks_clear(&gone->all.hooks);
    free(gone);
}
