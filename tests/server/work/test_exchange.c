/* Tests of server/work/exchange, server/http/request_head and server/http/router: an exchange's
 * way without a socket. */
#include "server/work/exchange.h"

#include <stdio.h>
#include <string.h>

#include "server/http/request_head.h"
#include "server/http/router.h"
#include "tests/harness/test.h"
#include "tests/server/live.h"

/* the body of the answer as text */
static const char *answer_text(const struct srv_exchange *exchange, char text[2048]) {
    snprintf(text, 2048, "%.*s", (int)exchange->bytes, exchange->data ? exchange->data : "");
    return text;
}

static const char *answer_header(const struct srv_exchange *exchange, const char *name) {
    for (int i = 0; i < exchange->headers; i++)
        if (!strcmp(exchange->header[i].name, name)) return exchange->header[i].value;
    return NULL;
}

/* reads a head; returns 1 when the exchange goes on */
static int answer_head(struct srv_exchange *exchange, const char *method, const char *target) {
    srv_exchange_reset(exchange);
    exchange->method = method;
    snprintf(exchange->target, sizeof exchange->target, "%s", target);
    return srv_request_head_head(exchange);
}

/* a route's answer, or 0 where it needs a worker */
static int answer_route(struct srv_exchange *exchange, const char *method, const char *target) {
    srv_exchange_reset(exchange);
    exchange->method = method;
    snprintf(exchange->target, sizeof exchange->target, "%s", target);
    return srv_router_head(exchange) && srv_router_body(exchange) ? 0 : exchange->status;
}

TEST(a_problem_replaces_the_answer_and_is_not_stored) {
    struct srv_service service;
    struct srv_exchange exchange;
    char text[2048];
    live_service(&service, 4);
    srv_exchange_init(&exchange, &service);
    CHECK(api_buffer_text(&exchange.answer, "half an answer") == PEND_OK);
    srv_exchange_header(&exchange, "Allow", "GET");
    srv_exchange_problem(&exchange, 404, "no \"%s\" here", "x");
    CHECK_INT(exchange.status, 404);
    CHECK_TEXT(exchange.media_type, "application/problem+json");
    CHECK_TEXT(answer_text(&exchange, text),
               "{\"type\":\"about:blank\",\"title\":\"Not Found\",\"status\":404,"
               "\"detail\":\"no \\\"x\\\" here\"}");
    CHECK_TEXT(answer_header(&exchange, "Cache-Control"), "no-store");
    CHECK(!answer_header(&exchange, "Allow"));
    srv_exchange_busy(&exchange, 7, "later");
    CHECK_INT(exchange.status, 503);
    CHECK_TEXT(answer_header(&exchange, "Retry-After"), "7");
    CHECK(srv_exchange_valid(&exchange));
    srv_exchange_reset(&exchange);
    CHECK(srv_exchange_valid(&exchange) && !exchange.status && !exchange.bytes &&
          !exchange.headers);
    srv_exchange_clear(&exchange);
    CHECK(!srv_exchange_valid(&exchange));
    live_service_clear(&service);
}

TEST(a_problem_needs_no_memory) {
    struct srv_service service;
    struct srv_exchange exchange;
    char text[2048];
    live_service(&service, 4);
    srv_exchange_init(&exchange, &service);
    test_alloc_fail(1, 1);
    srv_exchange_problem(&exchange, 404, "nothing");
    test_alloc_faults_off();
    CHECK_INT(exchange.status, 503);
    CHECK(strstr(answer_text(&exchange, text), "out of memory") != NULL);
    srv_exchange_clear(&exchange);
    live_service_clear(&service);
}

TEST(held_bytes_are_counted_and_bounded) {
    struct srv_service service;
    struct srv_exchange one, two;
    live_service(&service, 4);
    service.config.held_bytes = service.config.client_held_bytes = 100;
    srv_exchange_init(&one, &service);
    srv_exchange_init(&two, &service);
    CHECK_INT(srv_exchange_hold(&one, 60), SRV_ROOM);
    CHECK_INT(srv_exchange_hold(&two, 40), SRV_ROOM);
    CHECK_INT(srv_exchange_hold(&two, 41), SRV_ROOM_NONE);
    CHECK_INT(srv_exchange_hold(&one, 10), SRV_ROOM);
    CHECK_INT(srv_exchange_hold(&two, 42), SRV_ROOM);
    CHECK_INT(srv_exchange_hold(&two, 101), SRV_ROOM_NEVER);
    CHECK_INT(srv_exchange_hold(&two, 42), SRV_ROOM);
    CHECK_INT(srv_memory_all(&service.memory), 52);
    srv_exchange_reset(&one);
    CHECK_INT(srv_memory_all(&service.memory), 42);
    srv_exchange_clear(&two);
    srv_exchange_clear(&one);
    CHECK_INT(srv_memory_all(&service.memory), 0);
    live_service_clear(&service);
}

