/* Tests of server/store/store, server/store/sql and both databases: a job as a whole, opening,
 * unreachable databases. */
#include "server/store/store.h"

#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "tests/server/ground.h"

STORE_TEST(a_job_lives_from_submit_to_results) {
    struct srv_job job;
    struct srv_lease lease;
    void *request;
    size_t bytes;
    static char data[2 * SRV_CHUNK_BYTES + 1000], back[SRV_CHUNK_BYTES];
    (void)ground;
    for (size_t i = 0; i < sizeof data; i++) data[i] = (char)(i * 2654435761u >> 13);
    CHECK_INT(srv_store_job(store, "j1", &job), SRV_STORED_NONE);
    CHECK_INT(ground_claim(store, "w", SECOND, &lease), SRV_STORED_NONE);
    CHECK_INT(ground_submit(store, "j1", "anna", NULL, 2, 0, &job), SRV_STORED);
    CHECK_TEXT(job.id, "j1");
    CHECK(job.state == SRV_JOB_ACCEPTED && job.created > 1600000000LL * SECOND &&
          job.now >= job.created && !job.started);
    CHECK_INT(srv_store_job_request(store, "j1", &request, &bytes), SRV_STORED);
    CHECK(bytes == 7 && !memcmp(request, "{\"a\":1}", 7));
    free(request);
    for (int i = 0; i < 2; i++) {
        CHECK_INT(ground_claim(store, "w", 60 * SECOND, &lease), SRV_STORED);
        CHECK_TEXT(lease.job, "j1");
        CHECK_TEXT(lease.operation, "ensembles");
        CHECK(lease.part == i && lease.parts == 2 && lease.attempt == 1 && !lease.start);
        CHECK_INT(srv_store_extend(store, &lease, 60 * SECOND), SRV_STORED);
        CHECK_INT(srv_store_finish(store, &lease, data, i ? 0 : sizeof data, NULL, 0), SRV_STORED);
        CHECK_INT(srv_store_job(store, "j1", &job), SRV_STORED);
        CHECK(job.done == i + 1 && job.state == (i ? SRV_JOB_SUCCESSFUL : SRV_JOB_RUNNING) &&
              job.bytes == sizeof data);
        srv_lease_clear(&lease);
    }
    CHECK(job.finished >= job.started &&
          llabs(job.expires - job.finished - ground_rules.keep_us) < SECOND);
    for (long chunk = 0; chunk < 3; chunk++) {
        size_t want = chunk < 2 ? SRV_CHUNK_BYTES : 1000;
        CHECK_INT(srv_store_chunk(store, "j1", 0, chunk, back, &bytes), SRV_STORED);
        CHECK(bytes == want && !memcmp(back, data + chunk * SRV_CHUNK_BYTES, want));
    }
    CHECK_INT(srv_store_chunk(store, "j1", 0, 3, back, &bytes), SRV_STORED_NONE);
    CHECK_INT(srv_store_chunk(store, "j1", 1, 0, back, &bytes), SRV_STORED_NONE);
}

TEST(a_store_that_cannot_be_opened_says_why) {
    static const char *const bad[][2] = {{"oracle:x", "sqlite:PATH"},
                                         {"sqlite:", "needs the path of a file"},
                                         {"sqlite:/nowhere/at/all.db", "cannot be opened"},
                                         {"sqlite:/etc/passwd", "is not a store"},
                                         {"postgresql://127.0.0.1:1/x?colour=blue", "colour"}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        struct srv_store *store;
        struct pend_error error;
        CHECK_INT(srv_store_open(&store, bad[i][0], &ground_rules, &error), PEND_INVALID);
        CHECK(store == NULL);
        CHECK_SAYING(strstr(error.text, bad[i][1]) != NULL, "%s: %s", bad[i][0], error.text);
    }
}

STORE_TEST(a_store_outlives_its_processes_and_versions_are_kept_apart) {
    struct srv_job job;
    CHECK_INT(ground_submit(store, "j", "anna", NULL, 1, 0, &job), SRV_STORED);
    struct srv_store *again = ground_open(ground);
    REQUIRE(again);
    CHECK_INT(srv_store_job(again, "j", &job), SRV_STORED);
    srv_store_close(&again);
    /* a store with a later version is left unchanged */
    const struct srv_sql_driver *driver = ground->postgres ? &srv_sql_postgres : &srv_sql_sqlite;
    struct pend_error error;
    struct srv_sql *sql;
    REQUIRE(driver->open(&sql, ground->url, 0, &error) == PEND_OK);
    CHECK_INT(driver->run(sql, -1, "UPDATE pendulumd SET version = 99", NULL, 0, NULL, NULL),
              SRV_STORED);
    driver->close(sql);
    CHECK_INT(srv_store_open(&again, ground->url, &ground_rules, &error), PEND_INVALID);
    CHECK_SAYING(strstr(error.text, "version 99") != NULL, "%s", error.text);
    /* and by a process that had it open before: nothing is written into tables of an unknown
     * version */
    CHECK_INT(ground_submit(store, "k", "anna", NULL, 1, 0, &job), SRV_STORED_BROKEN);
    CHECK_SAYING(strstr(srv_store_complaint(store), "version 99") != NULL, "%s",
                 srv_store_complaint(store));
    CHECK_INT(srv_store_job(store, "j", &job), SRV_STORED_BROKEN);
    CHECK_INT(ground_ask(ground, "SELECT CAST(COUNT(*) AS BIGINT) FROM jobs"), 1);
}

