#include "server/http/router.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "api/json/did_you_mean.h"

#include "server/classes/class_reports.h"
#include "server/classes/class_request.h"
#include "server/classes/classes.h"
#include "server/config/hosts.h"
#include "server/http/assets.h"
#include "server/http/probes.h"
#include "server/http/request_head.h"
#include "server/jobs/jobs.h"
#include "server/protocol/cors.h"
#include "server/work/admission.h"
#include "server/work/compute.h"
#include "server/work/result.h"

static void router_metrics(struct srv_exchange *exchange) {
    struct srv_gauges gauges = srv_service_gauges(exchange->service);
    if (srv_metrics_write(&exchange->service->metrics, &gauges, srv_router_label,
                          &exchange->answer) != PEND_OK) {
        srv_exchange_busy(exchange, 1, "out of memory");
        return;
    }
    srv_exchange_answered(exchange, 200, "text/plain; version=0.0.4; charset=utf-8");
    srv_exchange_header(exchange, "Cache-Control", "no-store");
}

/* The three kinds of routes: a worker runs an operation; `begin` starts an answer that takes time;
 * `handle` answers at once. */
#define ROUTER_OPERATION(method, pattern, op)                                                      \
    { method, pattern, NULL, NULL, op, method " " pattern, 0 }
#define ROUTER_LATER(method, pattern, begin, special)                                              \
    { method, pattern, NULL, begin, API_OP_COUNT, method " " pattern, special }
#define ROUTER_AT_ONCE(method, pattern, handle, special)                                           \
    { method, pattern, handle, NULL, API_OP_COUNT, method " " pattern, special }

