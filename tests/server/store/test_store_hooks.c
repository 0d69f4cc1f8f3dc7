/* Tests of server/store/store_hooks: hooks are due from the end of their job until somebody has
 * said how it went. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/server/ground.h"

enum { MOST = 4 };

static const char url[] = "https://example.org/hook?for=anna";

static enum srv_stored hooked(struct srv_store *store, const char *id, const char *client) {
    struct srv_job job;
    struct srv_job_order order = ground_order(id, client);
    order.hook = url;
    enum srv_stored stored = srv_store_submit(store, &order, &job);
    CHECK(stored != SRV_STORED || job.notify == SRV_NOTIFY_WANTED);
    return stored;
}

static void end(struct srv_store *store) {
    struct srv_lease lease;
    CHECK_INT(ground_claim(store, "w", 60 * SECOND, &lease), SRV_STORED);
    CHECK_INT(srv_store_finish(store, &lease, "x", 1, NULL, 0), SRV_STORED);
}

static int taken(struct srv_store *store, int64_t lease_us, struct srv_hook hook[MOST]) {
    static const char *const busy[SRV_HOOKS_BUSY];
    int count;
    enum srv_stored stored = srv_store_hooks_take(store, lease_us, busy, MOST, hook, &count);
    CHECK_INT(stored, count ? SRV_STORED : SRV_STORED_NONE);
    return count;
}

static long long kept(const struct ground *ground) {
    return ground_ask(ground, "SELECT CAST(COUNT(*) AS BIGINT) FROM hooks");
}

STORE_TEST(a_hook_is_due_when_its_job_has_ended_and_is_taken_by_one) {
    struct srv_store *other = ground_open(ground);
    struct srv_hook hook[MOST];
    struct srv_job job;
    REQUIRE(other);
    CHECK_INT(ground_submit(store, "plain", "anna", NULL, 1, 0, &job), SRV_STORED);
    end(store);
    CHECK_INT(hooked(store, "j", "anna"), SRV_STORED);
    CHECK_INT(taken(store, 60 * SECOND, hook), 0);
    end(store);
    CHECK_INT(taken(store, 60 * SECOND, hook), 1);
    CHECK(!strcmp(hook[0].job.id, "j") && !strcmp(hook[0].url, url) && hook[0].attempt == 1);
    CHECK(hook[0].job.state == SRV_JOB_SUCCESSFUL && hook[0].job.finished > 0);
    CHECK_INT(taken(other, 60 * SECOND, hook), 0);
    CHECK_INT(srv_store_hook_told(store, "j", 1, SRV_NOTIFY_DELIVERED, 0, 204), SRV_STORED);
    CHECK_INT(srv_store_hook_told(store, "j", 1, SRV_NOTIFY_DELIVERED, 0, 204), SRV_STORED_LOST);
    CHECK_INT(srv_store_job(other, "j", &job), SRV_STORED);
    CHECK(job.notify == SRV_NOTIFY_DELIVERED && job.notify_attempts == 1);
    CHECK_INT(job.notify_status, 204);
    /* the url goes with the hook */
    CHECK_INT(kept(ground), 0);
    ground_sums(ground);
    srv_store_close(&other);
}

STORE_TEST(who_took_a_hook_and_died_is_followed_by_another_and_not_heard) {
    struct srv_store *other = ground_open(ground);
    struct srv_hook hook[MOST];
    struct srv_job job;
    REQUIRE(other);
    CHECK_INT(hooked(store, "j", "anna"), SRV_STORED);
    end(store);
    CHECK_INT(taken(store, 1000, hook), 1);
    ground_pause_ms(5);
    CHECK_INT(taken(other, 60 * SECOND, hook), 1);
    CHECK_INT(hook[0].attempt, 2);
    CHECK_INT(srv_store_hook_told(store, "j", 1, SRV_NOTIFY_FAILED, 0, 500), SRV_STORED_LOST);
    /* it is due again at once, and then after a while */
    CHECK_INT(srv_store_hook_told(other, "j", 2, SRV_NOTIFY_WANTED, 0, 503), SRV_STORED);
    CHECK_INT(srv_store_job(store, "j", &job), SRV_STORED);
    CHECK(job.notify == SRV_NOTIFY_WANTED && job.notify_attempts == 2 && job.notify_status == 503);
    ground_pause_ms(2);
    CHECK_INT(taken(store, 60 * SECOND, hook), 1);
    CHECK_INT(srv_store_hook_told(store, "j", 3, SRV_NOTIFY_WANTED, 3600LL * SECOND, 0),
              SRV_STORED);
    CHECK_INT(taken(store, 60 * SECOND, hook), 0);
    srv_store_close(&other);
}

