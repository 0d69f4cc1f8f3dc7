#include "server/store_leases.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "server/store_jobs.h"
#include "server/store_quotas.h"
#include "server/store_rows.h"

enum { SHARD_HELD = 1, SHARD_DONE = 2, LAST_SHARDS = 8 };

struct row_lease {
    int rows;
    struct srv_lease *lease;
};

static enum srv_stored row_lease(void *context, const struct srv_value field[]) {
    struct row_lease *row = context;
    struct srv_lease *lease = row->lease;
    lease->shard = (long)field[0].whole;
    lease->attempt = (long)field[1].whole;
    lease->start_bytes = field[2].bytes;
    if (field[2].kind == SRV_SQL_BYTES) {
        lease->start = malloc(field[2].bytes + 1);
        if (!lease->start) return SRV_STORED_BROKEN;
        memcpy(lease->start, field[2].data, field[2].bytes);
    }
    row->rows++;
    return SRV_STORED;
}

void srv_lease_clear(struct srv_lease *lease) {
    free(lease->start);
    *lease = (struct srv_lease){0};
}

/* the clients whose turn it is, first come first */
struct row_clients {
    int count;
    char name[8][SRV_NAME_BYTES];
};

static enum srv_stored row_client(void *context, const struct srv_value field[]) {
    struct row_clients *rows = context;
    if (rows->count < 8) srv_row_text(&field[0], rows->name[rows->count++], SRV_NAME_BYTES);
    return SRV_STORED;
}

struct row_ready {
    int rows;
    struct srv_lease *lease;
    int again; /* one that was held before is next */
};

static enum srv_stored row_ready(void *context, const struct srv_value field[]) {
    struct row_ready *row = context;
    srv_row_text(&field[0], row->lease->job, sizeof row->lease->job);
    srv_row_text(&field[1], row->lease->operation, sizeof row->lease->operation);
    row->lease->shards = (long)field[2].whole;
    /* what was held before comes last, unless there is much of it: it may be what kills its workers */
    int last = !field[5].whole && field[3].whole < field[2].whole && field[4].whole <= LAST_SHARDS;
    row->again = field[4].whole > 0 && !last;
    row->rows++;
    return SRV_STORED;
}

/* takes a shard of the job that is ready and locked */
static enum srv_stored claim_shard(struct srv_store *store, const char *client, const char *worker, int64_t lease_us,
                                   const struct row_ready *ready) {
    struct srv_lease *lease = ready->lease;
    struct row_lease row = {.lease = lease};
    enum srv_statement take = ready->again ? SQL_SHARD_AGAIN : SQL_SHARD_NEXT;
    SRV_STORED_TRY(SRV_RUN(store, take, row_lease, &row, srv_value_text(lease->job), srv_value_text(worker),
                           srv_value_whole(lease_us)));
    if (!row.rows) return SRV_STORED_BROKEN;
    SRV_STORED_TRY(SRV_RUN(store, SQL_JOB_CLAIM, NULL, NULL, srv_value_text(lease->job), srv_value_whole(ready->again),
                           srv_value_whole(!ready->again)));
    return srv_store_client(store, client, 0, 0, 1, NULL);
}

enum srv_stored srv_store_claim(struct srv_store *store, const char *worker, int64_t lease_us,
                                struct srv_lease *lease) {
    struct row_clients clients = {0};
    struct row_ready ready = {.lease = lease};
    *lease = (struct srv_lease){0};
    SRV_STORED_TRY(srv_store_begin(store));
    enum srv_stored stored = srv_store_run(store, SQL_CLIENTS, NULL, 0, row_client, &clients);
    const char *client = NULL;
    for (int i = 0; i < clients.count && stored == SRV_STORED && !ready.rows; i++) {
        client = clients.name[i];
        stored = SRV_RUN(store, SQL_JOB_READY, row_ready, &ready, srv_value_text(client));
    }
    if (stored == SRV_STORED && ready.rows) stored = claim_shard(store, client, worker, lease_us, &ready);
    /* what is ready but locked by another process will be free in a moment */
    else if (stored == SRV_STORED)
        stored = clients.count ? SRV_STORED_AGAIN : SRV_STORED_NONE;
    stored = srv_store_end(store, stored == SRV_STORED, stored);
    if (stored != SRV_STORED) srv_lease_clear(lease);
    return stored;
}

