/* Tests of server/store, server/sql and both databases behind them: each law on SQLite and on a real PostgreSQL. */
#include "server/store.h"

#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

#include "tests/harness/postgres.h"
#include "tests/harness/test.h"

static const struct srv_store_rules store_rules = {
    .client_jobs = 1000, .client_bytes = 1 << 28, .all_bytes = 1LL << 30, .keep_us = 3600000000LL, .client_scenes = 3};

/* a database that is empty when a test begins */
struct ground {
    char url[300], path[64];
    struct srv_store_rules rules;
    struct test_postgres *postgres;
};

static struct test_postgres *ground_postgres;

__attribute__((destructor)) static void ground_end(void) { test_postgres_stop(&ground_postgres); }

static int ground_begin(struct ground *ground, int postgres) {
    *ground = (struct ground){.rules = store_rules};
    if (!postgres) {
        snprintf(ground->path, sizeof ground->path, "/tmp/pendulumd-test-XXXXXX");
        if (!mkdtemp(ground->path)) return 0;
        snprintf(ground->url, sizeof ground->url, "sqlite:%s/store.db", ground->path);
        return 1;
    }
    if (!ground_postgres) ground_postgres = test_postgres_start();
    ground->postgres = ground_postgres;
    if (!ground->postgres) return 0;
    snprintf(ground->url, sizeof ground->url, "%s", test_postgres_url(ground->postgres));
    return test_postgres_run(ground->postgres, "DROP SCHEMA public CASCADE; CREATE SCHEMA public");
}

static void ground_clear(struct ground *ground) {
    char command[128];
    if (!*ground->path) return;
    snprintf(command, sizeof command, "rm -rf '%s'", ground->path);
    CHECK(!system(command));
}

static struct srv_store *ground_open(const struct ground *ground) {
    struct pend_error error;
    struct srv_store *store;
    CHECK_SAYING(srv_store_open(&store, ground->url, &ground->rules, &error) == PEND_OK, "%s: %s", ground->url,
                 error.text);
    return store;
}

