#include "server/http/router.h"

#include <stdio.h>
#include <string.h>

#include "tests/harness/test.h"
#include "tests/server/live.h"

static const char *answer_header(const struct srv_exchange *exchange, const char *name) {
    for (int i = 0; i < exchange->headers; i++)
        if (!strcmp(exchange->header[i].name, name)) return exchange->header[i].value;
    return NULL;
}

/* a route's answer, or 0 if it needs a worker */
static int answer_route(struct srv_exchange *exchange, const char *method, const char *target) {
    srv_exchange_reset(exchange);
    exchange->method = method;
    snprintf(exchange->target, sizeof exchange->target, "%s", target);
    return srv_router_head(exchange) && srv_router_body(exchange) ? 0 : exchange->status;
}

/* a path of the pattern: each variable is a%20b, a room a code; and the text that is read as
 * variables, from the first to the end of the last, NULL if there are none */
static const char *answer_fill(const char *pattern, char path[128], char argument[128]) {
    int variables = 0, room = strstr(pattern, "{room}") != NULL;
    char *at = path, *read = argument, *last = argument;
    for (; *pattern; pattern++) {
        if (*pattern != '{') {
            *at++ = *pattern;
            if (variables) *read++ = *pattern;
            continue;
        }
        at += sprintf(at, "%s", room ? "PK7TRA" : "a%20b");
        read += sprintf(read, "%s", room ? "PK7TRA" : "a b");
        last = read;
        pattern = strchr(pattern, '}');
        variables++;
    }
    *at = 0;
    *last = 0;
    return variables ? argument : NULL;
}

TEST(every_row_of_the_route_table_is_found) {
    struct srv_service service;
    struct srv_exchange exchange;
    live_service(&service, 4);
    srv_exchange_init(&exchange, &service);
    for (int i = 0; srv_router_label(i); i++) {
        char method[16], pattern[128], path[128], filled[128];
        REQUIRE(sscanf(srv_router_label(i), "%15s %127s", method, pattern) == 2);
        const char *argument = answer_fill(pattern, path, filled);
        /* the path of a file exists, but no file of this name; a room's path leads to the page;
         * embedding requires a link in the query */
        int rest = strstr(pattern, "{file}") != NULL, room = strstr(pattern, "{room}") != NULL,
            link = !strcmp(pattern, "/oembed");
        int status = answer_route(&exchange, method, path);
        const struct srv_route *route = exchange.route;
        CHECK_SAYING(srv_router_number(route) == i, "%s leads elsewhere", path);
        REQUIRE(route);
        CHECK_TEXT(route->method, method);
        CHECK_TEXT(route->pattern, pattern);
        CHECK_INT(status, !route->handle ? 0 : rest ? 404 : room ? 302 : link ? 422 : 200);
        CHECK_TEXT(exchange.argument, argument);
        /* a query does not change the route; four more segments do, except for a file */
        strcat(path, "?q");
        answer_route(&exchange, route->method, path);
        CHECK(exchange.route == route);
        strcpy(strchr(path, '?'), "/x/y/z/w");
        CHECK_INT(answer_route(&exchange, route->method, path), 404);
        CHECK((exchange.route == route) == rest);
    }
    CHECK(!srv_router_label(-1) && srv_router_label(8) != NULL);
    srv_exchange_clear(&exchange);
    live_service_clear(&service);
}

TEST(methods_that_a_path_does_not_have_are_told_those_it_has) {
    static const struct {
        const char *method, *path;
        int status;
        const char *allow;
    } asked[] = {
        {"GET", "/v1/trees", 405, "POST, QUERY, OPTIONS"},
        {"HEAD", "/v1/trees", 405, "POST, QUERY, OPTIONS"},
        {"PUT", "/v1/jobs/x", 405, "GET, HEAD, DELETE, OPTIONS"},
        {"POST", "/v1/jobs/x/results", 405, "GET, HEAD, OPTIONS"},
        {"GET", "/v1/jobs/x/nothing", 404, NULL},
        {"GET", "/v1/jobs//results", 404, NULL},
        {"DELETE", "/healthz", 405, "GET, HEAD, OPTIONS"},
        {"get", "/healthz", 405, "GET, HEAD, OPTIONS"},
        {"POST", "/v1/presets/x", 405, "GET, HEAD, OPTIONS"},
        {"OPTIONS", "/v1/presets/x", 204, "GET, HEAD, OPTIONS"},
        {"OPTIONS", "/v1/trees", 204, "POST, QUERY, OPTIONS"},
        {"OPTIONS", "*", 204, "GET, HEAD, POST, PUT, QUERY, DELETE, OPTIONS"},
        {"GET", "*", 404, NULL},
        {"OPTIONS", "/nowhere", 404, NULL},
        {"GET", "/v1/presets/", 404, NULL},
        {"GET", "/v1/presets/a/b", 404, NULL},
        {"GET", "/v1", 404, NULL},
        {"GET", "/HEALTHZ", 404, NULL},
        {"GET", "/healthz/", 404, NULL},
        {"HEAD", "/healthz", 200, NULL},
    };
    struct srv_service service;
    struct srv_exchange exchange;
    live_service(&service, 4);
    srv_exchange_init(&exchange, &service);
    for (size_t i = 0; i < sizeof asked / sizeof *asked; i++) {
        int status = answer_route(&exchange, asked[i].method, asked[i].path);
        CHECK_SAYING(status == asked[i].status, "%s %s: %d", asked[i].method, asked[i].path,
                     status);
        CHECK_TEXT(answer_header(&exchange, "Allow"), asked[i].allow);
    }
    srv_exchange_clear(&exchange);
    live_service_clear(&service);
}

