#include "server/work/admission.h"

#include <assert.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "server/base/clock.h"

static const char admission_realm[] = "Bearer realm=\"pendulumd\"";
static const char admission_invalid[] = "Bearer realm=\"pendulumd\", error=\"invalid_token\"";

int srv_admission_identify(struct srv_exchange *exchange) {
    const struct srv_service *service = exchange->service;
    const char *header = srv_service_config(service)->client_header,
               *value = exchange->field[SRV_FORWARDED];
    const struct srv_peers *trusted = srv_service_trusted(service);
    char address[SRV_PEER_BYTES];
    srv_peer_client(trusted, exchange->peer, header, value, address);
    int account =
        value && !srv_peer_names_addresses(header) && srv_peer_trusted(trusted, exchange->peer);
    srv_identity_make(&exchange->identity, address, account ? value : NULL,
                      exchange->field[SRV_AUTHORIZATION]);
    assert(exchange->identity.key[0] && exchange->identity.source[0]);
    return 1;
}

int srv_admission_named(struct srv_exchange *exchange) {
    switch (exchange->identity.fault) {
    case SRV_IDENTITY_GOOD:
        return 1;
    case SRV_IDENTITY_NO_ACCOUNT:
        srv_exchange_problem(
            exchange, 400, "the field %.60s, which says who asks, must be visible ASCII characters",
            srv_service_config(exchange->service)->client_header);
        return 0;
    case SRV_IDENTITY_NO_TOKEN:
        break;
    }
    srv_exchange_problem(exchange, 401, "%s", srv_identity_rule);
    srv_exchange_header(exchange, "WWW-Authenticate", admission_invalid);
    return 0;
}

void srv_admission_challenge(struct srv_exchange *exchange, const char *format, ...) {
    char why[200];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(why, sizeof why, format, arguments);
    va_end(arguments);
    srv_exchange_problem(exchange, 401,
                         "%s: draw a secret of your own, as with openssl rand -hex 16, and send it "
                         "with every request "
                         "as Authorization: Bearer SECRET",
                         why);
    srv_exchange_header(exchange, "WWW-Authenticate", admission_realm);
}

int srv_admission_count(struct srv_exchange *exchange) {
    struct srv_service *service = exchange->service;
    assert(!exchange->account && exchange->identity.key[0]);
    double a_minute = srv_service_config(service)->requests_a_minute;
    exchange->account =
        srv_clients_take(service->clients, exchange->identity.key, exchange->identity.source);
    if (!exchange->account) {
        srv_exchange_busy(exchange, 1, "out of memory");
        return 0;
    }
    if (a_minute <= 0) return 1;
    exchange->quota = srv_clients_quota(service->clients, exchange->account, a_minute,
                                        service->config.address_clients, srv_clock_now());
    if (exchange->quota.granted) return 1;
    srv_metrics_count(&service->metrics.refused_rate, 1);
    srv_exchange_problem(exchange, 429,
                         "more requests than the limit max-requests-a-minute of %.0f", a_minute);
    srv_exchange_retry(exchange, exchange->quota.retry);
    return 0;
}