/* the same test on each store */
#define STORE_TEST(name)                                                                                               \
    static void name(struct ground *ground, struct srv_store *store);                                                  \
    TEST(name##_on_sqlite) { on_ground(0, name); }                                                                     \
    TEST(name##_on_postgresql) { on_ground(1, name); }                                                                 \
    static void name(struct ground *ground, struct srv_store *store)

static void on_ground(int postgres, void (*test)(struct ground *ground, struct srv_store *store)) {
    struct ground ground;
    if (postgres && access("/usr/lib/postgresql", F_OK)) {
        test_skip("PostgreSQL is not installed");
        return;
    }
    REQUIRE(ground_begin(&ground, postgres));
    struct srv_store *store = ground_open(&ground);
    if (store) test(&ground, store);
    srv_store_close(&store);
    ground_clear(&ground);
}

static void pause_ms(int ms) { nanosleep(&(struct timespec){ms / 1000, ms % 1000 * 1000000L}, NULL); }

static enum srv_stored submit(struct srv_store *store, const char *id, const char *client, const char *key, long shards,
                              int chained, struct srv_job *job) {
    unsigned char digest[SRV_DIGEST_BYTES] = {1, 2, 3};
    struct srv_job_order order = {.id = id,
                                  .client = client,
                                  .operation = "ensembles",
                                  .key = key,
                                  .request = "{\"a\":1}",
                                  .request_bytes = 7,
                                  .digest = digest,
                                  .shards = shards,
                                  .chained = chained};
    return srv_store_submit(store, &order, job);
}

#define SECOND 1000000

STORE_TEST(a_job_lives_from_submit_to_results) {
    struct srv_job job;
    struct srv_lease lease;
    void *request;
    size_t bytes;
    static char data[2 * SRV_CHUNK_BYTES + 1000], back[SRV_CHUNK_BYTES];
    (void)ground;
    for (size_t i = 0; i < sizeof data; i++) data[i] = (char)(i * 2654435761u >> 13);
    CHECK_INT(srv_store_job(store, "j1", &job), SRV_STORED_NONE);
    CHECK_INT(srv_store_claim(store, "w", SECOND, &lease), SRV_STORED_NONE);
    CHECK_INT(submit(store, "j1", "anna", NULL, 2, 0, &job), SRV_STORED);
    CHECK_TEXT(job.id, "j1");
    CHECK(job.state == SRV_JOB_ACCEPTED && job.created > 1600000000LL * SECOND && job.now >= job.created &&
          !job.started);
    CHECK_INT(srv_store_request(store, "j1", &request, &bytes), SRV_STORED);
    CHECK(bytes == 7 && !memcmp(request, "{\"a\":1}", 7));
    free(request);
    for (int i = 0; i < 2; i++) {
        CHECK_INT(srv_store_claim(store, "w", 60 * SECOND, &lease), SRV_STORED);
        CHECK_TEXT(lease.job, "j1");
        CHECK_TEXT(lease.operation, "ensembles");
        CHECK(lease.shard == i && lease.shards == 2 && lease.attempt == 1 && !lease.start);
        CHECK_INT(srv_store_extend(store, &lease, 60 * SECOND), SRV_STORED);
        CHECK_INT(srv_store_finish(store, &lease, data, i ? 0 : sizeof data, NULL, 0), SRV_STORED);
        CHECK_INT(srv_store_job(store, "j1", &job), SRV_STORED);
        CHECK(job.done == i + 1 && job.state == (i ? SRV_JOB_SUCCESSFUL : SRV_JOB_RUNNING) && job.bytes == sizeof data);
        srv_lease_clear(&lease);
    }
    CHECK(job.finished >= job.started && llabs(job.expires - job.finished - store_rules.keep_us) < SECOND);
    for (long chunk = 0; chunk < 3; chunk++) {
        size_t want = chunk < 2 ? SRV_CHUNK_BYTES : 1000;
        CHECK_INT(srv_store_chunk(store, "j1", 0, chunk, back, &bytes), SRV_STORED);
        CHECK(bytes == want && !memcmp(back, data + chunk * SRV_CHUNK_BYTES, want));
    }
    CHECK_INT(srv_store_chunk(store, "j1", 0, 3, back, &bytes), SRV_STORED_NONE);
    CHECK_INT(srv_store_chunk(store, "j1", 1, 0, back, &bytes), SRV_STORED_NONE);
}

STORE_TEST(a_late_worker_writes_nothing) {
    struct srv_store *other = ground_open(ground);
    struct srv_store_sweep sweep;
    struct srv_lease late, now;
    struct srv_job job;
    char back[SRV_CHUNK_BYTES];
    size_t bytes;
    REQUIRE(other);
    CHECK_INT(submit(store, "j", "anna", NULL, 1, 0, &job), SRV_STORED);
    CHECK_INT(srv_store_claim(store, "late", 1000, &late), SRV_STORED);
    pause_ms(5);
    CHECK_INT(srv_store_sweep(other, NULL, &sweep), SRV_STORED);
    CHECK(sweep.released == 1 && !sweep.given_up);
    CHECK_INT(srv_store_extend(store, &late, SECOND), SRV_STORED_LOST);
    CHECK_INT(srv_store_claim(other, "now", 60 * SECOND, &now), SRV_STORED);
    CHECK(now.attempt == 2 && now.shard == 0);
    CHECK_INT(srv_store_finish(store, &late, "late", 4, NULL, 0), SRV_STORED_LOST);
    CHECK_INT(srv_store_fail(store, &late, "late"), SRV_STORED_LOST);
    CHECK_INT(srv_store_finish(other, &now, "now", 3, NULL, 0), SRV_STORED);
    CHECK_INT(srv_store_finish(store, &late, "late", 4, NULL, 0), SRV_STORED_LOST);
    /* told twice, because the first answer did not come through: once done */
    CHECK_INT(srv_store_finish(other, &now, "now", 3, NULL, 0), SRV_STORED);
    CHECK_INT(srv_store_chunk(store, "j", 0, 0, back, &bytes), SRV_STORED);
    CHECK(bytes == 3 && !memcmp(back, "now", 3));
    CHECK_INT(srv_store_job(store, "j", &job), SRV_STORED);
    CHECK(job.state == SRV_JOB_SUCCESSFUL && job.done == 1 && job.bytes == 3);
    srv_store_close(&other);
}

STORE_TEST(what_kills_three_workers_is_given_up) {
    struct srv_store_sweep sweep;
    struct srv_lease lease;
    struct srv_job job;
    (void)ground;
    CHECK_INT(submit(store, "poison", "anna", NULL, 7, 0, &job), SRV_STORED);
    /* one before the others, which are done: that the job gets on speaks for it; and as often as it may be afterwards
     */
    for (int i = 0; i <= SRV_MOST_KILLS; i++) {
        CHECK_INT(srv_store_claim(store, "w", 1000, &lease), SRV_STORED);
        CHECK(lease.shard == 0 && lease.attempt == i + 1);
        pause_ms(3);
        CHECK_INT(srv_store_sweep(store, NULL, &sweep), SRV_STORED);
        CHECK_INT(sweep.given_up, i == SRV_MOST_KILLS);
        for (int k = 1; k < 7 && !i; k++) {
            CHECK_INT(srv_store_claim(store, "w", 60000000, &lease), SRV_STORED);
            CHECK_INT(lease.shard, k);
            CHECK_INT(srv_store_finish(store, &lease, "x", 1, NULL, 0), SRV_STORED);
        }
    }
    CHECK_INT(srv_store_job(store, "poison", &job), SRV_STORED);
    CHECK_INT(job.state, SRV_JOB_FAILED);
    CHECK(strstr(job.message, "3 workers") && strstr(job.message, "part 1 of 7"));
    CHECK_INT(srv_store_claim(store, "w", 1000, &lease), SRV_STORED_NONE);
}

STORE_TEST(a_job_all_of_whose_parts_kill_ends_soon) {
    struct srv_store_sweep sweep = {0};
    struct srv_lease lease;
    struct srv_job job;
    int kills = 0;
    (void)ground;
    CHECK_INT(submit(store, "poison", "anna", NULL, 1000, 0, &job), SRV_STORED);
    for (; kills < 20 && !sweep.given_up; kills++) {
        CHECK_INT(srv_store_claim(store, "w", 1000, &lease), SRV_STORED);
        pause_ms(3);
        CHECK_INT(srv_store_sweep(store, NULL, &sweep), SRV_STORED);
    }
    CHECK_INT(sweep.given_up, 1);
    CHECK_INT(kills, 11);
}

STORE_TEST(what_a_worker_gives_back_bears_no_mark) {
    struct srv_lease lease;
    struct srv_job job;
    (void)ground;
    CHECK_INT(submit(store, "j", "anna", NULL, 1, 0, &job), SRV_STORED);
    for (int i = 1; i <= 5; i++) {
        CHECK_INT(srv_store_claim(store, "mine", 60 * SECOND, &lease), SRV_STORED);
        CHECK_INT(lease.attempt, i);
        CHECK_INT(srv_store_release(store, "another's"), SRV_STORED);
        CHECK_INT(srv_store_extend(store, &lease, 60 * SECOND), SRV_STORED);
        CHECK_INT(srv_store_release(store, "mine"), SRV_STORED);
        CHECK_INT(srv_store_extend(store, &lease, 60 * SECOND), SRV_STORED_LOST);
    }
    CHECK_INT(srv_store_job(store, "j", &job), SRV_STORED);
    CHECK_INT(job.state, SRV_JOB_RUNNING);
}

STORE_TEST(chained_shards_come_one_after_the_other) {
    struct srv_lease lease, none;
    struct srv_store_sweep sweep;
    struct srv_job job;
    char carry[16];
    (void)ground;
    CHECK_INT(submit(store, "chain", "anna", NULL, 4, 1, &job), SRV_STORED);
    for (long i = 0; i < 4; i++) {
        CHECK_INT(srv_store_claim(store, "w", i == 2 ? 1000 : 60 * SECOND, &lease), SRV_STORED);
        CHECK_INT(srv_store_claim(store, "w", SECOND, &none), SRV_STORED_NONE);
        if (i == 2 && lease.attempt == 1) {
            /* a shard that is done again starts from the same */
            srv_lease_clear(&lease);
            pause_ms(3);
            CHECK_INT(srv_store_sweep(store, NULL, &sweep), SRV_STORED);
            CHECK_INT(srv_store_claim(store, "w", 60 * SECOND, &lease), SRV_STORED);
            CHECK_INT(lease.attempt, 2);
        }
        CHECK_INT(lease.shard, i);
        snprintf(carry, sizeof carry, "after %ld", i - 1);
        if (i)
            CHECK(lease.start_bytes == 7 && !memcmp(lease.start, carry, 7));
        else
            CHECK(!lease.start);
        snprintf(carry, sizeof carry, "after %ld", i);
        CHECK_INT(srv_store_finish(store, &lease, "x", 1, i < 3 ? carry : NULL, 7), SRV_STORED);
        srv_lease_clear(&lease);
    }
    CHECK_INT(srv_store_job(store, "chain", &job), SRV_STORED);
    CHECK_INT(job.state, SRV_JOB_SUCCESSFUL);
}

STORE_TEST(a_key_makes_one_job_and_no_other) {
    struct srv_job job;
    unsigned char digest[SRV_DIGEST_BYTES] = {9};
    struct srv_job_order other = {.id = "j3",
                                  .client = "anna",
                                  .operation = "ensembles",
                                  .key = "k",
                                  .request = "",
                                  .digest = digest,
                                  .shards = 1};
    (void)ground;
    CHECK_INT(submit(store, "j1", "anna", "k", 1, 0, &job), SRV_STORED);
    CHECK_INT(submit(store, "j2", "anna", "k", 1, 0, &job), SRV_STORED);
    CHECK_TEXT(job.id, "j1");
    CHECK_INT(srv_store_job(store, "j2", &job), SRV_STORED_NONE);
    CHECK_INT(srv_store_submit(store, &other, &job), SRV_STORED_CLASH);
    CHECK_INT(submit(store, "j4", "berta", "k", 1, 0, &job), SRV_STORED);
    CHECK_TEXT(job.id, "j4");
    struct srv_store_figures figures;
    CHECK_INT(srv_store_figures(store, &figures), SRV_STORED);
    CHECK(figures.jobs[SRV_JOB_ACCEPTED] == 2 && figures.shards == 2);
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
        doubled->stored = submit(doubled->store, own, "anna", "same", 1, 0, &doubled->job);
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
    for (int i = 0; i < 8; i++) REQUIRE(!pthread_create(&thread[i], NULL, submit_doubled, &doubled[i]));
    for (int i = 0; i < 8; i++) pthread_join(thread[i], NULL);
    for (int i = 0; i < 8; i++) {
        CHECK_INT(doubled[i].stored, SRV_STORED);
        CHECK_TEXT(doubled[i].job.id, doubled[0].job.id);
        srv_store_close(&doubled[i].store);
    }
    CHECK_INT(srv_store_figures(store, &figures), SRV_STORED);
    CHECK_INT(figures.jobs[SRV_JOB_ACCEPTED], 1);
}

STORE_TEST(clients_take_turns_and_so_do_jobs) {
    struct srv_lease lease;
    struct srv_job job;
    char id[16], order[64] = "";
    (void)ground;
    /* anna floods, berta comes with one job of two shards: berta is served every second time */
    for (int i = 0; i < 10; i++) {
        snprintf(id, sizeof id, "a%d", i);
        CHECK_INT(submit(store, id, "anna", NULL, 1, 0, &job), SRV_STORED);
    }
    for (int i = 0; i < 4; i++) CHECK_INT(srv_store_claim(store, "w", 60 * SECOND, &lease), SRV_STORED);
    CHECK_TEXT(lease.job, "a3");
    CHECK_INT(submit(store, "b", "berta", NULL, 2, 0, &job), SRV_STORED);
    for (int i = 0; i < 4; i++) {
        CHECK_INT(srv_store_claim(store, "w", 60 * SECOND, &lease), SRV_STORED);
        order[i] = lease.job[0];
    }
    CHECK(!strcmp(order, "abab") || !strcmp(order, "baba"));
}

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
    CHECK_INT(submit(own, "j1", "anna", NULL, 2, 0, &job), SRV_STORED);
    CHECK_INT(submit(own, "j2", "anna", NULL, 1, 0, &job), SRV_STORED);
    CHECK_INT(submit(own, "j3", "anna", NULL, 1, 0, &job), SRV_STORED_QUOTA);
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
    CHECK_INT(submit(own, "j5", "anna", NULL, 1, 0, &job), SRV_STORED);
    do CHECK_INT(srv_store_claim(own, "w", 60 * SECOND, &lease), SRV_STORED);
    while (strcmp(lease.job, "j5"));
    CHECK_INT(srv_store_finish(own, &lease, data, 1000, NULL, 0), SRV_STORED);
    CHECK_INT(submit(own, "b1", "berta", NULL, 1, 0, &job), SRV_STORED);
    CHECK_INT(srv_store_claim(own, "w", 60 * SECOND, &lease), SRV_STORED);
    CHECK_INT(srv_store_finish(own, &lease, data, 600, NULL, 0), SRV_STORED_QUOTA);
    CHECK_INT(srv_store_job(own, "b1", &job), SRV_STORED);
    CHECK(strstr(job.message, "max-store-bytes") != NULL);
    srv_store_close(&own);
}

STORE_TEST(a_dismissed_job_stops_and_frees_what_it_held) {
    struct srv_lease lease;
    struct srv_store_sweep sweep;
    struct srv_job job;
    struct srv_store_figures figures;
    size_t bytes;
    static char data[100 * SRV_CHUNK_BYTES];
    (void)ground;
    CHECK_INT(srv_store_dismiss(store, "nobody", &job), SRV_STORED_NONE);
    CHECK_INT(submit(store, "j", "anna", NULL, 3, 0, &job), SRV_STORED);
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
    struct srv_store_rules brief = store_rules;
    struct srv_store_sweep sweep;
    struct srv_store *own;
    struct srv_lease lease;
    struct srv_job job;
    struct pend_error error;
    (void)store;
    brief.keep_us = 1000;
    REQUIRE(srv_store_open(&own, ground->url, &brief, &error) == PEND_OK);
    CHECK_INT(submit(own, "j", "anna", "k", 1, 0, &job), SRV_STORED);
    CHECK_INT(srv_store_claim(own, "w", 60 * SECOND, &lease), SRV_STORED);
    CHECK_INT(srv_store_finish(own, &lease, "abc", 3, NULL, 0), SRV_STORED);
    for (int i = 0; i < 10; i++) {
        pause_ms(2);
        CHECK_INT(srv_store_sweep(own, NULL, &sweep), SRV_STORED);
    }
    CHECK_INT(srv_store_job(own, "j", &job), SRV_STORED_NONE);
    CHECK_INT(submit(own, "again", "anna", "k", 1, 0, &job), SRV_STORED);
    CHECK_TEXT(job.id, "again");
    srv_store_close(&own);
}

STORE_TEST(a_list_is_the_clients_own_newest_first) {
    struct srv_job job[8];
    char id[16];
    int count;
    (void)ground;
    for (int i = 0; i < 10; i++) {
        snprintf(id, sizeof id, "j%d", i);
        CHECK_INT(submit(store, id, i % 2 ? "anna" : "berta", NULL, 1, 0, &job[0]), SRV_STORED);
    }
    CHECK_INT(srv_store_list(store, "anna", NULL, 3, job, &count), SRV_STORED);
    CHECK(count == 3 && !strcmp(job[0].id, "j9") && !strcmp(job[1].id, "j7") && !strcmp(job[2].id, "j5"));
    CHECK_INT(srv_store_list(store, "anna", "j5", 3, job, &count), SRV_STORED);
    CHECK(count == 2 && !strcmp(job[0].id, "j3") && !strcmp(job[1].id, "j1"));
    CHECK_INT(srv_store_list(store, "anna", "j4", 3, job, &count), SRV_STORED);
    CHECK_INT(count, 0);
}

STORE_TEST(scenes_last_and_never_change) {
    void *body;
    size_t bytes;
    (void)ground;
    CHECK_INT(srv_store_scene(store, "s", &body, &bytes), SRV_STORED_NONE);
    for (int i = 0; i < 2; i++) CHECK_INT(srv_store_scene_put(store, "s", "anna", "{}", 2), SRV_STORED);
    CHECK_INT(srv_store_scene_put(store, "s", "berta", "{ }", 3), SRV_STORED_CLASH);
    CHECK_INT(srv_store_scene_put(store, "t", "anna", "", 0), SRV_STORED);
    CHECK_INT(srv_store_scene_put(store, "u", "anna", "a\0b", 3), SRV_STORED);
    CHECK_INT(srv_store_scene_put(store, "v", "anna", "x", 1), SRV_STORED_QUOTA);
    CHECK_INT(srv_store_scene(store, "u", &body, &bytes), SRV_STORED);
    CHECK(bytes == 3 && !memcmp(body, "a\0b", 3));
    free(body);
}

/* ---- batches */

struct call_submit {
    struct srv_store_call call;
    const char *id;
    enum srv_stored spoil; /* returned in place of the result */
    int runs;
    struct srv_job job;
};

static enum srv_stored call_submit(struct srv_store *store, struct srv_store_call *call) {
    struct call_submit *own = (struct call_submit *)call;
    own->runs++;
    enum srv_stored stored = submit(store, own->id, "anna", strcmp(own->id, "twin") ? NULL : "j1", 1, 0, &own->job);
    return own->spoil && own->runs == 1 ? own->spoil : stored;
}

STORE_TEST(a_batch_is_one_transaction_of_independent_calls) {
    struct call_submit calls[4] = {{.id = "j1"}, {.id = "twin"}, {.id = "j1"}, {.id = "j4"}};
    for (int i = 0; i < 4; i++) calls[i].call.run = call_submit;
    struct srv_store_call *all[] = {&calls[0].call, &calls[1].call, &calls[2].call, &calls[3].call};
    struct srv_job job;
    (void)ground;
    /* the third uses an id that is taken: it fails alone */
    srv_store_together(store, all, srv_store_batch(store) > 1 ? 4 : 1);
    if (srv_store_batch(store) == 1)
        for (int i = 1; i < 4; i++) srv_store_together(store, &all[i], 1);
    for (int i = 0; i < 4; i++)
        CHECK_SAYING((calls[i].call.stored == SRV_STORED) == (i != 2), "call %d: %d", i, calls[i].call.stored);
    CHECK_INT(srv_store_job(store, "j4", &job), SRV_STORED);
    CHECK_INT(srv_store_job(store, "twin", &job), SRV_STORED);
    /* a failure that spoils the whole transaction: each is done again by itself, once */
    struct call_submit hard[2] = {{.id = "h1"}, {.id = "h2", .spoil = SRV_STORED_FULL}};
    hard[0].call.run = hard[1].call.run = call_submit;
    struct srv_store_call *both[] = {&hard[0].call, &hard[1].call};
    srv_store_together(store, both, 2);
    CHECK(hard[0].call.stored == SRV_STORED && hard[1].call.stored == SRV_STORED && hard[1].runs == 2);
    CHECK_INT(srv_store_job(store, "h1", &job), SRV_STORED);
    CHECK_INT(srv_store_job(store, "h2", &job), SRV_STORED);
}

/* ---- a model */

enum { MODEL_JOBS = 30, MODEL_SHARDS = 5 };

struct model_job {
    int open, chained, shards, dismissed, failed;
    enum { MODEL_FRESH, MODEL_HELD, MODEL_BACK, MODEL_DONE } shard[MODEL_SHARDS];
    long attempt[MODEL_SHARDS];
};

static int model_claimable(const struct model_job *job, int shard) {
    if (!job->open || shard >= job->shards) return 0;
    if (job->shard[shard] == MODEL_BACK) return 1;
    return job->shard[shard] == MODEL_FRESH && (!job->chained || !shard || job->shard[shard - 1] == MODEL_DONE);
}

static int model_any(const struct model_job job[], int jobs) {
    for (int j = 0; j < jobs; j++)
        for (int s = 0; s < MODEL_SHARDS; s++)
            if (model_claimable(&job[j], s)) return 1;
    return 0;
}

static int model_done(const struct model_job *job) {
    for (int s = 0; s < job->shards; s++)
        if (job->shard[s] != MODEL_DONE) return 0;
    return 1;
}

static int model_agrees(struct srv_store *store, const struct model_job model[], int jobs) {
    int good = 1;
    for (int j = 0; j < jobs && good; j++) {
        char id[16];
        struct srv_job job;
        int done = 0;
        snprintf(id, sizeof id, "m%d", j);
        for (int s = 0; s < model[j].shards; s++) done += model[j].shard[s] == MODEL_DONE;
        good = srv_store_job(store, id, &job) == SRV_STORED && job.done == done &&
               (job.state == SRV_JOB_DISMISSED) == model[j].dismissed &&
               (job.state == SRV_JOB_FAILED) == model[j].failed && (job.state <= SRV_JOB_RUNNING) == model[j].open;
    }
    return good;
}

STORE_TEST(random_histories_agree_with_a_model) {
    struct model_job model[MODEL_JOBS] = {0};
    struct srv_lease held[200];
    int jobs = 0, leases = 0, rounds = 600;
    unsigned long long random = 5;
    (void)ground;
    for (int round = 0; round < rounds; round++) {
        int act = test_random_int(&random, 10), good = 1;
        struct srv_job job;
        char id[16];
        if (act < 1 && jobs < MODEL_JOBS) {
            struct model_job *own = &model[jobs];
            *own = (struct model_job){.open = 1,
                                      .chained = test_random_int(&random, 2),
                                      .shards = 1 + test_random_int(&random, MODEL_SHARDS)};
            snprintf(id, sizeof id, "m%d", jobs++);
            good = submit(store, id, jobs % 3 ? "anna" : "berta", NULL, own->shards, own->chained, &job) == SRV_STORED;
        } else if (act < 5 && leases < 200) {
            struct srv_lease *lease = &held[leases];
            enum srv_stored stored =
                srv_store_claim(store, test_random_int(&random, 2) ? "w0" : "w1", 3600LL * SECOND, lease);
            good = stored == (model_any(model, jobs) ? SRV_STORED : SRV_STORED_NONE);
            if (stored == SRV_STORED) {
                struct model_job *own = &model[atoi(lease->job + 1)];
                good =
                    good && model_claimable(own, (int)lease->shard) && lease->attempt == own->attempt[lease->shard] + 1;
                own->shard[lease->shard] = MODEL_HELD;
                own->attempt[lease->shard] = lease->attempt;
                leases++;
            }
        } else if (act < 9 && leases) {
            /* any lease that was ever given, the lost ones too */
            struct srv_lease *lease = &held[test_random_int(&random, leases)];
            struct model_job *own = &model[atoi(lease->job + 1)];
            int mine =
                own->open && own->shard[lease->shard] == MODEL_HELD && own->attempt[lease->shard] == lease->attempt;
            int was = !own->dismissed && !own->failed && own->shard[lease->shard] == MODEL_DONE &&
                      own->attempt[lease->shard] == lease->attempt;
            int fail = test_random_int(&random, 12) == 0;
            const char *carry = own->chained && lease->shard + 1 < own->shards ? "c" : NULL;
            enum srv_stored stored =
                fail ? srv_store_fail(store, lease, "no") : srv_store_finish(store, lease, "r", 1, carry, 1);
            good = stored == (mine || (was && !fail) ? SRV_STORED : SRV_STORED_LOST);
            if (mine && fail) own->failed = 1;
            if (mine && fail) own->open = 0;
            if (mine && !fail) own->shard[lease->shard] = MODEL_DONE;
            if (model_done(own)) own->open = 0;
        } else if (jobs && test_random_int(&random, 4) == 0) {
            int j = test_random_int(&random, jobs);
            snprintf(id, sizeof id, "m%d", j);
            good = srv_store_dismiss(store, id, &job) == SRV_STORED;
            model[j].dismissed = 1;
            model[j].failed = model[j].open = 0;
        } else {
            const char *worker = test_random_int(&random, 2) ? "w0" : "w1";
            good = srv_store_release(store, worker) == SRV_STORED;
            /* which worker has what is not in the model: ask */
            for (int i = 0; i < leases; i++) {
                struct model_job *own = &model[atoi(held[i].job + 1)];
                int mine = own->open && own->shard[held[i].shard] == MODEL_HELD &&
                           own->attempt[held[i].shard] == held[i].attempt;
                if (mine && srv_store_extend(store, &held[i], 3600LL * SECOND) == SRV_STORED_LOST)
                    own->shard[held[i].shard] = MODEL_BACK;
            }
        }
        if (!CHECK_SAYING(good, "round %d, act %d", round, act)) break;
        if (round % 50 == 49 && !CHECK(model_agrees(store, model, jobs))) break;
    }
    CHECK(jobs > 10 && leases > 30);
    for (int i = 0; i < leases; i++) srv_lease_clear(&held[i]);
}

/* ---- what only one of them knows */

TEST(a_full_disk_is_said_and_harms_nothing) {
    struct ground ground;
    struct srv_job job;
    struct srv_lease lease;
    struct rlimit limit, tight;
    static char data[4 << 20];
    REQUIRE(ground_begin(&ground, 0));
    struct srv_store *store = ground_open(&ground);
    REQUIRE(store);
    signal(SIGXFSZ, SIG_IGN);
    REQUIRE(!getrlimit(RLIMIT_FSIZE, &limit));
    tight = (struct rlimit){3 << 20, limit.rlim_max};
    CHECK_INT(submit(store, "j", "anna", NULL, 1, 0, &job), SRV_STORED);
    CHECK_INT(srv_store_claim(store, "w", 60 * SECOND, &lease), SRV_STORED);
    REQUIRE(!setrlimit(RLIMIT_FSIZE, &tight));
    CHECK_INT(srv_store_finish(store, &lease, data, sizeof data, NULL, 0), SRV_STORED_FULL);
    /* the lease still holds, and the job can be ended with a reason although the disk is full */
    CHECK_INT(srv_store_fail(store, &lease, "the disk is full"), SRV_STORED);
    REQUIRE(!setrlimit(RLIMIT_FSIZE, &limit));
    CHECK_INT(srv_store_job(store, "j", &job), SRV_STORED);
    CHECK(job.state == SRV_JOB_FAILED && job.bytes == 0);
    CHECK_TEXT(job.message, "the disk is full");
    srv_store_close(&store);
    ground_clear(&ground);
}

TEST(a_store_that_cannot_be_opened_says_why) {
    static const char *const bad[][2] = {{"oracle:x", "sqlite:PATH"},
                                         {"sqlite:", "wants a file's path"},
                                         {"sqlite:/nowhere/at/all.db", "cannot be opened"},
                                         {"sqlite:/etc/passwd", "no store"},
                                         {"postgresql://127.0.0.1:1/x?colour=blue", "colour"}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        struct srv_store *store;
        struct pend_error error;
        CHECK_INT(srv_store_open(&store, bad[i][0], &store_rules, &error), PEND_INVALID);
        CHECK(store == NULL);
        CHECK_SAYING(strstr(error.text, bad[i][1]) != NULL, "%s: %s", bad[i][0], error.text);
    }
}

STORE_TEST(a_store_outlives_its_processes_and_versions_are_kept_apart) {
    struct srv_job job;
    CHECK_INT(submit(store, "j", "anna", NULL, 1, 0, &job), SRV_STORED);
    struct srv_store *again = ground_open(ground);
    REQUIRE(again);
    CHECK_INT(srv_store_job(again, "j", &job), SRV_STORED);
    srv_store_close(&again);
    /* a version of the future is left alone */
    const struct srv_sql_driver *driver = ground->postgres ? &srv_sql_postgres : &srv_sql_sqlite;
    struct pend_error error;
    struct srv_sql *sql;
    REQUIRE(driver->open(&sql, ground->url, &error) == PEND_OK);
    CHECK_INT(driver->run(sql, -1, "UPDATE pendulumd SET version = 99", NULL, 0, NULL, NULL), SRV_STORED);
    driver->close(sql);
    CHECK_INT(srv_store_open(&again, ground->url, &store_rules, &error), PEND_INVALID);
    CHECK_SAYING(strstr(error.text, "version 99") != NULL, "%s", error.text);
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
    struct srv_store *store = ground_open(&ground);
    REQUIRE(store);
    CHECK_INT(submit(store, "j", "anna", NULL, 1, 0, &job), SRV_STORED);
    for (int kill = 0; kill < 2; kill++) {
        REQUIRE(test_postgres_restart(ground.postgres, kill ? SIGQUIT : SIGINT));
        CHECK_INT(srv_store_job(store, "j", &job), SRV_STORED_AWAY);
        enum srv_stored stored = SRV_STORED_AWAY;
        for (int i = 0; i < 100 && stored == SRV_STORED_AWAY; i++) {
            pause_ms(20);
            stored = srv_store_job(store, "j", &job);
        }
        CHECK_INT(stored, SRV_STORED);
    }
    CHECK_INT(srv_store_claim(store, "w", SECOND, &lease), SRV_STORED);
    CHECK_TEXT(lease.job, "j");
    srv_store_close(&store);
}

/* nobody listens there: the store is away, in no time, and says of what */
TEST(a_database_that_is_not_there_yet_is_away) {
    struct srv_store *store;
    struct pend_error error;
    struct srv_job job;
    REQUIRE(srv_store_open(&store, "postgresql://127.0.0.1:1/x", &store_rules, &error) == PEND_OK);
    CHECK(!srv_store_settled(store));
    for (int i = 0; i < 3; i++) CHECK_INT(srv_store_job(store, "j", &job), SRV_STORED_AWAY);
    CHECK_SAYING(strstr(srv_store_complaint(store), "127.0.0.1"), "%s", srv_store_complaint(store));
    CHECK_INT(srv_store_listen(store, 1), 0);
    srv_store_close(&store);
}

STORE_TEST(processes_that_share_a_store_hear_each_other) {
    struct srv_job job;
    struct srv_store *ear = ground_open(ground);
    REQUIRE(ear);
    CHECK_INT(srv_store_listen(ear, 1), 0);
    CHECK_INT(submit(store, "j", "anna", NULL, 1, 0, &job), SRV_STORED);
    CHECK_INT(srv_store_listen(ear, 2000), 1);
    CHECK_INT(srv_store_listen(ear, 1), 0);
    /* what is not kept is not told */
    CHECK_INT(submit(store, "k", "anna", "key", 1, 0, &job), SRV_STORED);
    CHECK_INT(srv_store_listen(ear, 2000), 1);
    CHECK_INT(submit(store, "l", "anna", "key", 1, 0, &job), SRV_STORED);
    CHECK_TEXT(job.id, "k");
    CHECK_INT(srv_store_listen(ear, 50), 0);
    srv_store_close(&ear);
}