TEST(a_client_holds_no_more_than_its_share_and_others_the_rest) {
    struct srv_service service;
    struct srv_exchange one, two, other;
    char text[2048];
    live_service(&service, 4);
    service.config.held_bytes = 4 << 20;
    service.config.client_held_bytes = 1 << 20;
    struct srv_exchange *each[] = {&one, &two, &other};
    for (int i = 0; i < 3; i++) {
        srv_exchange_init(each[i], &service);
        char address[40];
        snprintf(address, sizeof address, "2001:db8:0:%d::%d", i == 2, i);
        CHECK(srv_identity_begin(&each[i]->identity, address, NULL));
    }
    /* two addresses of one network; their bodies have half of the share, small ones all of it */
    CHECK_INT(srv_exchange_hold(&one, 400000), SRV_ROOM);
    CHECK_INT(srv_exchange_hold(&two, 200000), SRV_ROOM_CLIENT);
    CHECK_INT(srv_exchange_hold(&two, 60000), SRV_ROOM);
    CHECK_INT(srv_exchange_hold(&other, 400000), SRV_ROOM);
    CHECK_INT(srv_exchange_hold(&other, 1100000), SRV_ROOM_NEVER);
    srv_exchange_crowded(&two, SRV_ROOM_CLIENT, "the body");
    CHECK_INT(two.status, 429);
    CHECK(strstr(answer_text(&two, text), "max-client-held-bytes") &&
          answer_header(&two, "Retry-After"));
    srv_exchange_crowded(&other, SRV_ROOM_NEVER, "the body");
    CHECK_INT(other.status, 413);
    srv_exchange_crowded(&other, SRV_ROOM_NONE, "the body");
    CHECK(other.status == 503 && answer_header(&other, "Retry-After"));
    for (int i = 0; i < 3; i++) srv_exchange_clear(each[i]);
    CHECK_INT(srv_memory_all(&service.memory), 0);
    live_service_clear(&service);
}

TEST(small_texts_end_where_their_room_does) {
    struct srv_service service;
    struct srv_exchange exchange;
    live_service(&service, 4);
    srv_exchange_init(&exchange, &service);
    char *first = srv_exchange_text(&exchange, 10),
         *second = srv_exchange_text(&exchange, SRV_TEXT_BYTES - 10);
    CHECK(first && second == first + 10);
    CHECK(!srv_exchange_text(&exchange, 1));
    CHECK(srv_exchange_text(&exchange, 0) != NULL);
    srv_exchange_reset(&exchange);
    CHECK(srv_exchange_text(&exchange, SRV_TEXT_BYTES) != NULL);
    srv_exchange_clear(&exchange);
    live_service_clear(&service);
}

TEST(fields_are_taken_in_by_name_in_any_case) {
    struct srv_service service;
    struct srv_exchange exchange;
    live_service(&service, 4);
    srv_exchange_init(&exchange, &service);
    CHECK(srv_request_head_field(&exchange, "content-TYPE", "a/b"));
    CHECK(srv_request_head_field(&exchange, "Unknown", "x"));
    CHECK(srv_request_head_field(&exchange, "Accept", "text/csv"));
    CHECK(srv_request_head_field(&exchange, "accept", "application/json;q=0.5"));
    CHECK(srv_request_head_field(&exchange, "User-Agent", "one"));
    CHECK(srv_request_head_field(&exchange, "User-Agent", "two"));
    CHECK_TEXT(exchange.field[SRV_CONTENT_TYPE], "a/b");
    CHECK_TEXT(exchange.field[SRV_ACCEPT], "text/csv, application/json;q=0.5");
    CHECK_TEXT(exchange.field[SRV_USER_AGENT], "two");
    CHECK(!exchange.field[SRV_EXPECT]);
    CHECK(!srv_request_head_field(&exchange, "Content-Type", "c/d"));
    CHECK_INT(exchange.status, 400);
    srv_exchange_reset(&exchange);
    char large[SRV_TEXT_BYTES + 1];
    memset(large, 'a', SRV_TEXT_BYTES);
    large[SRV_TEXT_BYTES] = 0;
    CHECK(srv_request_head_field(&exchange, "Accept", large));
    CHECK(!srv_request_head_field(&exchange, "Accept", "b"));
    CHECK_INT(exchange.status, 431);
    srv_exchange_clear(&exchange);
    live_service_clear(&service);
}