STORE_TEST(every_end_of_a_job_is_told) {
    struct srv_hook hook[MOST];
    struct srv_lease lease;
    struct srv_job job;
    CHECK_INT(hooked(store, "failed", "anna"), SRV_STORED);
    CHECK_INT(ground_claim(store, "w", 60 * SECOND, &lease), SRV_STORED);
    CHECK_INT(srv_store_fail(store, &lease, "no"), SRV_STORED);
    CHECK_INT(hooked(store, "dismissed", "anna"), SRV_STORED);
    CHECK_INT(srv_store_dismiss(store, "dismissed", &job), SRV_STORED);
    CHECK_INT(hooked(store, "damaged", "anna"), SRV_STORED);
    ground_run(ground, "UPDATE jobs SET operation = 'forces' WHERE id = 'damaged'");
    CHECK_INT(srv_store_job(store, "damaged", &job), SRV_STORED);
    CHECK_INT(job.state, SRV_JOB_FAILED);
    CHECK_INT(taken(store, 60 * SECOND, hook), 3);
    CHECK_TEXT(hook[0].job.id, "failed");
    CHECK_TEXT(hook[0].job.message, "no");
    CHECK_INT(hook[1].job.state, SRV_JOB_DISMISSED);
    CHECK_TEXT(hook[2].job.id, "damaged");
    CHECK_INT(hook[2].job.state, SRV_JOB_FAILED);
    ground_sums(ground);
}

STORE_TEST(hooks_go_with_their_jobs_and_with_their_client) {
    struct srv_hook hook[MOST];
    struct srv_store_sweep sweep;
    int count;
    CHECK_INT(hooked(store, "open", "anna"), SRV_STORED);
    CHECK_INT(hooked(store, "other", "bert"), SRV_STORED);
    CHECK_INT(srv_store_erase_jobs(store, "anna", SRV_ERASE_MOST, &count), SRV_STORED);
    CHECK_INT(count, 1);
    CHECK_INT(kept(ground), 1);
    end(store);
    ground_run(ground, "UPDATE jobs SET expires = 1");
    do CHECK_INT(srv_store_sweep(store, NULL, &sweep), SRV_STORED);
    while (sweep.more);
    CHECK_INT(kept(ground), 0);
    /* one whose job is gone all the same, and one that nobody can have written */
    CHECK_INT(hooked(store, "bad", "anna"), SRV_STORED);
    end(store);
    ground_run(ground,
               "INSERT INTO hooks (job, client, url, due) VALUES ('gone', 'anna', 'https://x', 1)");
    ground_run(ground, "UPDATE hooks SET url = '' WHERE job = 'bad'");
    CHECK_INT(taken(store, 60 * SECOND, hook), 0);
    CHECK_INT(kept(ground), 0);
    ground_sums(ground);
}