STORE_TEST(a_store_is_opened_while_another_process_writes) {
    const struct srv_sql_driver *driver = ground->postgres ? &srv_sql_postgres : &srv_sql_sqlite;
    struct pend_error error;
    struct srv_sql *sql;
    struct srv_job job;
    REQUIRE(driver->open(&sql, ground->url, 0, &error) == PEND_OK);
    REQUIRE(driver->run(sql, -1, "{begin}", NULL, 0, NULL, NULL) == SRV_STORED);
    CHECK_INT(driver->run(sql, -1, "UPDATE pendulumd SET version = version", NULL, 0, NULL, NULL),
              SRV_STORED);
    struct srv_store *again = ground_open(ground);
    REQUIRE(again);
    CHECK_INT(driver->run(sql, -1, "COMMIT", NULL, 0, NULL, NULL), SRV_STORED);
    CHECK_INT(ground_submit(store, "j", "anna", NULL, 1, 0, &job), SRV_STORED);
    CHECK_INT(srv_store_job(again, "j", &job), SRV_STORED);
    srv_store_close(&again);
    driver->close(sql);
}

TEST(a_lost_database_is_away_and_comes_back) {
    struct ground ground;
    struct srv_job job;
    struct srv_lease lease;
    if (access("/usr/lib/postgresql", F_OK)) {
        test_skip("PostgreSQL is not installed");
        return;
    }
    REQUIRE(ground_begin(&ground, 1));
    OWN(srv_store, close) *store = ground_open(&ground);
    REQUIRE(store);
    CHECK_INT(ground_submit(store, "j", "anna", NULL, 1, 0, &job), SRV_STORED);
    for (int kill = 0; kill < 2; kill++) {
        REQUIRE(test_postgres_restart(ground.postgres, kill ? SIGQUIT : SIGINT));
        CHECK_INT(srv_store_job(store, "j", &job), SRV_STORED_AWAY);
        enum srv_stored stored = SRV_STORED_AWAY;
        for (int i = 0; i < 50 * TEST_PATIENCE && stored == SRV_STORED_AWAY; i++) {
            ground_pause_ms(20);
            stored = srv_store_job(store, "j", &job);
        }
        CHECK_INT(stored, SRV_STORED);
    }
    CHECK_INT(ground_claim(store, "w", SECOND, &lease), SRV_STORED);
    CHECK_TEXT(lease.job, "j");
}

/* nobody listens there: the store is unreachable at once, and says why */
TEST(a_database_that_is_not_there_yet_is_away) {
    OWN(srv_store, close) *store;
    struct pend_error error;
    struct srv_job job;
    REQUIRE(srv_store_open(&store, "postgresql://127.0.0.1:1/x", &ground_rules, &error) == PEND_OK);
    CHECK(!srv_store_settled(store));
    for (int i = 0; i < 3; i++) CHECK_INT(srv_store_job(store, "j", &job), SRV_STORED_AWAY);
    CHECK_SAYING(strstr(srv_store_complaint(store), "127.0.0.1"), "%s", srv_store_complaint(store));
    CHECK_INT(srv_store_listen(store, 1, -1), 0);
}

STORE_TEST(processes_that_share_a_store_hear_each_other) {
    struct srv_job job;
    OWN(srv_store, close) *ear = ground_open(ground);
    REQUIRE(ear);
    CHECK_INT(srv_store_listen(ear, 1, -1), 0);
    CHECK_INT(ground_submit(store, "j", "anna", NULL, 1, 0, &job), SRV_STORED);
    srv_store_ring(store, SRV_RING_ALL);
    CHECK(srv_store_listen(ear, 1000 * TEST_PATIENCE, -1) & SRV_RING_WORK);
    CHECK_INT(srv_store_listen(ear, 1, -1), 0);
    /* an unstored job is not reported */
    CHECK_INT(ground_submit(store, "k", "anna", "key", 1, 0, &job), SRV_STORED);
    srv_store_ring(store, SRV_RING_ALL);
    CHECK(srv_store_listen(ear, 1000 * TEST_PATIENCE, -1) & SRV_RING_WORK);
    CHECK_INT(ground_submit(store, "l", "anna", "key", 1, 0, &job), SRV_STORED);
    CHECK_TEXT(job.id, "k");
    srv_store_ring(store, SRV_RING_ALL);
    CHECK_INT(srv_store_listen(ear, 50, -1), 0);
}