enum srv_stored srv_store_extend(struct srv_store *store, const struct srv_lease *lease, int64_t lease_us) {
    struct srv_row_wholes row = {.count = 1};
    SRV_STORED_TRY(srv_store_begin(store));
    enum srv_stored stored =
        SRV_RUN(store, SQL_SHARD_EXTEND, srv_row_wholes, &row, srv_value_text(lease->job),
                srv_value_whole(lease->shard), srv_value_whole(lease->attempt), srv_value_whole(lease_us));
    if (stored == SRV_STORED && !row.rows) stored = SRV_STORED_LOST;
    return srv_store_end(store, stored == SRV_STORED, stored);
}

/* locks the job, then the shard; LOST unless this attempt holds it or, with `done`, has already finished it */
static enum srv_stored lease_check(struct srv_store *store, const struct srv_lease *lease, struct srv_job *job,
                                   int *done) {
    struct srv_row_wholes shard = {.count = 2};
    *done = 0;
    enum srv_stored stored = srv_store_find(store, SQL_JOB_LOCK, lease->job, job);
    if (stored == SRV_STORED_NONE) return SRV_STORED_LOST;
    SRV_STORED_TRY(stored);
    SRV_STORED_TRY(
        SRV_RUN(store, SQL_SHARD, srv_row_wholes, &shard, srv_value_text(lease->job), srv_value_whole(lease->shard)));
    if (!shard.rows || shard.whole[1] != lease->attempt) return SRV_STORED_LOST;
    *done = shard.whole[0] == SHARD_DONE;
    return *done || (shard.whole[0] == SHARD_HELD && srv_job_open(job)) ? SRV_STORED : SRV_STORED_LOST;
}

static enum srv_stored finish_data(struct srv_store *store, const struct srv_lease *lease, const char *data,
                                   size_t bytes) {
    for (size_t at = 0; at < bytes; at += SRV_CHUNK_BYTES) {
        size_t piece = bytes - at < SRV_CHUNK_BYTES ? bytes - at : SRV_CHUNK_BYTES;
        SRV_STORED_TRY(SRV_RUN(store, SQL_RESULT_PUT, NULL, NULL, srv_value_text(lease->job),
                               srv_value_whole(lease->shard), srv_value_whole((int64_t)(at / SRV_CHUNK_BYTES)),
                               srv_value_bytes(data + at, piece)));
    }
    return SRV_RUN(store, SQL_SHARD_END, NULL, NULL, srv_value_text(lease->job), srv_value_whole(lease->shard),
                   srv_value_whole((int64_t)bytes));
}

enum srv_stored srv_store_finish(struct srv_store *store, const struct srv_lease *lease, const void *data, size_t bytes,
                                 const void *carry, size_t carry_bytes) {
    struct srv_job job;
    int64_t kept = 0;
    int done, over = 0;
    char message[SRV_MESSAGE_BYTES];
    SRV_STORED_TRY(srv_store_begin(store));
    enum srv_stored stored = lease_check(store, lease, &job, &done);
    if (stored != SRV_STORED || done) return srv_store_end(store, 0, stored);
    stored = srv_store_client(store, job.client, 0, (long long)bytes, 0, &kept);
    if (stored == SRV_STORED) stored = srv_store_room(store, bytes, kept, message);
    if (stored == SRV_STORED_QUOTA) {
        /* what was counted is taken back, and the job ends */
        over = 1;
        stored = srv_store_client(store, job.client, 0, -(long long)bytes, 0, NULL);
        if (stored == SRV_STORED) stored = srv_store_job_end(store, &job, SRV_JOB_FAILED, message);
    } else {
        if (stored == SRV_STORED) stored = finish_data(store, lease, data, bytes);
        /* a job that gets on is not what kills its workers */
        if (stored == SRV_STORED) stored = SRV_RUN(store, SQL_SHARDS_CLEARED, NULL, NULL, srv_value_text(lease->job));
        if (stored == SRV_STORED)
            stored = SRV_RUN(store, SQL_JOB_STEP, NULL, NULL, srv_value_text(lease->job),
                             srv_value_whole((int64_t)bytes), srv_value_bytes(carry, carry_bytes));
        if (stored == SRV_STORED && job.done + 1 == job.shards)
            stored = srv_store_job_end(store, &job, SRV_JOB_SUCCESSFUL, "");
        else if (stored == SRV_STORED && carry)
            stored = srv_store_plain(store, SQL_RING);
    }
    int keep = stored == SRV_STORED;
    return srv_store_end(store, keep, keep && over ? SRV_STORED_QUOTA : stored);
}

enum srv_stored srv_store_fail(struct srv_store *store, const struct srv_lease *lease, const char *message) {
    struct srv_job job;
    int done;
    SRV_STORED_TRY(srv_store_begin(store));
    enum srv_stored stored = lease_check(store, lease, &job, &done);
    if (stored == SRV_STORED && done) stored = SRV_STORED_LOST;
    if (stored == SRV_STORED) stored = srv_store_job_end(store, &job, SRV_JOB_FAILED, message);
    return srv_store_end(store, stored == SRV_STORED, stored);
}

