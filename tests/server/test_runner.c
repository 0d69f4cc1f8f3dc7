/* Tests of server/runner: what becomes of a part when its daemon drains, and memory that is not there. */
#include "server/runner.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "server/store.h"
#include "tests/harness/test.h"
#include "tests/server/live.h"

static const struct srv_store_rules runner_rules = {.client_jobs = 100,
                                                    .client_bytes = 1 << 28,
                                                    .all_bytes = 1LL << 30,
                                                    .keep_us = 3600000000LL,
                                                    .client_scenes = 3,
                                                    .client_scene_bytes = 1 << 20,
                                                    .all_scene_bytes = 1 << 24};

enum { ID = SRV_ID_BYTES - 1 };

/* posts a job to a live daemon; its id */
static void runner_post(const struct srv_daemon *daemon, const char *body, char id[SRV_ID_BYTES]) {
    struct test_client client;
    struct test_reply reply;
    char text[1024];
    id[0] = 0;
    snprintf(text, sizeof text,
             "POST /v1/trajectories HTTP/1.1\r\nHost: x\r\nPrefer: wait=5, respond-async; foo\r\nContent-Type: "
             "application/json\r\nContent-Length: %zu\r\n\r\n%s",
             strlen(body), body);
    if (!live_say(daemon, &client, text)) return;
    CHECK_INT(test_client_receive(&client, &reply, 0, TEST_PATIENCE), 202);
    const char *location = test_reply_header(&reply, "Location");
    if (CHECK(location && strlen(location) == 9 + ID)) snprintf(id, SRV_ID_BYTES, "%s", location + 9);
    test_reply_clear(&reply);
    test_client_close(&client);
}

static struct srv_store *runner_look(const char *url) {
    struct srv_store *store;
    struct pend_error error;
    CHECK(srv_store_open(&store, url, &runner_rules, &error) == PEND_OK);
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
        runner_post(daemon, LIVE_LONG, id);
        for (double until = test_clock() + TEST_PATIENCE; job.state == SRV_JOB_ACCEPTED && test_clock() < until;) {
            CHECK_INT(srv_store_job(store, id, &job), SRV_STORED);
            test_sleep(0.005);
        }
        CHECK_INT(job.state, SRV_JOB_RUNNING);
        /* it is held, for as long as the daemon lives */
        CHECK_INT(srv_store_claim(store, "other", 1000000, &lease), SRV_STORED_NONE);
        srv_daemon_free(&daemon);
        CHECK_INT(srv_store_claim(store, "other", 60000000, &lease), SRV_STORED);
        CHECK_TEXT(lease.job, id);
        CHECK_INT(lease.attempt, 2);
        srv_lease_clear(&lease);
    }
    srv_store_close(&store);
    if (daemon) srv_daemon_free(&daemon);
    snprintf(command, sizeof command, "rm -rf '%s'", directory);
    CHECK(!system(command));
}

TEST(a_runner_that_was_not_started_ends_and_want_of_memory_is_told) {
    struct srv_service service;
    struct srv_runner *runner;
    live_service(&service, 4);
    REQUIRE(srv_runner_new(&runner, &service, 3) == PEND_OK);
    srv_runner_news(runner);
    srv_runner_dismiss(runner, "nobody");
    CHECK(srv_runner_drain(runner));
    srv_runner_free(&runner);
    CHECK(!runner);
    test_alloc_fail(1, 0);
    enum pend_status status = srv_runner_new(&runner, &service, 3);
    test_alloc_faults_off();
    CHECK_INT(status, PEND_NO_MEMORY);
    CHECK(!runner);
    live_service_clear(&service);
}
