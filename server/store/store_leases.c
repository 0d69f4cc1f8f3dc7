#include "server/store/store_jobs.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { PART_HELD = 1, PART_DONE = 2 };

enum srv_stored srv_store_extend(struct srv_store *store, const struct srv_lease *lease,
                                 int64_t lease_us) {
    assert(lease_us > 0 && lease->part >= 0 && lease->attempt >= 1);
    struct srv_row_wholes row = {.count = 1};
    SRV_STORED_TRY(srv_store_begin(store));
    enum srv_stored stored = SRV_RUN(store, SQL_PART_EXTEND, srv_row_wholes, &row, lease->job,
                                     lease->part, lease->attempt, lease_us);
    if (stored == SRV_STORED && !row.rows) stored = SRV_STORED_LOST;
    store->wrote = row.rows; /* a lost lease wrote nothing: other calls of the batch are kept */
    return srv_store_end(store, stored);
}

static enum srv_stored row_held(void *context, const struct srv_value field[]) {
    struct srv_store_ahead *ahead = context;
    if (ahead->rows == SRV_STORE_AHEAD) return SRV_STORED;
    struct srv_store_held *held = &ahead->held[ahead->rows];
    struct srv_row_jobs row = {.cap = 1, .job = &held->job, .with_part = 1};
    SRV_STORED_TRY(srv_row_job(&row, field));
    held->part_state = row.part_state;
    held->attempt = row.attempt;
    ahead->rows += row.count;
    return SRV_STORED;
}

static int ahead_order(const void *a, const void *b) {
    return strcmp((*(const struct srv_lease *const *)a)->job,
                  (*(const struct srv_lease *const *)b)->job);
}

/* locks and reads the rows of all parts that the batch will finish, in the order of their jobs, so
 * that two processes cannot deadlock */
static enum srv_stored ahead_read(struct srv_store *store) {
    struct srv_store_ahead *ahead = &store->ahead;
    int last = ahead->leases - 1;
    ahead->read = 1;
    qsort(ahead->lease, (size_t)ahead->leases, sizeof *ahead->lease, ahead_order);
    for (int i = 0; i < last; i++)
        SRV_STORED_TRY(SRV_POST(store, SQL_LEASE, ahead->lease[i]->job, ahead->lease[i]->part));
    return SRV_RUN(store, SQL_LEASE, row_held, ahead, ahead->lease[last]->job,
                   ahead->lease[last]->part);
}

/* takes the row of a part that was read ahead; returns 0 if there is none */
static int ahead_take(struct srv_store_ahead *ahead, const struct srv_lease *lease,
                      struct srv_store_held *held) {
    for (int i = 0; i < ahead->rows && lease->parts == 1; i++) {
        if (strcmp(ahead->held[i].job.id, lease->job) != 0) continue;
        *held = ahead->held[i];
        ahead->held[i] = ahead->held[--ahead->rows];
        return 1;
    }
    return 0;
}

static enum srv_stored lease_read(struct srv_store *store, const struct srv_lease *lease,
                                  struct srv_store_held *held) {
    struct srv_row_jobs row = {.cap = 1, .job = &held->job, .with_part = 1};
    if (store->ahead.leases && !store->ahead.read) SRV_STORED_TRY(ahead_read(store));
    if (ahead_take(&store->ahead, lease, held)) return SRV_STORED;
    SRV_STORED_TRY(SRV_RUN(store, SQL_LEASE, srv_row_job, &row, lease->job, lease->part));
    held->part_state = row.part_state;
    held->attempt = row.attempt;
    return row.count ? SRV_STORED : SRV_STORED_NONE;
}

/* locks the job and the part; LOST unless this attempt holds it or, with `done`, has already
 * finished it */
static enum srv_stored lease_check(struct srv_store *store, const struct srv_lease *lease,
                                   struct srv_job *job, int *done) {
    struct srv_store_held held;
    *done = 0;
    enum srv_stored stored = lease_read(store, lease, &held);
    if (stored == SRV_STORED_NONE) return SRV_STORED_LOST;
    SRV_STORED_TRY(stored);
    *job = held.job;
    if (job->flaw) return SRV_STORED_DAMAGED;
    if (held.attempt != lease->attempt || job->state > SRV_JOB_SUCCESSFUL) return SRV_STORED_LOST;
    *done = held.part_state == PART_DONE;
    return *done || (held.part_state == PART_HELD && srv_job_open(job)) ? SRV_STORED
                                                                        : SRV_STORED_LOST;
}

