#include "server/reload.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "server/config/hosts.h"

/* options that are read at every use, as are the limits of requests (api/base/limits.h) */
static const char *const reload_names[] = {
    "compress-above",     "cors-origins",     "hosts",
    "trusted-proxy",      "client-header",    "max-queue",
    "max-client-queue",   "max-wait-seconds", "max-requests-a-minute",
    "max-held-bytes",     "header-seconds",   "body-seconds",
    "send-seconds",       "least-rate",       "drain-seconds",
    "drain-idle-seconds", "access-log",       "log",
    "max-scene-bytes",    "max-job-members",  "max-job-samples",
    "max-job-steps",      "max-job-seconds",  "audit-log",
    "log-client",         "role-header",      "frame-ancestors",
    "deprecated",         "sunset",
};

int srv_reload_may(const char *name) {
    const struct api_limit_row *limit;
    for (size_t i = 0; i < sizeof reload_names / sizeof *reload_names; i++)
        if (!strcmp(reload_names[i], name)) return 1;
    for (int i = 0; (limit = api_limits_row(i)); i++)
        if (!strcmp(limit->name, name)) return 1;
    return 0;
}

static int reload_open(const char *path) {
    int fd = open(path, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC | O_NONBLOCK, 0640);
    return fd < 0 ? -2 : fd;
}

int srv_reload_log(const struct srv_config *config) {
    if (!config->access_log) return -1;
    if (!strcmp(config->log, "-"))
        return config->access_log == SRV_CONFIG_AUTO && isatty(STDOUT_FILENO) ? -1 : STDOUT_FILENO;
    return reload_open(config->log);
}

int srv_reload_audit(const struct srv_config *config) {
    if (!strcmp(config->audit_log, "none")) return -1;
    return strcmp(config->audit_log, "-") ? reload_open(config->audit_log) : STDOUT_FILENO;
}

/* opens both logs; returns 0 after logging the error if one cannot be opened */
static int reload_logs(const struct srv_config *config, int *log, int *audit,
                       struct pend_error *error) {
    const char *path = config->log;
    *audit = -1;
    *log = srv_reload_log(config);
    if (*log != -2) {
        *audit = srv_reload_audit(config);
        path = config->audit_log;
    }
    if (*log != -2 && *audit != -2) return 1;
    (void)pend_fail(error, PEND_INVALID, -1, 0, "the log %.150s cannot be opened: %s", path,
                    strerror(errno));
    if (*log > STDERR_FILENO) close(*log);
    return 0;
}

static void reload_take(struct srv_config *config, const struct srv_config *from, int i) {
    assert(config != from);
    size_t bytes;
    void *to = srv_config_value(config, i, &bytes);
    if (bytes) memcpy(to, srv_config_value((struct srv_config *)from, i, &bytes), bytes);
}

/* Returns true if option i of the table has the same value in two configs. */
static int reload_same(const struct srv_config *one, const struct srv_config *other, int i) {
    size_t bytes;
    const void *first = srv_config_value((struct srv_config *)one, i, &bytes);
    const void *second = srv_config_value((struct srv_config *)other, i, &bytes);
    if (bytes == sizeof(double)) return !memcmp(first, second, bytes);
    return !bytes || !strcmp(first, second);
}

/* logs the changed options, and those that need a restart; returns the number of changes */
static int reload_tell(struct srv_log *log, const struct srv_config *now,
                       const struct srv_config *next) {
    struct srv_option row;
    int changed = 0;
    for (int i = 0; srv_config_row(i, &row); i++) {
        if (reload_same(now, next, i)) continue;
        int may = srv_reload_may(row.name);
        changed += may;
        if (may)
            srv_log_message(log, "reload: %s has a new value", row.name);
        else
            srv_log_message(log,
                            "reload: %s has changed, which needs a restart: the old value is kept",
                            row.name);
    }
    return changed;
}

enum pend_status srv_reload(struct srv_service *service, const struct srv_config *next,
                            struct pend_error *error) {
    const struct srv_config *now = srv_service_config(service);
    struct srv_reloaded *made = calloc(1, sizeof *made);
    if (!made) return pend_fail(error, PEND_NO_MEMORY, -1, 0, "out of memory");
    struct srv_option row;
    made->config = *now;
    for (int i = 0; srv_config_row(i, &row); i++) // options that need a restart keep their values
        if (srv_reload_may(row.name)) reload_take(&made->config, next, i);
    made->job_limits = srv_config_job_limits(&made->config);
    enum pend_status status = srv_peers_read(&made->trusted, made->config.trusted_proxy, error);
    int log, audit;
    if (status == PEND_OK && !reload_logs(&made->config, &log, &audit, error))
        status = PEND_INVALID;
    if (status != PEND_OK) {
        free(made);
        return status;
    }
    made->hosts =
        srv_hosts_mean(made->config.hosts, made->config.listen, srv_peers_any(&made->trusted));
    int changed = reload_tell(service->log, now, next);
    made->before = atomic_load(&service->reloaded);
    atomic_store_explicit(&service->reloaded, made, memory_order_release);
    srv_queue_bound(service->queue, (int)made->config.queue, (int)made->config.client_queue);
    srv_log_turn(service->log, SRV_LOG_REQUESTS, log);
    srv_log_turn(service->log, SRV_LOG_AUDIT, audit);
    srv_log_message(service->log,
                    changed == 1 ? "reload: %d option has changed"
                                 : "reload: %d options have changed",
                    changed);
    char count[16];
    snprintf(count, sizeof count, "%d", changed);
    srv_log_audit_entry(service->log, &(struct srv_log_audit_entry){.id = "",
                                                                    .who = "operator",
                                                                    .role = "",
                                                                    .what = "reload of options",
                                                                    .of = count,
                                                                    .outcome = "done"});
    if (next->warning[0]) srv_log_message(service->log, "%s", next->warning);
    return PEND_OK;
}

void srv_reload_clear(struct srv_service *service) {
    struct srv_reloaded *gone = atomic_exchange(&service->reloaded, NULL);
    while (gone) {
        struct srv_reloaded *before = gone->before;
        free(gone);
        gone = before;
    }
}
