/* Tests of server/store/store_sweep: what is deleted, and when. */
#include "server/store/store_call.h"

#include <stdio.h>

#include "tests/server/ground.h"

STORE_TEST(a_dismissed_job_stops_and_frees_what_it_held) {
    struct srv_lease lease;
    struct srv_store_sweep sweep;
    struct srv_job job;
    struct srv_store_figures figures;
    size_t bytes;
    static char data[100 * SRV_CHUNK_BYTES];
    CHECK_INT(srv_store_dismiss(store, "nobody", &job), SRV_STORED_NONE);
    CHECK_INT(ground_submit(store, "j", "anna", NULL, 3, 0, &job), SRV_STORED);
    CHECK_INT(ground_claim(store, "w", 60 * SECOND, &lease), SRV_STORED);
    CHECK_INT(srv_store_finish(store, &lease, data, sizeof data, NULL, 0), SRV_STORED);
    CHECK_INT(ground_claim(store, "w", 60 * SECOND, &lease), SRV_STORED);
    CHECK_INT(srv_store_dismiss(store, "j", &job), SRV_STORED);
    CHECK_INT(job.state, SRV_JOB_DISMISSED);
    CHECK_INT(srv_store_extend(store, &lease, SECOND), SRV_STORED_LOST);
    CHECK_INT(srv_store_finish(store, &lease, data, 5, NULL, 0), SRV_STORED_LOST);
    CHECK_INT(ground_claim(store, "w", SECOND, &lease), SRV_STORED_NONE);
    int sweeps = 0;
    do CHECK_INT(srv_store_sweep(store, NULL, &sweep), SRV_STORED);
    while (sweep.more && ++sweeps < 10);
    CHECK_INT(sweeps, 2);
    CHECK_INT(srv_store_chunk(store, "j", 0, 99, data, &bytes), SRV_STORED_NONE);
    CHECK_INT(srv_store_figures(store, &figures), SRV_STORED);
    CHECK(figures.bytes == SRV_ROW_BYTES && figures.jobs[SRV_JOB_DISMISSED] == 1 && !figures.parts);
    ground_sums(ground);
    /* the list of removals keeps a page of the disk, so that a job can be dismissed on a full
     * disk */
    CHECK_INT(ground_ask(ground, "SELECT COUNT(*) FROM removals"), 1);
    if (ground->postgres) {
        ground_run(ground, "VACUUM removals");
        CHECK(ground_ask(ground, "SELECT pg_relation_size('removals')") > 0);
    }
}

STORE_TEST(a_job_past_its_time_is_removed) {
    struct srv_store_rules brief = ground_rules;
    struct srv_store_sweep sweep;
    OWN(srv_store, close) *own;
    struct srv_lease lease;
    struct srv_job job;
    struct pend_error error;
    (void)store;
    brief.keep_us = 1000;
    REQUIRE(srv_store_open(&own, ground->url, &brief, &error) == PEND_OK);
    CHECK_INT(ground_submit(own, "j", "anna", "k", 1, 0, &job), SRV_STORED);
    CHECK_INT(ground_claim(own, "w", 60 * SECOND, &lease), SRV_STORED);
    CHECK_INT(srv_store_finish(own, &lease, "abc", 3, NULL, 0), SRV_STORED);
    for (int i = 0; i < 10; i++) {
        ground_pause_ms(2);
        CHECK_INT(srv_store_sweep(own, NULL, &sweep), SRV_STORED);
    }
    CHECK_INT(srv_store_job(own, "j", &job), SRV_STORED_NONE);
    CHECK_INT(ground_submit(own, "again", "anna", "k", 1, 0, &job), SRV_STORED);
    CHECK_TEXT(job.id, "again");
}

/* a connection whose jobs expire at once */
static struct srv_store *brief_open(struct ground *ground) {
    ground->rules.keep_us = 1000;
    return ground_open(ground);
}

/* submits a job and finishes its parts, each with this many bytes */
static void brief_job(struct srv_store *store, const char *id, long parts, size_t bytes) {
    static char data[3 * SRV_CHUNK_BYTES];
    struct srv_lease lease;
    struct srv_job job;
    CHECK_INT(ground_submit(store, id, "anna", NULL, parts, 0, &job), SRV_STORED);
    for (long i = 0; i < parts; i++) {
        CHECK_INT(ground_claim(store, "w", 60 * SECOND, &lease), SRV_STORED);
        CHECK_INT(srv_store_finish(store, &lease, data, bytes, NULL, 0), SRV_STORED);
    }
}

/* sweeps until nothing is left; returns the number of sweeps, at most 100 */
static int brief_sweep(struct srv_store *store, int *expired) {
    struct srv_store_sweep sweep = {.more = 1};
    int sweeps = 0;
    for (*expired = 0; sweep.more && sweeps < 100; sweeps++) {
        CHECK_INT(srv_store_sweep(store, NULL, &sweep), SRV_STORED);
        *expired += sweep.expired;
    }
    return sweeps;
}

