#include "server/router.h"

#include <stdio.h>
#include <string.h>

#include "api/openapi.h"

static const char router_json[] = "application/json";

static void router_healthz(struct srv_exchange *exchange) {
    static const char alive[] = "{\"status\":\"ok\"}";
    srv_exchange_static(exchange, 200, router_json, alive, sizeof alive - 1);
    srv_exchange_header(exchange, "Cache-Control", "no-store");
}

static void router_readyz(struct srv_exchange *exchange) {
    static const char ready[] = "{\"status\":\"ready\"}";
    if (atomic_load(&exchange->service->draining)) {
        srv_exchange_busy(exchange, 5, "the server is draining");
        return;
    }
    srv_exchange_static(exchange, 200, router_json, ready, sizeof ready - 1);
    srv_exchange_header(exchange, "Cache-Control", "no-store");
}

static void router_openapi(struct srv_exchange *exchange) {
    srv_exchange_static(exchange, 200, router_json, api_openapi_json, api_openapi_bytes);
}

static const struct srv_route router_table[] = {
    {"POST", "/v1/trees", NULL, API_OP_TREES},          {"POST", "/v1/trajectories", NULL, API_OP_TRAJECTORIES},
    {"POST", "/v1/forces", NULL, API_OP_FORCES},        {"POST", "/v1/modes", NULL, API_OP_MODES},
    {"POST", "/v1/ensembles", NULL, API_OP_ENSEMBLES},  {"GET", "/v1/presets", NULL, API_OP_PRESETS},
    {"GET", "/v1/presets/{name}", NULL, API_OP_PRESET}, {"GET", "/openapi.json", router_openapi, API_OP_COUNT},
    {"GET", "/healthz", router_healthz, API_OP_COUNT},  {"GET", "/readyz", router_readyz, API_OP_COUNT},
};

enum { ROUTER_COUNT = sizeof router_table / sizeof *router_table, ROUTER_ALLOW = 64 };

const struct srv_route *srv_router_row(int i) { return i >= 0 && i < ROUTER_COUNT ? &router_table[i] : NULL; }

/* does the path follow the pattern? The variable part goes to argument, NULL where there is none */
static int router_match(const char *pattern, const char *path, const char **argument) {
    size_t fixed = strcspn(pattern, "{");
    *argument = NULL;
    if (!pattern[fixed]) return !strcmp(pattern, path);
    if (strncmp(pattern, path, fixed) || !path[fixed] || strchr(path + fixed, '/')) return 0;
    *argument = path + fixed;
    return 1;
}

static int router_serves(const struct srv_route *route, const char *method) {
    if (!strcmp(route->method, method)) return 1;
    return !strcmp(route->method, "GET") && !strcmp(method, "HEAD");
}

static void router_allow_add(char allow[ROUTER_ALLOW], const char *method) {
    size_t bytes = strlen(allow);
    snprintf(allow + bytes, ROUTER_ALLOW - bytes, "%s%s", bytes ? ", " : "", method);
}

/* what a path without the asked method can do; "" where there is no such path */
static void router_allow(const char *path, char allow[ROUTER_ALLOW]) {
    const char *argument;
    allow[0] = 0;
    for (int i = 0; i < ROUTER_COUNT; i++) {
        if (!router_match(router_table[i].pattern, path, &argument)) continue;
        router_allow_add(allow, router_table[i].method);
        if (!strcmp(router_table[i].method, "GET")) router_allow_add(allow, "HEAD");
    }
    if (allow[0]) router_allow_add(allow, "OPTIONS");
}

/* OPTIONS, 404 or 405 */
static void router_explain(struct srv_exchange *exchange) {
    char *allow = srv_exchange_text(exchange, ROUTER_ALLOW);
    if (!allow) {
        srv_exchange_problem(exchange, 431, "the request's head is too long");
        return;
    }
    router_allow(exchange->path, allow);
    int options = !strcmp(exchange->method, "OPTIONS");
    if (options && !strcmp(exchange->path, "*")) strcpy(allow, "GET, HEAD, POST, OPTIONS");
    if (!allow[0]) {
        srv_exchange_problem(exchange, 404, "there is nothing at %.200s; see /openapi.json", exchange->path);
        return;
    }
    if (options)
        srv_exchange_static(exchange, 204, NULL, NULL, 0);
    else
        srv_exchange_problem(exchange, 405, "%.40s is not for %.200s, but %s", exchange->method, exchange->path, allow);
    srv_exchange_header(exchange, "Allow", allow);
}

int srv_router_find(struct srv_exchange *exchange) {
    for (int i = 0; i < ROUTER_COUNT; i++) {
        const struct srv_route *route = &router_table[i];
        if (!router_serves(route, exchange->method) ||
            !router_match(route->pattern, exchange->path, &exchange->argument))
            continue;
        exchange->route = route;
        if (route->handle || !atomic_load(&exchange->service->draining)) return 1;
        srv_exchange_busy(exchange, 5, "the server is draining");
        exchange->close = 1;
        return 0;
    }
    router_explain(exchange);
    return 0;
}

int srv_router_begin(struct srv_exchange *exchange) {
    if (exchange->route->handle) {
        exchange->route->handle(exchange);
        return 1;
    }
    if (srv_queue_count(exchange->service->queue) < (int)exchange->service->config.queue) return 0;
    srv_exchange_busy(exchange, 1, "every worker is busy and the queue is full: max-queue");
    return 1;
}
