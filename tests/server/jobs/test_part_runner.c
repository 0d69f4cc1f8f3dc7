/* Tests of server/jobs/part_runner: parts of a daemon that drains, and lack of memory. */
#include "server/jobs/part_runner.h"

#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/call/request.h"
#include "server/jobs/part_claim.h"
#include "server/store/store.h"
#include "tests/server/ground.h"
#include "tests/server/live.h"

enum { ID = SRV_ID_BYTES - 1 };

/* requests that were read since the program started */
static atomic_int runner_reads;

enum pend_status
__real_api_request_read(const struct api_request *request, const struct api_format *format,
                        const struct api_limits *limits, struct api_problem *problem, void **state,
                        char digest[API_DIGEST_BYTES], struct api_buffer *canonical);
enum pend_status
__wrap_api_request_read(const struct api_request *request, const struct api_format *format,
                        const struct api_limits *limits, struct api_problem *problem, void **state,
                        char digest[API_DIGEST_BYTES], struct api_buffer *canonical);

enum pend_status
__wrap_api_request_read(const struct api_request *request, const struct api_format *format,
                        const struct api_limits *limits, struct api_problem *problem, void **state,
                        char digest[API_DIGEST_BYTES], struct api_buffer *canonical) {
    atomic_fetch_add(&runner_reads, 1);
    return __real_api_request_read(request, format, limits, problem, state, digest, canonical);
}

enum srv_stored __real_srv_store_claim(struct srv_store *store, struct srv_claim *claim,
                                       struct srv_lease lease[]);
enum srv_stored __wrap_srv_store_claim(struct srv_store *store, struct srv_claim *claim,
                                       struct srv_lease lease[]);

/* 1: the next claim that finds something is undone and must be repeated; 2: it was */
static atomic_int runner_again;

enum srv_stored __wrap_srv_store_claim(struct srv_store *store, struct srv_claim *claim,
                                       struct srv_lease lease[]) {
    int again = atomic_load(&runner_again) == 2;
    enum srv_stored stored = __real_srv_store_claim(store, claim, lease);
    if (again) {
        CHECK(stored == SRV_STORED && claim->count == 1 && lease[0].attempt == 2);
        atomic_store(&runner_again, 3);
    }
    if (stored != SRV_STORED || atomic_load(&runner_again) != 1) return stored;
    CHECK(lease[0].request != NULL);
    CHECK_INT(srv_store_release(store, claim->worker), SRV_STORED);
    atomic_store(&runner_again, 2);
    return SRV_STORED_AGAIN;
}

/* posts a job to a live daemon; returns its id */
static void runner_post(const struct srv_daemon *daemon, const char *path, const char *body,
                        char id[SRV_ID_BYTES]) {
    OWN(test_client, close) client;
    OWN(test_reply, clear) reply = {0};
    char text[1024];
    id[0] = 0;
    snprintf(text, sizeof text,
             "POST %s HTTP/1.1\r\nHost: x\r\nPrefer: foo=5, respond-async; wait\r\nContent-Type: "
             "application/json\r\nContent-Length: %zu\r\n\r\n%s",
             path, strlen(body), body);
    if (!live_say(daemon, &client, text)) return;
    CHECK_INT(test_client_receive(&client, &reply, 0, TEST_PATIENCE), 202);
    const char *location = test_reply_header(&reply, "Location");
    if (CHECK(location && strlen(location) == 9 + ID))
        snprintf(id, SRV_ID_BYTES, "%s", location + 9);
}

static struct srv_store *runner_look(const char *url) {
    struct srv_store *store;
    struct pend_error error;
    CHECK(srv_store_open(&store, url, &ground_rules, &error) == PEND_OK);
    return store;
}