static const struct srv_route router_table[] = {
    ROUTER_OPERATION("POST", "/v1/trees", API_OP_TREES),
    ROUTER_OPERATION("POST", "/v1/trajectories", API_OP_TRAJECTORIES),
    ROUTER_OPERATION("POST", "/v1/forces", API_OP_FORCES),
    ROUTER_OPERATION("POST", "/v1/modes", API_OP_MODES),
    ROUTER_OPERATION("POST", "/v1/ensembles", API_OP_ENSEMBLES),
    ROUTER_OPERATION("POST", "/v1/lyapunov", API_OP_LYAPUNOV),
    ROUTER_OPERATION("POST", "/v1/sections", API_OP_SECTIONS),
    ROUTER_OPERATION("POST", "/v1/response", API_OP_RESPONSE),
    ROUTER_OPERATION("POST", "/v1/controllers", API_OP_CONTROLLERS),
    ROUTER_OPERATION("POST", "/v1/fits", API_OP_FITS),
    ROUTER_OPERATION("POST", "/v1/tables", API_OP_TABLES),
    ROUTER_OPERATION("POST", "/v1/trials", API_OP_TRIALS),
    ROUTER_OPERATION("POST", "/v1/orbits", API_OP_ORBITS),
    ROUTER_OPERATION("POST", "/v1/equations", API_OP_EQUATIONS),
    ROUTER_OPERATION("GET", "/v1/presets", API_OP_PRESETS),
    ROUTER_OPERATION("GET", "/v1/presets/{name}", API_OP_PRESET),
    ROUTER_LATER("POST", "/v1/scenes", srv_scenes_create, SRV_ROUTE_CLOSED | SRV_ROUTE_COUNTED),
    ROUTER_LATER("GET", "/v1/scenes/{id}", srv_scenes_read, 0),
    ROUTER_LATER("DELETE", "/v1/scenes/{id}", srv_scenes_drop,
                 SRV_ROUTE_CLOSED | SRV_ROUTE_COUNTED),
    ROUTER_LATER("GET", "/v1/jobs", srv_job_list, SRV_ROUTE_CLOSED | SRV_ROUTE_COUNTED),
    ROUTER_LATER("GET", "/v1/jobs/{id}", srv_jobs_read, 0),
    ROUTER_LATER("DELETE", "/v1/jobs/{id}", srv_jobs_dismiss, SRV_ROUTE_CLOSED | SRV_ROUTE_COUNTED),
    ROUTER_LATER("GET", "/v1/jobs/{id}/events", srv_jobs_events, 0),
    ROUTER_LATER("GET", "/v1/jobs/{id}/request", srv_job_request, SRV_ROUTE_COUNTED),
    ROUTER_LATER("GET", "/v1/jobs/{id}/results", srv_job_results, SRV_ROUTE_COUNTED),
    ROUTER_LATER("DELETE", "/v1/clients/{name}", srv_erasure, SRV_ROUTE_CLOSED | SRV_ROUTE_COUNTED),
    ROUTER_LATER("POST", "/v1/classes", srv_classes_create, SRV_ROUTE_CLOSED | SRV_ROUTE_COUNTED),
    ROUTER_LATER("GET", "/v1/classes", srv_classes_list, SRV_ROUTE_CLOSED | SRV_ROUTE_COUNTED),
    ROUTER_LATER("GET", "/v1/classes/{code}", srv_class_reports_room,
                 SRV_ROUTE_CLOSED | SRV_ROUTE_COUNTED),
    ROUTER_LATER("DELETE", "/v1/classes/{code}", srv_classes_erase,
                 SRV_ROUTE_CLOSED | SRV_ROUTE_COUNTED),
    ROUTER_LATER("POST", "/v1/classes/{code}/pupils", srv_classes_join,
                 SRV_ROUTE_CLOSED | SRV_ROUTE_COUNTED),
    ROUTER_LATER("GET", "/v1/classes/{code}/events", srv_classes_events,
                 SRV_ROUTE_CLOSED | SRV_ROUTE_COUNTED),
    ROUTER_LATER("GET", "/v1/classes/{code}/table", srv_class_reports_table,
                 SRV_ROUTE_CLOSED | SRV_ROUTE_COUNTED),
    ROUTER_LATER("GET", "/v1/classes/{code}/histograms/{id}", srv_class_reports_histogram,
                 SRV_ROUTE_CLOSED | SRV_ROUTE_COUNTED),
    ROUTER_LATER("PUT", "/v1/classes/{code}/{kind}/{id}", srv_classes_put,
                 SRV_ROUTE_CLOSED | SRV_ROUTE_COUNTED),
    ROUTER_LATER("DELETE", "/v1/classes/{code}/{kind}/{id}", srv_classes_remove,
                 SRV_ROUTE_CLOSED | SRV_ROUTE_COUNTED),
    ROUTER_AT_ONCE("GET", "/", srv_assets_index, 0),
    ROUTER_AT_ONCE("GET", "/oembed", srv_assets_oembed, 0),
    ROUTER_AT_ONCE("GET", "/docs", srv_assets_docs, 0),
    ROUTER_AT_ONCE("GET", "/sw.js", srv_assets_worker, 0),
    ROUTER_AT_ONCE("GET", "/page/{digest}/{file}", srv_assets_file, 0),
    ROUTER_AT_ONCE("GET", "/openapi.json", srv_assets_description, 0),
    ROUTER_AT_ONCE("GET", "/openapi-3.0.json", srv_assets_description, 0),
    ROUTER_AT_ONCE("GET", "/healthz", srv_probes_health, SRV_ROUTE_ANY_HOST | SRV_ROUTE_PROBE),
    ROUTER_AT_ONCE("GET", "/version", srv_probes_version, SRV_ROUTE_PROBE),
    ROUTER_AT_ONCE("GET", "/readyz", srv_probes_readiness, SRV_ROUTE_ANY_HOST | SRV_ROUTE_PROBE),
    ROUTER_AT_ONCE("GET", "/metrics", router_metrics,
                   SRV_ROUTE_ANY_ADDRESS | SRV_ROUTE_CLOSED | SRV_ROUTE_OPERATOR | SRV_ROUTE_PROBE),
    /* last, because a word of six letters such as readyz could be a code */
    ROUTER_AT_ONCE("GET", "/{room}", srv_assets_room, 0),
};

