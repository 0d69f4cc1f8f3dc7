/* The life of a job and of a scene during which something fails: a statement, an allocation, a
 * write to the disk; the n-th, for every n, once and from there on. Everything reported as stored
 * is stored, nothing else is, and the next life is unaffected. */
#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "server/store/store_classes.h"
#include "tests/server/ground.h"

enum { LIFE_BYTES = SRV_CHUNK_BYTES + 1000, LIFE_PARTS = 2, MOST_FAULTS = 20000 };

static char life_data[LIFE_BYTES], life_back[SRV_CHUNK_BYTES];

/* --- a driver of which a statement fails --- */

/* the failure: the connection is lost before the statement took effect, or after it; the database
 * asks for a retry, or reports damage */
enum fault { FAULT_AWAY, FAULT_AWAY_AFTER, FAULT_AGAIN, FAULT_BROKEN, FAULTS };

static struct {
    const struct srv_sql_driver *real;
    struct srv_sql_driver driver;
    long count, fail_at; /* 0 = none fails */
    int for_good, lost;
    enum fault fault;
    const char *lose; /* a statement that takes effect, and whose answer is lost */
} faulty;

static int faulty_fails(const char *text) {
    if (!faulty.fail_at) return 0;
    faulty.count++;
    int due = faulty.for_good ? faulty.count >= faulty.fail_at : faulty.count == faulty.fail_at;
    /* only a begin reconnects a lost connection */
    if (*text == '{') faulty.lost = 0;
    return due || faulty.lost;
}

/* what the server does with a lost connection, and the effect of a rollback whatever it returns */
static enum srv_stored faulty_end(struct srv_sql *sql, const char *text) {
    int lost = faulty.fault <= FAULT_AWAY_AFTER;
    if (!faulty.lost && (lost || !strcmp(text, "ROLLBACK")))
        faulty.real->run(sql, SQL_ROLLBACK, "ROLLBACK", NULL, 0, NULL, NULL);
    faulty.lost = lost;
    srv_sql_complain(sql, "a test wants it to fail");
    return lost                          ? SRV_STORED_AWAY
           : faulty.fault == FAULT_AGAIN ? SRV_STORED_AGAIN
                                         : SRV_STORED_BROKEN;
}

static enum srv_stored faulty_run(struct srv_sql *sql, int id, const char *text,
                                  const struct srv_value value[], int count, srv_row_fn *row,
                                  void *context) {
    if (faulty.lose && !strcmp(text, faulty.lose)) {
        CHECK_INT(faulty.real->run(sql, id, text, value, count, row, context), SRV_STORED);
        faulty.lose = NULL;
        faulty.fault = FAULT_AWAY_AFTER;
        faulty.fail_at = LONG_MAX; /* until the next begin */
        faulty.count = 0;
        return faulty_end(sql, text);
    }
    if (!faulty_fails(text)) return faulty.real->run(sql, id, text, value, count, row, context);
    if (!faulty.lost && faulty.fault == FAULT_AWAY_AFTER)
        faulty.real->run(sql, id, text, value, count, row, context);
    return faulty_end(sql, text);
}

static enum srv_stored faulty_post(struct srv_sql *sql, int id, const char *text,
                                   const struct srv_value value[], int count) {
    return faulty_fails(text) ? faulty_end(sql, text)
                              : faulty.real->post(sql, id, text, value, count);
}

static void faulty_begin(struct srv_store *store) {
    faulty.real = store->sql->driver;
    faulty.driver = *faulty.real;
    faulty.driver.run = faulty_run;
    if (faulty.real->post) faulty.driver.post = faulty_post;
    faulty.fail_at = 0;
    store->sql->driver = &faulty.driver;
}

static void faulty_fail(long count, int for_good, enum fault fault) {
    faulty.count = 0;
    faulty.lost = 0;
    faulty.fail_at = count;
    faulty.for_good = for_good;
    faulty.fault = fault;
}

/* --- a life --- */

/* What the store returned: for the job, for each part's claim and end, for the scene. */
struct life {
    enum srv_stored submitted, claimed[LIFE_PARTS], finished[LIFE_PARTS], put, kept, dropped,
        dismissed;
};

/* one call of a batch, as the storage threads make it */
struct life_call {
    struct srv_store_call call; /* first */
    struct life *life;
    struct srv_lease *lease;
};

