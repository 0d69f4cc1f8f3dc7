/* Tests of server/store/store_seals: rows with possible values that were not written like that, or
 * not there. */
#include "server/store/store_rows.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/server/ground.h"

/* a statement with one byte string in it, in the database's notation: %s */
static void seals_bytes(const struct ground *ground, const char *before, const char *text,
                        const char *after) {
    char hex[64], statement[512];
    for (size_t i = 0; text[i]; i++) snprintf(hex + 2 * i, 3, "%02x", (unsigned char)text[i]);
    snprintf(statement, sizeof statement, ground->postgres ? "%s '\\x%s'::bytea %s" : "%s X'%s' %s",
             before, hex, after);
    ground_run(ground, statement);
}

/* claims until no claim must be repeated; returns whether a part was found */
static int seals_claim(struct srv_store *store, struct srv_lease *lease) {
    enum srv_stored stored = SRV_STORED_AGAIN;
    for (int tries = 0; stored == SRV_STORED_AGAIN && tries < 20; tries++)
        stored = ground_claim_whole(store, "w", 60 * (int64_t)SECOND, lease);
    CHECK_SAYING(stored == SRV_STORED || stored == SRV_STORED_NONE, "the claims end with %d: %s",
                 stored, srv_store_complaint(store));
    return stored == SRV_STORED;
}

static void seals_failed(struct srv_store *store, const char *id, const char *word) {
    struct srv_job job;
    CHECK_INT(srv_store_job(store, id, &job), SRV_STORED);
    CHECK_SAYING(job.state == SRV_JOB_FAILED && strstr(job.message, word), "%s is %d: %s", id,
                 job.state, job.message);
    /* it stays so when it is read again */
    CHECK_INT(srv_store_job(store, id, &job), SRV_STORED);
    CHECK_SAYING(job.state == SRV_JOB_FAILED && !job.flaw, "%s: %s", id, job.flaw ? job.flaw : "");
}

STORE_TEST(a_job_whose_request_became_another_good_one_fails) {
    struct srv_lease lease;
    struct srv_job job;
    CHECK_INT(ground_submit(store, "changed", "anna", NULL, 1, 0, &job), SRV_STORED);
    seals_bytes(ground, "UPDATE jobs SET request =", "{\"a\":2}", "");
    CHECK_INT(ground_submit(store, "good", "anna", NULL, 1, 0, &job), SRV_STORED);
    if (CHECK(seals_claim(store, &lease))) {
        CHECK_TEXT(lease.job, "good");
        CHECK(lease.request_bytes == 7 && !memcmp(lease.request, "{\"a\":1}", 7));
        CHECK_INT(srv_store_finish(store, &lease, "r", 1, NULL, 0), SRV_STORED);
        srv_lease_clear(&lease);
    }
    seals_failed(store, "changed", "request");
    CHECK_INT(srv_store_job(store, "good", &job), SRV_STORED);
    CHECK_INT(job.state, SRV_JOB_SUCCESSFUL);
    ground_sums(ground);
}

STORE_TEST(a_long_request_is_judged_when_it_is_read) {
    char request[6000];
    struct srv_job_order order = ground_order("long", "anna");
    order.request = request;
    order.request_bytes = sizeof request;
    struct srv_lease lease;
    struct srv_job job;
    void *back;
    size_t bytes;
    memset(request, ' ', sizeof request);
    CHECK_INT(srv_store_submit(store, &order, &job), SRV_STORED);
    CHECK_INT(srv_store_job_request(store, "long", &back, &bytes), SRV_STORED);
    CHECK(bytes == sizeof request && !memcmp(back, request, bytes));
    free(back);
    if (!CHECK(seals_claim(store, &lease))) return;
    CHECK(!lease.request);
    ground_run(ground, ground->postgres
                           ? "UPDATE jobs SET request = set_byte(request, 5000, 33)"
                           : "UPDATE jobs SET request = CAST(substr(request, 1, 5000) || X'21' || "
                             "substr(request, 5002) AS BLOB)");
    CHECK_INT(srv_store_job_request(store, "long", &back, &bytes), SRV_STORED_DAMAGED);
    CHECK(!back);
    CHECK_INT(srv_store_finish(store, &lease, "r", 1, NULL, 0), SRV_STORED_LOST);
    seals_failed(store, "long", "request");
    /* it has no request any more, which is no damage */
    CHECK_INT(srv_store_job_request(store, "long", &back, &bytes), SRV_STORED);
    CHECK_INT((long long)bytes, 0);
    free(back);
    srv_lease_clear(&lease);
    ground_sums(ground);
}

