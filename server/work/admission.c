#include "server/work/admission.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

#include "server/base/clock.h"

static const char admission_realm[] = "Bearer realm=\"pendulumd\"";
static const char admission_invalid[] = "Bearer realm=\"pendulumd\", error=\"invalid_token\"";

/* Adds a WWW-Authenticate field that names the error. If memory is short the field is shorter. */
static void admission_asks(struct srv_exchange *exchange, const char *error, const char *name,
                           const char *value) {
    enum { ADMISSION_ASKS = 192 };
    char *text = srv_exchange_text(exchange, ADMISSION_ASKS);
    if (text)
        snprintf(text, ADMISSION_ASKS, "%s, error=\"%s\", %s=\"%.100s\"", admission_realm, error,
                 name, value);
    srv_exchange_header(exchange, "WWW-Authenticate", text ? text : admission_realm);
}

static void admission_key(struct srv_exchange *exchange) {
    const struct srv_identity *identity = &exchange->identity;
    static const char other[] = "ask the operator of this server for another one";
    char since[SRV_KEY_TIME];
    const char *name = identity->secret[0] ? identity->secret + 4 : "", *why = "it is unknown";
    srv_metrics_count(&exchange->service->metrics.refused_keys, 1);
    srv_keys_time(identity->since, since);
    switch (identity->verdict) {
    case SRV_KEY_BROKEN:
        why = "the key is malformed";
        srv_exchange_problem(exchange, 401,
                             API_TYPE_CREDENTIALS
                             "this key is malformed: a key is pdk_ and %d characters, of which the "
                             "last six are a checksum; send the whole key",
                             SRV_KEY_TOKEN - 1 - 4);
        break;
    case SRV_KEY_EXPIRED:
        why = "the key has expired";
        srv_exchange_problem(exchange, 401,
                             API_TYPE_CREDENTIALS "the key %s has expired, at %s: %s", name, since,
                             other);
        break;
    case SRV_KEY_REVOKED:
        why = "the key was revoked";
        srv_exchange_problem(exchange, 401,
                             API_TYPE_CREDENTIALS "the key %s was revoked, at %s: %s", name, since,
                             other);
        break;
    case SRV_KEY_UNKNOWN:
    case SRV_KEY_GOOD:
        srv_exchange_problem(
            exchange, 401,
            API_TYPE_CREDENTIALS
            "this key is unknown to this server: it was not created here, or was removed; %s",
            other);
        break;
    }
    admission_asks(exchange, "invalid_token", "error_description", why);
}

int srv_admission_identify(struct srv_exchange *exchange) {
    const struct srv_service *service = exchange->service;
    const char *header = srv_service_config(service)->client_header,
               *value = exchange->field[SRV_FORWARDED];
    const struct srv_peers *trusted = srv_service_trusted(service);
    char address[SRV_PEER_BYTES];
    srv_peer_client(trusted, exchange->peer, header, value, address);
    int account =
        value && !srv_peer_names_addresses(header) && srv_peer_trusted(trusted, exchange->peer);
    const struct srv_identity_words words = {.address = address,
                                             .account = account ? value : NULL,
                                             .roles = account ? exchange->field[SRV_ROLES] : NULL,
                                             .authorization = exchange->field[SRV_AUTHORIZATION],
                                             .now = (int64_t)time(NULL)};
    srv_identity_make(&exchange->identity, service->keys, &words);
    assert(exchange->identity.key[0] && exchange->identity.source[0]);
    return 1;
}

int srv_admission_named(struct srv_exchange *exchange) {
    switch (exchange->identity.fault) {
    case SRV_IDENTITY_GOOD:
        return 1;
    case SRV_IDENTITY_NO_ACCOUNT:
        srv_exchange_problem(
            exchange, 400,
            "the field %.60s, which identifies the client, must be visible ASCII characters",
            srv_service_config(exchange->service)->client_header);
        return 0;
    case SRV_IDENTITY_NO_KEY:
        admission_key(exchange);
        return 0;
    case SRV_IDENTITY_NO_TOKEN:
        break;
    }
    srv_exchange_problem(exchange, 401, API_TYPE_CREDENTIALS "%s", srv_identity_rule);
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
                         "%s: generate a random secret, such as by openssl rand -hex 16, and send "
                         "it with every request as Authorization: Bearer SECRET",
                         why);
    srv_exchange_header(exchange, "WWW-Authenticate", admission_realm);
}