static enum srv_stored life_submit(struct srv_store *store, struct srv_store_call *call) {
    struct srv_job job;
    (void)call;
    return ground_submit(store, "job", "anna", "key", LIFE_PARTS, 1, &job);
}

static enum srv_stored life_claim(struct srv_store *store, struct srv_store_call *call) {
    const struct life_call *own = (struct life_call *)call;
    /* a failed call of a batch is run again */
    srv_lease_clear(own->lease);
    return ground_claim_whole(store, "worker", 60 * (int64_t)SECOND, own->lease);
}

static enum srv_stored life_finish(struct srv_store *store, struct srv_store_call *call) {
    const struct life_call *own = (struct life_call *)call;
    int last = own->lease->part == LIFE_PARTS - 1;
    return srv_store_finish(store, own->lease, life_data, LIFE_BYTES, last ? NULL : "carry",
                            last ? 0 : 5);
}

static enum srv_stored life_put(struct srv_store *store, struct srv_store_call *call) {
    (void)call;
    return srv_store_scene_put(store, "scene", "anna", NULL, "{\"a\":1}", 7);
}

/* a call together with another one, so that the batch fails first */
static enum srv_stored life_together(struct srv_store *store, struct life_call *one,
                                     struct life_call *two) {
    struct srv_store_call *const calls[] = {&one->call, &two->call};
    srv_store_together(store, calls, 2);
    return one->call.stored;
}

static void life_parts(struct srv_store *store, struct life *life) {
    struct srv_job job;
    struct srv_lease lease = {0};
    void *request = NULL;
    size_t bytes;
    for (long part = 0; part < LIFE_PARTS; part++) {
        struct life_call claim = {.call.run = life_claim, .life = life, .lease = &lease};
        struct life_call finish = {.call.run = life_finish, .life = life, .lease = &lease};
        struct srv_store_call *const alone[] = {&claim.call};
        srv_store_together(store, alone, 1);
        life->claimed[part] = claim.call.stored;
        if (claim.call.stored == SRV_STORED) {
            if (srv_store_job_request(store, "job", &request, &bytes) == SRV_STORED) free(request);
            srv_store_extend(store, &lease, 60 * (int64_t)SECOND);
            REQUIRE(lease.part >= 0 && lease.part < LIFE_PARTS);
            srv_store_together(store, (struct srv_store_call *const[]){&finish.call}, 1);
            life->finished[lease.part] = finish.call.stored;
        }
        srv_lease_clear(&lease);
    }
    for (long chunk = 0; chunk < 2; chunk++)
        srv_store_chunk(store, "job", 0, chunk, life_back, &bytes);
    srv_store_job(store, "job", &job);
}

static void life_scene(struct srv_store *store, struct life *life) {
    void *body = NULL;
    size_t bytes;
    if (srv_store_scene(store, "scene", &body, &bytes) == SRV_STORED) {
        CHECK(bytes == 7 && !memcmp(body, "{\"a\":1}", 7));
        free(body);
    }
    /* once more, with the same body: it is compared */
    srv_store_scene_put(store, "scene", "anna", NULL, "{\"a\":1}", 7);
    life->kept = srv_store_scene_keep(store, "scene", "berta", NULL);
    life->dropped = srv_store_scene_drop(store, "scene", "anna");
}

static void life_run(struct srv_store *store, struct life *life) {
    struct life_call submit = {.call.run = life_submit, .life = life};
    struct life_call put = {.call.run = life_put, .life = life};
    struct srv_store_figures figures;
    struct srv_store_sweep sweep;
    struct srv_job list[4];
    int count;
    *life = (struct life){0};
    for (int i = 0; i < LIFE_PARTS; i++) life->finished[i] = SRV_STORED_NONE;
    life->submitted = life_together(store, &submit, &put);
    life->put = put.call.stored;
    life_parts(store, life);
    life_scene(store, life);
    ground_list(store, "anna", NULL, 4, list, &count);
    srv_store_figures(store, &figures);
    srv_store_sweep(store, NULL, &sweep);
}

/* --- afterwards --- */

