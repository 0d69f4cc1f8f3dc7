/* Claims: choosing the parts of jobs that a worker computes next, several small ones at a time.
 * Leaves to others: the results of the parts (store_leases).
 * Invariant: nobody held a part when it is claimed; the cost of a claim does not depend on how
 * many parts wait. */
#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "server/base/clock.h"
#include "server/base/hash_table.h"
#include "server/store/store_jobs.h"
#include "server/store/store_rows.h"

/* CROWD: number of a client's changes that triggers a write to its row */
enum { LAST_PARTS = 8, TURN_CLIENTS = 8, CROWD = 16 };

/* ns between two comparisons of the sums with the jobs */
#define MEND_NS INT64_C(1000000000)

/* a rank is a time plus a number of microseconds; this program never writes a larger value */
#define CLAIM_RANK (INT64_C(1) << 62)

/* FLOOR_US: us that the commit of a submitted job may take; FLOOR_NS: ns between two looks at all
 * ranks, which take 1/FLOOR_SHARE of the time at most */
#define FLOOR_US INT64_C(1000000)
#define FLOOR_NS INT64_C(1000000000)
enum { FLOOR_SHARE = 20 };

struct row_lease {
    int rows;
    struct srv_lease *lease;
    const char *flaw; /* a column whose value cannot have been written by this program */
};

static enum srv_stored row_lease(void *context, const struct srv_value field[]) {
    struct row_lease *lease_row = context;
    struct srv_lease *lease = lease_row->lease;
    struct srv_row row = {field, NULL};
    lease->part = (long)srv_row_whole(&row, 0, lease->parts - 1, "parts");
    lease->attempt = (long)srv_row_whole(&row, 1, SRV_ROW_MOST, "attempt");
    if (row.next->kind == SRV_SQL_BYTES) {
        lease->start_bytes = row.next->bytes;
        lease->start = malloc(row.next->bytes + 1);
        if (!lease->start) return SRV_STORED_BROKEN;
        memcpy(lease->start, row.next->data, row.next->bytes);
    } else if (row.next->kind != SRV_SQL_NULL && !row.flaw)
        row.flaw = "start";
    lease_row->flaw = row.flaw;
    lease_row->rows++;
    return SRV_STORED;
}

void srv_lease_clear(struct srv_lease *lease) {
    free(lease->start);
    free(lease->request);
    *lease = (struct srv_lease){0};
}

/* the clients in the order of their turns */
struct row_clients {
    int count, nameless;
    struct turn {
        char name[SRV_NAME_BYTES];
        int64_t turn, weight, late; /* late: changes not yet in the client's row */
        const char *flaw;           /* a damaged column of the client's row */
    } client[TURN_CLIENTS];
};

static enum srv_stored row_client(void *context, const struct srv_value field[]) {
    struct row_clients *rows = context;
    if (rows->count == TURN_CLIENTS) return SRV_STORED;
    struct turn *client = &rows->client[rows->count];
    struct srv_row row = {field, NULL};
    srv_row_word(&row, 1, client->name, SRV_NAME_BYTES, "name");
    rows->nameless |= row.flaw != NULL;
    if (row.flaw) return SRV_STORED;
    rows->count++;
    client->turn = srv_row_whole(&row, 0, SRV_ROW_MOST, "turn");
    client->weight = srv_row_whole(&row, 1, SRV_ROW_MOST, "weight");
    client->late = row.next->whole;
    client->flaw = row.flaw;
    return SRV_STORED;
}

/* sorts the clients by turn, including turns that this transaction used but has not written yet */
static enum srv_stored clients_order(struct srv_store *store, struct row_clients *rows) {
    struct srv_tally_client *client;
    for (int i = 0; i < rows->count; i++) {
        SRV_STORED_TRY(srv_tally_client(&store->tally, rows->client[i].name, &client));
        struct turn one = rows->client[i];
        one.turn += client->turn;
        int at = i;
        for (; at > 0 && one.turn < rows->client[at - 1].turn; at--)
            rows->client[at] = rows->client[at - 1];
        rows->client[at] = one;
    }
    return SRV_STORED;
}

