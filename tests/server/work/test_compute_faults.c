/* One request for every operation while an allocation fails: on a worker, and through a live daemon
 * as an answer and as a job. A failure costs at most the answer to its own request: no memory stays
 * held, and the next request is answered. */
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>

#include "server/http/router.h"
#include "server/protocol/cache.h"
#include "server/service_setup.h"
#include "server/work/admission.h"
#include "server/work/compute.h"
#include "server/work/workers.h"
#include "tests/harness/requests.h"
#include "tests/harness/test.h"
#include "tests/server/live.h"

/* sanitizers take every second, the thread sanitizer, with which one thread alone runs the loop,
 * every eighth */
enum { FAULTS_STRIDE = (TEST_STRIDE + 1) / 2 };

static const char *faults_path(const struct test_request *one, char path[64]) {
    const char *name = one->op == API_OP_PRESET ? "presets/double" : api_op_at(one->op)->name;
    snprintf(path, 64, "/v1/%s", name);
    return path;
}

/* --- on a worker, without a socket --- */

static atomic_int faults_finished;

static void faults_finish(struct srv_exchange *exchange) {
    (void)exchange;
    atomic_fetch_add(&faults_finished, 1);
}

/* computes a request while the n-th allocation fails; returns its status, and sets *over if there
 * were fewer */
static int faults_compute(struct srv_service *service, const struct test_request *one, long n,
                          int for_good, int *over) {
    OWN(srv_exchange, clear) exchange;
    char path[64];
    srv_exchange_init(&exchange, service);
    exchange.finish = faults_finish;
    snprintf(exchange.peer, sizeof exchange.peer, "127.0.0.1");
    exchange.method = one->body ? "POST" : "GET";
    snprintf(exchange.target, sizeof exchange.target, "%s", faults_path(one, path));
    exchange.field[SRV_CONTENT_TYPE] = one->body ? "application/json" : NULL;
    exchange.field[SRV_ACCEPT] = one->accept;
    CHECK(srv_router_head(&exchange));
    if (one->body) CHECK(api_buffer_text(&exchange.body, one->body) == PEND_OK);
    atomic_store(&faults_finished, 0);
    long before = test_alloc_count();
    test_alloc_fail(n, for_good);
    srv_compute_begin(&exchange);
    double until = test_clock() + TEST_PATIENCE;
    while (test_clock() < until && !faults_finished) test_sleep(0.0002);
    /* on a slow machine the answer is a stream, which its reader leaves */
    int streamed = faults_finished && exchange.work;
    if (streamed) srv_compute_leave(&exchange, SRV_STOP_LEFT);
    *over = !streamed && test_alloc_count() - before < n;
    test_alloc_faults_off();
    CHECK(faults_finished);
    return exchange.status;
}

/* waits until the worker, which delivers an answer before it cleans up, is idle; returns 0 if that
 * does not happen */
static int faults_rest(struct srv_service *service) {
    double until = test_clock() + TEST_PATIENCE;
    while (srv_memory_all(&service->memory) || service->computing || service->busy) {
        if (test_clock() > until) return 0;
        test_sleep(0.0002);
    }
    return 1;
}