/* everything reported as stored exists */
static void life_kept(struct srv_store *store, const struct life *life, const char *what) {
    struct srv_job job;
    size_t bytes;
    enum srv_stored stored = srv_store_job(store, "job", &job);
    CHECK_SAYING(stored == SRV_STORED || stored == SRV_STORED_NONE, "%s: the job: %d %s", what,
                 stored, srv_store_complaint(store));
    if (life->submitted == SRV_STORED)
        CHECK_SAYING(stored == SRV_STORED, "%s: the job is gone: %d", what, stored);
    for (long part = 0; part < LIFE_PARTS; part++) {
        if (life->finished[part] != SRV_STORED) continue;
        CHECK_SAYING(job.done > part && job.state != SRV_JOB_FAILED, "%s: part %ld is not done",
                     what, part);
        stored = srv_store_chunk(store, "job", part, 0, life_back, &bytes);
        CHECK_SAYING(stored == SRV_STORED && bytes == SRV_CHUNK_BYTES &&
                         !memcmp(life_back, life_data, bytes),
                     "%s: part %ld: %d, %zu bytes", what, part, stored, bytes);
    }
}

/* ends the remaining jobs; nothing is left then */
static void life_clear(const struct ground *ground, struct srv_store *store, const char *what) {
    static const char *const tables[] = {
        "jobs", "parts", "results", "removals WHERE job = 'job'", "scenes", "keepers", "clients"};
    struct srv_store_sweep sweep;
    struct srv_job job;
    char text[128];
    int sweeps = 0;
    enum srv_stored stored = srv_store_release(store, "worker");
    CHECK_SAYING(stored == SRV_STORED, "%s: release %d %s", what, stored,
                 srv_store_complaint(store));
    stored = srv_store_dismiss(store, "job", &job);
    ground_run(ground, "UPDATE jobs SET expires = 1");
    CHECK_SAYING(stored == SRV_STORED || stored == SRV_STORED_NONE, "%s: dismiss %d", what, stored);
    srv_store_scene_drop(store, "scene", "anna");
    srv_store_scene_drop(store, "scene", "berta");
    do stored = srv_store_sweep(store, NULL, &sweep);
    while (stored == SRV_STORED && sweep.more && ++sweeps < 10);
    CHECK_SAYING(stored == SRV_STORED, "%s: sweep %d %s", what, stored, srv_store_complaint(store));
    for (size_t i = 0; i < sizeof tables / sizeof *tables; i++) {
        snprintf(text, sizeof text, "SELECT COUNT(*) FROM %s", tables[i]);
        long long left = ground_ask(ground, text);
        CHECK_SAYING(!left, "%s: %lld rows are left of %s", what, left, tables[i]);
    }
}

static void life_whole(const struct ground *ground, const char *what) {
    CHECK_SAYING(ground_sums(ground), "%s", what);
    if (!ground->postgres)
        CHECK_SAYING(
            ground_ask(
                ground,
                "SELECT COUNT(*) FROM pragma_integrity_check WHERE integrity_check = 'ok'") == 1,
            "%s: the file is damaged", what);
}

/* after a life with a failure: everything is as the store reported, and a life without one
 * succeeds */
static void life_judge(const struct ground *ground, struct srv_store *store,
                       const struct life *life, const char *what) {
    struct life good;
    life_whole(ground, what);
    life_kept(store, life, what);
    life_clear(ground, store, what);
    life_run(store, &good);
    CHECK_SAYING(good.submitted == SRV_STORED && good.put == SRV_STORED &&
                     good.kept == SRV_STORED && good.dropped == SRV_STORED,
                 "%s: the next: %d %d %d %d %s", what, good.submitted, good.put, good.kept,
                 good.dropped, srv_store_complaint(store));
    for (int i = 0; i < LIFE_PARTS; i++)
        CHECK_SAYING(good.claimed[i] == SRV_STORED && good.finished[i] == SRV_STORED,
                     "%s: the next part %d: %d %d %s", what, i, good.claimed[i], good.finished[i],
                     srv_store_complaint(store));
    life_kept(store, &good, what);
    life_clear(ground, store, what);
}

static struct srv_store *life_open(const struct ground *ground) {
    struct pend_error error;
    struct srv_store *store;
    CHECK_SAYING(srv_store_open(&store, ground->url, &ground->rules, &error) == PEND_OK, "%s",
                 error.text);
    return store;
}

/* A call of a batch whose commit is not acknowledged. */
enum lost { SUBMIT, CLAIM, EXTEND, FINISH, RELEASE, DISMISS, PUT, KEEP, DROP, MAKE, JOIN, LOST };

struct lost_call {
    struct srv_store_call call; /* first */
    enum lost entry;
    int number; /* of the two calls */
    struct srv_claim claim;
    struct srv_lease lease[1];
};