/* A locked job with a part that can be claimed. */
struct ready {
    struct srv_job job;
    int again; /* the next part was held before */
    int alone; /* that part must be computed alone */
    int64_t part_us, rank;
    void *request; /* malloc'ed; NULL if it is long or memory is short */
    size_t request_bytes;
};

struct row_ready {
    int rows;
    struct ready ready[SRV_CLAIMS];
};

/* reads and verifies the request of a job; a request that is too long for a claim, or not bytes, is
 * read later */
static void row_request(struct ready *ready, const struct srv_value *seal,
                        const struct srv_value *request) {
    const char **flaw = &ready->job.flaw;
    if (request->kind != SRV_SQL_BYTES) return;
    if (!*flaw && !srv_seal_request_whole(seal, request->data, request->bytes)) *flaw = "request";
    if (*flaw || !(ready->request = malloc(request->bytes + 1))) return;
    if (request->bytes) memcpy(ready->request, request->data, request->bytes);
    ready->request_bytes = request->bytes;
}

static enum srv_stored row_ready(void *context, const struct srv_value field[]) {
    struct row_ready *rows = context;
    if (rows->rows == SRV_CLAIMS) return SRV_STORED;
    struct ready *ready = &rows->ready[rows->rows++];
    struct srv_job *job = &ready->job;
    struct srv_row_jobs one = {.cap = 1, .job = job};
    struct srv_row row = {field + SRV_ROW_JOB, NULL};
    *ready = (struct ready){0};
    SRV_STORED_TRY(srv_row_job(&one, field));
    ready->part_us = srv_row_whole(&row, 0, SRV_ROW_MOST, "part_us");
    /* check part_us here: an SQL error in the rank could not name the job */
    if (one.count && ready->part_us > CLAIM_RANK / SRV_RANK_TIMES / job->parts)
        row.flaw = "part_us";
    ready->rank = srv_row_whole(&row, -CLAIM_RANK, CLAIM_RANK, "rank");
    if (!one.count || !srv_job_open(job)) row.flaw = one.count ? "state" : "id";
    if (!job->flaw) job->flaw = row.flaw;
    /* a part that was held before may have crashed its worker, so it comes last, unless there are
     * many */
    int last = !job->chained && job->begun < job->parts && job->waiting <= LAST_PARTS;
    ready->again = job->waiting > 0 && !last;
    ready->alone = ready->again && row.next->whole >= job->waiting;
    row_request(ready, &field[SRV_ROW_SEAL], row.next + 1);
    return SRV_STORED;
}

/* None of the clients whose turn it is has a job that can be claimed. The sums of clients that
 * should have such jobs are recounted, so that they do not block the others. One statement compares
 * a client's sum with its jobs, so that a claim of another process between two statements is not
 * taken for a damaged sum; and with several processes it is compared once a second. What this
 * transaction has claimed, and rows that another has locked, are counted too. */
static enum srv_stored claim_mend(struct srv_store *store, const struct row_clients *clients,
                                  int *mended) {
    int64_t now_ns = srv_clock_now();
    *mended = clients->nameless;
    if (clients->nameless) SRV_STORED_TRY(SRV_RUN(store, SQL_CLIENTS_NAMELESS, NULL, NULL));
    if (store->sql->driver->lists && now_ns < store->mended_ns + MEND_NS) return SRV_STORED;
    store->mended_ns = now_ns;
    for (int i = 0; i < clients->count; i++) {
        const char *name = clients->client[i].name;
        struct srv_row_wholes wrong = {.count = 1};
        struct srv_tally_client *client;
        SRV_STORED_TRY(srv_tally_client(&store->tally, name, &client));
        if (client->ready) continue;
        SRV_STORED_TRY(SRV_RUN(store, SQL_CLIENT_WRONG, srv_row_wholes, &wrong, name));
        if (!wrong.whole[0]) continue;
        SRV_STORED_TRY(srv_tally_count_anew(&store->tally, name));
        *mended = 1;
    }
    return SRV_STORED;
}

