#include "server/work/compute.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/call/call.h"
#include "server/base/clock.h"
#include "server/http/router.h"
#include "server/protocol/response_body.h"
#include "server/work/admission.h"
#include "server/work/workers.h"
#include "tests/harness/server.h"
#include "tests/harness/test.h"
#include "tests/server/live.h"

static atomic_int compute_finished;

static void compute_finish(struct srv_exchange *exchange) {
    (void)exchange;
    atomic_fetch_add(&compute_finished, 1);
}

/* an exchange that posts a body to a path, ready for the queue */
static void compute_post(struct srv_exchange *exchange, struct srv_service *service,
                         const char *path, const char *body) {
    srv_exchange_init(exchange, service);
    exchange->finish = compute_finish;
    snprintf(exchange->peer, sizeof exchange->peer, "127.0.0.1");
    exchange->method = "POST";
    snprintf(exchange->target, sizeof exchange->target, "%s", path);
    exchange->field[SRV_CONTENT_TYPE] = "application/json";
    CHECK(srv_router_head(exchange) && api_buffer_text(&exchange->body, body) == PEND_OK);
}

static int compute_await(int count) {
    double until = test_clock() + TEST_PATIENCE;
    while (test_clock() < until && compute_finished < count) test_sleep(0.001);
    return compute_finished == count;
}

TEST(a_computed_exchange_comes_back_answered) {
    struct srv_service service;
    struct srv_workers *workers;
    struct srv_exchange exchange;
    live_service(&service, 4);
    atomic_store(&compute_finished, 0);
    REQUIRE(srv_workers_new(&workers, 1, service.queue, &service.fairness) == PEND_OK);
    compute_post(&exchange, &service, "/v1/trees", LIVE_SHORT);
    srv_compute_begin(&exchange);
    CHECK(compute_await(1));
    srv_workers_free(&workers);
    CHECK_INT(exchange.status, 200);
    CHECK_TEXT(exchange.media_type, "application/json");
    CHECK(exchange.bytes && strstr(exchange.data, "\"subtree_mass\""));
    CHECK(exchange.queued && exchange.waited > 0 && exchange.computed > 0);
    CHECK_INT(service.computing, 0);
    CHECK(srv_memory_all(&service.memory) > 0);
    srv_exchange_clear(&exchange);
    /* the cache has the answer */
    CHECK(srv_memory_all(&service.memory) > 0 &&
          srv_memory_all(&service.memory) == (long long)srv_cache_size(service.cache).bodies);
    live_service_clear(&service);
}

TEST(a_full_queue_answers_503_at_once) {
    struct srv_service service;
    struct srv_exchange one, two;
    live_service(&service, 1);
    atomic_store(&compute_finished, 0);
    compute_post(&one, &service, "/v1/trees", LIVE_SHORT);
    compute_post(&two, &service, "/v1/trees", LIVE_SHORT);
    CHECK(srv_router_body(&one));
    srv_compute_begin(&one);
    CHECK_INT(compute_finished, 0);
    CHECK(srv_router_body(&two));
    srv_compute_begin(&two);
    CHECK_INT(compute_finished, 1);
    CHECK_INT(two.status, 503);
    /* the client of the first leaves while it waits */
    srv_compute_leave(&one, SRV_STOP_LEFT);
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
    REQUIRE(srv_workers_new(&workers, 1, service.queue, &service.fairness) == PEND_OK);
    compute_post(&exchange, &service, "/v1/trajectories", LIVE_ENDLESS);
    srv_compute_begin(&exchange);
    test_sleep(0.05);
    CHECK_INT(compute_finished, 0);
    double until = test_clock() + TEST_PATIENCE;
    srv_compute_leave(&exchange, SRV_STOP_SHUTDOWN);
    CHECK_INT(compute_finished, 1);
    while (atomic_load(&service.computing) && test_clock() < until) test_sleep(0.001);
    CHECK_INT(service.computing, 0);
    srv_workers_free(&workers);
    CHECK_INT(exchange.status, 503);
    CHECK(strstr(exchange.data, "the server is stopping") != NULL);
    srv_exchange_clear(&exchange);
    live_service_clear(&service);
}

/* the estimated time of a trajectory */
static double compute_cost(const char *body) {
    struct api_limits limits;
    OWN(api_call, free) *call;
    OWN(api_buffer, clear) out;
    struct api_request request = {.op = API_OP_TRAJECTORIES,
                                  .content_type = "application/json",
                                  .body = body,
                                  .body_bytes = strlen(body)};
    api_limits_init(&limits);
    api_buffer_init(&out, 1 << 20);
    if (!CHECK(api_call_new(&call, &limits) == PEND_OK)) return 1;
    CHECK(api_call_open(call, &request, &out) == API_MORE);
    return api_call_cost(call);
}

TEST(a_computation_that_is_sure_to_outrun_its_time_is_not_begun) {
    struct srv_service service;
    struct srv_workers *workers;
    struct srv_exchange exchange;
    live_service(&service, 4);
    service.config.limits.compute_seconds = 1e-3 * compute_cost(LIVE_LONG);
    atomic_store(&compute_finished, 0);
    REQUIRE(srv_workers_new(&workers, 1, service.queue, &service.fairness) == PEND_OK);
    compute_post(&exchange, &service, "/v1/trajectories", LIVE_LONG);
    srv_compute_begin(&exchange);
    CHECK(compute_await(1));
    srv_workers_free(&workers);
    CHECK_INT(exchange.status, 422);
    CHECK(exchange.bytes && strstr(exchange.data, "max-compute-seconds") && !exchange.steps);
    srv_exchange_clear(&exchange);
    live_service_clear(&service);
}