static enum srv_stored lost_run(struct srv_store *store, struct srv_store_call *call) {
    struct lost_call *own = (struct lost_call *)call;
    char id[] = {(char)('a' + own->number), 0}, code[] = "AAAAAA";
    struct srv_job job;
    struct srv_class room;
    const char *full;
    code[0] = (char)('A' + own->number);
    struct srv_class_new made = {code, id, NULL, "here", 3600 * (int64_t)SECOND, 0, 1, 9};
    struct srv_class_put join = {
        .code = code, .who = "pupil", .source = "", .fold = "n", .body = "{\"n\"}", .bytes = 5};
    switch (own->entry) {
    case SUBMIT:
        return ground_submit(store, id, "anna", NULL, 1, 0, &job);
    case CLAIM:
        return srv_store_claim(store, &own->claim, own->lease);
    case EXTEND:
        return srv_store_extend(store, own->lease, 60 * (int64_t)SECOND);
    case FINISH:
        return srv_store_finish(store, own->lease, "x", 1, NULL, 0);
    case RELEASE:
        return srv_store_release(store, "w");
    case DISMISS:
        return srv_store_dismiss(store, own->lease[0].job, &job);
    case PUT:
        return srv_store_scene_put(store, id, "anna", NULL, "{}", 2);
    case KEEP:
        return srv_store_scene_keep(store, id, "berta", NULL);
    case DROP:
        return srv_store_scene_drop(store, id, "anna");
    case MAKE:
        return srv_store_class_new(store, &made, &room, &full);
    default:
        return srv_store_class_join(store, &join, &room);
    }
}

/* alone and in a batch, a commit takes effect but is not acknowledged: the calls say so, and
 * nothing is done twice */
STORE_TEST(a_commit_whose_answer_is_lost_is_looked_up) {
    static const char *const rows[][2] = {{"jobs WHERE bytes = 1 OR state = 4", "3"},
                                          {"parts WHERE attempt > 1", "0"},
                                          {"scenes", "3"},
                                          {"keepers WHERE client = 'berta'", "3"},
                                          {"keepers", "3"},
                                          {"classes WHERE pupils = 1", "3"}};
    struct srv_store_rules rules = {.classes = 9, .class_pupils = 9, .class_bytes = 1 << 20};
    struct lost_call one = {.number = 0}, two = one;
    struct srv_store_call *const calls[] = {&one.call, &two.call};
    char text[128];
    store->rules.classes = rules.classes;
    store->rules.class_pupils = rules.class_pupils;
    store->rules.class_bytes = rules.class_bytes;
    faulty_begin(store);
    for (int count = 1; count <= 2; count++)
        for (enum lost entry = SUBMIT; entry < LOST; entry++) {
            struct lost_call *both[] = {&one, &two};
            for (int i = 0; i < count; i++) {
                both[i]->call.run = lost_run;
                both[i]->entry = entry;
                both[i]->number = count - 1 + i;
                if (entry == CLAIM)
                    both[i]->claim = (struct srv_claim){
                        .worker = "w", .lease_us = 60 * (int64_t)SECOND, .most = 1};
            }
            if (count == 2 && entry == FINISH) two.entry = DISMISS;
            faulty.lose = "COMMIT";
            srv_store_together(store, calls, count);
            for (int i = 0; i < count; i++)
                CHECK_SAYING(both[i]->call.stored == SRV_STORED, "entry %d, call %d of %d: %d %s",
                             entry, i, count, both[i]->call.stored, srv_store_complaint(store));
            CHECK_SAYING(!faulty.lose, "entry %d does not commit", entry);
            if (entry == DISMISS)
                for (int i = 0; i < count; i++) srv_lease_clear(&both[i]->lease[0]);
        }
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        snprintf(text, sizeof text, "SELECT COUNT(*) FROM %s", rows[i][0]);
        CHECK_SAYING(ground_ask(ground, text) == atoi(rows[i][1]), "%s", text);
    }
    ground_sums(ground);
    faulty.fail_at = 0;
}

