/* Tests of batches that finish parts: reading ahead and writing together give the same results as
 * single calls. */
#include <stdio.h>
#include <string.h>

#include "server/store/store_call.h"
#include "tests/server/ground.h"

enum { JOBS = 40, WORK_BYTES = 5 };

enum entry { FINISH, DISMISS, EXTEND, RELEASE, FAIL, SUBMIT };

/* A call of a batch, of the kinds that a process makes at the same time. */
struct work {
    struct srv_store_call call; /* first */
    enum entry entry;
    struct srv_lease *lease;
    int expected; /* enum srv_stored */
};

static enum srv_stored work_run(struct srv_store *store, struct srv_store_call *call) {
    struct work *work = (struct work *)call;
    struct srv_job job;
    switch (work->entry) {
    case FINISH:
        return srv_store_finish(store, work->lease, "12345", WORK_BYTES, NULL, 0);
    case DISMISS:
        return srv_store_dismiss(store, work->lease->job, &job);
    case EXTEND:
        return srv_store_extend(store, work->lease, 60 * (int64_t)SECOND);
    case RELEASE:
        return srv_store_release(store, "w");
    case FAIL:
        return srv_store_fail(store, work->lease, "it has failed");
    case SUBMIT:
        return ground_submit(store, "new", "anna", "key", 1, 0, &job);
    }
    return SRV_STORED_BROKEN;
}

/* runs work in one batch, in the listed order, and checks the result of each call */
static void work_together(struct srv_store *store, struct work work[], int count) {
    struct srv_store_call *calls[SRV_STORE_AHEAD];
    for (int i = 0; i < count; i++) {
        work[i].call.run = work_run;
        work[i].call.finish = work[i].entry == FINISH ? work[i].lease : NULL;
        calls[i] = &work[i].call;
    }
    srv_store_together(store, calls, count);
    for (int i = 0; i < count; i++)
        CHECK_SAYING((int)work[i].call.stored == work[i].expected, "call %d, entry %d: %d, not %d",
                     i, work[i].entry, work[i].call.stored, work[i].expected);
}

/* jobs of one part, all held by "w" */
static void work_begin(struct srv_store *store, struct srv_lease lease[], int count) {
    struct srv_job job;
    char id[16];
    for (int i = 0; i < count; i++) {
        snprintf(id, sizeof id, "j%02d", i);
        CHECK_INT(ground_submit(store, id, i % 3 ? "anna" : "berta", NULL, 1, 0, &job), SRV_STORED);
    }
    for (int i = 0; i < count; i++)
        CHECK_INT(ground_claim(store, "w", 60 * (int64_t)SECOND, &lease[i]), SRV_STORED);
}

static enum srv_job_state work_state(struct srv_store *store, const struct srv_lease *lease) {
    struct srv_job job = {.state = SRV_JOB_STATES};
    CHECK_INT(srv_store_job(store, lease->job, &job), SRV_STORED);
    if (job.state == SRV_JOB_SUCCESSFUL)
        CHECK(job.done == 1 && job.bytes == WORK_BYTES && job.expires > job.finished);
    return job.state;
}

/* --- how often the database is waited for --- */

static struct {
    const struct srv_sql_driver *real;
    struct srv_sql_driver driver;
    int runs;
} counted;

static enum srv_stored counted_run(struct srv_sql *sql, int id, const char *text,
                                   const struct srv_value value[], int count, srv_row_fn *row,
                                   void *context) {
    counted.runs++;
    return counted.real->run(sql, id, text, value, count, row, context);
}

/* for two clients: their sums, the totals and the clock are read, forty parts by one statement, and
 * everything is committed */
POSTGRES_TEST(a_batch_waits_for_the_database_a_few_times_however_many_parts_it_ends) {
    struct srv_lease lease[JOBS] = {0};
    struct work work[JOBS] = {0};
    char data[SRV_CHUNK_BYTES];
    size_t bytes;
    work_begin(store, lease, JOBS);
    for (int i = 0; i < JOBS; i++) work[i] = (struct work){.entry = FINISH, .lease = &lease[i]};
    counted.real = store->sql->driver;
    counted.driver = *counted.real;
    counted.driver.run = counted_run;
    counted.runs = 0;
    store->sql->driver = &counted.driver;
    work_together(store, work, JOBS);
    store->sql->driver = counted.real;
    CHECK_SAYING(counted.runs <= 7, "%d waits for %d parts", counted.runs, JOBS);
    for (int i = 0; i < JOBS; i++) {
        CHECK_INT(work_state(store, &lease[i]), SRV_JOB_SUCCESSFUL);
        CHECK_INT(srv_store_chunk(store, lease[i].job, 0, 0, data, &bytes), SRV_STORED);
        CHECK(bytes == WORK_BYTES && !memcmp(data, "12345", WORK_BYTES));
    }
    ground_sums(ground);
}

