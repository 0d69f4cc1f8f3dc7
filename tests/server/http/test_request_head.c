#include "server/http/request_head.h"

#include <stdio.h>
#include <string.h>

#include "tests/harness/test.h"
#include "tests/server/live.h"

/* reads a head; returns 1 if the exchange continues */
static int answer_head(struct srv_exchange *exchange, const char *method, const char *target) {
    srv_exchange_reset(exchange);
    exchange->method = method;
    snprintf(exchange->target, sizeof exchange->target, "%s", target);
    return srv_request_head_head(exchange);
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
