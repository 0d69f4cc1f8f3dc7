/* Claims: choosing the parts of jobs that a worker computes next, several small ones at a time.
 * Leaves to others: the results of the parts (store_leases).
 * Invariant: nobody held a part when it is claimed; the cost of a claim does not depend on how
 * many parts wait. */
#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "server/base/clock.h"
#include "server/store/store_jobs.h"
#include "server/store/store_quotas.h"
#include "server/store/store_rows.h"
#include "server/store/store_seals.h"

/* CROWD: changes of a client after which they are put into its row */
enum { LAST_PARTS = 8, TURN_CLIENTS = 8, CROWD = 16 };

/* between two comparisons of sums with jobs */
#define MEND_NS INT64_C(1000000000)

/* a job's rank is an instant and a number of microseconds: this program writes no larger value */
#define CLAIM_RANK (INT64_C(1) << 62)

struct row_lease {
    int rows;
    struct srv_lease *lease;
    const char *flaw; /* a column that holds what nobody can have written */
};

static enum srv_stored row_lease(void *context, const struct srv_value field[]) {
    struct row_lease *row = context;
    struct srv_lease *lease = row->lease;
    lease->part = (long)srv_row_whole(&field[0], 0, lease->parts - 1, "parts", &row->flaw);
    lease->attempt = (long)srv_row_whole(&field[1], 1, SRV_ROW_MOST, "attempt", &row->flaw);
    if (field[2].kind != SRV_SQL_NULL && field[2].kind != SRV_SQL_BYTES && !row->flaw)
        row->flaw = "start";
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
    free(lease->request);
    *lease = (struct srv_lease){0};
}