TEST(a_part_that_was_running_is_given_back_by_a_drain_and_lost_by_nobody) {
    char directory[] = "/tmp/pendulumd-test-XXXXXX", url[96], id[SRV_ID_BYTES], command[96];
    struct srv_job job = {.state = SRV_JOB_ACCEPTED};
    struct srv_lease lease;
    REQUIRE(mkdtemp(directory));
    snprintf(url, sizeof url, "sqlite:%s/store.db", directory);
    const char *const options[] = {"--store", url, "--workers", "1", NULL};
    struct srv_daemon *daemon = live_start(options);
    struct srv_store *store = runner_look(url);
    if (daemon && store) {
        runner_post(daemon, "/v1/trajectories", LIVE_LONG, id);
        for (double until = test_clock() + TEST_PATIENCE;
             job.state == SRV_JOB_ACCEPTED && test_clock() < until;) {
            CHECK_INT(srv_store_job(store, id, &job), SRV_STORED);
            test_sleep(0.005);
        }
        CHECK_INT(job.state, SRV_JOB_RUNNING);
        /* it is held as long as the daemon lives */
        CHECK_INT(ground_claim_whole(store, "other", 1000000, &lease), SRV_STORED_NONE);
        srv_daemon_free(&daemon);
        CHECK_INT(ground_claim_whole(store, "other", 60000000, &lease), SRV_STORED);
        CHECK_TEXT(lease.job, id);
        CHECK_INT(lease.attempt, 2);
        srv_lease_clear(&lease);
    }
    srv_store_close(&store);
    if (daemon) srv_daemon_free(&daemon);
    snprintf(command, sizeof command, "rm -rf '%s'", directory);
    CHECK(!system(command));
}

/* ns: the longest of many rests after a claim of this many of 64 small parts that took this long */
static int64_t runner_rest_after(int count, int64_t took, long workers) {
    struct srv_part_claim claim;
    int64_t longest = 0;
    srv_part_claim_init(&claim, SECOND);
    for (int i = 1; i < 1000; i++) {
        int64_t begun = i * (int64_t)1000 * SECOND * 1000;
        CHECK_INT(srv_part_claim_due(&claim, SRV_CLAIMS, 0, begun), 1);
        claim.asked.count = count;
        for (int k = 0; k < count; k++) claim.lease[k] = (struct srv_lease){.parts = 1};
        CHECK_INT(srv_part_claim_take(&claim, SRV_STORED, workers, begun + took), count);
        int64_t rest = claim.at - begun - took;
        if (rest > longest) longest = rest;
    }
    return longest;
}

/* the busier the database, the longer the rest; a worker that gets half continues almost at once,
 * one that gets little lets others work */
TEST(a_claim_rests_by_what_it_found_and_how_long_that_took) {
    const int64_t ms = 1000000;
    int64_t quick = runner_rest_after(SRV_CLAIMS, 4 * ms, 65),
            slow = runner_rest_after(SRV_CLAIMS, 100 * ms, 65);
    CHECK(runner_rest_after(SRV_CLAIMS, 100 * ms, 1) <= 0);
    CHECK(quick > 15 * ms && quick <= 16 * ms && slow > 390 * ms && slow <= 400 * ms);
    CHECK(runner_rest_after(SRV_CLAIMS / 2, 100 * ms, 65) <= 20 * ms);
    CHECK(runner_rest_after(1, 4 * ms, 65) > 1000 * ms);
}

TEST(a_claim_that_is_made_again_lets_go_of_what_it_had) {
    char directory[] = "/tmp/pendulumd-test-XXXXXX", url[96], id[SRV_ID_BYTES], command[96];
    struct srv_job job = {.state = SRV_JOB_ACCEPTED};
    REQUIRE(mkdtemp(directory));
    snprintf(url, sizeof url, "sqlite:%s/store.db", directory);
    const char *const options[] = {"--store", url, "--workers", "1", NULL};
    struct srv_daemon *daemon = live_start(options);
    struct srv_store *store = runner_look(url);
    if (daemon && store) {
        atomic_store(&runner_again, 1);
        runner_post(daemon, "/v1/trajectories",
                    "{\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1]},\"times\":{"
                    "\"start\":0,\"stop\":1,\"count\":5}}",
                    id);
        for (double until = test_clock() + TEST_PATIENCE;
             job.state <= SRV_JOB_RUNNING && test_clock() < until;) {
            if (!CHECK_INT(srv_store_job(store, id, &job), SRV_STORED)) break;
            test_sleep(0.005);
        }
        CHECK_INT(job.state, SRV_JOB_SUCCESSFUL);
        CHECK_INT(atomic_load(&runner_again), 3);
        atomic_store(&runner_again, 0);
    }
    srv_store_close(&store);
    if (daemon) srv_daemon_free(&daemon);
    snprintf(command, sizeof command, "rm -rf '%s'", directory);
    CHECK(!system(command));
}