STORE_TEST(a_job_that_does_not_know_its_hook_any_more_loses_it) {
    struct srv_hook hook[MOST];
    struct srv_store_sweep sweep;
    struct srv_job job;
    /* what cannot be read is told, and what says that there is none goes with its job */
    CHECK_INT(hooked(store, "unread", "anna"), SRV_STORED);
    CHECK_INT(hooked(store, "denied", "anna"), SRV_STORED);
    ground_run(ground, "UPDATE jobs SET notify = 77 WHERE id = 'unread'");
    ground_run(ground, "UPDATE jobs SET notify = 0 WHERE id = 'denied'");
    CHECK_INT(srv_store_job(store, "unread", &job), SRV_STORED);
    CHECK_INT(job.state, SRV_JOB_FAILED);
    CHECK_INT(taken(store, 60 * SECOND, hook), 1);
    CHECK_TEXT(hook[0].job.id, "unread");
    end(store);
    CHECK_INT(kept(ground), 2);
    ground_run(ground, "UPDATE jobs SET expires = 1");
    do CHECK_INT(srv_store_sweep(store, NULL, &sweep), SRV_STORED);
    while (sweep.more);
    CHECK_INT(kept(ground), 0);
    ground_sums(ground);
}

STORE_TEST(an_altered_hook_harms_no_other) {
    static const char *const value[] = {"NULL", "-1", "9223372036854775807", "'word'", "''"};
    static const char *const column[] = {"job", "url", "due", "attempts", "client"};
    struct srv_hook hook[MOST];
    char id[24], text[200];
    int told = 0;
    for (int i = 0; i < 25; i++) {
        struct srv_sql *sql;
        struct pend_error error;
        snprintf(id, sizeof id, "bad%d", i);
        CHECK_INT(hooked(store, id, "anna"), SRV_STORED);
        end(store);
        snprintf(text, sizeof text, "UPDATE hooks SET %s = %s WHERE job = '%s'", column[i / 5],
                 value[i % 5], id);
        const struct srv_sql_driver *driver =
            ground->postgres ? &srv_sql_postgres : &srv_sql_sqlite;
        REQUIRE(driver->open(&sql, ground->url, 0, &error) == PEND_OK);
        /* the database may refuse it */
        driver->run(sql, -1, text, NULL, 0, NULL, NULL);
        driver->close(sql);
    }
    CHECK_INT(hooked(store, "good", "anna"), SRV_STORED);
    end(store);
    /* rounds that find nothing but what is to go are no reason to stop */
    for (int i = 0; i < 25; i++) {
        int count = taken(store, 60 * SECOND, hook);
        for (int k = 0; k < count; k++) told |= !strcmp(hook[k].job.id, "good");
    }
    CHECK(told);
    ground_sums(ground);
}

STORE_TEST(hooks_of_busy_clients_wait_for_those_of_others) {
    static const char *const busy[SRV_HOOKS_BUSY] = {"anna"};
    struct srv_hook hook[MOST];
    int count;
    CHECK_INT(hooked(store, "first", "anna"), SRV_STORED);
    CHECK_INT(hooked(store, "second", "bert"), SRV_STORED);
    end(store);
    end(store);
    CHECK_INT(srv_store_hooks_take(store, 60 * SECOND, busy, MOST, hook, &count), SRV_STORED);
    CHECK(count == 1 && !strcmp(hook[0].job.id, "second"));
    CHECK_INT(taken(store, 60 * SECOND, hook), 1);
    CHECK_TEXT(hook[0].job.id, "first");
    ground_sums(ground);
}

STORE_TEST(hooks_of_busy_sources_wait_for_those_of_others) {
    static const char *const busy[SRV_HOOKS_BUSY] = {[SRV_HOOKS_CLIENTS] = "a school"};
    struct srv_hook hook[MOST];
    int count;
    CHECK_INT(hooked(store, "first", "anna"), SRV_STORED);
    CHECK_INT(hooked(store, "second", "bert"), SRV_STORED);
    CHECK_INT(hooked(store, "third", "carl"), SRV_STORED);
    for (int i = 0; i < 3; i++) end(store);
    ground_run(ground, "UPDATE clients SET source = 'a school' WHERE name <> 'bert'");
    CHECK_INT(srv_store_hooks_take(store, 60 * SECOND, busy, MOST, hook, &count), SRV_STORED);
    CHECK(count == 1 && !strcmp(hook[0].job.id, "second"));
    CHECK(strcmp(hook[0].source, "a school") != 0);
    CHECK_INT(taken(store, 60 * SECOND, hook), 2);
    CHECK_TEXT(hook[0].source, "a school");
}
