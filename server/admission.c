#include "server/admission.h"

#include <string.h>

#include "server/clock.h"

void srv_admission_client(struct srv_exchange *exchange) {
    const struct srv_service *service = exchange->service;
    if (service->trusted.count)
        srv_peer_client(&service->trusted, exchange->peer, service->config.client_header,
                        exchange->field[SRV_FORWARDED], exchange->client);
    else
        memcpy(exchange->client, exchange->peer, sizeof exchange->client);
}

int srv_admission_count(struct srv_exchange *exchange) {
    struct srv_service *service = exchange->service;
    double a_minute = service->config.requests_a_minute;
    exchange->account = srv_clients_take(service->clients, exchange->client);
    if (!exchange->account) {
        srv_exchange_busy(exchange, 1, "out of memory");
        return 0;
    }
    if (a_minute <= 0) return 1;
    exchange->quota = srv_clients_quota(service->clients, exchange->account, a_minute, srv_clock_now());
    if (exchange->quota.granted) return 1;
    srv_metrics_count(&service->metrics.refused_rate, 1);
    srv_exchange_problem(exchange, 429, "more requests than the limit max-requests-a-minute of %.0f", a_minute);
    srv_exchange_retry(exchange, exchange->quota.retry);
    return 0;
}