enum {
    ROUTER_COUNT = sizeof router_table / sizeof *router_table,
    ROUTER_ALLOW = 64,
    ROUTER_LABEL = 64,
    ROUTER_PATH = 64 /* longest unknown path for which a suggestion is made */
};

static_assert((int)ROUTER_COUNT < (int)SRV_METRIC_ROUTES, "every route has its counters");

int srv_router_number(const struct srv_route *route) {
    return route ? (int)(route - router_table) : -1;
}

const char *srv_router_label(int i) {
    return i >= 0 && i < ROUTER_COUNT ? router_table[i].label : NULL;
}

/* Matches a path with a pattern. A variable stands between two slashes; {file} is the rest of the
 * path, slashes included; {room} is a room's code and nothing else. On success *argument and *bytes
 * receive the part from the first variable to the end of the last one, or NULL if there is none. */
static int router_match(const char *pattern, const char *path, const char **argument,
                        size_t *bytes) {
    char code[SRV_CLASS_CODE];
    *argument = NULL;
    *bytes = 0;
    while (*pattern) {
        size_t fixed = strcspn(pattern, "{");
        if (strncmp(pattern, path, fixed)) return 0;
        pattern += fixed;
        path += fixed;
        if (!*pattern) break;
        size_t name = strcspn(pattern, "}") + 1,
               part = !strcmp(pattern, "{file}") ? strlen(path) : strcspn(path, "/");
        if (!part || (!strcmp(pattern, "{room}") && !srv_class_request_read_code(path, code)))
            return 0;
        if (!*argument) *argument = path;
        pattern += name;
        path += part;
        *bytes = (size_t)(path - *argument);
    }
    return !*path;
}

/* Returns 1 if the route supports QUERY too: it only computes and changes nothing. */
static int router_queried(const struct srv_route *route) {
    return !strcmp(route->method, "POST") && route->op != API_OP_COUNT;
}

static int router_serves(const struct srv_route *route, const char *method) {
    if (!strcmp(route->method, method)) return 1;
    if (!strcmp(method, "QUERY")) return router_queried(route);
    return !strcmp(route->method, "GET") && !strcmp(method, "HEAD");
}

static void router_allow_add(char allow[ROUTER_ALLOW], const char *method) {
    size_t bytes = strlen(allow);
    snprintf(allow + bytes, ROUTER_ALLOW - bytes, "%s%s", bytes ? ", " : "", method);
}

/* Lists the methods of a path, except routes with a property in `without`; "" if the path does not
 * exist. */
static void router_allow(const char *path, unsigned without, char allow[ROUTER_ALLOW]) {
    const char *argument;
    size_t bytes;
    int any = 0;
    allow[0] = 0;
    for (int i = 0; i < ROUTER_COUNT; i++) {
        if (!router_match(router_table[i].pattern, path, &argument, &bytes)) continue;
        any = 1;
        if (router_table[i].special & without) continue;
        router_allow_add(allow, router_table[i].method);
        if (!strcmp(router_table[i].method, "GET")) router_allow_add(allow, "HEAD");
        if (router_queried(&router_table[i])) router_allow_add(allow, "QUERY");
    }
    if (any) router_allow_add(allow, "OPTIONS");
}

/* Finds the route of a method and a path, and its variable part as router_match does; NULL if
 * there is none. */
static const struct srv_route *router_route(const char *method, const char *path,
                                            const char **argument, size_t *bytes) {
    for (int i = 0; i < ROUTER_COUNT; i++)
        if (router_serves(&router_table[i], method) &&
            router_match(router_table[i].pattern, path, argument, bytes))
            return &router_table[i];
    return NULL;
}