/* counts one more finished part of the job; the last one ends it */
static enum srv_stored finish_step(struct srv_store *store, struct srv_job *job, size_t bytes,
                                   const void *carry, size_t carry_bytes) {
    struct srv_job was = *job;
    int64_t now;
    job->done++;
    job->bytes += (long long)bytes;
    if (job->done < job->parts) {
        SRV_STORED_TRY(
            SRV_POST(store, SQL_JOB_STEP, job->id, bytes, srv_value_bytes(carry, carry_bytes)));
        store->tally.ring |= carry ? SRV_RING_WORK : 0;
        return srv_store_count_job(store, &was, job);
    }
    SRV_STORED_TRY(srv_store_now(store, &now));
    SRV_STORED_TRY(
        SRV_POST(store, SQL_JOB_SUCCEED, job->id, bytes, now, now + store->rules.keep_us));
    job->state = SRV_JOB_SUCCESSFUL;
    store->tally.ring |= SRV_RING_ENDS;
    return srv_store_count_job(store, &was, job);
}

/* ends a call that stores nothing; if the job has ended, a sweep deletes the part's file */
static enum srv_stored finish_late(struct srv_store *store, const struct srv_lease *lease,
                                   const struct srv_job *job, enum srv_stored stored) {
    int vain = stored == SRV_STORED_LOST && lease->elsewhere &&
               (!*job->id || job->state > SRV_JOB_SUCCESSFUL);
    if (vain) stored = SRV_POST(store, SQL_REMOVAL_PUT, lease->job, "nobody", 0);
    stored = srv_store_end(store, stored);
    return vain && stored == SRV_STORED ? SRV_STORED_LOST : stored;
}

enum srv_stored srv_store_finish(struct srv_store *store, const struct srv_lease *lease,
                                 const void *data, size_t bytes, const void *carry,
                                 size_t carry_bytes) {
    assert(lease->part >= 0 && lease->part < lease->parts && lease->attempt >= 1);
    struct srv_job job = {0};
    int64_t now;
    int done, over = 0;
    char message[SRV_REQUEST_HEAD_BYTES];
    SRV_STORED_TRY(srv_store_begin(store));
    enum srv_stored stored = lease_check(store, lease, &job, &done);
    if (stored != SRV_STORED || done) return finish_late(store, lease, &job, stored);
    /* read before the first write, because writes are collected over the calls of a batch */
    size_t counted = bytes + lease->elsewhere;
    stored = srv_store_room(store, job.client, counted, message);
    if (stored == SRV_STORED) stored = srv_store_now(store, &now);
    if (stored == SRV_STORED_QUOTA) {
        over = 1;
        stored = srv_store_job_end(store, &job, SRV_JOB_FAILED, message);
    } else {
        if (stored == SRV_STORED) stored = srv_blobs_put(store, lease, data, bytes);
        if (stored == SRV_STORED)
            stored = SRV_POST(store, SQL_PART_END, lease->job, lease->part, counted);
        /* progress resets the count of vanished workers */
        if (stored == SRV_STORED && job.parts > 1)
            stored = SRV_POST(store, SQL_PARTS_CLEARED, lease->job);
        if (stored == SRV_STORED) stored = finish_step(store, &job, counted, carry, carry_bytes);
    }
    stored = srv_store_end(store, stored);
    return stored == SRV_STORED && over ? SRV_STORED_QUOTA : stored;
}

enum srv_stored srv_store_fail(struct srv_store *store, const struct srv_lease *lease,
                               const char *message) {
    assert(message && *message && lease->attempt >= 1);
    struct srv_job job;
    int done;
    SRV_STORED_TRY(srv_store_begin(store));
    enum srv_stored stored = lease_check(store, lease, &job, &done);
    if (stored == SRV_STORED && done) stored = SRV_STORED_LOST;
    if (stored == SRV_STORED) stored = srv_store_job_end(store, &job, SRV_JOB_FAILED, message);
    return srv_store_end(store, stored);
}