TEST(every_operation_on_a_worker_survives_want_of_memory_wherever_it_comes) {
    static const char *const options[] = {"--cache-bytes", "0", NULL};
    struct srv_service service = {.config = live_config(options)};
    struct srv_workers *workers;
    struct pend_error error = {.text = ""};
    service.config.queue = 4;
    REQUIRE(srv_service_setup_init(&service, &error) == PEND_OK);
    CHECK(srv_log_new(&service.log, -1, 2) == PEND_OK);
    REQUIRE(srv_workers_new(&workers, 1, service.queue, &service.fairness) == PEND_OK);
    for (int i = 0; i < TEST_REQUESTS; i++)
        for (int for_good = 0; for_good < 2; for_good++) {
            int over = 0, faults = 0, usual = i == 2 ? 422 : 200;
            long n = 1 + (i + for_good) % FAULTS_STRIDE;
            for (; !over; n += (n < 60 ? 1 : n / 12) * FAULTS_STRIDE, faults++) {
                int status = faults_compute(&service, &test_requests[i], n, for_good, &over);
                CHECK_SAYING(status == usual || status == 503, "request %d, allocation %ld%s: %d",
                             i, n, for_good ? " for good" : "", status);
                /* nothing is left of it: neither counted memory nor a computation */
                CHECK_SAYING(faults_rest(&service),
                             "request %d, allocation %ld: %lld bytes are held, %d are computed", i,
                             n, (long long)srv_memory_all(&service.memory), (int)service.computing);
            }
            CHECK_SAYING(faults * FAULTS_STRIDE > 3, "request %d met %d faults only", i, faults);
            CHECK_INT(faults_compute(&service, &test_requests[i], 1000000000, 0, &over), usual);
        }
    srv_workers_free(&workers);
    srv_log_free(&service.log);
    srv_service_setup_clear(&service);
}

/* --- through a live daemon --- */

/* a request whose answer is sent while it is computed, in compressed blocks */
static const struct test_request faults_stream = {
    API_OP_TRAJECTORIES,
    "{" TEST_TREE ",\"initial\":{\"theta\":[1,2]},\"times\":{\"stop\":2,\"count\":20000}}",
    "text/csv\r\nAccept-Encoding: gzip"};

enum { FAULTS_ANSWER, FAULTS_JOB, FAULTS_GONE /* the client leaves in the middle of the answer */ };

/* sends a request on a separate connection */
static int faults_send(const struct srv_daemon *daemon, struct test_client *client,
                       const struct test_request *one, int job) {
    char text[2048], path[64];
    if (!test_client_open(client, live_port(daemon))) return 0;
    int bytes = snprintf(
        text, sizeof text,
        "%s %s HTTP/1.1\r\nHost: x\r\nConnection: close\r\n%s%s%s%s%sContent-Length: %zu\r\n\r\n%s",
        one->body ? "POST" : "GET", faults_path(one, path), job ? "Prefer: respond-async\r\n" : "",
        one->accept ? "Accept: " : "", one->accept ? one->accept : "", one->accept ? "\r\n" : "",
        one->body ? "Content-Type: application/json\r\n" : "", one->body ? strlen(one->body) : 0,
        one->body ? one->body : "");
    return send(client->fd, text, (size_t)bytes, MSG_NOSIGNAL) == bytes;
}

/* reads until the server closes, without allocating; keeps the beginning of the answer */
static void faults_read(const struct test_client *client, int kind, char head[], size_t cap) {
    struct pollfd look = {.fd = client->fd, .events = POLLIN};
    char rest[4096];
    size_t got = 0;
    ssize_t bytes = 1;
    while (bytes > 0 && !(kind == FAULTS_GONE && got)) {
        if (!CHECK(poll(&look, 1, (int)(1000 * TEST_PATIENCE)) == 1)) break;
        bytes = recv(client->fd, got + 1 < cap ? head + got : rest,
                     got + 1 < cap ? cap - 1 - got : sizeof rest, 0);
        if (bytes > 0 && got + 1 < cap) got += (size_t)bytes;
    }
    head[got] = 0;
}

/* waits for the end of a job; a failed one must say why */
static void faults_job(const struct srv_daemon *daemon, const char *location) {
    struct test_client client;
    struct test_reply reply;
    char text[160];
    int ended = 0;
    for (double until = test_clock() + TEST_PATIENCE; !ended && test_clock() < until;) {
        snprintf(text, sizeof text, "GET %s HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n",
                 location);
        if (!live_say(daemon, &client, text)) return;
        CHECK_INT(test_client_receive(&client, &reply, 0, TEST_PATIENCE), 200);
        int failed = strstr(reply.body, "\"status\":\"failed\"") != NULL;
        ended = failed || strstr(reply.body, "\"status\":\"successful\"");
        if (failed) CHECK_SAYING(strstr(reply.body, "memory"), "%s", reply.body);
        test_reply_clear(&reply);
        test_client_close(&client);
        if (!ended) test_sleep(0.002);
    }
    CHECK_SAYING(ended, "%s does not end", location);
}