TEST(a_runner_that_was_not_started_ends_and_want_of_memory_is_told) {
    struct srv_service service;
    struct srv_part_runner *runner;
    live_service(&service, 4);
    REQUIRE(srv_part_runner_new(&runner, &service, 3) == PEND_OK);
    srv_part_runner_news(runner, SRV_RING_ALL);
    srv_part_runner_dismiss(runner, "nobody");
    CHECK(srv_part_runner_drain(runner));
    srv_part_runner_free(&runner);
    CHECK(!runner);
    test_alloc_fail(1, 0);
    enum pend_status status = srv_part_runner_new(&runner, &service, 3);
    test_alloc_faults_off();
    CHECK_INT(status, PEND_NO_MEMORY);
    CHECK(!runner);
    live_service_clear(&service);
}

/* a job from its submission to its results, and how often its request was read */
static void runner_count(const struct srv_daemon *daemon, struct srv_store *store, const char *path,
                         const char *body, long least) {
    char id[SRV_ID_BYTES], text[128];
    struct srv_job job = {.state = SRV_JOB_ACCEPTED};
    int before = atomic_load(&runner_reads);
    runner_post(daemon, path, body, id);
    for (double until = test_clock() + TEST_PATIENCE;
         job.state <= SRV_JOB_RUNNING && test_clock() < until;) {
        CHECK_INT(srv_store_job(store, id, &job), SRV_STORED);
        test_sleep(0.005);
    }
    CHECK_INT(job.state, SRV_JOB_SUCCESSFUL);
    CHECK_SAYING(job.parts >= least, "%ld parts", job.parts);
    CHECK_INT(atomic_load(&runner_reads) - before, 1 + job.parts);
    snprintf(text, sizeof text, "GET /v1/jobs/%s HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n",
             id);
    CHECK_INT(live_status(daemon, text), 200);
    CHECK_INT(atomic_load(&runner_reads) - before, 1 + job.parts);
    snprintf(text, sizeof text,
             "GET /v1/jobs/%s/results HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n", id);
    CHECK_INT(live_status(daemon, text), 200);
    CHECK_INT(atomic_load(&runner_reads) - before, 2 + job.parts);
}

TEST(a_request_is_read_once_when_its_job_is_taken_and_once_a_part) {
    char directory[] = "/tmp/pendulumd-test-XXXXXX", url[96], command[96];
    REQUIRE(mkdtemp(directory));
    snprintf(url, sizeof url, "sqlite:%s/store.db", directory);
    const char *const options[] = {"--store", url, "--workers", "2", "--job-part-seconds",
                                   "0.001",   NULL};
    struct srv_daemon *daemon = live_start(options);
    struct srv_store *store = runner_look(url);
    if (daemon && store) {
        runner_count(daemon, store, "/v1/trajectories",
                     "{\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1]},\"initial\":"
                     "{\"phi\":[1,2]},\"times\":{\"start\":0,\"stop\":200,\"count\":4000}}",
                     3);
        runner_count(daemon, store, "/v1/modes", LIVE_SHORT, 1);
    }
    srv_store_close(&store);
    if (daemon) srv_daemon_free(&daemon);
    snprintf(command, sizeof command, "rm -rf '%s'", directory);
    CHECK(!system(command));
}
