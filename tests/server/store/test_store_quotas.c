/* Tests of server/store/store_quotas: exceeded limits. */
#include "server/store/store_jobs.h"

#include <pthread.h>
#include <stdio.h>
#include <string.h>

#include "server/store/store_call.h"
#include "tests/server/ground.h"

STORE_TEST(quotas_hold_and_say_so) {
    struct srv_lease lease;
    struct srv_job job;
    struct srv_store_sweep sweep;
    struct srv_store_rules tight = {.client_jobs = 2,
                                    .client_bytes = 3400,
                                    .all_bytes = 5000,
                                    .keep_us = 3600LL * SECOND,
                                    .client_scenes = 1};
    OWN(srv_store, close) *own;
    struct pend_error error;
    static char data[1600];
    (void)store;
    REQUIRE(srv_store_open(&own, ground->url, &tight, &error) == PEND_OK);
    CHECK_INT(ground_submit(own, "j1", "anna", NULL, 2, 0, &job), SRV_STORED);
    CHECK_INT(ground_submit(own, "j2", "anna", NULL, 1, 0, &job), SRV_STORED);
    CHECK_INT(ground_submit(own, "j3", "anna", NULL, 1, 0, &job), SRV_STORED_QUOTA);
    CHECK(strstr(job.message, "max-client-jobs") != NULL);
    CHECK_INT(ground_claim(own, "w", 60 * SECOND, &lease), SRV_STORED);
    CHECK_INT(srv_store_finish(own, &lease, data, 600, NULL, 0), SRV_STORED);
    do CHECK_INT(ground_claim(own, "w", 60 * SECOND, &lease), SRV_STORED);
    while (strcmp(lease.job, "j1"));
    CHECK_INT(srv_store_finish(own, &lease, data, 600, NULL, 0), SRV_STORED_QUOTA);
    CHECK_INT(srv_store_job(own, "j1", &job), SRV_STORED);
    CHECK(job.state == SRV_JOB_FAILED && strstr(job.message, "max-client-bytes"));
    /* the failed job's bytes are deleted, and there is space again */
    do CHECK_INT(srv_store_sweep(own, NULL, &sweep), SRV_STORED);
    while (sweep.more);
    CHECK_INT(srv_store_job(own, "j1", &job), SRV_STORED);
    CHECK_INT(job.bytes, 0);
    CHECK_INT(ground_submit(own, "j5", "anna", NULL, 1, 0, &job), SRV_STORED);
    do CHECK_INT(ground_claim(own, "w", 60 * SECOND, &lease), SRV_STORED);
    while (strcmp(lease.job, "j5"));
    CHECK_INT(srv_store_finish(own, &lease, data, 300, NULL, 0), SRV_STORED);
    CHECK_INT(ground_submit(own, "b1", "berta", NULL, 1, 0, &job), SRV_STORED);
    CHECK_INT(ground_claim(own, "w", 60 * SECOND, &lease), SRV_STORED);
    CHECK_INT(srv_store_finish(own, &lease, data, 600, NULL, 0), SRV_STORED_QUOTA);
    CHECK_INT(srv_store_job(own, "b1", &job), SRV_STORED);
    CHECK(strstr(job.message, "max-store-bytes") != NULL);
}

static enum srv_stored submit_from(struct srv_store *store, const char *id, const char *client,
                                   const char *source, struct srv_job *job) {
    struct srv_job_order order = ground_order(id, client);
    order.source = source;
    return srv_store_submit(store, &order, job);
}

