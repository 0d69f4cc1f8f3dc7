#include "server/daemon.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

#include "server/base/clock.h"
#include "server/config/listen.h"
#include "server/http/http.h"
#include "server/jobs/events.h"
#include "server/jobs/part_runner.h"
#include "server/reload.h"
#include "server/sandbox_setup.h"
#include "server/service_setup.h"
#include "server/work/workers.h"

enum {
    DAEMON_FILES = 64 + 64, /* open files besides those of connections and of lingering sockets */
    DAEMON_END_MS = 5000    /* longest wait for the last answers to be sent */
};

struct srv_daemon {
    struct srv_service service;
    struct srv_watch *watch;
    struct srv_workers *workers;
    struct srv_http *http, *probes; /* for all routes; for probes and metrics only, or NULL */
    double connections;             /* as configured; the system may allow fewer */
    int64_t drained;                /* ns: start of the drain; 0 = not draining */
    int probe_fd;                   /* -1 = none, or `probes` owns it */
    char url[SRV_URL_BYTES], probe_url[SRV_URL_BYTES];
    char lack[SRV_CONFIG_TEXT]; /* missing layers of the sandbox; "" = none */
};

/* Raises the limit of open files as far as the system allows, and lowers the number of connections
 * if that is not enough. An eighth of the files is for lingering sockets; returns their number. */
static int daemon_files(struct srv_config *config, struct srv_log *log) {
    struct rlimit files;
    int lingering = SRV_WATCH_LINGERING;
    if (getrlimit(RLIMIT_NOFILE, &files)) return lingering;
    rlim_t need = (rlim_t)config->connections + DAEMON_FILES + SRV_WATCH_LINGERING;
    if (files.rlim_cur < need) {
        files.rlim_cur = files.rlim_max < need ? files.rlim_max : need;
        setrlimit(RLIMIT_NOFILE, &files);
        getrlimit(RLIMIT_NOFILE, &files);
    }
    if (files.rlim_cur >= need) return lingering;
    if (files.rlim_cur / 8 < SRV_WATCH_LINGERING) lingering = (int)(files.rlim_cur / 8);
    rlim_t other = DAEMON_FILES + (rlim_t)lingering;
    double most = files.rlim_cur > other + 1 ? (double)(files.rlim_cur - other) : 1;
    if (most > config->connections) most = config->connections;
    srv_log_message(log, "max-connections is %.0f, not %.0f: the system allows %llu open files",
                    most, config->connections, (unsigned long long)files.rlim_cur);
    config->connections = most;
    return lingering;
}

/* opens the audit log; returns 0 if that fails, with errno set */
static int daemon_audit(struct srv_daemon *daemon, const struct srv_config *config) {
    int audit = srv_reload_audit(config);
    if (audit != -2) {
        srv_log_turn(daemon->service.log, SRV_LOG_AUDIT, audit);
        return 1;
    }
    srv_log_message(daemon->service.log,
                    "the log %.150s cannot be opened: %s; logging continues to the old file",
                    config->audit_log, strerror(errno));
    return 0;
}

static enum pend_status daemon_probes(struct srv_daemon *daemon, struct pend_error *error) {
    int fd = daemon->probe_fd;
    daemon->probe_fd = -1;
    if (fd < 0) return PEND_OK;
    PEND_TRY(srv_http_new(&daemon->probes, &daemon->service, daemon->watch, fd, 1, error));
    srv_log_message(daemon->service.log, "probes and metrics on %s", daemon->probe_url);
    return PEND_OK;
}

static enum pend_status daemon_start(struct srv_daemon *daemon, struct pend_error *error) {
    struct srv_service *service = &daemon->service;
    struct srv_config *config = &service->config;
    int fd;
    PEND_TRY(srv_service_setup_init(service, error));
    if (strcmp(config->probe_listen, "none"))
        PEND_TRY(
            srv_listen_open(config->probe_listen, &daemon->probe_fd, daemon->probe_url, error));
    PEND_TRY(srv_listen_open(config->listen, &fd, daemon->url, error));
    int log = srv_reload_log(config);
    if (log == -2) {
        close(fd);
        return pend_fail(error, PEND_INVALID, -1, 0, "the log %.150s cannot be opened: %s",
                         config->log, strerror(errno));
    }
    enum pend_status status = srv_sandbox_enter(config, daemon->lack, error);
    if (status != PEND_OK) {
        close(fd);
        return status;
    }
    status = srv_log_new(&service->log, log, STDERR_FILENO);
    if (status == PEND_OK && !daemon_audit(daemon, config)) {
        close(fd);
        return pend_fail(error, PEND_INVALID, -1, 0, "the log %.150s cannot be opened: %s",
                         config->audit_log, strerror(errno));
    }
    if (status == PEND_OK) {
        int lingering = daemon_files(config, service->log);
        status = srv_watch_new(&daemon->watch);
        if (status == PEND_OK) srv_watch_lingering(daemon->watch, lingering);
    }
    if (status == PEND_OK)
        status =
            srv_workers_new(&daemon->workers, service->workers, service->queue, &service->fairness);
    if (status == PEND_OK) {
        status = srv_service_setup_jobs(service, error);
        if (status == PEND_OK)
            status = srv_http_new(&daemon->http, service, daemon->watch, fd, 0, error);
        else
            close(fd);
        return status == PEND_OK ? daemon_probes(daemon, error) : status;
    }
    close(fd);
    return pend_fail(error, status, -1, 0, "not enough memory or threads for %d workers",
                     service->workers);
}