STORE_TEST(a_life_survives_every_statement_that_fails) {
    (void)store;
    test_disk_fail(LONG_MAX, 0, EIO);
    for (int i = 0; i < LIFE_BYTES; i++) life_data[i] = (char)(i * 31);
    for (int mode = 0; mode < 2 * FAULTS; mode++) {
        struct life life;
        OWN(srv_store, close) *own = life_open(ground);
        REQUIRE(own);
        CHECK(own->sql->driver->run(own->sql, -1,
                                    ground->postgres ? "SET synchronous_commit = off"
                                                     : "PRAGMA synchronous = OFF",
                                    NULL, 0, NULL, NULL) == SRV_STORED);
        faulty_begin(own);
        /* every third, on PostgreSQL every fourteenth, others in each mode: each costs connections
         * for the recount */
        long step = ground->postgres ? 14 : 3 * TEST_STRIDE, n = 1 + mode * 5 % step;
        for (int over = 0; !over && n < MOST_FAULTS; n += step) {
            char what[80];
            snprintf(what, sizeof what, "statement %ld, fault %d%s", n, mode / 2,
                     mode % 2 ? " for good" : "");
            faulty_fail(n, mode % 2, (enum fault)(mode / 2));
            life_run(own, &life);
            over = faulty.count < n;
            faulty.fail_at = 0;
            life_judge(ground, own, &life, what);
        }
        CHECK_SAYING(n > 40 && n < MOST_FAULTS, "%ld statements", n);
    }
    test_disk_faults_off();
}

STORE_TEST(a_life_survives_every_allocation_that_fails) {
    (void)store;
    test_disk_fail(LONG_MAX, 0, EIO);
    for (int i = 0; i < LIFE_BYTES; i++) life_data[i] = (char)(i * 31);
    for (int for_good = 0; for_good < 2; for_good++) {
        long n = 1;
        /* the first sixty, and then a fortieth of them, on PostgreSQL, where each costs
         * connections, a fifteenth: the same few allocate again and again */
        for (int over = 0; !over && n < MOST_FAULTS;
             n += (n < 60 ? 1 : n / (ground->postgres ? 15 : 40)) * TEST_STRIDE) {
            struct life life = {.submitted = SRV_STORED_BROKEN};
            struct pend_error error;
            OWN(srv_store, close) *own = NULL;
            char what[80];
            for (int i = 0; i < LIFE_PARTS; i++) life.finished[i] = SRV_STORED_NONE;
            snprintf(what, sizeof what, "allocation %ld%s", n, for_good ? " for good" : "");
            long before = test_alloc_count();
            test_alloc_fail(n, for_good);
            enum pend_status status = srv_store_open(&own, ground->url, &ground->rules, &error);
            if (status == PEND_OK) life_run(own, &life);
            over = test_alloc_count() - before < n;
            test_alloc_faults_off();
            CHECK_SAYING(status == PEND_OK ? own != NULL : !own, "%s: %d", what, status);
            if (!own) own = life_open(ground);
            REQUIRE(own);
            life_judge(ground, own, &life, what);
        }
        CHECK_SAYING(n < MOST_FAULTS, "%ld allocations", n);
    }
    test_disk_faults_off();
}

static void life_disk(struct ground *ground, struct srv_store *store) {
    static const int errors[] = {EIO, ENOSPC};
    srv_store_close(&store);
    for (int i = 0; i < LIFE_BYTES; i++) life_data[i] = (char)(i * 31);
    for (int mode = 0; mode < 4; mode++) {
        long n = 1;
        /* the first sixty, and then a twentieth of them: most are pages of the log */
        for (int over = 0; !over && n < MOST_FAULTS;
             n += n < 60 ? TEST_STRIDE : n / 20 * TEST_STRIDE) {
            struct life life;
            struct srv_store *own = life_open(ground);
            char what[80];
            REQUIRE(own);
            snprintf(what, sizeof what, "write %ld, %s%s", n, strerror(errors[mode / 2]),
                     mode % 2 ? " for good" : "");
            test_disk_fail(n, mode % 2, errors[mode / 2]);
            life_run(own, &life);
            over = test_disk_faults_off() < n;
            CHECK_SAYING(!strstr(srv_store_complaint(own), "rollback"), "%s: %s", what,
                         srv_store_complaint(own));
            test_disk_fail(LONG_MAX, 0, EIO);
            life_judge(ground, own, &life, what);
            srv_store_close(&own);
            test_disk_faults_off();
        }
        CHECK_SAYING(n > 20 && n < MOST_FAULTS, "%ld writes", n);
    }
}

TEST(a_life_survives_every_write_that_fails_on_sqlite) {
    OWN(ground, clear) ground;
    REQUIRE(ground_begin(&ground, 0));
    struct srv_store *store = ground_open(&ground);
    if (store) life_disk(&ground, store);
}
