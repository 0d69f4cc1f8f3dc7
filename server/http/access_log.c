#include "server/http/access_log.h"

#include <string.h>

#include "server/base/clock.h"
#include "server/http/router.h"
#include "server/jobs/jobs.h"

static void access_log_count(const struct srv_exchange *exchange,
                             const struct srv_log_request *line, int64_t now) {
    struct srv_metrics *metrics = &exchange->service->metrics;
    srv_metrics_request(metrics, srv_router_number(exchange->route), line->status);
    srv_metrics_time(&metrics->queue, exchange->waited);
    srv_metrics_time(&metrics->compute, exchange->computed);
    if (exchange->sending) srv_metrics_time(&metrics->write, now - exchange->sending);
    srv_metrics_time(&metrics->total, line->total);
    if (line->bytes_in) srv_metrics_count(&metrics->bytes_in, line->bytes_in);
    if (line->bytes_out) srv_metrics_count(&metrics->bytes_out, line->bytes_out);
}

/* The address or account of a client, as far as the options allow it in the log. */
static const char *access_log_client(const struct srv_exchange *exchange,
                                     char text[SRV_PEER_BYTES]) {
    const char *how = srv_service_config(exchange->service)->log_client,
               *client = exchange->identity.shown[0] ? exchange->identity.shown : exchange->peer;
    if (!strcmp(how, "full") || !strncmp(client, "account:", 8)) return client;
    text[0] = 0;
    if (!strcmp(how, "network")) srv_peer_shorten(client, text);
    return text[0] ? text : "-";
}

/* Returns 1 if the audit log records the request: changes, operators' requests and refusals. */
static int access_log_audit(const struct srv_exchange *exchange, int status) {
    const struct srv_route *route = exchange->route;
    if (status == 401 || status == 403) return 1;
    if (!route || !exchange->method) return 0;
    int kept = !strcmp(exchange->method, "DELETE") ||
               (!strcmp(exchange->method, "POST") && route->begin) || srv_jobs_wanted(exchange);
    return kept ||
           (exchange->identity.role != SRV_ROLE_NONE && (route->special & SRV_ROUTE_OPERATOR) != 0);
}

/* The object of a request: the variable part of the path, or the location of a created object. */
static const char *access_log_of(const struct srv_exchange *exchange) {
    if (exchange->argument) return exchange->argument;
    for (int i = 0; i < exchange->headers; i++)
        if (!strcmp(exchange->header[i].name, "Location")) return exchange->header[i].value;
    return NULL;
}

static void access_log_account(const struct srv_exchange *exchange,
                               const struct srv_log_request *line) {
    const struct srv_identity *identity = &exchange->identity;
    int status = line->status;
    const struct srv_log_audit_entry entry = {
        .id = line->id,
        .who = identity->secret[0] ? identity->secret : line->client,
        .role = srv_role_word(identity->role),
        .what = exchange->route ? exchange->route->label : line->method,
        .of = access_log_of(exchange),
        .status = status,
        .outcome = status >= 200 && status < 300   ? "done"
                   : status < 200 || status >= 500 ? "failed"
                                                   : "refused"};
    srv_log_audit_entry(exchange->service->log, &entry);
}

void srv_access_log_enter(const struct srv_exchange *exchange, const char *outcome, int status) {
    assert(srv_exchange_valid(exchange) && (!status || (status >= 200 && status <= 599)));
    int64_t now = srv_clock_now();
    char shown[SRV_PEER_BYTES];
    int bodiless = !exchange->method || !strcmp(exchange->method, "HEAD") || status == 304;
    struct srv_log_request line = {.id = exchange->id ? exchange->id : "",
                                   .client = access_log_client(exchange, shown),
                                   .token = exchange->identity.secret[0] ? exchange->identity.secret
                                                                         : NULL,
                                   .method = exchange->method ? exchange->method : "",
                                   .target = exchange->target,
                                   .agent = exchange->field[SRV_USER_AGENT],
                                   .trace = exchange->trace,
                                   .cache = exchange->cache,
                                   .status = status,
                                   .outcome = outcome,
                                   .bytes_in = exchange->body.bytes,
                                   .bytes_out = bodiless ? 0 : exchange->bytes,
                                   .wait = exchange->waited,
                                   .compute = exchange->computed,
                                   .total = exchange->received ? now - exchange->received : 0,
                                   .steps = exchange->steps};
    access_log_count(exchange, &line, now);
    srv_log_request(exchange->service->log, &line);
    if (access_log_audit(exchange, status)) access_log_account(exchange, &line);
}