/* 300 jobs with results take only as many steps as their number requires, and are deleted directly,
 * without becoming "dismissed" */
STORE_TEST(expired_jobs_go_many_at_a_time_and_as_they_are) {
    OWN(srv_store, close) *own = brief_open(ground);
    struct srv_store_figures figures;
    char id[16];
    int expired;
    (void)store;
    REQUIRE(own);
    for (int i = 0; i < 300; i++) {
        snprintf(id, sizeof id, "j%d", i);
        brief_job(own, id, 1, 5);
    }
    ground_pause_ms(5);
    int sweeps = brief_sweep(own, &expired);
    /* 128 at a time, so that no other call waits long, and one or two sweeps that find nothing */
    CHECK_SAYING(sweeps >= 4 && sweeps <= 5, "%d sweeps", sweeps);
    CHECK_INT(expired, 300);
    CHECK_INT(srv_store_figures(own, &figures), SRV_STORED);
    CHECK(!figures.jobs[SRV_JOB_SUCCESSFUL] && !figures.jobs[SRV_JOB_DISMISSED] && !figures.bytes);
    CHECK_INT(ground_ask(ground, "SELECT CAST(COUNT(*) AS BIGINT) FROM parts"), 0);
    CHECK_INT(ground_ask(ground, "SELECT CAST(COUNT(*) AS BIGINT) FROM results"), 0);
    ground_sums(ground);
}

/* the row of a large job is deleted at once, the rest piece by piece, counted until then */
STORE_TEST(a_large_expired_job_goes_piece_by_piece) {
    OWN(srv_store, close) *own = brief_open(ground);
    struct srv_store_figures figures;
    struct srv_store_sweep sweep;
    struct srv_job job;
    int expired;
    (void)store;
    REQUIRE(own);
    brief_job(own, "j", 40, 3 * SRV_CHUNK_BYTES);
    ground_pause_ms(5);
    CHECK_INT(srv_store_sweep(own, NULL, &sweep), SRV_STORED);
    CHECK(sweep.more && sweep.expired == 1);
    CHECK_INT(srv_store_job(own, "j", &job), SRV_STORED_NONE);
    CHECK_INT(srv_store_figures(own, &figures), SRV_STORED);
    CHECK_INT(figures.bytes, 120LL * SRV_CHUNK_BYTES);
    ground_sums(ground);
    CHECK_INT(brief_sweep(own, &expired), 3);
    CHECK_INT(srv_store_figures(own, &figures), SRV_STORED);
    CHECK_INT(figures.bytes, 0);
    CHECK_INT(ground_ask(ground, "SELECT CAST(COUNT(*) AS BIGINT) FROM parts"), 0);
    ground_sums(ground);
}

/* the time announced to its client is kept, also when it is dismissed after its end */
STORE_TEST(a_job_that_ended_expires_when_it_was_said_to) {
    struct srv_job ended, job;
    (void)ground;
    brief_job(store, "j", 1, 5);
    CHECK_INT(srv_store_job(store, "j", &ended), SRV_STORED);
    ground_pause_ms(3);
    CHECK_INT(srv_store_dismiss(store, "j", &job), SRV_STORED);
    CHECK(job.state == SRV_JOB_DISMISSED && job.expires == ended.expires &&
          job.finished == ended.finished);
    CHECK_INT(srv_store_job(store, "j", &job), SRV_STORED);
    CHECK(job.state == SRV_JOB_DISMISSED && job.expires == ended.expires &&
          job.finished == ended.finished);
    ground_sums(ground);
}

/* a clock that is a week ahead for a while deletes no result; once it is trusted, it does */
STORE_TEST(a_clock_that_jumps_ahead_ends_no_job) {
    OWN(srv_store, close) *own = brief_open(ground);
    struct srv_store_sweep sweep;
    struct srv_job job;
    (void)store;
    REQUIRE(own);
    CHECK_INT(srv_store_sweep(own, NULL, &sweep), SRV_STORED);
    brief_job(own, "j", 1, 5);
    ground_pause_ms(5);
    own->expiry.seen -= 7LL * 86400 * SECOND;
    CHECK_INT(srv_store_sweep(own, NULL, &sweep), SRV_STORED);
    CHECK(!sweep.expired && !sweep.more);
    CHECK_INT(srv_store_job(own, "j", &job), SRV_STORED);
    CHECK_INT(job.state, SRV_JOB_SUCCESSFUL);
    own->expiry.hold_ns = 0;
    CHECK_INT(srv_store_sweep(own, NULL, &sweep), SRV_STORED);
    CHECK_INT(sweep.expired, 1);
}