/* Called if no client in turn has a claimable job. Recounts the sums of clients that should have
 * one, so that they do not block the others. One statement compares a client's sum with its jobs,
 * so that a concurrent claim does not look like a damaged sum. With several processes the
 * comparison is made once a second. Parts claimed in this transaction and rows locked by others
 * count too. */
static enum srv_stored claim_damaged(struct srv_store *store, const char *client,
                                     const struct srv_job *damaged) {
    struct srv_job job;
    if (!*damaged->id) {
        if (damaged->flaw) SRV_STORED_TRY(SRV_RUN(store, SQL_JOBS_NAMELESS, NULL, NULL));
        return srv_store_recount(store, client);
    }
    SRV_STORED_TRY(srv_store_find(store, SQL_JOB_LOCK, damaged->id, &job));
    if (!job.flaw) srv_row_job_fail(&job, damaged->flaw ? damaged->flaw : "rank");
    return srv_store_condemn(store, &job);
}

static enum srv_stored claim_next(struct srv_store *store, struct ready *ready,
                                  const struct srv_claim *asked, struct srv_lease *lease) {
    struct row_lease row = {.lease = lease};
    struct srv_job *job = &ready->job;
    if (!ready->again && !job->chained) {
        /* the row of a part that was never held is known, so it is not read */
        lease->part = job->begun;
        lease->attempt = 1;
        return SRV_POST(store, SQL_PART_FIRST, job->id, lease->part, asked->worker,
                        asked->lease_us);
    }
    SRV_STORED_TRY(SRV_RUN(store, ready->again ? SQL_PART_AGAIN : SQL_PART_NEXT, row_lease, &row,
                           job->id, asked->worker, asked->lease_us));
    job->flaw = row.rows ? row.flaw : "ready";
    return job->flaw ? SRV_STORED_DAMAGED : SRV_STORED;
}

static enum srv_stored claim_part(struct srv_store *store, const struct turn *client,
                                  const struct srv_claim *asked, struct ready *ready,
                                  struct srv_lease *lease) {
    struct srv_job was = ready->job, is = was;
    struct srv_tally_client *turn;
    if (was.flaw) return SRV_STORED_DAMAGED;
    lease->parts = was.parts;
    SRV_STORED_TRY(claim_next(store, ready, asked, lease));
    lease->alone = ready->alone;
    lease->waited_us = was.begun ? 0 : was.now - was.created;
    memcpy(lease->job, was.id, sizeof lease->job);
    memcpy(lease->operation, was.operation, sizeof lease->operation);
    lease->part_us = ready->part_us;
    lease->request = ready->request;
    lease->request_bytes = ready->request_bytes;
    ready->request = NULL;
    SRV_STORED_TRY(SRV_POST(store, SQL_JOB_CLAIM, was.id, ready->again, !ready->again));
    is.state = SRV_JOB_RUNNING;
    is.waiting -= ready->again;
    is.begun += !ready->again;
    SRV_STORED_TRY(srv_store_count_job(store, &was, &is));
    SRV_STORED_TRY(srv_tally_client(&store->tally, client->name, &turn));
    turn->turn += client->weight;
    return SRV_STORED;
}

struct claim {
    struct srv_claim *asked;
    int64_t sum_us; /* estimated computation time of its parts */
    struct srv_lease *lease;
    int count;
    int aside;                   /* the claim takes a part that was set aside */
    char client[SRV_NAME_BYTES]; /* the client with a damaged row, or with a job whose row is
                                    damaged; "" = none */
    struct srv_job
        damaged; /* the damaged job; without an id and a flaw the client's row is damaged */
};

/* whether a part with this estimated time may join the claim */
static int claim_suits(const struct claim *claim, int64_t part_us) {
    return !claim->count || claim->lease[0].alone
               ? !claim->count
               : (claim->lease[0].part_us <= SRV_SMALL_US && part_us <= SRV_SMALL_US &&
                  claim->sum_us + part_us <= SRV_CLAIM_US);
}