enum pend_status srv_daemon_new(struct srv_daemon **daemon, const struct srv_config *config,
                                struct pend_error *error) {
    struct srv_daemon *made = *daemon = calloc(1, sizeof *made);
    if (!made) return pend_fail(error, PEND_NO_MEMORY, -1, 0, "out of memory");
    made->service.config = *config;
    made->probe_fd = -1;
    made->connections = config->connections;
    enum pend_status status = daemon_start(made, error);
    if (status != PEND_OK) srv_daemon_free(daemon);
    return status;
}

const char *srv_daemon_url(const struct srv_daemon *daemon) { return daemon->url; }

const char *srv_daemon_lack(const struct srv_daemon *daemon) { return daemon->lack; }

struct srv_log *srv_daemon_log(const struct srv_daemon *daemon) {
    return daemon->service.log;
}

double srv_daemon_idle(struct srv_daemon *daemon) {
    return daemon->service.runner ? srv_part_runner_idle(daemon->service.runner) : 0;
}

enum pend_status srv_daemon_reload(struct srv_daemon *daemon, const struct srv_config *next,
                                   struct pend_error *error) {
    struct srv_config same = *next;
    if (same.connections == daemon->connections)
        same.connections = daemon->service.config.connections;
    return srv_reload(&daemon->service, &same, error);
}

int srv_daemon_has_keys(const struct srv_daemon *daemon) { return daemon->service.keys != NULL; }

void srv_daemon_look(struct srv_daemon *daemon) {
    if (daemon->service.keys) srv_key_ring_look(daemon->service.keys, daemon->service.log);
}

void srv_daemon_reopen(struct srv_daemon *daemon) {
    const struct srv_config *config = srv_service_config(&daemon->service);
    int log = srv_reload_log(config);
    if (log == -2)
        srv_log_message(daemon->service.log,
                        "the log %.150s cannot be opened: %s; logging continues to the old file",
                        config->log, strerror(errno));
    else
        srv_log_turn(daemon->service.log, SRV_LOG_REQUESTS, log);
    daemon_audit(daemon, config);
}

double srv_daemon_patience(const struct srv_daemon *daemon) {
    return srv_service_config(&daemon->service)->drain_seconds;
}

int srv_daemon_drain(struct srv_daemon *daemon, int hurry) {
    if (!daemon->drained) daemon->drained = srv_clock_now();
    atomic_store(&daemon->service.draining, hurry ? SRV_DRAIN_HURRY : SRV_DRAIN_LAST);
    /* Stop listening first: a refused client can safely send any request to another process. */
    int closed = srv_http_quiesce(daemon->http);
    if (hurry) srv_watch_leave_all(daemon->watch);
    srv_events_drain(daemon->service.events);
    int held = daemon->service.runner && !srv_part_runner_drain(daemon->service.runner);
    if (!closed || held || atomic_load(&daemon->service.computing)) return 0;
    int64_t patience =
        hurry ? 0 : srv_clock_span(srv_service_config(&daemon->service)->drain_idle_seconds);
    return !srv_watch_busy(daemon->watch, daemon->drained, patience);
}

static void daemon_nap(void) { nanosleep(&(struct timespec){.tv_nsec = 5000000}, NULL); }

void srv_daemon_free(struct srv_daemon **daemon) {
    struct srv_daemon *gone = *daemon;
    *daemon = NULL;
    if (!gone) return;
    if (gone->http) {
        /* A computation ends after its current piece of work; slow answers are cut off. */
        int64_t end = srv_clock_now() + (int64_t)DAEMON_END_MS * 1000000;
        while (!srv_daemon_drain(gone, 1) &&
               (srv_clock_now() < end || atomic_load(&gone->service.computing)))
            daemon_nap();
    }
    while (gone->service.runner && gone->service.storage &&
           !srv_part_runner_drain(gone->service.runner))
        daemon_nap();
    if (gone->probe_fd >= 0) close(gone->probe_fd);
    srv_workers_free(&gone->workers);
    srv_http_free(&gone->http);
    srv_http_free(&gone->probes);
    srv_service_setup_jobs_end(&gone->service);
    srv_watch_free(&gone->watch);
    srv_log_free(&gone->service.log);
    srv_service_setup_clear(&gone->service);
    srv_reload_clear(&gone->service);
    free(gone);
}
