#include "server/http/probes.h"

#include <string.h>

#include "api/base/engine.h"

static const char probes_json[] = "application/json";

void srv_probes_health(struct srv_exchange *exchange) {
    static const char alive[] = "{\"status\":\"ok\"}";
    srv_exchange_static(exchange, 200, probes_json, alive, sizeof alive - 1);
    srv_exchange_header(exchange, "Cache-Control", "no-store");
}

void srv_probes_version(struct srv_exchange *exchange) {
    if (api_buffer_format(&exchange->answer, "{\"version\":\"%s\",\"engine\":\"%s\"}", api_version,
                          api_engine_name) != PEND_OK) {
        srv_exchange_busy(exchange, 1, "out of memory");
        return;
    }
    srv_exchange_answered(exchange, 200, probes_json);
    srv_exchange_header(exchange, "Cache-Control", "no-cache");
}

/* Returns 1 if the probe asks about jobs as well, 0 if not, -1 for an unknown query. */
static int probes_need(const struct srv_exchange *exchange) {
    if (!exchange->query || !*exchange->query)
        return !srv_config_answers(&exchange->service->config);
    return strcmp(exchange->query, "need=jobs") ? -1 : 1;
}

void srv_probes_readiness(struct srv_exchange *exchange) {
    const struct srv_service *service = exchange->service;
    const char *jobs = srv_service_jobless(service);
    int need = probes_need(exchange);
    if (need < 0) {
        srv_exchange_problem(exchange, 422, "the query must be need=jobs, got ?%.100s",
                             exchange->query);
        return;
    }
    if (atomic_load(&service->draining)) {
        srv_exchange_busy(exchange, 5, "the server is draining");
        return;
    }
    if (need && jobs) {
        srv_exchange_busy(exchange, 5, jobs);
        return;
    }
    /* without a store the process is meant to serve no jobs */
    const char *status = jobs && service->storage ? "degraded" : "ready";
    exchange->answer.bytes = 0;
    if (api_buffer_format(&exchange->answer, "{\"status\":\"%s\",\"jobs\":\"%s\"}", status,
                          jobs ? jobs : "ready") != PEND_OK) {
        srv_exchange_busy(exchange, 1, "out of memory");
        return;
    }
    srv_exchange_answered(exchange, 200, probes_json);
    srv_exchange_header(exchange, "Cache-Control", "no-store");
}