void srv_admission_forbid(struct srv_exchange *exchange, enum srv_role needed, const char *what) {
    const struct srv_identity *identity = &exchange->identity;
    const char *role = srv_role_word(needed);
    srv_metrics_count(&exchange->service->metrics.refused_roles, 1);
    if (identity->role == SRV_ROLE_ANONYMOUS && identity->kind != SRV_IDENTITY_ACCOUNT) {
        srv_exchange_problem(exchange, 401,
                             "%s: that needs a key of the role %s from the operator of this "
                             "server; send it as Authorization: Bearer KEY",
                             what, role);
        srv_exchange_header(exchange, "WWW-Authenticate", admission_realm);
        return;
    }
    srv_exchange_problem(exchange, 403, API_TYPE_ROLE "%s: your role is %s, and that needs %s",
                         what, srv_role_word(identity->role), role);
    admission_asks(exchange, "insufficient_scope", "scope", role);
}

/* The requests a minute that this client may send; 0 = no limit. `named` receives the name of the
 * limit. */
static double admission_rate(const struct srv_exchange *exchange, char named[64]) {
    double all = srv_service_config(exchange->service)->requests_a_minute,
           own = fmax(60 * exchange->identity.limits.value[SRV_LIMIT_REQUESTS], 1);
    if (isinf(own) || (all > 0 && all <= own)) {
        snprintf(named, 64, "max-requests-a-minute");
        return all;
    }
    snprintf(named, 64, "requests of the role %.20s", srv_role_word(exchange->identity.role));
    return own;
}

/* Answers 429 if the client has used up its share of computing time of the last minutes. */
static int admission_computed(struct srv_exchange *exchange) {
    double seconds = exchange->identity.limits.value[SRV_LIMIT_COMPUTE];
    if (isinf(seconds)) return 1;
    double wait =
        srv_clients_debt(exchange->service->clients, exchange->account, seconds, srv_clock_now());
    if (wait <= 0) return 1;
    srv_metrics_count(&exchange->service->metrics.refused_compute, 1);
    srv_exchange_problem(
        exchange, 429,
        API_TYPE_RATE
        "your requests have computed for more than the %.15g seconds per minute of the role %s",
        seconds, srv_role_word(exchange->identity.role));
    srv_exchange_retry(exchange, wait);
    return 0;
}

int srv_admission_count(struct srv_exchange *exchange) {
    struct srv_service *service = exchange->service;
    char named[64];
    assert(!exchange->account && exchange->identity.key[0]);
    double a_minute = admission_rate(exchange, named);
    exchange->account =
        srv_clients_take(service->clients, exchange->identity.key, exchange->identity.source);
    if (!exchange->account) {
        srv_exchange_busy(exchange, 1, "out of memory");
        return 0;
    }
    atomic_store(&exchange->account->priority,
                 (int)exchange->identity.limits.value[SRV_LIMIT_PRIORITY]);
    if (!admission_computed(exchange)) return 0;
    if (a_minute <= 0) return 1;
    exchange->quota = srv_clients_quota(service->clients, exchange->account, a_minute,
                                        service->config.address_clients, srv_clock_now());
    if (exchange->quota.granted) return 1;
    srv_metrics_count(&service->metrics.refused_rate, 1);
    srv_exchange_problem(exchange, 429,
                         API_TYPE_RATE "more requests than the limit %s of %.0f per minute", named,
                         a_minute);
    srv_exchange_retry(exchange, exchange->quota.retry);
    return 0;
}