TEST(a_drain_answers_what_comes_until_it_is_in_a_hurry) {
    struct srv_service service;
    struct srv_exchange exchange;
    live_service(&service, 4);
    srv_exchange_init(&exchange, &service);
    CHECK_INT(answer_route(&exchange, "GET", "/readyz"), 200);
    CHECK(strstr(exchange.data, "\"status\":\"ready\""));
    CHECK_INT(answer_route(&exchange, "GET", "/readyz?need=jobs"), 503);
    CHECK_INT(answer_route(&exchange, "GET", "/readyz?need=tea"), 422);
    atomic_store(&service.draining, SRV_DRAIN_LAST);
    CHECK_INT(answer_route(&exchange, "POST", "/v1/trees"), 0);
    atomic_store(&service.draining, SRV_DRAIN_HURRY);
    CHECK_INT(answer_route(&exchange, "GET", "/readyz"), 503);
    CHECK(answer_header(&exchange, "Retry-After") != NULL);
    CHECK_INT(answer_route(&exchange, "GET", "/healthz"), 200);
    CHECK_INT(answer_route(&exchange, "POST", "/v1/trees"), 503);
    CHECK(exchange.close && answer_header(&exchange, "Retry-After"));
    CHECK_INT(answer_route(&exchange, "GET", "/v1/trees"), 405);
    srv_exchange_clear(&exchange);
    live_service_clear(&service);
}

TEST(the_stages_of_a_request_answer_in_their_order_and_each_knows_who_asks) {
    static const struct {
        const char *method, *target, *authorization;
        int status;
    } asked[] = {
        /* the order of checks: form of the head, client, route, quota */
        {"GET", "/%zz", "Bearer short", 400},
        {"GET", "/nothing", "Bearer short", 401},
        {"GET", "/nothing", NULL, 404},
        {"PUT", "/v1/trees", NULL, 405},
        {"GET", "/v1/presets", NULL, 0},
        {"GET", "/v1/presets", NULL, 429},
        {"GET", "/v1/jobs/x/results", NULL, 429},
        {"GET", "/v1/jobs/x", NULL, 0},
        {"GET", "/healthz", NULL, 200},
        {"GET", "/v1/presets", "Bearer 3f1c9a5b7d2e4f60819a2b3c4d5e6f70", 0},
    };
    struct srv_service service;
    struct srv_exchange exchange;
    live_service(&service, 4);
    service.config.requests_a_minute = 1;
    srv_exchange_init(&exchange, &service);
    snprintf(exchange.peer, sizeof exchange.peer, "192.0.2.1");
    for (size_t i = 0; i < sizeof asked / sizeof *asked; i++) {
        srv_exchange_reset(&exchange);
        exchange.method = asked[i].method;
        exchange.field[SRV_AUTHORIZATION] = asked[i].authorization;
        snprintf(exchange.target, sizeof exchange.target, "%s", asked[i].target);
        int passed = srv_router_head(&exchange) && srv_router_body(&exchange);
        CHECK_SAYING(passed == !asked[i].status && exchange.status == asked[i].status,
                     "%s %s is %d", asked[i].method, asked[i].target, exchange.status);
        CHECK_TEXT(exchange.identity.shown, "192.0.2.1");
        CHECK_INT(exchange.identity.kind, i == 9 ? SRV_IDENTITY_TOKEN : SRV_IDENTITY_ADDRESS);
    }
    srv_exchange_clear(&exchange);
    live_service_clear(&service);
}