TEST(a_computation_that_outruns_its_time_says_so) {
    struct srv_service service;
    struct srv_workers *workers;
    struct srv_exchange exchange;
    live_service(&service, 4);
    /* an estimate below it by this factor is started */
    service.config.limits.compute_seconds = compute_cost(LIVE_LONG) / 2.9;
    atomic_store(&compute_finished, 0);
    REQUIRE(srv_workers_new(&workers, 1, service.queue, &service.fairness) == PEND_OK);
    compute_post(&exchange, &service, "/v1/trajectories", LIVE_LONG);
    srv_compute_begin(&exchange);
    CHECK(compute_await(1));
    srv_workers_free(&workers);
    /* a build that is many times slower predicts it */
    CHECK(exchange.status == 503 || exchange.status == 422);
    CHECK(exchange.bytes && strstr(exchange.data, "max-compute-seconds"));
    const char *again = exchange.status == 422 ? "1" : NULL;
    for (int i = 0; i < exchange.response_body->headers; i++)
        if (!strcmp(exchange.response_body->header[i].name, "Retry-After"))
            again = exchange.response_body->header[i].value;
    CHECK(again && atoi(again) > 0);
    srv_exchange_clear(&exchange);
    live_service_clear(&service);
}

TEST(an_answer_that_leaves_no_memory_is_503) {
    struct srv_service service;
    struct srv_workers *workers;
    struct srv_exchange exchange;
    live_service(&service, 4);
    service.config.held_bytes = service.config.client_held_bytes = 1 << 20;
    /* others hold most of the memory; then one request is more than any client may hold */
    srv_memory_add(&service.memory, SRV_MEMORY_BODIES, (1 << 20) - 100);
    REQUIRE(srv_workers_new(&workers, 1, service.queue, &service.fairness) == PEND_OK);
    for (int never = 0; never < 2; never++) {
        if (never) service.config.client_held_bytes = 100;
        atomic_store(&compute_finished, 0);
        compute_post(&exchange, &service, "/v1/trees", LIVE_SHORT);
        srv_compute_begin(&exchange);
        CHECK(compute_await(1));
        CHECK_INT(exchange.status, never ? 422 : 503);
        CHECK(exchange.bytes &&
              strstr(exchange.data, never ? "max-client-held-bytes of 100" : "max-held-bytes"));
        srv_exchange_clear(&exchange);
    }
    srv_workers_free(&workers);
    live_service_clear(&service);
}

TEST(who_waits_too_long_for_a_worker_is_told) {
    struct srv_service service;
    struct srv_workers *workers;
    struct srv_exchange late, soon;
    live_service(&service, 4);
    service.config.wait_seconds = 60;
    atomic_store(&compute_finished, 0);
    compute_post(&late, &service, "/v1/trees", LIVE_SHORT);
    srv_compute_begin(&late);
    srv_clock_advance(srv_clock_span(61));
    REQUIRE(srv_workers_new(&workers, 1, service.queue, &service.fairness) == PEND_OK);
    CHECK(compute_await(1));
    service.config.wait_seconds = 3600;
    compute_post(&soon, &service, "/v1/trees", LIVE_SHORT);
    srv_compute_begin(&soon);
    CHECK(compute_await(2));
    srv_workers_free(&workers);
    CHECK_INT(late.status, 503);
    CHECK(late.bytes && strstr(late.data, "max-wait-seconds"));
    CHECK_INT(soon.status, 200);
    CHECK_INT((long)service.metrics.refused_wait, 1);
    CHECK_INT(service.computing, 0);
    srv_exchange_clear(&late);
    srv_exchange_clear(&soon);
    live_service_clear(&service);
}

TEST(a_computation_survives_want_of_memory_wherever_it_comes) {
    int answered = 0;
    for (int n = 1; n < 400 && !answered; n++) {
        struct srv_service service;
        struct srv_workers *workers;
        struct srv_exchange exchange;
        live_service(&service, 4);
        atomic_store(&compute_finished, 0);
        REQUIRE(srv_workers_new(&workers, 1, service.queue, &service.fairness) == PEND_OK);
        compute_post(&exchange, &service, "/v1/trees", LIVE_SHORT);
        exchange.coding = SRV_GZIP;
        service.config.compress_above = 1;
        long before = test_alloc_count();
        test_alloc_fail(n, 0);
        srv_compute_begin(&exchange);
        CHECK(compute_await(1));
        int untouched = test_alloc_count() - before < n;
        test_alloc_faults_off();
        srv_workers_free(&workers);
        CHECK_SAYING(exchange.status == 200 || exchange.status == 503, "fault %d: status %d", n,
                     exchange.status);
        CHECK(srv_cache_valid(service.cache) && !service.computing);
        answered = untouched && exchange.status == 200;
        srv_exchange_clear(&exchange);
        live_service_clear(&service);
    }
    CHECK(answered);
}
