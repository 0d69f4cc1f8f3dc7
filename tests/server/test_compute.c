#include "server/compute.h"

#include <string.h>

#include "server/router.h"
#include "server/workers.h"
#include "tests/harness/server.h"
#include "tests/harness/test.h"
#include "tests/server/live.h"

static atomic_int compute_finished;

static void compute_finish(struct srv_exchange *exchange) {
    (void)exchange;
    atomic_fetch_add(&compute_finished, 1);
}

/* an exchange that posts a body to a path, ready for the queue */
static void compute_post(struct srv_exchange *exchange, struct srv_service *service, const char *path,
                         const char *body) {
    srv_exchange_init(exchange, service);
    exchange->finish = compute_finish;
    exchange->method = "POST";
    exchange->path = path;
    exchange->field[SRV_CONTENT_TYPE] = "application/json";
    CHECK(srv_router_find(exchange) && api_buffer_text(&exchange->body, body) == PEND_OK);
}

static int compute_await(int count) {
    for (double until = test_clock() + 10; test_clock() < until && compute_finished < count;) test_sleep(0.001);
    return compute_finished == count;
}

TEST(a_computed_exchange_comes_back_answered) {
    struct srv_service service;
    struct srv_workers *workers;
    struct srv_exchange exchange;
    live_service(&service, 4);
    atomic_store(&compute_finished, 0);
    REQUIRE(srv_workers_new(&workers, 1, service.queue) == PEND_OK);
    compute_post(&exchange, &service, "/v1/trees", LIVE_SHORT);
    srv_compute_queue(&exchange);
    CHECK(compute_await(1));
    srv_workers_free(&workers);
    CHECK_INT(exchange.status, 200);
    CHECK_TEXT(exchange.media_type, "application/json");
    CHECK(exchange.bytes && strstr(exchange.data, "\"subtree_mass\""));
    CHECK(exchange.queued && exchange.begun >= exchange.queued && exchange.computed >= exchange.begun);
    CHECK_INT(service.computing, 0);
    CHECK(service.held > 0);
    srv_exchange_clear(&exchange);
    CHECK_INT(service.held, 0);
    live_service_clear(&service);
}

TEST(a_full_queue_answers_503_at_once) {
    struct srv_service service;
    struct srv_exchange one, two;
    live_service(&service, 1);
    atomic_store(&compute_finished, 0);
    compute_post(&one, &service, "/v1/trees", LIVE_SHORT);
    compute_post(&two, &service, "/v1/trees", LIVE_SHORT);
    CHECK_INT(srv_router_begin(&one), 0);
    srv_compute_queue(&one);
    CHECK_INT(compute_finished, 0);
    /* the router sees it, and the queue itself would */
    CHECK_INT(srv_router_begin(&two), 1);
    CHECK_INT(two.status, 503);
    srv_exchange_clear(&two);
    compute_post(&two, &service, "/v1/trees", LIVE_SHORT);
    srv_compute_queue(&two);
    CHECK_INT(compute_finished, 1);
    CHECK_INT(two.status, 503);
    /* the client of the first goes away while it waits */
    srv_compute_stop(&one, SRV_STOP_LEFT);
    CHECK_INT(compute_finished, 2);
    CHECK_INT(one.status, 503);
    CHECK_INT(service.computing, 0);
    CHECK(srv_queue_valid(service.queue) && !srv_queue_count(service.queue));
    srv_exchange_clear(&one);
    srv_exchange_clear(&two);
    live_service_clear(&service);
}

TEST(a_stopped_computation_ends_within_a_piece_of_its_work) {
    struct srv_service service;
    struct srv_workers *workers;
    struct srv_exchange exchange;
    live_service(&service, 4);
    atomic_store(&compute_finished, 0);
    REQUIRE(srv_workers_new(&workers, 1, service.queue) == PEND_OK);
    compute_post(&exchange, &service, "/v1/trajectories", LIVE_LONG);
    srv_compute_queue(&exchange);
    test_sleep(0.05);
    CHECK_INT(compute_finished, 0);
    double begin = test_clock();
    srv_compute_stop(&exchange, SRV_STOP_SHUTDOWN);
    CHECK(compute_await(1));
    double seconds = test_clock() - begin;
    CHECK_SAYING(seconds < 0.5, "it took %.3f s", seconds);
    srv_workers_free(&workers);
    CHECK_INT(exchange.status, 503);
    CHECK(strstr(exchange.data, "the server is stopping") != NULL);
    srv_exchange_clear(&exchange);
    live_service_clear(&service);
}

TEST(a_computation_that_outruns_its_time_says_so) {
    struct srv_service service;
    struct srv_workers *workers;
    struct srv_exchange exchange;
    live_service(&service, 4);
    service.config.limits.compute_seconds = 0.05;
    atomic_store(&compute_finished, 0);
    REQUIRE(srv_workers_new(&workers, 1, service.queue) == PEND_OK);
    compute_post(&exchange, &service, "/v1/trajectories", LIVE_LONG);
    srv_compute_queue(&exchange);
    CHECK(compute_await(1));
    srv_workers_free(&workers);
    CHECK_INT(exchange.status, 503);
    CHECK(exchange.bytes && strstr(exchange.data, "max-compute-seconds"));
    srv_exchange_clear(&exchange);
    live_service_clear(&service);
}

TEST(an_answer_that_leaves_no_memory_is_503) {
    struct srv_service service;
    struct srv_workers *workers;
    struct srv_exchange exchange;
    live_service(&service, 4);
    service.config.held_bytes = 100;
    atomic_store(&compute_finished, 0);
    REQUIRE(srv_workers_new(&workers, 1, service.queue) == PEND_OK);
    compute_post(&exchange, &service, "/v1/trees", LIVE_SHORT);
    srv_compute_queue(&exchange);
    CHECK(compute_await(1));
    srv_workers_free(&workers);
    CHECK_INT(exchange.status, 503);
    CHECK(exchange.bytes && strstr(exchange.data, "max-held-bytes"));
    srv_exchange_clear(&exchange);
    live_service_clear(&service);
}