/* Returns 1 for a request from a web page of an origin that is not listed. */
static int router_foreign(const struct srv_exchange *exchange) {
    return srv_cors_foreign(srv_service_config(exchange->service)->cors_origins,
                            exchange->field[SRV_ORIGIN], exchange->field[SRV_FETCH_SITE],
                            exchange->host);
}

/* Answers OPTIONS; tells a browser's preflight which method and fields the page may use. */
static void router_options(struct srv_exchange *exchange) {
    const char *argument, *method = exchange->field[SRV_PREFLIGHT];
    size_t bytes;
    srv_exchange_static(exchange, 204, NULL, NULL, 0);
    if (!exchange->field[SRV_ORIGIN] || !method) return;
    char *methods = srv_exchange_text(exchange, ROUTER_ALLOW);
    if (!methods) return;
    const struct srv_route *route = router_route(method, exchange->path, &argument, &bytes);
    exchange->closed = route && (route->special & SRV_ROUTE_CLOSED);
    router_allow(exchange->path, router_foreign(exchange) ? SRV_ROUTE_CLOSED : 0, methods);
    srv_exchange_header(exchange, "Access-Control-Allow-Methods", methods);
    srv_exchange_header(exchange, "Access-Control-Allow-Headers", srv_cors_fields);
    srv_exchange_header(exchange, "Access-Control-Max-Age", "86400");
}

/* Returns the pattern that an unknown path probably meant, or NULL. Tries the path without a slash
 * at its end, then its last segment under /v1; both may be misspelt or a synonym. */
static const char *router_meant(const char *path) {
    const char *patterns[ROUTER_COUNT + 1] = {0}, *last = strrchr(path, '/');
    char whole[ROUTER_PATH];
    size_t bytes = strlen(path);
    if (bytes + sizeof "/v1" > sizeof whole || !last) return NULL;
    if (!last[1]) bytes--;
    for (int i = 0; i < ROUTER_COUNT; i++) patterns[i] = router_table[i].pattern;
    snprintf(whole, sizeof whole, "%.*s", (int)bytes, path);
    const char *meant = api_did_you_mean(whole, patterns);
    if (meant && strlen(meant) > 4) return meant;
    last = strrchr(whole, '/');
    if (!last || strlen(last) < 4) return NULL;
    char under[ROUTER_PATH];
    snprintf(under, sizeof under, "/v1%s", last);
    return api_did_you_mean(under, patterns);
}

static int router_exists(struct srv_exchange *exchange) {
    if (exchange->route) return 1;
    if (exchange->probes) {
        srv_exchange_problem(exchange, 404,
                             "this address answers only GET /healthz, /readyz, /version and "
                             "/metrics: see the option --probe-listen");
        return 0;
    }
    char *allow = srv_exchange_text(exchange, ROUTER_ALLOW);
    if (!allow) {
        srv_exchange_problem(exchange, 431, "the request's head is too long");
        return 0;
    }
    router_allow(exchange->path, 0, allow);
    int options = !strcmp(exchange->method, "OPTIONS");
    if (options && !strcmp(exchange->path, "*"))
        strcpy(allow, "GET, HEAD, POST, PUT, QUERY, DELETE, OPTIONS");
    if (!allow[0]) {
        const char *meant = router_meant(exchange->path);
        srv_exchange_problem(exchange, 404, "there is nothing at %.200s; %s%s%s", exchange->path,
                             meant ? "did you mean " : "see /openapi.json", meant ? meant : "",
                             meant ? "?" : "");
        return 0;
    }
    if (options)
        router_options(exchange);
    else
        srv_exchange_problem(exchange, 405, "%.40s is not allowed for %.200s: use %s",
                             exchange->method, exchange->path, allow);
    srv_exchange_header(exchange, "Allow", allow);
    return 0;
}