struct row_shards {
    int count;
    struct {
        char job[SRV_ID_BYTES];
        int64_t number;
    } shard[SQL_SHARDS_MOST];
};

static enum srv_stored row_shard(void *context, const struct srv_value field[]) {
    struct row_shards *rows = context;
    if (rows->count == SQL_SHARDS_MOST) return SRV_STORED;
    srv_row_text(&field[0], rows->shard[rows->count].job, SRV_ID_BYTES);
    rows->shard[rows->count++].number = field[1].whole;
    return SRV_STORED;
}

/* a shard waits again; with `mark` because its lease ran out, which counts against it */
static enum srv_stored shard_back(struct srv_store *store, const char *id, int64_t number, int mark,
                                  struct srv_store_sweep *sweep) {
    struct srv_row_wholes row = {.count = 1};
    struct srv_job job;
    char message[SRV_MESSAGE_BYTES];
    enum srv_stored stored = srv_store_find(store, SQL_JOB_LOCK, id, &job);
    if (stored == SRV_STORED_NONE || (stored == SRV_STORED && !srv_job_open(&job))) return SRV_STORED;
    SRV_STORED_TRY(stored);
    SRV_STORED_TRY(SRV_RUN(store, SQL_SHARD_BACK, srv_row_wholes, &row, srv_value_text(id), srv_value_whole(number),
                           srv_value_whole(mark)));
    if (!row.rows) return SRV_STORED;
    sweep->released++;
    if (row.whole[0] < SRV_MOST_KILLS) return SRV_RUN(store, SQL_JOB_WAIT, NULL, NULL, srv_value_text(id));
    sweep->given_up++;
    snprintf(message, sizeof message,
             "given up: %d workers ended or fell silent over part %lld of %ld, and nothing was done between",
             SRV_MOST_KILLS, (long long)number + 1, job.shards);
    return srv_store_job_end(store, &job, SRV_JOB_FAILED, message);
}

enum srv_stored srv_store_back(struct srv_store *store, const char *worker, int64_t before,
                               struct srv_store_sweep *sweep, int *found) {
    struct row_shards rows = {0};
    enum srv_stored stored = worker ? SRV_RUN(store, SQL_SHARDS_OF, row_shard, &rows, srv_value_text(worker))
                                    : SRV_RUN(store, SQL_SHARDS_LATE, row_shard, &rows, srv_value_whole(before));
    *found = rows.count;
    SRV_STORED_TRY(stored);
    for (int i = 0; i < rows.count; i++)
        SRV_STORED_TRY(shard_back(store, rows.shard[i].job, rows.shard[i].number, !worker, sweep));
    return sweep->released ? srv_store_plain(store, SQL_RING) : SRV_STORED;
}

enum srv_stored srv_store_release(struct srv_store *store, const char *worker) {
    struct srv_store_sweep sweep;
    enum srv_stored stored;
    int found;
    do {
        sweep = (struct srv_store_sweep){0};
        SRV_STORED_TRY(srv_store_begin(store));
        stored = srv_store_back(store, worker, 0, &sweep, &found);
        stored = srv_store_end(store, stored == SRV_STORED, stored);
    } while (stored == SRV_STORED && sweep.released == SQL_SHARDS_MOST);
    return stored;
}

struct row_chunk {
    int rows;
    void *data;
    size_t bytes;
};

static enum srv_stored row_chunk(void *context, const struct srv_value field[]) {
    struct row_chunk *row = context;
    if (field[0].bytes > SRV_CHUNK_BYTES) return SRV_STORED_BROKEN;
    row->rows++;
    row->bytes = field[0].bytes;
    if (row->bytes) memcpy(row->data, field[0].data, row->bytes);
    return SRV_STORED;
}

enum srv_stored srv_store_chunk(struct srv_store *store, const char *id, long shard, long chunk, void *data,
                                size_t *bytes) {
    struct row_chunk row = {.data = data};
    *bytes = 0;
    SRV_STORED_TRY(srv_store_begin(store));
    enum srv_stored stored =
        SRV_RUN(store, SQL_RESULT, row_chunk, &row, srv_value_text(id), srv_value_whole(shard), srv_value_whole(chunk));
    if (stored == SRV_STORED && !row.rows) stored = SRV_STORED_NONE;
    stored = srv_store_end(store, 1, stored);
    if (stored == SRV_STORED) *bytes = row.bytes;
    return stored;
}
