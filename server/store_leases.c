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
    const char *flaw; /* a column that holds what nobody can have written */
};

static enum srv_stored row_lease(void *context, const struct srv_value field[]) {
    struct row_lease *row = context;
    struct srv_lease *lease = row->lease;
    lease->shard = (long)srv_row_whole(&field[0], 0, lease->shards - 1, "shards", &row->flaw);
    lease->attempt = (long)srv_row_whole(&field[1], 1, SRV_ROW_MOST, "attempt", &row->flaw);
    if (field[2].kind != SRV_SQL_NULL && field[2].kind != SRV_SQL_BYTES && !row->flaw) row->flaw = "start";
    if (field[2].kind == SRV_SQL_BYTES) {
        lease->start_bytes = field[2].bytes;
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

enum { TURN_CLIENTS = 8 };

/* the clients whose turn it is, first come first */
struct row_clients {
    int count, nameless;
    struct {
        char name[SRV_NAME_BYTES];
        int64_t turn, weight;
        const char *flaw; /* of its row */
    } client[TURN_CLIENTS];
};

static enum srv_stored row_client(void *context, const struct srv_value field[]) {
    struct row_clients *rows = context;
    if (rows->count == TURN_CLIENTS) return SRV_STORED;
    const char *flaw = NULL;
    srv_row_word(&field[0], 1, rows->client[rows->count].name, SRV_NAME_BYTES, "name", &flaw);
    rows->nameless |= flaw != NULL;
    if (flaw) return SRV_STORED;
    rows->client[rows->count].turn = srv_row_whole(&field[1], 0, SRV_ROW_MOST, "turn", &flaw);
    rows->client[rows->count].weight = srv_row_whole(&field[2], 1, SRV_ROW_MOST, "weight", &flaw);
    rows->client[rows->count++].flaw = flaw;
    return SRV_STORED;
}

/* what this transaction has changed and not yet written counts as well: the turns that its claims took */
static enum srv_stored clients_order(struct srv_store *store, struct row_clients *rows) {
    struct srv_tally_client *client;
    for (int i = 0; i < rows->count; i++) {
        SRV_STORED_TRY(srv_store_client(store, rows->client[i].name, &client));
        rows->client[i].turn += client->turn;
    }
    for (int i = 1; i < rows->count; i++)
        for (int j = i; j > 0 && rows->client[j].turn < rows->client[j - 1].turn; j--) {
            struct row_clients swap = {.client[0] = rows->client[j]};
            rows->client[j] = rows->client[j - 1];
            rows->client[j - 1] = swap.client[0];
        }
    return SRV_STORED;
}

/* A job of which a shard can be claimed, locked. */
struct row_ready {
    int rows;
    struct srv_job job;
    int again; /* one that was held before is next */
    const char *flaw;
};

static enum srv_stored row_ready(void *context, const struct srv_value field[]) {
    struct row_ready *row = context;
    struct srv_job *job = &row->job;
    const char **flaw = &row->flaw;
    *job = (struct srv_job){.state = SRV_JOB_RUNNING};
    srv_row_word(&field[0], 1, job->id, sizeof job->id, "id", flaw);
    srv_row_word(&field[1], 1, job->operation, sizeof job->operation, "operation", flaw);
    job->shards = (long)srv_row_whole(&field[2], 1, SRV_ROW_MOST, "shards", flaw);
    job->begun = (long)srv_row_whole(&field[3], 0, job->shards, "begun", flaw);
    job->waiting = (long)srv_row_whole(&field[4], 0, job->begun, "waiting", flaw);
    job->chained = (int)srv_row_whole(&field[5], 0, 1, "chained", flaw);
    job->done = (long)srv_row_whole(&field[6], 0, job->begun, "done", flaw);
    job->state = (enum srv_job_state)srv_row_whole(&field[7], SRV_JOB_ACCEPTED, SRV_JOB_RUNNING, "state", flaw);
    /* what was held before comes last, unless there is much of it: it may be what kills its workers */
    int last = !job->chained && job->begun < job->shards && job->waiting <= LAST_SHARDS;
    row->again = job->waiting > 0 && !last;
    row->rows++;
    return SRV_STORED;
}

/* Nobody whose turn it is has a job that can be claimed: those of whom it is only said are counted anew, so that they
 * stand in nobody's way. What this transaction has claimed, and what another has locked, is there. */
static enum srv_stored claim_mend(struct srv_store *store, const struct row_clients *clients, int *mended) {
    *mended = clients->nameless;
    if (clients->nameless) SRV_STORED_TRY(srv_store_plain(store, SQL_CLIENTS_NAMELESS));
    for (int i = 0; i < clients->count; i++) {
        const char *name = clients->client[i].name;
        struct srv_row_wholes some = {.count = 1};
        struct srv_tally_client *client;
        SRV_STORED_TRY(srv_store_client(store, name, &client));
        if (client->ready) continue;
        SRV_STORED_TRY(SRV_RUN(store, SQL_CLIENT_READY, srv_row_wholes, &some, srv_value_text(name)));
        if (some.whole[0]) continue;
        SRV_STORED_TRY(srv_store_recount_client(store, name));
        *mended = 1;
    }
    return SRV_STORED;
}

/* a job that was to be claimed is damaged: it fails, or goes where it has no name to fail under; so is an account */
static enum srv_stored claim_damaged(struct srv_store *store, const char *client, const struct row_ready *ready) {
    struct srv_job job;
    if (!ready->rows) return srv_store_recount(store, client);
    if (!*ready->job.id) {
        SRV_STORED_TRY(srv_store_plain(store, SQL_JOBS_NAMELESS));
        return srv_store_recount(store, client);
    }
    SRV_STORED_TRY(srv_store_find(store, SQL_JOB_LOCK, ready->job.id, &job));
    if (!job.flaw) srv_row_job_fail(&job, ready->flaw ? ready->flaw : "rank");
    return srv_store_condemn(store, &job);
}

/* takes a shard of the job that is ready and locked */
static enum srv_stored claim_shard(struct srv_store *store, const char *client, int64_t weight, const char *worker,
                                   int64_t lease_us, struct row_ready *ready, struct srv_lease *lease) {
    struct row_lease row = {.lease = lease};
    struct srv_job was = ready->job, is;
    struct srv_tally_client *turn;
    if (ready->flaw) return SRV_STORED_DAMAGED;
    lease->shards = was.shards;
    enum srv_statement take = ready->again ? SQL_SHARD_AGAIN : SQL_SHARD_NEXT;
    SRV_STORED_TRY(SRV_RUN(store, take, row_lease, &row, srv_value_text(was.id), srv_value_text(worker),
                           srv_value_whole(lease_us)));
    ready->flaw = row.rows ? row.flaw : "ready";
    if (ready->flaw) return SRV_STORED_DAMAGED;
    memcpy(lease->job, was.id, sizeof lease->job);
    memcpy(lease->operation, was.operation, sizeof lease->operation);
    SRV_STORED_TRY(SRV_POST(store, SQL_JOB_CLAIM, srv_value_text(was.id), srv_value_whole(ready->again),
                            srv_value_whole(!ready->again)));
    snprintf(was.client, sizeof was.client, "%s", client);
    is = was;
    is.state = SRV_JOB_RUNNING;
    is.waiting -= ready->again;
    is.begun += !ready->again;
    SRV_STORED_TRY(srv_store_count_job(store, &was, &is));
    SRV_STORED_TRY(srv_store_client(store, client, &turn));
    turn->turn += weight;
    return SRV_STORED;
}

enum srv_stored srv_store_claim(struct srv_store *store, const char *worker, int64_t lease_us,
                                struct srv_lease *lease) {
    struct row_clients clients = {0};
    struct row_ready ready = {0};
    *lease = (struct srv_lease){0};
    SRV_STORED_TRY(srv_store_begin(store));
    enum srv_stored stored = srv_store_run(store, SQL_CLIENTS, NULL, 0, row_client, &clients);
    if (stored == SRV_STORED) stored = clients_order(store, &clients);
    const char *client = NULL;
    int64_t weight = 1;
    for (int i = 0; i < clients.count && stored == SRV_STORED && !ready.rows; i++) {
        client = clients.client[i].name;
        weight = clients.client[i].weight;
        stored = clients.client[i].flaw ? SRV_STORED_DAMAGED : SRV_STORED;
        if (stored == SRV_STORED) stored = SRV_RUN(store, SQL_JOB_READY, row_ready, &ready, srv_value_text(client));
    }
    if (stored == SRV_STORED && ready.rows)
        stored = claim_shard(store, client, weight, worker, lease_us, &ready, lease);
    int mended = 0;
    if (stored == SRV_STORED && !ready.rows) {
        /* what is ready but locked by another process will be free in a moment */
        stored = claim_mend(store, &clients, &mended);
        if (stored == SRV_STORED) stored = mended || clients.count ? SRV_STORED_AGAIN : SRV_STORED_NONE;
    }
    stored = srv_store_end(store, mended || stored == SRV_STORED, stored);
    if (stored == SRV_STORED_DAMAGED && client) {
        SRV_STORED_TRY(srv_store_begin(store));
        stored = claim_damaged(store, client, &ready);
        stored = srv_store_end(store, stored == SRV_STORED, stored == SRV_STORED ? SRV_STORED_AGAIN : stored);
    }
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

/* locks the job and the shard; LOST unless this attempt holds it or, with `done`, has already finished it */
static enum srv_stored lease_check(struct srv_store *store, const struct srv_lease *lease, struct srv_job *job,
                                   int *done) {
    struct srv_row_jobs rows = {.cap = 1, .job = job, .with_lease = 1};
    *done = 0;
    SRV_STORED_TRY(
        SRV_RUN(store, SQL_LEASE, srv_row_job, &rows, srv_value_text(lease->job), srv_value_whole(lease->shard)));
    if (rows.count && job->flaw) return SRV_STORED_DAMAGED;
    if (!rows.count || rows.attempt != lease->attempt || job->state > SRV_JOB_SUCCESSFUL) return SRV_STORED_LOST;
    *done = rows.shard_state == SHARD_DONE;
    return *done || (rows.shard_state == SHARD_HELD && srv_job_open(job)) ? SRV_STORED : SRV_STORED_LOST;
}

static enum srv_stored finish_data(struct srv_store *store, const struct srv_lease *lease, const char *data,
                                   size_t bytes) {
    for (size_t at = 0; at < bytes; at += SRV_CHUNK_BYTES) {
        size_t piece = bytes - at < SRV_CHUNK_BYTES ? bytes - at : SRV_CHUNK_BYTES;
        SRV_STORED_TRY(SRV_POST(store, SQL_RESULT_PUT, srv_value_text(lease->job), srv_value_whole(lease->shard),
                                srv_value_whole((int64_t)(at / SRV_CHUNK_BYTES)), srv_value_bytes(data + at, piece)));
    }
    return SRV_POST(store, SQL_SHARD_END, srv_value_text(lease->job), srv_value_whole(lease->shard),
                    srv_value_whole((int64_t)bytes));
}

/* the job has a shard more that is done; the last one ends it */
static enum srv_stored finish_step(struct srv_store *store, struct srv_job *job, size_t bytes, const void *carry,
                                   size_t carry_bytes) {
    struct srv_job was = *job;
    int64_t now;
    job->done++;
    job->bytes += (long long)bytes;
    if (job->done < job->shards) {
        SRV_STORED_TRY(SRV_POST(store, SQL_JOB_STEP, srv_value_text(job->id), srv_value_whole((int64_t)bytes),
                                srv_value_bytes(carry, carry_bytes)));
        store->tally.ring |= carry != NULL;
        return srv_store_count_job(store, &was, job);
    }
    SRV_STORED_TRY(srv_store_now(store, &now));
    SRV_STORED_TRY(SRV_POST(store, SQL_JOB_SUCCEED, srv_value_text(job->id), srv_value_whole((int64_t)bytes),
                            srv_value_whole(now), srv_value_whole(now + store->rules.keep_us)));
    job->state = SRV_JOB_SUCCESSFUL;
    store->tally.ring = 1;
    return srv_store_count_job(store, &was, job);
}

enum srv_stored srv_store_finish(struct srv_store *store, const struct srv_lease *lease, const void *data, size_t bytes,
                                 const void *carry, size_t carry_bytes) {
    struct srv_job job;
    int done, over = 0;
    char message[SRV_MESSAGE_BYTES];
    SRV_STORED_TRY(srv_store_begin(store));
    enum srv_stored stored = lease_check(store, lease, &job, &done);
    if (stored != SRV_STORED || done) return srv_store_end(store, 0, stored);
    stored = srv_store_room(store, job.client, bytes, message);
    if (stored == SRV_STORED_QUOTA) {
        over = 1;
        stored = srv_store_job_end(store, &job, SRV_JOB_FAILED, message);
    } else {
        if (stored == SRV_STORED) stored = finish_data(store, lease, data, bytes);
        /* a job that gets on is not what kills its workers */
        if (stored == SRV_STORED && job.shards > 1)
            stored = SRV_POST(store, SQL_SHARDS_CLEARED, srv_value_text(lease->job));
        if (stored == SRV_STORED) stored = finish_step(store, &job, bytes, carry, carry_bytes);
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
    enum srv_stored stored = srv_store_lock(store, id, &job);
    /* what no open job has any more is not looked at again and again */
    if (stored == SRV_STORED_NONE || (stored == SRV_STORED && !srv_job_open(&job)))
        return SRV_RUN(store, SQL_SHARDS_REMOVE_SOME, NULL, NULL, srv_value_text(id));
    SRV_STORED_TRY(stored);
    SRV_STORED_TRY(SRV_RUN(store, SQL_SHARD_BACK, srv_row_wholes, &row, srv_value_text(id), srv_value_whole(number),
                           srv_value_whole(mark)));
    if (!row.rows) return SRV_STORED;
    sweep->released++;
    struct srv_job was = job;
    job.waiting++;
    SRV_STORED_TRY(srv_store_count_job(store, &was, &job));
    if (row.whole[0] < SRV_MOST_KILLS) return SRV_POST(store, SQL_JOB_WAIT, srv_value_text(id));
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
    store->tally.ring |= sweep->released > 0;
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
    if (field[0].kind != SRV_SQL_BYTES || field[0].bytes > SRV_CHUNK_BYTES) return SRV_STORED_DAMAGED;
    row->rows++;
    row->bytes = field[0].bytes;
    if (row->bytes) memcpy(row->data, field[0].data, row->bytes);
    return SRV_STORED;
}

enum srv_stored srv_store_chunk(struct srv_store *store, const char *id, long shard, long chunk, void *data,
                                size_t *bytes) {
    struct row_chunk row = {.data = data};
    *bytes = 0;
    SRV_STORED_TRY(srv_store_look(store));
    enum srv_stored stored =
        SRV_RUN(store, SQL_RESULT, row_chunk, &row, srv_value_text(id), srv_value_whole(shard), srv_value_whole(chunk));
    if (stored == SRV_STORED && !row.rows) stored = SRV_STORED_NONE;
    stored = srv_store_end(store, 1, stored);
    if (stored == SRV_STORED) *bytes = row.bytes;
    return stored;
}