STORE_TEST(what_never_changes_of_a_job_has_not_changed) {
    static const char *const change[] = {
        "operation = 'forces'",     "parts = 3",     "chained = 1",       "created = created + 1",
        "client = 'berta'",         "seal = digest", "title = 'b title'", "version = ''",
        "title = '', version = ''", "id = 'moved'",
    };
    enum { CHANGES = sizeof change / sizeof *change };
    struct srv_job job, page[10];
    char text[128];
    void *request;
    size_t bytes;
    int count;
    for (int i = 0; i < CHANGES; i++) {
        CHECK_INT(ground_submit(store, "j", "anna", NULL, 2, 0, &job), SRV_STORED);
        snprintf(text, sizeof text, "UPDATE jobs SET %s WHERE id = 'j'", change[i]);
        ground_run(ground, text);
        const char *id = i == CHANGES - 1 ? "moved" : "j",
                   *client = strstr(text, "berta") ? "berta" : "anna";
        CHECK_INT(ground_list(store, client, NULL, 10, page, &count), SRV_STORED);
        CHECK_SAYING(count == 1 && page[0].state == SRV_JOB_FAILED, "%s: %d", change[i],
                     page[0].state);
        CHECK_INT(srv_store_job(store, id, &job), SRV_STORED);
        CHECK_SAYING(job.state == SRV_JOB_FAILED && strstr(job.message, "seal"), "%s: %d %s",
                     change[i], job.state, job.message);
        seals_failed(store, id, "seal");
        CHECK_INT(srv_store_job_request(store, id, &request, &bytes), SRV_STORED);
        free(request);
        ground_run(ground, "DELETE FROM jobs");
        ground_run(ground, "DELETE FROM clients");
        ground_run(ground, "DELETE FROM removals WHERE job <> '.'");
    }
}

/* two finished jobs, each of two parts with one chunk each */
static void seals_results(struct srv_store *store) {
    static const char *const jobs[] = {"one", "two"};
    struct srv_lease lease;
    struct srv_job job;
    char data[64];
    for (int i = 0; i < 2; i++) {
        CHECK_INT(ground_submit(store, jobs[i], "anna", NULL, 2, 0, &job), SRV_STORED);
        for (int part = 0; part < 2; part++) {
            CHECK_INT(ground_claim(store, "w", 60 * (int64_t)SECOND, &lease), SRV_STORED);
            snprintf(data, sizeof data, "%s %ld", lease.job, lease.part);
            CHECK_INT(srv_store_finish(store, &lease, data, strlen(data), NULL, 0), SRV_STORED);
            srv_lease_clear(&lease);
        }
    }
}

STORE_TEST(chunks_of_results_that_were_exchanged_are_found) {
    char back[SRV_CHUNK_BYTES];
    size_t bytes;
    seals_results(store);
    CHECK_INT(srv_store_chunk(store, "one", 1, 0, back, &bytes), SRV_STORED);
    CHECK(bytes == 5 && !memcmp(back, "one 1", 5));
    /* the same part of two jobs */
    ground_run(ground, "UPDATE results SET job = 'x' WHERE job = 'one' AND part = 0");
    ground_run(ground, "UPDATE results SET job = 'one' WHERE job = 'two' AND part = 0");
    ground_run(ground, "UPDATE results SET job = 'two' WHERE job = 'x'");
    CHECK_INT(srv_store_chunk(store, "one", 0, 0, back, &bytes), SRV_STORED_DAMAGED);
    CHECK_INT(srv_store_chunk(store, "two", 0, 0, back, &bytes), SRV_STORED_DAMAGED);
    CHECK_INT(srv_store_chunk(store, "two", 1, 0, back, &bytes), SRV_STORED);
    /* two parts of one job */
    ground_run(ground, "UPDATE results SET part = 7 WHERE job = 'two' AND part = 1");
    CHECK_INT(srv_store_chunk(store, "two", 7, 0, back, &bytes), SRV_STORED_DAMAGED);
}