/* whether to skip a job because its waiting parts were set aside */
static int claim_passes(const struct claim *claim, struct ready *ready) {
    const struct srv_job *job = &ready->job;
    if (!ready->alone || job->flaw || claim->aside) return 0;
    claim->asked->skipped = 1;
    if (claim->asked->aside || job->chained || job->begun == job->parts) return 1;
    ready->again = ready->alone = 0;
    return 0;
}

/* Reads a client's jobs that can be claimed, lowest ranks first. While a transaction anywhere holds
 * an old snapshot, PostgreSQL keeps the index entries of jobs that have ended since, and a look at
 * all ranks passes over all of them. So a look begins at the rank below which the last one has
 * claimed everything; returned parts with lower ranks are found by the next look at all ranks. */
static enum srv_stored claim_look(struct srv_store *store, const char *name, int most,
                                  struct srv_store_floor *floor, struct row_ready *rows) {
    int64_t begin = srv_clock_now();
    if (strcmp(floor->client, name) != 0) *floor = (struct srv_store_floor){.full_ns = begin};
    snprintf(floor->client, sizeof floor->client, "%s", name);
    if (begin < floor->full_ns) {
        SRV_STORED_TRY(SRV_RUN(store, SQL_JOBS_READY, row_ready, rows, name, most, floor->rank));
        if (rows->rows || begin < floor->rest_ns) return SRV_STORED;
    }
    SRV_STORED_TRY(SRV_RUN(store, SQL_JOBS_READY, row_ready, rows, name, most, INT64_MIN));
    int64_t end = srv_clock_now();
    floor->rest_ns = end + FLOOR_SHARE * (end - begin);
    floor->full_ns = floor->rest_ns > end + FLOOR_NS ? floor->rest_ns : end + FLOOR_NS;
    return SRV_STORED;
}

/* lowers a floor to the rank of a job, or to the lowest rank that its parts can get */
static void floor_lower(struct srv_store_floor *floor, const struct ready *ready) {
    const struct srv_job *job = &ready->job;
    int64_t least = job->flaw ? INT64_MIN : job->now - FLOOR_US, rank = ready->rank;
    if (!job->flaw && job->parts > 1)
        rank -= srv_store_rank(0, ready->part_us * (job->parts - job->begun));
    if (rank < least) least = rank;
    if (least < floor->rank) floor->rank = least;
}

static enum srv_stored claim_client(struct srv_store *store, const struct turn *client, int most,
                                    struct claim *claim) {
    struct row_ready rows = {0};
    struct srv_store_floor *floor =
        &store->floor[srv_hash_bytes(1, client->name, strlen(client->name)) % SRV_STORE_FLOORS];
    enum srv_stored stored =
        client->flaw ? SRV_STORED_DAMAGED : claim_look(store, client->name, most, floor, &rows);
    floor->rank = rows.rows ? CLAIM_RANK : floor->rank;
    for (int i = 0; i < rows.rows && stored == SRV_STORED; i++) {
        struct ready *ready = &rows.ready[i];
        struct srv_job *job = &ready->job;
        floor_lower(floor, ready);
        if (!claim_suits(claim, ready->part_us)) break;
        if (claim_passes(claim, ready)) continue;
        /* a damaged job is handled only if it is the first */
        if (job->flaw && claim->count) break;
        claim->sum_us += ready->part_us;
        stored = claim_part(store, client, claim->asked, ready, &claim->lease[claim->count++]);
        if (stored == SRV_STORED_DAMAGED) claim->damaged = *job;
    }
    if (stored == SRV_STORED_DAMAGED) memcpy(claim->client, client->name, sizeof claim->client);
    for (int i = 0; i < rows.rows; i++) free(rows.ready[i].request);
    return stored;
}