/* Copies the variable part of the path. Returns 0 if memory is short. */
static int router_argument(struct srv_exchange *exchange, const char *argument, size_t bytes) {
    exchange->argument = argument;
    if (!argument || !argument[bytes]) return 1;
    char *text = srv_exchange_text(exchange, bytes + 1);
    if (!text) return 0;
    memcpy(text, argument, bytes);
    text[bytes] = 0;
    exchange->argument = text;
    return 1;
}

/* --- stages --- */

/* Passes an exchange unless it was refused while its head was read, for a repeated field or too
 * many connections. */
static int router_unrefused(struct srv_exchange *exchange) { return !exchange->status; }

static int router_find(struct srv_exchange *exchange) {
    const char *argument = NULL;
    size_t bytes = 0;
    const struct srv_route *route =
        router_route(exchange->method, exchange->path, &argument, &bytes);
    if (exchange->probes && route && !(route->special & SRV_ROUTE_PROBE)) route = NULL;
    exchange->route = route;
    exchange->op = route ? route->op : API_OP_COUNT;
    if (!route || router_argument(exchange, argument, bytes)) return 1;
    srv_exchange_problem(exchange, 431, "the request's head is too long");
    return 0;
}

/* Answers 421 if the request names a host that the server does not accept. */
static int router_host(struct srv_exchange *exchange) {
    unsigned special = exchange->route ? exchange->route->special : 0;
    if ((special & SRV_ROUTE_ANY_HOST) || exchange->probes) return 1;
    if ((special & SRV_ROUTE_ANY_ADDRESS) && srv_hosts_numeric(exchange->host)) return 1;
    if (srv_hosts_allow(srv_service_hosts(exchange->service), exchange->host)) return 1;
    srv_exchange_problem(exchange, 421,
                         "this server does not answer to the host %.100s: the option --hosts lists "
                         "the allowed names",
                         exchange->host);
    return 0;
}

/* Returns 1 if the route computes, at once or as a job. */
static int router_computes(const struct srv_route *route) {
    return !route->handle && !route->begin;
}

/* Answers 401 or 403 if the client's role does not allow the route. Without a key file there are
 * no roles. */
static int router_may(struct srv_exchange *exchange) {
    const struct srv_identity *identity = &exchange->identity;
    const double *limit = identity->limits.value;
    unsigned special = exchange->route->special;
    int computes = router_computes(exchange->route),
        jobs = exchange->route->begin == srv_job_results;
    if (identity->role == SRV_ROLE_NONE || exchange->probes) return 1;
    if ((special & SRV_ROUTE_OPERATOR) && identity->role != SRV_ROLE_OPERATOR)
        srv_admission_forbid(exchange, SRV_ROLE_OPERATOR,
                             "only the operator of the server may do this");
    else if ((computes || (special & SRV_ROUTE_COUNTED)) && limit[SRV_LIMIT_REQUESTS] <= 0)
        srv_admission_forbid(exchange, SRV_ROLE_PUPIL, "this role may not send requests here");
    else if ((computes || jobs) && limit[SRV_LIMIT_COMPUTE] <= 0)
        srv_admission_forbid(exchange, SRV_ROLE_PUPIL, "this role may not compute here");
    else if (srv_jobs_wanted(exchange) && limit[SRV_LIMIT_JOBS] <= 0)
        srv_admission_forbid(exchange, SRV_ROLE_TEACHER, "this role may not post jobs");
    else
        return 1;
    return 0;
}

/* Returns true if the body is a form of files, which a page may send without a preflight even where
 * a preflight would be refused. */
static int router_form(const struct srv_exchange *exchange) {
    static const char form[] = "multipart/form-data";
    const char *type = exchange->field[SRV_CONTENT_TYPE];
    return type && !strncasecmp(type, form, sizeof form - 1) &&
           !srv_cors_origin(srv_service_config(exchange->service)->cors_origins,
                            exchange->field[SRV_ORIGIN], 0);
}