/* one request while the n-th allocation of the process fails; returns its status, 0 without an
 * answer, and sets *over if there were fewer */
static int faults_ask(const struct srv_daemon *daemon, const struct test_request *one, long n,
                      int kind, int *over) {
    struct test_client client;
    char head[4096], location[80] = "";
    int status = 0;
    long before = test_alloc_count();
    test_alloc_fail(n, 0);
    CHECK(faults_send(daemon, &client, one, kind == FAULTS_JOB));
    faults_read(&client, kind, head, sizeof head);
    test_client_close(&client);
    /* a job is computed after its answer: until nothing allocates any more */
    for (long count = -1; kind == FAULTS_JOB && count != test_alloc_count();) {
        count = test_alloc_count();
        test_sleep(0.005);
    }
    *over = test_alloc_count() - before < n;
    test_alloc_faults_off();
    sscanf(head, "HTTP/1.1 %d", &status);
    if (status >= 500) CHECK_SAYING(strstr(head, "\"status\":5"), "%s: %s", one->body, head);
    if (status != 202) return status;
    const char *at = strstr(head, "\nLocation: ");
    if (CHECK_SAYING(at && sscanf(at, "\nLocation: %79s", location) == 1, "%s", head))
        faults_job(daemon, location);
    return status;
}

static void faults_loop(const struct srv_daemon *daemon, const struct test_request *one, long first,
                        int kind, int usual) {
    int over = 0, faults = 0;
    for (long n = first; !over; n += 1 + n / 3 * FAULTS_STRIDE, faults++) {
        int status = faults_ask(daemon, one, n, kind, &over);
        CHECK_SAYING(status == usual || status == 503 || status == 500 || status == 0,
                     "%s, allocation %ld: %d", one->body, n, status);
    }
    CHECK_SAYING(faults * FAULTS_STRIDE > 2, "%s met %d faults only",
                 one->body ? one->body : "a GET", faults);
    /* and the next is as before */
    CHECK_INT(faults_ask(daemon, one, 1000000000, kind, &over), usual);
}

TEST(every_operation_of_a_live_daemon_survives_want_of_memory_as_an_answer_and_as_a_job) {
    char directory[] = "/tmp/pendulumd-test-XXXXXX", url[96], command[96];
    REQUIRE(mkdtemp(directory));
    snprintf(url, sizeof url, "sqlite:%s/store.db", directory);
    const char *const options[] = {"--store", url, "--workers", "1", "--cache-bytes", "0", NULL};
    struct srv_daemon *daemon = live_start(options);
    REQUIRE(daemon);
    for (int i = 0; i < TEST_REQUESTS; i++) {
        faults_loop(daemon, &test_requests[i], 1 + i % 3, FAULTS_ANSWER, i == 2 ? 422 : 200);
        if (api_op_at(test_requests[i].op)->table)
            faults_loop(daemon, &test_requests[i], 1 + i % 4, FAULTS_JOB, 202);
    }
    for (long first = 1; first < 4; first++) {
        faults_loop(daemon, &faults_stream, first, FAULTS_ANSWER, 200);
        faults_loop(daemon, &faults_stream, first, FAULTS_GONE, 200);
    }
    /* nothing is in progress, held or leased */
    static const char *const nothing[] = {"pendulumd_held_kind_bytes{kind=\"bodies\"} ",
                                          "pendulumd_held_kind_bytes{kind=\"computations\"} ",
                                          "pendulumd_held_kind_bytes{kind=\"answers\"} ",
                                          "pendulumd_jobs{state=\"running\"} ",
                                          "pendulumd_jobs{state=\"accepted\"} "};
    for (size_t i = 0; i < sizeof nothing / sizeof *nothing; i++) live_await(daemon, nothing[i], 0);
    srv_daemon_free(&daemon);
    snprintf(command, sizeof command, "rm -rf '%s'", directory);
    CHECK(!system(command));
}