static enum srv_stored claim_turns(struct srv_store *store, const struct row_clients *clients,
                                   struct claim *claim) {
    for (int i = 0; i < clients->count; i++) {
        const struct turn *client = &clients->client[i];
        /* divide the remaining parts among the remaining clients */
        int left = claim->asked->most - claim->count, others = clients->count - i;
        if (!left || (client->flaw && claim->count)) break;
        SRV_STORED_TRY(claim_client(store, client, (left + others - 1) / others, claim));
        if (claim->count && client->late >= CROWD)
            memcpy(store->crowded, client->name, sizeof store->crowded);
        if (claim->count && !claim_suits(claim, 0)) break;
    }
    return SRV_STORED;
}

/* claims within the open transaction; *mended: a repair was made, which must be committed whatever
 * was claimed */
static enum srv_stored claim_found(struct srv_store *store, struct claim *claim, int *mended) {
    struct row_clients clients = {0};
    SRV_STORED_TRY(SRV_RUN(store, SQL_CLIENTS, row_client, &clients));
    SRV_STORED_TRY(clients_order(store, &clients));
    claim->aside = claim->asked->aside == SRV_CLAIM_ASIDE;
    SRV_STORED_TRY(claim_turns(store, &clients, claim));
    if (!claim->count && claim->asked->skipped && claim->asked->aside) {
        claim->aside = 1;
        SRV_STORED_TRY(claim_turns(store, &clients, claim));
    }
    if (claim->count) return SRV_STORED;
    SRV_STORED_TRY(claim_mend(store, &clients, mended));
    /* ready parts that another process has locked will be free in a moment */
    return *mended ? SRV_STORED : clients.count ? SRV_STORED_LOST : SRV_STORED_NONE;
}

/* true if a claim whose commit is unknown has taken effect, that is, its first part is held */
static enum srv_stored claim_known(struct srv_store *store, struct srv_claim *claim,
                                   struct srv_lease lease[]) {
    struct srv_row_wholes row = {.count = 1};
    assert(claim->count >= 0 && claim->count <= claim->most);
    if (claim->count && store->unsure) {
        SRV_STORED_TRY(srv_store_begin(store));
        enum srv_stored stored = SRV_RUN(store, SQL_PART_OURS, srv_row_wholes, &row, lease[0].job,
                                         lease[0].part, lease[0].attempt, claim->worker);
        SRV_STORED_TRY(srv_store_end(store, stored));
        if (row.rows) return SRV_STORED;
    }
    for (int i = 0; i < claim->count; i++) srv_lease_clear(&lease[i]);
    claim->count = claim->skipped = 0;
    return SRV_STORED;
}

/* claims in one transaction, and handles a damaged job in a second one */
static enum srv_stored claim_try(struct srv_store *store, struct claim *claim) {
    int mended = 0;
    SRV_STORED_TRY(srv_store_begin(store));
    enum srv_stored stored = srv_store_end(store, claim_found(store, claim, &mended));
    if (stored == SRV_STORED_DAMAGED && claim->client[0]) {
        mended = 1;
        SRV_STORED_TRY(srv_store_begin(store));
        stored = srv_store_end(store, claim_damaged(store, claim->client, &claim->damaged));
    }
    return stored == SRV_STORED && mended ? SRV_STORED_AGAIN : stored;
}

enum srv_stored srv_store_claim(struct srv_store *store, struct srv_claim *asked,
                                struct srv_lease lease[]) {
    struct claim claim = {.asked = asked, .lease = lease};
    assert(asked->most >= 1 && asked->most <= SRV_CLAIMS && asked->lease_us > 0);
    SRV_STORED_TRY(claim_known(store, asked, lease));
    if (asked->count) return SRV_STORED;
    for (int i = 0; i < asked->most; i++) lease[i] = (struct srv_lease){0};
    enum srv_stored stored = claim_try(store, &claim);
    assert(claim.count <= asked->most && (stored != SRV_STORED || claim.count >= 1));
    /* an uncertain claim keeps its leases, for its repetition; else they expire */
    int kept = stored == SRV_STORED || (stored == SRV_STORED_AWAY && store->unsure);
    for (int i = 0; i < asked->most && !kept; i++) srv_lease_clear(&lease[i]);
    if (kept) asked->count = claim.count;
    return stored;
}
