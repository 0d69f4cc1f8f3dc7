/* Tests of server/store/store_call: batches. */
#include "server/store/store_call.h"

#include <string.h>

#include "tests/server/ground.h"

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
    enum srv_stored stored = ground_submit(store, own->id, "anna",
                                           strcmp(own->id, "twin") ? NULL : "j1", 1, 0, &own->job);
    return own->spoil && own->runs == 1 ? own->spoil : stored;
}

STORE_TEST(a_batch_is_one_transaction_of_independent_calls) {
    struct call_submit calls[4] = {{.id = "j1"}, {.id = "twin"}, {.id = "j1"}, {.id = "j4"}};
    for (int i = 0; i < 4; i++) calls[i].call.run = call_submit;
    struct srv_store_call *all[] = {&calls[0].call, &calls[1].call, &calls[2].call, &calls[3].call};
    struct srv_job job;
    (void)ground;
    /* the third uses an id that exists: it alone fails */
    srv_store_together(store, all, srv_store_batch(store) > 1 ? 4 : 1);
    if (srv_store_batch(store) == 1)
        for (int i = 1; i < 4; i++) srv_store_together(store, &all[i], 1);
    for (int i = 0; i < 4; i++)
        CHECK_SAYING((calls[i].call.stored == SRV_STORED) == (i != 2), "call %d: %d", i,
                     calls[i].call.stored);
    CHECK_INT(srv_store_job(store, "j4", &job), SRV_STORED);
    CHECK_INT(srv_store_job(store, "twin", &job), SRV_STORED);
    /* a failure that aborts the whole transaction: each call is repeated alone, once */
    struct call_submit hard[2] = {{.id = "h1"}, {.id = "h2", .spoil = SRV_STORED_FULL}};
    hard[0].call.run = hard[1].call.run = call_submit;
    struct srv_store_call *both[] = {&hard[0].call, &hard[1].call};
    srv_store_together(store, both, 2);
    CHECK(hard[0].call.stored == SRV_STORED && hard[1].call.stored == SRV_STORED &&
          hard[1].runs == 2);
    CHECK_INT(srv_store_job(store, "h1", &job), SRV_STORED);
    CHECK_INT(srv_store_job(store, "h2", &job), SRV_STORED);
}

struct call_extend {
    struct srv_store_call call;
    const struct srv_lease *lease;
};

static enum srv_stored call_extend(struct srv_store *store, struct srv_store_call *call) {
    return srv_store_extend(store, ((struct call_extend *)call)->lease, SECOND);
}

/* a part may end in the batch in which its lease was to be renewed */
STORE_TEST(a_lease_that_is_lost_does_not_repeat_the_calls_beside_it) {
    const struct srv_lease lost = {.job = "none", .attempt = 1};
    struct call_submit before = {.id = "j1", .call.run = call_submit},
                       after = {.id = "j2", .call.run = call_submit};
    struct call_extend late = {.call.run = call_extend, .lease = &lost};
    struct srv_store_call *all[] = {&before.call, &late.call, &after.call};
    struct srv_job job;
    (void)ground;
    srv_store_together(store, all, 3);
    CHECK_INT(late.call.stored, SRV_STORED_LOST);
    CHECK(before.call.stored == SRV_STORED && after.call.stored == SRV_STORED);
    CHECK(before.runs == 1 && after.runs == 1);
    CHECK_INT(srv_store_job(store, "j2", &job), SRV_STORED);
}

static enum srv_stored call_finds_lost(struct srv_store *store, struct srv_store_call *call) {
    return ((struct call_submit *)call)->runs
               ? call_submit(store, call)
               : (((struct call_submit *)call)->runs++, SRV_STORED_AWAY);
}

STORE_TEST(a_connection_that_was_lost_meanwhile_costs_no_answer) {
    struct call_submit one = {.id = "j1", .call.run = call_finds_lost};
    struct srv_store_call *all[] = {&one.call};
    (void)ground;
    srv_store_together(store, all, 1);
    CHECK(one.call.stored == SRV_STORED && one.runs == 2);
}

/* a database that is unreachable for reads only, and counts the ends of transactions */
static int away_commits;

static enum srv_stored away_run(struct srv_sql *sql, int id, const char *text,
                                const struct srv_value value[], int count, srv_row_fn *row,
                                void *context) {
    (void)sql, (void)id, (void)value, (void)count, (void)row, (void)context;
    away_commits += !strcmp(text, "COMMIT");
    return SRV_STORED;
}

static enum srv_stored away_post(struct srv_sql *sql, int id, const char *text,
                                 const struct srv_value value[], int count) {
    (void)sql, (void)id, (void)value, (void)count;
    return strcmp(text, "{look}") ? SRV_STORED : SRV_STORED_AWAY;
}

TEST(a_read_that_could_not_begin_leaves_the_next_call_its_commit) {
    static const struct srv_sql_driver driver = {.lists = 1, .run = away_run, .post = away_post};
    static struct srv_store store;
    struct srv_sql sql = {.driver = &driver};
    store.sql = &sql;
    store.settled = 1;
    CHECK_INT(srv_store_look(&store), SRV_STORED_AWAY);
    CHECK_INT(srv_store_begin(&store), SRV_STORED);
    CHECK_INT(srv_store_end(&store, SRV_STORED), SRV_STORED);
    CHECK_INT(away_commits, 1);
}

STORE_TEST(a_transaction_of_which_a_statement_failed_is_not_said_to_be_kept) {
    struct srv_sql *sql = store->sql;
    CHECK_INT(sql->driver->run(sql, -1, "{begin}", NULL, 0, NULL, NULL), SRV_STORED);
    CHECK(sql->driver->run(sql, -1, "SELECT no_such_column", NULL, 0, NULL, NULL) != SRV_STORED);
    CHECK_INT(sql->driver->run(sql, -1, "COMMIT", NULL, 0, NULL, NULL),
              ground->postgres ? SRV_STORED_AGAIN : SRV_STORED);
}
