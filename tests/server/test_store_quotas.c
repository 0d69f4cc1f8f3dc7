/* Tests of server/store_quotas: what is too much. */
#include "server/store_quotas.h"

#include <string.h>

#include "tests/server/ground.h"

STORE_TEST(quotas_hold_and_say_so) {
    struct srv_lease lease;
    struct srv_job job;
    struct srv_store_sweep sweep;
    struct srv_store_rules tight = {
        .client_jobs = 2, .client_bytes = 1000, .all_bytes = 1500, .keep_us = 3600LL * SECOND, .client_scenes = 1};
    struct srv_store *own;
    struct pend_error error;
    static char data[1600];
    (void)store;
    REQUIRE(srv_store_open(&own, ground->url, &tight, &error) == PEND_OK);
    CHECK_INT(ground_submit(own, "j1", "anna", NULL, 2, 0, &job), SRV_STORED);
    CHECK_INT(ground_submit(own, "j2", "anna", NULL, 1, 0, &job), SRV_STORED);
    CHECK_INT(ground_submit(own, "j3", "anna", NULL, 1, 0, &job), SRV_STORED_QUOTA);
    CHECK(strstr(job.message, "max-client-jobs") != NULL);
    CHECK_INT(srv_store_claim(own, "w", 60 * SECOND, &lease), SRV_STORED);
    CHECK_INT(srv_store_finish(own, &lease, data, 600, NULL, 0), SRV_STORED);
    do CHECK_INT(srv_store_claim(own, "w", 60 * SECOND, &lease), SRV_STORED);
    while (strcmp(lease.job, "j1"));
    CHECK_INT(srv_store_finish(own, &lease, data, 600, NULL, 0), SRV_STORED_QUOTA);
    CHECK_INT(srv_store_job(own, "j1", &job), SRV_STORED);
    CHECK(job.state == SRV_JOB_FAILED && strstr(job.message, "max-client-bytes"));
    /* the failed job's bytes go, and there is room again */
    do CHECK_INT(srv_store_sweep(own, NULL, &sweep), SRV_STORED);
    while (sweep.more);
    CHECK_INT(srv_store_job(own, "j1", &job), SRV_STORED);
    CHECK_INT(job.bytes, 0);
    CHECK_INT(ground_submit(own, "j5", "anna", NULL, 1, 0, &job), SRV_STORED);
    do CHECK_INT(srv_store_claim(own, "w", 60 * SECOND, &lease), SRV_STORED);
    while (strcmp(lease.job, "j5"));
    CHECK_INT(srv_store_finish(own, &lease, data, 1000, NULL, 0), SRV_STORED);
    CHECK_INT(ground_submit(own, "b1", "berta", NULL, 1, 0, &job), SRV_STORED);
    CHECK_INT(srv_store_claim(own, "w", 60 * SECOND, &lease), SRV_STORED);
    CHECK_INT(srv_store_finish(own, &lease, data, 600, NULL, 0), SRV_STORED_QUOTA);
    CHECK_INT(srv_store_job(own, "b1", &job), SRV_STORED);
    CHECK(strstr(job.message, "max-store-bytes") != NULL);
    srv_store_close(&own);
}
