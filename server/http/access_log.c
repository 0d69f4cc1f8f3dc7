#include "server/http/access_log.h"

#include <assert.h>
#include <string.h>

#include "server/base/clock.h"
#include "server/http/router.h"

/* counts a request that is over */
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

void srv_access_log_enter(const struct srv_exchange *exchange, const char *outcome, int status) {
    assert(srv_exchange_valid(exchange) && (!status || (status >= 200 && status <= 599)));
    int64_t now = srv_clock_now();
    int bodiless = !exchange->method || !strcmp(exchange->method, "HEAD") || status == 304;
    struct srv_log_request line = {
        .id = exchange->id ? exchange->id : "",
        .client = exchange->identity.shown[0] ? exchange->identity.shown : exchange->peer,
        .token = exchange->identity.secret[0] ? exchange->identity.secret : NULL,
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
}