/* --- what a batch changes is seen by its later calls --- */

STORE_TEST(a_job_that_a_batch_ends_is_not_finished_by_it) {
    struct srv_lease lease[8] = {0};
    work_begin(store, lease, 8);
    struct work work[] = {
        {.entry = FINISH, .lease = &lease[0]},
        {.entry = EXTEND, .lease = &lease[1]},
        {.entry = DISMISS, .lease = &lease[1]},
        {.entry = FINISH, .lease = &lease[1], .expected = SRV_STORED_LOST},
        {.entry = SUBMIT},
        {.entry = FINISH, .lease = &lease[2]},
        {.entry = DISMISS, .lease = &lease[2]},
        {.entry = FAIL, .lease = &lease[3]},
        {.entry = FINISH, .lease = &lease[3], .expected = SRV_STORED_LOST},
        {.entry = FINISH, .lease = &lease[4]},
        {.entry = FINISH, .lease = &lease[4]}, /* again: it is done, and counted once */
        {.entry = EXTEND, .lease = &lease[4], .expected = SRV_STORED_LOST},
        {.entry = FINISH, .lease = &lease[5]}};
    work_together(store, work, sizeof work / sizeof *work);
    static const enum srv_job_state want[] = {
        SRV_JOB_SUCCESSFUL, SRV_JOB_DISMISSED,  SRV_JOB_DISMISSED, SRV_JOB_FAILED,
        SRV_JOB_SUCCESSFUL, SRV_JOB_SUCCESSFUL, SRV_JOB_RUNNING,   SRV_JOB_RUNNING};
    for (int i = 0; i < 8; i++) CHECK_INT(work_state(store, &lease[i]), want[i]);
    ground_sums(ground);
}

/* a process that returns all parts that it holds cannot finish them afterwards */
STORE_TEST(a_part_that_a_batch_gives_back_is_not_finished_by_it) {
    struct srv_lease lease[6] = {0}, again[6] = {0};
    work_begin(store, lease, 6);
    struct work work[] = {{.entry = FINISH, .lease = &lease[0]},
                          {.entry = RELEASE},
                          {.entry = FINISH, .lease = &lease[1], .expected = SRV_STORED_LOST},
                          {.entry = FINISH, .lease = &lease[2], .expected = SRV_STORED_LOST}};
    work_together(store, work, 4);
    CHECK_INT(work_state(store, &lease[0]), SRV_JOB_SUCCESSFUL);
    ground_sums(ground);
    /* the new holder finishes them, and the previous attempt does not, in any order */
    for (int i = 1; i < 6; i++) {
        CHECK_INT(ground_claim(store, "w", 60 * (int64_t)SECOND, &again[i]), SRV_STORED);
        CHECK_INT(again[i].attempt, 2);
    }
    struct srv_lease old = again[1], older = again[2];
    old.attempt = older.attempt = 1;
    struct work both[] = {{.entry = FINISH, .lease = &old, .expected = SRV_STORED_LOST},
                          {.entry = FINISH, .lease = &again[1]},
                          {.entry = FINISH, .lease = &again[2]},
                          {.entry = FINISH, .lease = &older, .expected = SRV_STORED_LOST},
                          {.entry = FINISH, .lease = &again[3]}};
    work_together(store, both, 5);
    for (int i = 1; i < 4; i++) CHECK_INT(work_state(store, &again[i]), SRV_JOB_SUCCESSFUL);
    ground_sums(ground);
}

/* one part's job was deleted, one's row is damaged, one's results exceed the quota: the others are
 * stored */
STORE_TEST(what_is_wrong_with_one_part_of_a_batch_harms_no_other) {
    struct srv_lease lease[6] = {0};
    work_begin(store, lease, 6);
    char text[160];
    snprintf(text, sizeof text, "DELETE FROM parts WHERE job = '%s'", lease[1].job);
    ground_run(ground, text);
    snprintf(text, sizeof text, "UPDATE jobs SET state = 77 WHERE id = '%s'", lease[3].job);
    ground_run(ground, text);
    struct work work[6];
    for (int i = 0; i < 6; i++) work[i] = (struct work){.entry = FINISH, .lease = &lease[i]};
    work[1].expected = SRV_STORED_LOST;
    work[3].expected = SRV_STORED_DAMAGED;
    work_together(store, work, 6);
    for (int i = 0; i < 6; i++)
        if (i != 1 && i != 3) CHECK_INT(work_state(store, &lease[i]), SRV_JOB_SUCCESSFUL);
}
