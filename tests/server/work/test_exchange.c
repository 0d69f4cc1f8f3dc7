#include "server/work/exchange.h"

#include <stdio.h>
#include <string.h>

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
    /* two addresses of one network; their bodies may use half of the share, small ones all */
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