/* a new client for each job does not exceed the limits of its address */
STORE_TEST(all_clients_of_an_address_share_its_bounds) {
    struct srv_job job;
    struct srv_lease lease;
    OWN(srv_store, close) *own;
    char name[16];
    static char data[900];
    (void)store;
    ground->rules.source_jobs = 4;
    ground->rules.source_clients = 3;
    ground->rules.source_bytes = 6000;
    REQUIRE((own = ground_open(ground)) != NULL);
    for (int i = 0; i < 4; i++) {
        snprintf(name, sizeof name, "t%d", i);
        CHECK_INT(submit_from(own, name, name, "home", &job),
                  i < 3 ? SRV_STORED : SRV_STORED_QUOTA);
    }
    CHECK(strstr(job.message, "max-address-clients") != NULL);
    CHECK_INT(submit_from(own, "t0b", "t0", "home", &job), SRV_STORED);
    CHECK_INT(submit_from(own, "t0c", "t0", "home", &job), SRV_STORED_QUOTA);
    CHECK(strstr(job.message, "max-client-jobs") != NULL);
    /* others are not affected: another address, and the client of the address itself */
    CHECK_INT(submit_from(own, "s0", "s0", "school", &job), SRV_STORED);
    CHECK_INT(submit_from(own, "h0", "home", "home", &job), SRV_STORED);
    CHECK_INT(srv_store_dismiss(own, "h0", &job), SRV_STORED);
    CHECK_INT(srv_store_dismiss(own, "s0", &job), SRV_STORED);
    for (int i = 0; i < 4; i++) {
        CHECK_INT(ground_claim(own, "w", 60 * SECOND, &lease), SRV_STORED);
        CHECK_INT(srv_store_finish(own, &lease, data, i < 2 ? sizeof data : 1, NULL, 0),
                  SRV_STORED);
        srv_lease_clear(&lease);
    }
    CHECK_INT(submit_from(own, "t1b", "t1", "home", &job), SRV_STORED_QUOTA);
    CHECK_SAYING(strstr(job.message, "bytes of jobs") != NULL, "%s", job.message);
    CHECK_INT(submit_from(own, "s1", "s1", "school", &job), SRV_STORED);
}

static enum srv_stored submit_bytes(struct srv_store *store, const char *id, size_t bytes,
                                    struct srv_job *job) {
    static const char request[12000];
    struct srv_job_order order = ground_order(id, "anna");
    order.request = request;
    order.request_bytes = bytes;
    return srv_store_submit(store, &order, job);
}

/* the quota limits the bytes on disk: a request counts, and is deleted at its job's end */
STORE_TEST(a_request_is_counted_and_goes_with_its_job) {
    struct srv_job job;
    OWN(srv_store, close) *own;
    struct srv_store_figures figures;
    enum srv_stored stored = SRV_STORED;
    char id[16];
    int jobs = 0;
    (void)store;
    ground->rules.client_bytes = 64 << 10;
    REQUIRE((own = ground_open(ground)) != NULL);
    for (; stored == SRV_STORED && jobs < 100; jobs += stored == SRV_STORED) {
        snprintf(id, sizeof id, "j%d", jobs);
        stored = submit_bytes(own, id, 10000, &job);
    }
    CHECK_INT(stored, SRV_STORED_QUOTA);
    CHECK_SAYING(strstr(job.message, "max-client-bytes") != NULL, "%s", job.message);
    CHECK_INT(jobs, 5);
    CHECK_INT(ground_ask(ground, "SELECT CAST(SUM(LENGTH(request)) AS BIGINT) FROM jobs"), 50000);
    for (int i = 0; i < jobs; i++) {
        snprintf(id, sizeof id, "j%d", i);
        CHECK_INT(srv_store_dismiss(own, id, &job), SRV_STORED);
    }
    CHECK_INT(ground_ask(ground, "SELECT CAST(SUM(LENGTH(request)) AS BIGINT) FROM jobs"), 0);
    CHECK_INT(srv_store_figures(own, &figures), SRV_STORED);
    CHECK_INT(figures.bytes, 5LL * SRV_ROW_BYTES);
    CHECK_INT(submit_bytes(own, "k", 10000, &job), SRV_STORED);
    ground_sums(ground);
}

/* ended jobs are limited as well, however small they are */
STORE_TEST(jobs_that_ended_are_bounded) {
    struct srv_job job;
    OWN(srv_store, close) *own;
    enum srv_stored stored = SRV_STORED;
    char id[16];
    int jobs = 0;
    (void)store;
    ground->rules.client_bytes = 64 << 10;
    REQUIRE((own = ground_open(ground)) != NULL);
    for (; stored == SRV_STORED && jobs < 200; jobs += stored == SRV_STORED) {
        snprintf(id, sizeof id, "j%d", jobs);
        stored = submit_bytes(own, id, 2, &job);
        if (stored == SRV_STORED) CHECK_INT(srv_store_dismiss(own, id, &job), SRV_STORED);
    }
    CHECK_INT(stored, SRV_STORED_QUOTA);
    CHECK_INT(jobs, 63);
}