STORE_TEST(a_chunk_or_a_scene_with_another_seal_is_damaged) {
    char back[SRV_CHUNK_BYTES];
    void *body;
    size_t bytes;
    seals_results(store);
    CHECK_INT(srv_store_scene_put(store, "scene", "anna", NULL, "{}", 2), SRV_STORED);
    CHECK_INT(srv_store_scene_put(store, "other", "anna", NULL, "[]", 2), SRV_STORED);
    ground_run(ground, "UPDATE results SET seal = data");
    CHECK_INT(srv_store_chunk(store, "one", 0, 0, back, &bytes), SRV_STORED_DAMAGED);
    ground_run(ground, "UPDATE scenes SET seal = body WHERE id = 'scene'");
    CHECK_INT(srv_store_scene(store, "scene", &body, &bytes), SRV_STORED_DAMAGED);
    CHECK(!body);
    CHECK_INT(srv_store_scene_put(store, "scene", "anna", NULL, "{}", 2), SRV_STORED_DAMAGED);
    /* it can be deleted, and stored again */
    CHECK_INT(srv_store_scene_drop(store, "scene", "anna"), SRV_STORED);
    CHECK_INT(srv_store_scene_put(store, "scene", "anna", NULL, "{}", 2), SRV_STORED);
    CHECK_INT(srv_store_scene(store, "scene", &body, &bytes), SRV_STORED);
    free(body);
    seals_bytes(ground, "UPDATE scenes SET body =", "[]", "WHERE id = 'scene'");
    CHECK_INT(srv_store_scene(store, "scene", &body, &bytes), SRV_STORED_DAMAGED);
    CHECK_INT(srv_store_scene(store, "other", &body, &bytes), SRV_STORED);
    CHECK(bytes == 2 && !memcmp(body, "[]", 2));
    free(body);
    ground_sums(ground);
}

STORE_TEST(a_rank_that_a_claim_would_overflow_fails_its_job_and_no_claim_is_made_again_for_ever) {
    struct srv_lease lease;
    struct srv_job job;
    CHECK_INT(ground_submit(store, "bad", "anna", NULL, 2, 0, &job), SRV_STORED);
    CHECK_INT(ground_submit(store, "good", "anna", NULL, 1, 0, &job), SRV_STORED);
    ground_run(ground,
               "UPDATE jobs SET rank = -9223372036854775807, part_us = 1000 WHERE id = 'bad'");
    if (CHECK(seals_claim(store, &lease))) {
        CHECK_TEXT(lease.job, "good");
        srv_lease_clear(&lease);
    }
    CHECK(!seals_claim(store, &lease));
    seals_failed(store, "bad", "rank");
    ground_sums(ground);
}

STORE_TEST(a_damaged_job_does_not_end_a_list_of_those_since_an_instant) {
    static const char *const id[] = {"one", "bad", "two"};
    struct srv_job job[3];
    char last[SRV_ID_BYTES];
    int count = 0;
    for (int i = 0; i < 3; i++)
        CHECK_INT(ground_submit(store, id[i], "anna", NULL, 1, 0, &job[0]), SRV_STORED);
    struct srv_job_wish wish = {
        .state = SRV_JOB_STATES, .since = job[0].created - SECOND, .most = 3};
    ground_run(ground, "UPDATE jobs SET state = 99 WHERE id = 'bad'");
    CHECK_INT(srv_store_list(store, "anna", &wish, job, &count, last), SRV_STORED);
    CHECK_INT(count, 3);
    for (int i = 0; i < count; i++) CHECK_INT(job[i].flaw != NULL, !strcmp(job[i].id, "bad"));
    /* the newest first: an undamaged one from before the instant ends it */
    wish.since += 3600 * (int64_t)SECOND;
    CHECK_INT(srv_store_list(store, "anna", &wish, job, &count, last), SRV_STORED);
    CHECK_INT(count, 0);
}