/* the clients whose turn it is, first come first */
struct row_clients {
    int count, nameless;
    struct {
        char name[SRV_NAME_BYTES];
        int64_t turn, weight, late; /* late: changes that are not in its row yet */
        const char *flaw;           /* of its row */
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
    rows->client[rows->count].late = field[3].whole;
    rows->client[rows->count++].flaw = flaw;
    return SRV_STORED;
}

/* what this transaction has changed and not yet written counts as well: the turns that its
 * claims took */
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

/* A job of which a part can be claimed, locked. */
struct ready {
    struct srv_job job;
    int again; /* one that was held before is next */
    int alone; /* and it is to be computed alone */
    int64_t part_us, waited_us;
    const char *flaw; /* a column that holds what nobody can have written */
    void *request;    /* malloc'ed; NULL when it is long, or memory is short */
    size_t request_bytes;
};

struct row_ready {
    const char *client;
    int rows;
    struct ready ready[SRV_CLAIMS];
};

/* the request of a job, with its seal; one that is too long for a claim, or is no bytes, is read
 * and judged by itself */
static enum srv_stored row_request(struct ready *ready, const struct srv_value seal[],
                                   const struct srv_value *request) {
    if (request->kind != SRV_SQL_BYTES) return SRV_STORED;
    if (!ready->flaw && !srv_seal_request_whole(seal, request->data, request->bytes))
        ready->flaw = "request";
    if (ready->flaw || !(ready->request = malloc(request->bytes + 1))) return SRV_STORED;
    if (request->bytes) memcpy(ready->request, request->data, request->bytes);
    ready->request_bytes = request->bytes;
    return SRV_STORED;
}

static enum srv_stored row_ready(void *context, const struct srv_value field[]) {
    struct row_ready *rows = context;
    if (rows->rows == SRV_CLAIMS) return SRV_STORED;
    struct ready *ready = &rows->ready[rows->rows++];
    struct srv_job *job = &ready->job;
    const char **flaw = &ready->flaw;
    *ready = (struct ready){0};
    srv_row_word(&field[0], 1, job->id, sizeof job->id, "id", flaw);
    srv_row_word(&field[1], 1, job->operation, sizeof job->operation, "operation", flaw);
    job->parts = (long)srv_row_whole(&field[2], 1, SRV_ROW_MOST, "parts", flaw);
    job->begun = (long)srv_row_whole(&field[3], 0, job->parts, "begun", flaw);
    job->waiting = (long)srv_row_whole(&field[4], 0, job->begun, "waiting", flaw);
    job->chained = (int)srv_row_whole(&field[5], 0, 1, "chained", flaw);
    job->done = (long)srv_row_whole(&field[6], 0, job->begun, "done", flaw);
    job->state = (enum srv_job_state)srv_row_whole(&field[7], SRV_JOB_ACCEPTED, SRV_JOB_RUNNING,
                                                   "state", flaw);
    ready->part_us = srv_row_whole(&field[8], 0, SRV_ROW_MOST, "part", flaw);
    /* the claim changes the rank by what `part` says, in a statement whose failure comes too late
     * to name the job */
    if (ready->part_us > CLAIM_RANK / SRV_RANK_TIMES / job->parts && !*flaw) *flaw = "part";
    srv_row_whole(&field[9], -CLAIM_RANK, CLAIM_RANK, "rank", flaw);
    job->created = srv_row_whole(&field[10], 0, SRV_ROW_LATEST, "created", flaw);
    snprintf(job->client, sizeof job->client, "%s", rows->client);
    srv_row_word(&field[12], 0, job->title, sizeof job->title, "title", flaw);
    srv_row_word(&field[13], 0, job->version, sizeof job->version, "version", flaw);
    if (!*flaw && !srv_seal_job_whole(job, &field[11])) *flaw = "seal";
    /* what was held before comes last, unless there is much of it: it may be what kills its
     * workers */
    int last = !job->chained && job->begun < job->parts && job->waiting <= LAST_PARTS;
    ready->again = job->waiting > 0 && !last;
    ready->waited_us = field[16].whole - job->created;
    ready->alone = ready->again && field[15].whole >= job->waiting;
    return row_request(ready, &field[11], &field[14]);
}

/* None of the clients whose turn it is has a job that can be claimed. The sums of clients that
 * should have such jobs are counted anew, so that they do not block the others. One statement
 * compares a client's sum with its jobs, so that a claim of another process between two statements
 * is not taken for a damaged sum; and with several processes it is compared once a second. What
 * this transaction has claimed, and rows that another has locked, are counted too. */
static enum srv_stored claim_mend(struct srv_store *store, const struct row_clients *clients,
                                  int *mended) {
    int64_t now_ns = srv_clock_now();
    *mended = clients->nameless;
    if (clients->nameless) SRV_STORED_TRY(srv_store_plain(store, SQL_CLIENTS_NAMELESS));
    if (store->sql->driver->lists && now_ns < store->mended_ns + MEND_NS) return SRV_STORED;
    store->mended_ns = now_ns;
    for (int i = 0; i < clients->count; i++) {
        const char *name = clients->client[i].name;
        struct srv_row_wholes wrong = {.count = 1};
        struct srv_tally_client *client;
        SRV_STORED_TRY(srv_store_client(store, name, &client));
        if (client->ready) continue;
        SRV_STORED_TRY(
            SRV_RUN(store, SQL_CLIENT_WRONG, srv_row_wholes, &wrong, srv_value_text(name)));
        if (!wrong.whole[0]) continue;
        SRV_STORED_TRY(srv_store_recount_client(store, name));
        *mended = 1;
    }
    return SRV_STORED;
}

/* a job that was to be claimed is damaged: it fails, or goes where it has no name to fail under;
 * so is an account */
static enum srv_stored claim_damaged(struct srv_store *store, const char *client,
                                     const struct ready *ready) {
    struct srv_job job;
    if (!ready) return srv_store_recount(store, client);
    if (!*ready->job.id) {
        SRV_STORED_TRY(srv_store_plain(store, SQL_JOBS_NAMELESS));
        return srv_store_recount(store, client);
    }
    SRV_STORED_TRY(srv_store_find(store, SQL_JOB_LOCK, ready->job.id, &job));
    if (!job.flaw) srv_row_job_fail(&job, ready->flaw ? ready->flaw : "rank");
    return srv_store_condemn(store, &job);
}

/* claims the first part of a job of which no part was held and whose parts are independent: the
 * part's row is known without reading it */
static enum srv_stored claim_first(struct srv_store *store, const struct ready *ready,
                                   const char *worker, int64_t lease_us, struct srv_lease *lease) {
    lease->part = ready->job.begun;
    lease->attempt = 1;
    return SRV_POST(store, SQL_PART_FIRST, srv_value_text(ready->job.id),
                    srv_value_whole(lease->part), srv_value_text(worker),
                    srv_value_whole(lease_us));
}

/* takes a part of the job, whichever is next */
static enum srv_stored claim_next(struct srv_store *store, struct ready *ready, const char *worker,
                                  int64_t lease_us, struct srv_lease *lease) {
    struct row_lease row = {.lease = lease};
    if (!ready->again && !ready->job.chained)
        return claim_first(store, ready, worker, lease_us, lease);
    SRV_STORED_TRY(SRV_RUN(store, ready->again ? SQL_PART_AGAIN : SQL_PART_NEXT, row_lease, &row,
                           srv_value_text(ready->job.id), srv_value_text(worker),
                           srv_value_whole(lease_us)));
    ready->flaw = row.rows ? row.flaw : "ready";
    return ready->flaw ? SRV_STORED_DAMAGED : SRV_STORED;
}

static enum srv_stored claim_part(struct srv_store *store, const char *client, int64_t weight,
                                  const struct srv_claim *claim, struct ready *ready,
                                  struct srv_lease *lease) {
    struct srv_job was = ready->job, is;
    struct srv_tally_client *turn;
    if (ready->flaw) return SRV_STORED_DAMAGED;
    lease->parts = was.parts;
    SRV_STORED_TRY(claim_next(store, ready, claim->worker, claim->lease_us, lease));
    lease->alone = ready->alone;
    lease->waited_us = was.begun ? 0 : ready->waited_us;
    memcpy(lease->job, was.id, sizeof lease->job);
    memcpy(lease->operation, was.operation, sizeof lease->operation);
    lease->part_us = ready->part_us;
    lease->request = ready->request;
    lease->request_bytes = ready->request_bytes;
    ready->request = NULL;
    SRV_STORED_TRY(SRV_POST(store, SQL_JOB_CLAIM, srv_value_text(was.id),
                            srv_value_whole(ready->again), srv_value_whole(!ready->again)));
    is = was;
    is.state = SRV_JOB_RUNNING;
    is.waiting -= ready->again;
    is.begun += !ready->again;
    SRV_STORED_TRY(srv_store_count_job(store, &was, &is));
    SRV_STORED_TRY(srv_store_client(store, client, &turn));
    turn->turn += weight;
    return SRV_STORED;
}

/* The parts of one claim. */
struct claim {
    struct srv_claim *asked;
    int64_t sum_us; /* computation of what it has, as it is estimated */
    struct srv_lease *lease;
    int most, count;
    int aside;                   /* takes a part that was set aside */
    char client[SRV_NAME_BYTES]; /* whose row is damaged, or the row of a job of it; "" = none is */
    int bad;                     /* the job's */
    struct ready damaged;
};

/* whether a part of so much computation may be claimed beside what the claim has */
static int claim_suits(const struct claim *claim, int64_t part_us) {
    return !claim->count || claim->lease[0].alone
               ? !claim->count
               : (claim->lease[0].part_us <= SRV_SMALL_US && part_us <= SRV_SMALL_US &&
                  claim->sum_us + part_us <= SRV_CLAIM_US);
}

/* takes parts of a client's jobs, one of each */
static enum srv_stored claim_client(struct srv_store *store, const char *client, int64_t weight,
                                    int most, struct claim *claim) {
    struct row_ready rows = {.client = client};
    enum srv_stored stored = SRV_RUN(store, SQL_JOBS_READY, row_ready, &rows,
                                     srv_value_text(client), srv_value_whole(most));
    for (int i = 0;
         i < rows.rows && stored == SRV_STORED && claim_suits(claim, rows.ready[i].part_us); i++) {
        struct ready *ready = &rows.ready[i];
        if (ready->alone && !ready->flaw && !claim->aside) {
            claim->asked->skipped = 1;
            if (claim->asked->aside || ready->job.chained || ready->job.begun == ready->job.parts)
                continue;
            ready->again = ready->alone = 0;
        }
        /* a damaged job is treated when it is the first */
        if (ready->flaw && claim->count) break;
        claim->sum_us += ready->part_us;
        stored =
            claim_part(store, client, weight, claim->asked, ready, &claim->lease[claim->count]);
        claim->count++;
        if (stored != SRV_STORED_DAMAGED) continue;
        claim->bad = 1;
        claim->damaged = *ready;
    }
    for (int i = 0; i < rows.rows; i++) free(rows.ready[i].request);
    return stored;
}

/* asks the clients, those whose turn it is first */
static enum srv_stored claim_turns(struct srv_store *store, const struct row_clients *clients,
                                   struct claim *claim) {
    enum srv_stored stored = SRV_STORED;
    for (int i = 0; i < clients->count && stored == SRV_STORED && claim->count < claim->most; i++) {
        const char *name = clients->client[i].name;
        /* each gets its share of what is left */
        int others = clients->count - i, share = (claim->most - claim->count + others - 1) / others;
        if (clients->client[i].flaw && claim->count) break;
        stored = clients->client[i].flaw
                     ? SRV_STORED_DAMAGED
                     : claim_client(store, name, clients->client[i].weight,
                                    share < SRV_CLAIMS ? share : SRV_CLAIMS, claim);
        if (stored == SRV_STORED_DAMAGED) memcpy(claim->client, name, sizeof claim->client);
        if (claim->count && clients->client[i].late >= CROWD)
            memcpy(store->crowded, name, sizeof store->crowded);
        if (claim->count && !claim_suits(claim, 0)) break;
    }
    return stored;
}

/* claims in the transaction that has begun; *mended: something of the store was put right, which is
 * to be kept whatever was claimed */
static enum srv_stored claim_found(struct srv_store *store, struct claim *claim, int *mended) {
    struct row_clients clients = {0};
    SRV_STORED_TRY(srv_store_run(store, SQL_CLIENTS, NULL, 0, row_client, &clients));
    SRV_STORED_TRY(clients_order(store, &clients));
    claim->aside = claim->asked->aside == SRV_CLAIM_ASIDE;
    SRV_STORED_TRY(claim_turns(store, &clients, claim));
    if (!claim->count && claim->asked->skipped && claim->asked->aside) {
        claim->aside = 1;
        SRV_STORED_TRY(claim_turns(store, &clients, claim));
    }
    if (claim->count) return SRV_STORED;
    SRV_STORED_TRY(claim_mend(store, &clients, mended));
    /* parts that are ready but locked by another process will be free in a moment */
    return *mended ? SRV_STORED_AGAIN : clients.count ? SRV_STORED_LOST : SRV_STORED_NONE;
}

/* whether a claim whose commit nobody has heard of has taken effect: then its first part is held */
static enum srv_stored claim_known(struct srv_store *store, struct srv_claim *claim,
                                   struct srv_lease lease[]) {
    struct srv_row_wholes row = {.count = 1};
    assert(claim->count >= 0 && claim->count <= claim->most);
    if (claim->count && store->unsure) {
        SRV_STORED_TRY(srv_store_begin(store));
        enum srv_stored stored =
            SRV_RUN(store, SQL_PART_OURS, srv_row_wholes, &row, srv_value_text(lease[0].job),
                    srv_value_whole(lease[0].part), srv_value_whole(lease[0].attempt),
                    srv_value_text(claim->worker));
        SRV_STORED_TRY(srv_store_end(store, 0, stored));
        if (row.rows) return SRV_STORED;
    }
    for (int i = 0; i < claim->count; i++) srv_lease_clear(&lease[i]);
    claim->count = claim->skipped = 0;
    return SRV_STORED;
}

/* claims in a transaction, and treats a damaged job in another */
static enum srv_stored claim_try(struct srv_store *store, struct claim *claim) {
    int mended = 0;
    SRV_STORED_TRY(srv_store_begin(store));
    enum srv_stored stored = claim_found(store, claim, &mended);
    stored = srv_store_end(store, mended || stored == SRV_STORED, stored);
    if (stored != SRV_STORED_DAMAGED || !claim->client[0]) return stored;
    SRV_STORED_TRY(srv_store_begin(store));
    stored = claim_damaged(store, claim->client, claim->bad ? &claim->damaged : NULL);
    return srv_store_end(store, stored == SRV_STORED,
                         stored == SRV_STORED ? SRV_STORED_AGAIN : stored);
}

enum srv_stored srv_store_claim(struct srv_store *store, struct srv_claim *asked,
                                struct srv_lease lease[]) {
    struct claim claim = {.asked = asked, .lease = lease, .most = asked->most};
    assert(asked->most >= 1 && asked->most <= SRV_CLAIMS && asked->lease_us > 0);
    SRV_STORED_TRY(claim_known(store, asked, lease));
    if (asked->count) return SRV_STORED;
    for (int i = 0; i < asked->most; i++) lease[i] = (struct srv_lease){0};
    enum srv_stored stored = claim_try(store, &claim);
    assert(claim.count <= asked->most && (stored != SRV_STORED || claim.count >= 1));
    /* a claim whose outcome is unknown is asked for again, or given up when its leases run out */
    int kept = stored == SRV_STORED || (stored == SRV_STORED_AWAY && store->unsure);
    for (int i = 0; i < asked->most && !kept; i++) srv_lease_clear(&lease[i]);
    if (kept) asked->count = claim.count;
    return stored;
}