/* a full store is reported before a job is refused */
STORE_TEST(a_full_store_says_so) {
    struct srv_store_figures figures;
    struct srv_job job;
    OWN(srv_store, close) *own;
    (void)store;
    ground->rules.all_bytes = 2 * SRV_ROW_BYTES + 100;
    REQUIRE((own = ground_open(ground)) != NULL);
    CHECK_INT(ground_submit(own, "a", "anna", NULL, 1, 0, &job), SRV_STORED);
    CHECK_INT(srv_store_figures(own, &figures), SRV_STORED);
    CHECK(!figures.full);
    CHECK_INT(ground_submit(own, "b", "anna", NULL, 1, 0, &job), SRV_STORED);
    CHECK_INT(srv_store_figures(own, &figures), SRV_STORED);
    CHECK(figures.full && strstr(figures.full, "max-store-bytes"));
}

/* recounts the sums of a client, on a separate connection */
struct quotas_counter {
    struct srv_store *store;
    enum srv_stored stored;
};

static void *quotas_count_anew(void *context) {
    struct quotas_counter *counter = context;
    counter->stored = srv_store_begin(counter->store);
    if (counter->stored == SRV_STORED)
        counter->stored =
            srv_store_end(counter->store, srv_tally_count_anew(&counter->store->tally, "anna"));
    return NULL;
}

/* A submit and a recount at the same time: on PostgreSQL the recount waits for the row that the
 * submit has changed, and must count what the submit has committed meanwhile. A sum without it
 * would become negative at the job's end. */
STORE_TEST(sums_are_counted_anew_with_what_others_have_just_changed) {
    const struct srv_sql_driver *driver = ground->postgres ? &srv_sql_postgres : &srv_sql_sqlite;
    static const char *const submit[] = {
        "INSERT INTO jobs (id, client, operation, request, key, digest, parts, chained, part_us, "
        "rank, created, held, seal, title, version) SELECT 'j2', client, operation, request, key, "
        "digest, parts, chained, part_us, rank, created, held, seal, title, version FROM jobs "
        "WHERE id = 'j1'",
        "UPDATE clients SET jobs = jobs + 1, ready = ready + 1, bytes = bytes + (SELECT held FROM "
        "jobs WHERE id = 'j1') WHERE name = 'anna'"};
    OWN(srv_store, close) *other = ground_open(ground);
    struct srv_job job;
    struct srv_sql *sql;
    struct pend_error error;
    struct quotas_counter counter = {other, SRV_STORED_BROKEN};
    pthread_t thread;
    REQUIRE(other);
    CHECK_INT(ground_submit(store, "j1", "anna", NULL, 1, 0, &job), SRV_STORED);
    CHECK_INT(srv_store_job(other, "j1", &job), SRV_STORED);
    REQUIRE(driver->open(&sql, ground->url, 0, &error) == PEND_OK);
    CHECK_INT(driver->run(sql, -1, "{begin}", NULL, 0, NULL, NULL), SRV_STORED);
    for (int i = 0; i < 2; i++)
        CHECK_INT(driver->run(sql, -1, submit[i], NULL, 0, NULL, NULL), SRV_STORED);
    REQUIRE(!pthread_create(&thread, NULL, quotas_count_anew, &counter));
    ground_pause_ms(300);
    CHECK_INT(driver->run(sql, -1, "COMMIT", NULL, 0, NULL, NULL), SRV_STORED);
    pthread_join(thread, NULL);
    CHECK_INT(counter.stored, SRV_STORED);
    driver->close(sql);
    CHECK_INT(ground_ask(ground, "SELECT jobs FROM clients WHERE name = 'anna'"), 2);
    CHECK_INT(ground_ask(ground, "SELECT ready FROM clients WHERE name = 'anna'"), 2);
    CHECK_INT(ground_ask(ground, "SELECT bytes FROM clients WHERE name = 'anna'"), 2 * job.held);
}

STORE_TEST(sums_that_cannot_be_are_counted_anew_when_a_job_is_submitted) {
    struct srv_job job;
    CHECK_INT(ground_submit(store, "j1", "anna", NULL, 1, 0, &job), SRV_STORED);
    ground_run(ground, "UPDATE clients SET jobs = -1, bytes = -5 WHERE name = 'anna'");
    CHECK_INT(ground_submit(store, "j2", "anna", NULL, 1, 0, &job), SRV_STORED);
    CHECK_INT(ground_ask(ground, "SELECT jobs FROM clients WHERE name = 'anna'"), 2);
    CHECK(ground_sums(ground));
}
