/* Tests of server/store_sweep: what goes, and when. */
#include "server/store.h"

#include "tests/server/ground.h"

STORE_TEST(a_dismissed_job_stops_and_frees_what_it_held) {
    struct srv_lease lease;
    struct srv_store_sweep sweep;
    struct srv_job job;
    struct srv_store_figures figures;
    size_t bytes;
    static char data[100 * SRV_CHUNK_BYTES];
    (void)ground;
    CHECK_INT(srv_store_dismiss(store, "nobody", &job), SRV_STORED_NONE);
    CHECK_INT(ground_submit(store, "j", "anna", NULL, 3, 0, &job), SRV_STORED);
    CHECK_INT(srv_store_claim(store, "w", 60 * SECOND, &lease), SRV_STORED);
    CHECK_INT(srv_store_finish(store, &lease, data, sizeof data, NULL, 0), SRV_STORED);
    CHECK_INT(srv_store_claim(store, "w", 60 * SECOND, &lease), SRV_STORED);
    CHECK_INT(srv_store_dismiss(store, "j", &job), SRV_STORED);
    CHECK_INT(job.state, SRV_JOB_DISMISSED);
    CHECK_INT(srv_store_extend(store, &lease, SECOND), SRV_STORED_LOST);
    CHECK_INT(srv_store_finish(store, &lease, data, 5, NULL, 0), SRV_STORED_LOST);
    CHECK_INT(srv_store_claim(store, "w", SECOND, &lease), SRV_STORED_NONE);
    int sweeps = 0;
    do CHECK_INT(srv_store_sweep(store, NULL, &sweep), SRV_STORED);
    while (sweep.more && ++sweeps < 10);
    CHECK_INT(sweeps, 2);
    CHECK_INT(srv_store_chunk(store, "j", 0, 99, data, &bytes), SRV_STORED_NONE);
    CHECK_INT(srv_store_figures(store, &figures), SRV_STORED);
    CHECK(figures.bytes == 0 && figures.jobs[SRV_JOB_DISMISSED] == 1 && !figures.shards);
}

STORE_TEST(a_job_past_its_time_is_removed) {
    struct srv_store_rules brief = ground_rules;
    struct srv_store_sweep sweep;
    struct srv_store *own;
    struct srv_lease lease;
    struct srv_job job;
    struct pend_error error;
    (void)store;
    brief.keep_us = 1000;
    REQUIRE(srv_store_open(&own, ground->url, &brief, &error) == PEND_OK);
    CHECK_INT(ground_submit(own, "j", "anna", "k", 1, 0, &job), SRV_STORED);
    CHECK_INT(srv_store_claim(own, "w", 60 * SECOND, &lease), SRV_STORED);
    CHECK_INT(srv_store_finish(own, &lease, "abc", 3, NULL, 0), SRV_STORED);
    for (int i = 0; i < 10; i++) {
        ground_pause_ms(2);
        CHECK_INT(srv_store_sweep(own, NULL, &sweep), SRV_STORED);
    }
    CHECK_INT(srv_store_job(own, "j", &job), SRV_STORED_NONE);
    CHECK_INT(ground_submit(own, "again", "anna", "k", 1, 0, &job), SRV_STORED);
    CHECK_TEXT(job.id, "again");
    srv_store_close(&own);
}