TEST(targets_are_taken_apart) {
    static const struct {
        const char *target, *path, *query;
    } good[] = {
        {"/", "/", NULL},
        {"/a/b", "/a/b", NULL},
        {"/a?b=c?d", "/a", "b=c?d"},
        {"/a?", "/a", ""},
        {"*", "*", NULL},
        {"http://host", "/", NULL},
        {"http://host?q", "/", "q"},
        {"HTTP://host:80/a?q", "/a", "q"},
        {"https://[::1]/a", "/a", NULL},
        {"/%61%20%C3%a9%25", "/a \xc3\xa9%", NULL},
        {"/a%2fb%2F", "/a%2fb%2F", NULL},
        {"/a?%zz", "/a", "%zz"},
    };
    static const char *const bad[] = {
        "/%",      "/%0",      "/%zz", "/%00", "/%0a", "/%7F",  "a",           "ftp://a/b",
        "http://", "http:///", "a:80", "/a#b", "/\"",  "/a\\b", "http://u@h/", "http://u:p@h/a"};
    struct srv_service service;
    struct srv_exchange exchange;
    live_service(&service, 4);
    srv_exchange_init(&exchange, &service);
    for (size_t i = 0; i < sizeof good / sizeof *good; i++) {
        if (!CHECK_SAYING(answer_head(&exchange, "GET", good[i].target), "%s is refused",
                          good[i].target))
            continue;
        CHECK_TEXT(exchange.path, good[i].path);
        CHECK_TEXT(exchange.query, good[i].query);
    }
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        CHECK_SAYING(!answer_head(&exchange, "GET", bad[i]), "%s is accepted", bad[i]);
        CHECK_INT(exchange.status, 400);
    }
    srv_exchange_clear(&exchange);
    live_service_clear(&service);
}

TEST(lengths_and_expectations_are_checked) {
    struct srv_service service;
    struct srv_exchange exchange;
    live_service(&service, 4);
    service.config.limits.body_bytes = 100;
    srv_exchange_init(&exchange, &service);
    static const struct {
        const char *name, *value;
        int status;
        long long length;
    } heads[] = {
        {"Content-Length", "100", 0, 100}, {"Content-Length", "101", 413, 101},
        {"Content-Length", "0", 0, 0},     {"Transfer-Encoding", "chunked", 0, -1},
        {"Expect", "100-Continue", 0, 0},  {"Expect", "200-ok", 417, 0},
    };
    for (size_t i = 0; i < sizeof heads / sizeof *heads; i++) {
        srv_exchange_reset(&exchange);
        exchange.method = "POST";
        strcpy(exchange.target, "/");
        CHECK(srv_request_head_field(&exchange, heads[i].name, heads[i].value));
        CHECK_INT(srv_request_head_head(&exchange), !heads[i].status);
        CHECK_INT(exchange.status, heads[i].status);
        CHECK_INT(exchange.length, heads[i].length);
    }
    srv_exchange_clear(&exchange);
    live_service_clear(&service);
}

/* a path of the pattern: each variable is a%20b; and what the variables are read as, NULL
 * without any */
static const char *answer_fill(const char *pattern, char path[128], char argument[128]) {
    int variables = 0;
    char *at = path;
    for (; *pattern; pattern++) {
        if (*pattern != '{') {
            *at++ = *pattern;
            continue;
        }
        at += sprintf(at, "a%%20b");
        pattern = strchr(pattern, '}');
        variables++;
    }
    *at = 0;
    strcpy(argument, variables > 1 ? "a b/a b" : "a b");
    return variables ? argument : NULL;
}

TEST(every_row_of_the_route_table_is_found) {
    struct srv_service service;
    struct srv_exchange exchange;
    live_service(&service, 4);
    srv_exchange_init(&exchange, &service);
    for (int i = 0; srv_router_row(i); i++) {
        const struct srv_route *route = srv_router_row(i);
        char path[128], filled[128];
        const char *argument = answer_fill(route->pattern, path, filled);
        /* two variables are a file's path: found, but of that name there is none */
        int rest = argument && strchr(argument, '/');
        int status = answer_route(&exchange, route->method, path);
        CHECK_SAYING(exchange.route == route, "%s leads elsewhere", path);
        CHECK_INT(status, !route->handle ? 0 : rest ? 404 : 200);
        CHECK_TEXT(exchange.argument, argument);
        /* a query changes nothing, one more part does, but where it is a file's */
        strcat(path, "?q");
        answer_route(&exchange, route->method, path);
        CHECK(exchange.route == route);
        strcpy(strchr(path, '?'), "/x/y");
        CHECK_INT(answer_route(&exchange, route->method, path), 404);
        CHECK((exchange.route == route) == rest);
    }
    CHECK(!srv_router_row(-1) && srv_router_row(8) != NULL);
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
        {"OPTIONS", "*", 204, "GET, HEAD, POST, QUERY, DELETE, OPTIONS"},
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
        /* the form of the head before who asks, who asks before the route, the quota last */
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