/* Answers 403 if a web page of another origin may not use the route. */
static int router_origin(struct srv_exchange *exchange) {
    int job = srv_jobs_wanted(exchange);
    exchange->closed = (exchange->route->special & SRV_ROUTE_CLOSED) != 0;
    int kept = exchange->closed || job || router_form(exchange);
    if (!kept || !router_foreign(exchange)) {
        exchange->closed |= job;
        return 1;
    }
    srv_exchange_problem(
        exchange, 403,
        API_TYPE_ORIGIN
        "a web page of the origin %.100s may only compute and read by id: the option cors-origins "
        "lists pages that may create, list and end jobs and scenes, and use classrooms",
        exchange->field[SRV_ORIGIN]);
    return 0;
}

/* Answers 503 if this process does not serve the route, or no longer does. */
static int router_role(struct srv_exchange *exchange) {
    const struct srv_route *route = exchange->route;
    const struct srv_service *service = exchange->service;
    if (route->handle) return 1;
    if (!srv_config_answers(&service->config)) {
        srv_exchange_busy(exchange, 60, "this process only computes jobs: --role worker");
        return 0;
    }
    if (route->begin || atomic_load(&service->draining) < SRV_DRAIN_HURRY) return 1;
    srv_exchange_busy(exchange, 5, "the server is stopping");
    exchange->close = 1;
    return 0;
}

/* Answers 429 if the route counts against the client's quota, which is used up. */
static int router_quota(struct srv_exchange *exchange) {
    const struct srv_route *route = exchange->route;
    if (!router_computes(route) && !(route->special & SRV_ROUTE_COUNTED)) return 1;
    return srv_admission_count(exchange);
}

static int router_handle(struct srv_exchange *exchange) {
    if (!exchange->route->handle) return 1;
    exchange->route->handle(exchange);
    return 0;
}

static int router_cache(struct srv_exchange *exchange) {
    return exchange->route->begin || srv_jobs_wanted(exchange) || !srv_result_cached(exchange);
}

/* A stage passes an exchange on, returning 1, or answers it, returning 0. It runs on the sockets'
 * thread: it neither waits nor computes. */
typedef int router_stage(struct srv_exchange *exchange);

/* The stages that need only a request's head, in order. */
static router_stage *const router_head[] = {
    srv_admission_identify, /* identity of the client; every request passes */
    router_unrefused,
    srv_request_head_head, /* 400, 413, 414, 415, 417: length of the body, target */
    router_find,
    router_host,         /* 421 */
    srv_admission_named, /* 400, 401: invalid account or token */
    router_exists,       /* 404, 405, OPTIONS */
    router_may,          /* 401, 403: role */
    router_origin,       /* 403 */
    router_role,         /* 503 */
    router_quota,        /* 429 */
};

/* The stages that need the body, in order. An exchange that passes them goes to its route. */
static router_stage *const router_body[] = {
    router_handle,
    router_cache,
};

static int router_pass(struct srv_exchange *exchange, router_stage *const stage[], size_t count) {
    assert(srv_exchange_valid(exchange));
    for (size_t i = 0; i < count; i++) {
        int passed = stage[i](exchange);
        assert(passed || exchange->status);
        if (!passed) return 0;
    }
    assert(!exchange->status);
    return 1;
}

int srv_router_head(struct srv_exchange *exchange) {
    return router_pass(exchange, router_head, sizeof router_head / sizeof *router_head);
}

int srv_router_body(struct srv_exchange *exchange) {
    assert(exchange->route);
    return router_pass(exchange, router_body, sizeof router_body / sizeof *router_body);
}

void srv_router_hand(struct srv_exchange *exchange) {
    const struct srv_route *route = exchange->route;
    assert(route && !route->handle && !exchange->status);
    if (route->begin)
        route->begin(exchange);
    else if (srv_jobs_wanted(exchange))
        srv_jobs_submit(exchange);
    else
        srv_compute_begin(exchange);
}
