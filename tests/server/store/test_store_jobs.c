/* Tests of server/store/store_jobs: keys and lists. */
#include "server/store/store_jobs.h"

#include <pthread.h>
#include <stdio.h>
#include <string.h>

#include "tests/server/ground.h"

STORE_TEST(a_key_makes_one_job_and_no_other) {
    struct srv_job job;
    unsigned char digest[SRV_DIGEST_BYTES] = {9};
    struct srv_job_order other = ground_order("j3", "anna");
    other.key = "k";
    other.digest = digest;
    (void)ground;
    CHECK_INT(ground_submit(store, "j1", "anna", "k", 1, 0, &job), SRV_STORED);
    CHECK_INT(ground_submit(store, "j2", "anna", "k", 1, 0, &job), SRV_STORED);
    CHECK_TEXT(job.id, "j1");
    CHECK_INT(srv_store_job(store, "j2", &job), SRV_STORED_NONE);
    CHECK_INT(srv_store_submit(store, &other, &job), SRV_STORED_CLASH);
    CHECK_INT(ground_submit(store, "j4", "berta", "k", 1, 0, &job), SRV_STORED);
    CHECK_TEXT(job.id, "j4");
    struct srv_store_figures figures;
    CHECK_INT(srv_store_figures(store, &figures), SRV_STORED);
    CHECK(figures.jobs[SRV_JOB_ACCEPTED] == 2 && figures.parts == 2);
}

struct doubled {
    struct srv_store *store;
    int number;
    enum srv_stored stored;
    struct srv_job job;
};

static void *submit_doubled(void *context) {
    struct doubled *doubled = context;
    char own[16];
    snprintf(own, sizeof own, "d%d", doubled->number);
    doubled->stored = SRV_STORED_AGAIN;
    for (int i = 0; i < 20 && doubled->stored == SRV_STORED_AGAIN; i++)
        doubled->stored = ground_submit(doubled->store, own, "anna", "same", 1, 0, &doubled->job);
    return NULL;
}

STORE_TEST(doubled_submissions_from_eight_clients_make_one_job) {
    struct doubled doubled[8] = {{0}};
    pthread_t thread[8];
    struct srv_store_figures figures;
    for (int i = 0; i < 8; i++) {
        doubled[i].store = ground_open(ground);
        doubled[i].number = i;
        REQUIRE(doubled[i].store);
    }
    for (int i = 0; i < 8; i++)
        REQUIRE(!pthread_create(&thread[i], NULL, submit_doubled, &doubled[i]));
    for (int i = 0; i < 8; i++) pthread_join(thread[i], NULL);
    for (int i = 0; i < 8; i++) {
        CHECK_INT(doubled[i].stored, SRV_STORED);
        CHECK_TEXT(doubled[i].job.id, doubled[0].job.id);
        srv_store_close(&doubled[i].store);
    }
    CHECK_INT(srv_store_figures(store, &figures), SRV_STORED);
    CHECK_INT(figures.jobs[SRV_JOB_ACCEPTED], 1);
}

STORE_TEST(a_list_is_the_clients_own_newest_first) {
    struct srv_job job[8];
    char id[16];
    int count;
    (void)ground;
    for (int i = 0; i < 10; i++) {
        snprintf(id, sizeof id, "j%d", i);
        CHECK_INT(ground_submit(store, id, i % 2 ? "anna" : "berta", NULL, 1, 0, &job[0]),
                  SRV_STORED);
    }
    CHECK_INT(ground_list(store, "anna", NULL, 3, job, &count), SRV_STORED);
    CHECK(count == 3 && !strcmp(job[0].id, "j9") && !strcmp(job[1].id, "j7") &&
          !strcmp(job[2].id, "j5"));
    CHECK_INT(ground_list(store, "anna", "j5", 3, job, &count), SRV_STORED);
    CHECK(count == 2 && !strcmp(job[0].id, "j3") && !strcmp(job[1].id, "j1"));
    CHECK_INT(ground_list(store, "anna", "j4", 3, job, &count), SRV_STORED);
    CHECK_INT(count, 0);
}