struct row_parts {
    int count;
    struct {
        char job[SRV_ID_BYTES];
        int64_t number;
    } part[SQL_PARTS_MOST];
};

static enum srv_stored row_part(void *context, const struct srv_value field[]) {
    struct row_parts *rows = context;
    if (rows->count == SQL_PARTS_MOST) return SRV_STORED;
    srv_row_text(&field[0], rows->part[rows->count].job, SRV_ID_BYTES);
    rows->part[rows->count++].number = field[1].whole;
    return SRV_STORED;
}

/* returns a part to the queue; `mark`: its lease expired, which counts against it */
static enum srv_stored part_back(struct srv_store *store, const char *id, int64_t number, int mark,
                                 struct srv_store_sweep *sweep) {
    struct srv_row_wholes row = {.count = 1};
    struct srv_job job;
    char message[SRV_REQUEST_HEAD_BYTES];
    enum srv_stored stored = srv_store_lock(store, id, &job);
    /* deletes parts without an open job, so that they are not found again; a job that ended while
     * its row was awaited keeps its completed parts */
    if (stored == SRV_STORED_NONE) return SRV_RUN(store, SQL_PARTS_REMOVE_SOME, NULL, NULL, id);
    if (stored == SRV_STORED && !srv_job_open(&job))
        return SRV_RUN(store, SQL_PARTS_HELD_REMOVE, NULL, NULL, id);
    SRV_STORED_TRY(stored);
    SRV_STORED_TRY(SRV_RUN(store, SQL_PART_BACK, srv_row_wholes, &row, id, number, mark));
    if (!row.rows) return SRV_STORED;
    sweep->released++;
    struct srv_job was = job;
    job.waiting++;
    SRV_STORED_TRY(srv_store_count_job(store, &was, &job));
    if (row.whole[0] < SRV_MOST_KILLS) return SRV_POST(store, SQL_JOB_WAIT, id);
    sweep->given_up++;
    snprintf(message, sizeof message,
             "failed: %d workers ended or stopped responding while they computed only part %lld of "
             "%ld, and no other part was finished in between",
             SRV_MOST_KILLS, (long long)number + 1, job.parts);
    return srv_store_job_end(store, &job, SRV_JOB_FAILED, message);
}

enum srv_stored srv_store_back(struct srv_store *store, const char *worker, int64_t before,
                               struct srv_store_sweep *sweep, int *found) {
    assert(worker ? *worker != 0 : before >= 0);
    struct row_parts rows = {0};
    enum srv_stored stored = worker ? SRV_RUN(store, SQL_PARTS_OF, row_part, &rows, worker)
                                    : SRV_RUN(store, SQL_PARTS_LATE, row_part, &rows, before);
    *found = rows.count;
    SRV_STORED_TRY(stored);
    for (int i = 0; i < rows.count; i++)
        SRV_STORED_TRY(part_back(store, rows.part[i].job, rows.part[i].number, !worker, sweep));
    if (sweep->released) store->tally.ring |= SRV_RING_WORK;
    return SRV_STORED;
}

enum srv_stored srv_store_release(struct srv_store *store, const char *worker) {
    struct srv_store_sweep sweep;
    enum srv_stored stored;
    int found;
    do {
        sweep = (struct srv_store_sweep){0};
        SRV_STORED_TRY(srv_store_begin(store));
        stored = srv_store_back(store, worker, 0, &sweep, &found);
        stored = srv_store_end(store, stored);
    } while (stored == SRV_STORED && sweep.released == SQL_PARTS_MOST);
    return stored;
}

enum srv_stored srv_store_chunk(struct srv_store *store, const char *id, long part, long chunk,
                                void *data, size_t *bytes) {
    assert(part >= 0 && chunk >= 0);
    *bytes = 0;
    SRV_STORED_TRY(srv_store_look(store));
    return srv_store_end(store, srv_blobs_get(store, id, part, chunk, data, bytes));
}