/* a key whose job was dismissed, has failed or expired makes a new job, for any request */
STORE_TEST(a_key_is_free_again_once_its_job_is_gone) {
    struct srv_job job;
    struct srv_lease lease;
    (void)ground;
    CHECK_INT(ground_submit(store, "a", "anna", "k", 1, 0, &job), SRV_STORED);
    CHECK_INT(srv_store_dismiss(store, "a", &job), SRV_STORED);
    CHECK_INT(ground_submit(store, "b", "anna", "k", 1, 0, &job), SRV_STORED);
    CHECK_TEXT(job.id, "b");
    CHECK_INT(job.state, SRV_JOB_ACCEPTED);
    /* it exists: the same key returns it */
    CHECK_INT(ground_submit(store, "c", "anna", "k", 1, 0, &job), SRV_STORED);
    CHECK_TEXT(job.id, "b");
    CHECK_INT(ground_claim(store, "w", SECOND, &lease), SRV_STORED);
    CHECK_TEXT(lease.job, "b");
    CHECK_INT(srv_store_fail(store, &lease, "it fails"), SRV_STORED);
    srv_lease_clear(&lease);
    CHECK_INT(ground_submit(store, "d", "anna", "k", 1, 0, &job), SRV_STORED);
    CHECK_TEXT(job.id, "d");
    /* the old ones still exist, without the key */
    CHECK_INT(srv_store_job(store, "b", &job), SRV_STORED);
    CHECK_INT(job.state, SRV_JOB_FAILED);
    CHECK_INT(srv_store_dismiss(store, "d", &job), SRV_STORED);
    CHECK_INT(srv_store_dismiss(store, "d", &job), SRV_STORED);
    struct srv_job_order other = ground_order("e", "anna");
    other.key = "k";
    other.digest = (const unsigned char[SRV_DIGEST_BYTES]){9};
    CHECK_INT(srv_store_submit(store, &other, &job), SRV_STORED);
    CHECK_TEXT(job.id, "e");
}

static void finishes(struct srv_store *store, const char *id) {
    OWN(srv_lease, clear) lease;
    CHECK_INT(ground_claim(store, "w", SECOND, &lease), SRV_STORED);
    CHECK_TEXT(lease.job, id);
    CHECK_INT(srv_store_finish(store, &lease, "r", 1, NULL, 0), SRV_STORED);
}

static void on_expiring(struct ground *ground, struct srv_store *unused) {
    struct srv_job job;
    (void)unused;
    /* stored for an hour: a repetition returns the result; stored for no time: it makes a new job,
     * swept or not */
    OWN(srv_store, close) *store = ground_open(ground);
    if (!store) return;
    CHECK_INT(ground_submit(store, "a", "anna", "k", 1, 0, &job), SRV_STORED);
    finishes(store, "a");
    CHECK_INT(ground_submit(store, "b", "anna", "k", 1, 0, &job), SRV_STORED);
    CHECK_TEXT(job.id, "a");
    CHECK_INT(job.state, SRV_JOB_SUCCESSFUL);
    srv_store_close(&store);
    ground->rules.keep_us = 1000;
    store = ground_open(ground);
    if (!store) return;
    CHECK_INT(ground_submit(store, "c", "anna", "l", 1, 0, &job), SRV_STORED);
    finishes(store, "c");
    ground_pause_ms(20);
    CHECK_INT(ground_submit(store, "d", "anna", "l", 1, 0, &job), SRV_STORED);
    CHECK_TEXT(job.id, "d");
    CHECK_INT(job.state, SRV_JOB_ACCEPTED);
}

STORE_TEST(a_key_is_free_again_once_its_job_has_expired) { on_expiring(ground, store); }
