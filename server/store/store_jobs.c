#include "server/store/store_jobs.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* LIST_ROWS: rows per statement of a list. RING_PARTS: with so many waiting parts all workers are
 * busy claiming. */
enum { LIST_ROWS = 100, RING_PARTS = 512 };

enum srv_stored srv_store_find(struct srv_store *store, enum srv_statement id, const char *name,
                               struct srv_job *job) {
    struct srv_row_jobs rows = {.cap = 1, .job = job};
    SRV_STORED_TRY(SRV_RUN(store, id, srv_row_job, &rows, name));
    return rows.count ? SRV_STORED : SRV_STORED_NONE;
}

enum srv_stored srv_store_condemn(struct srv_store *store, struct srv_job *job) {
    assert(*job->id && job->state == SRV_JOB_FAILED);
    unsigned char seal[SRV_SEAL_JOB_BYTES];
    SRV_STORED_TRY(srv_store_now(store, &job->now));
    job->held = SRV_ROW_BYTES;
    job->bytes = 0;
    job->finished = job->now;
    job->expires = job->now + store->rules.keep_us;
    if (!job->created) job->created = job->now;
    if (!*job->client) snprintf(job->client, sizeof job->client, "nobody");
    if (!*job->operation) snprintf(job->operation, sizeof job->operation, "unknown");
    job->parts = 1;
    job->chained = 0;
    srv_seal_job(seal, job, "", 0);
    SRV_STORED_TRY(SRV_RUN(store, SQL_JOB_CONDEMN, NULL, NULL, job->id, job->client, job->operation,
                           job->message, job->created, job->finished, job->expires, job->held,
                           srv_value_bytes("", 0), srv_value_bytes(seal, sizeof seal)));
    /* the job's parts and results are deleted later, in steps */
    SRV_STORED_TRY(SRV_RUN(store, SQL_REMOVAL_PUT, NULL, NULL, job->id, job->client, 0));
    store->tally.ring |= SRV_RING_STOP | SRV_RING_ENDS;
    /* the numbers of a damaged row cannot be subtracted from the sums */
    return srv_store_recount(store, job->client);
}

enum srv_stored srv_store_lock(struct srv_store *store, const char *id, struct srv_job *job) {
    SRV_STORED_TRY(srv_store_find(store, SQL_JOB_LOCK, id, job));
    return job->flaw ? srv_store_condemn(store, job) : SRV_STORED;
}

int srv_job_open(const struct srv_job *job) { return job->state <= SRV_JOB_RUNNING; }

/* true if a job's key can be used again: it failed, was dismissed or has expired */
static int submit_spent(const struct srv_job *job) {
    return job->state >= SRV_JOB_FAILED || (job->expires > 0 && job->expires < job->now);
}

static enum srv_stored submit_known(struct srv_store *store, const struct srv_job_order *order,
                                    struct srv_job *job) {
    struct srv_row_jobs rows = {.cap = 1, .job = job, .with_digest = 1};
    SRV_STORED_TRY(SRV_RUN(store, SQL_JOB_OF_KEY, srv_row_job, &rows, order->client, order->key));
    if (!rows.count) return SRV_STORED_NONE;
    if (submit_spent(job)) {
        SRV_STORED_TRY(SRV_POST(store, SQL_KEY_FREE, job->id));
        return SRV_STORED_NONE;
    }
    return memcmp(rows.digest, order->digest, SRV_DIGEST_BYTES) ? SRV_STORED_CLASH : SRV_STORED;
}

/* returns the bytes counted for a job without results */
static long long submit_held(const struct srv_job_order *order) {
    return SRV_ROW_BYTES + (long long)order->request_bytes +
           SRV_PART_BYTES * (long long)(order->parts - 1);
}

static void submit_job(const struct srv_job_order *order, int64_t now, struct srv_job *job) {
    *job = (struct srv_job){.parts = order->parts,
                            .chained = order->chained,
                            .created = now,
                            .now = now,
                            .held = submit_held(order)};
    snprintf(job->id, sizeof job->id, "%s", order->id);
    snprintf(job->client, sizeof job->client, "%s", order->client);
    snprintf(job->operation, sizeof job->operation, "%s", order->operation);
    snprintf(job->title, sizeof job->title, "%s", order->title ? order->title : "");
    snprintf(job->version, sizeof job->version, "%s", order->version ? order->version : "");
}

static enum srv_stored submit_count(struct srv_store *store, const struct srv_job *job) {
    struct srv_tally_client *client;
    SRV_STORED_TRY(srv_tally_client(&store->tally, job->client, &client));
    client->jobs++;
    client->ready++;
    /* if many parts wait, all idle workers are claiming already */
    int64_t *changes = store->tally.changes;
    if (store->tally.were[SRV_TALLY_PARTS] + changes[SRV_TALLY_PARTS] < RING_PARTS)
        store->tally.ring |= SRV_RING_WORK;
    changes[SRV_JOB_ACCEPTED]++;
    changes[SRV_TALLY_PARTS] += srv_job_claimable(job);
    return srv_store_count_bytes(store, job->client, job->held);
}

/* checks the client's own limits for one more open job and its bytes */
static enum srv_stored submit_allowed(const struct srv_store *store,
                                      const struct srv_job_order *order,
                                      const struct srv_tally_client *client,
                                      char message[SRV_REQUEST_HEAD_BYTES]) {
    int64_t open = client->jobs_were + client->jobs;
    long long kept = client->bytes_were + client->bytes + submit_held(order);
    if (open >= store->rules.client_jobs)
        snprintf(message, SRV_REQUEST_HEAD_BYTES, "the client has max-client-jobs, %ld, open jobs",
                 store->rules.client_jobs);
    else if (order->client_jobs && open >= order->client_jobs)
        snprintf(message, SRV_REQUEST_HEAD_BYTES,
                 "the client has %ld open jobs, the limit of its role or key", order->client_jobs);
    else if (order->client_bytes && kept > order->client_bytes)
        snprintf(message, SRV_REQUEST_HEAD_BYTES,
                 "the client's stored jobs would exceed the %lld bytes that its role or key "
                 "allows; DELETE jobs that are no longer needed",
                 order->client_bytes);
    else
        return SRV_STORED;
    return SRV_STORED_QUOTA;
}

int64_t srv_store_rank(int64_t created, int64_t left_us) {
    assert(left_us >= 0);
    return created + (left_us < SRV_RANK_KNEE_US ? SRV_RANK_TIMES * left_us
                                                 : left_us + INT64_C(1000000) * SRV_RANK_MOST_S);
}

static enum srv_stored submit_new(struct srv_store *store, const struct srv_job_order *order,
                                  struct srv_job *job) {
    struct srv_tally_client *client;
    int64_t now, part_us = order->cost_us / order->parts;
    unsigned char seal[SRV_SEAL_JOB_BYTES];
    SRV_STORED_TRY(srv_tally_look(&store->tally, order->client, &client));
    SRV_STORED_TRY(submit_allowed(store, order, client, job->message));
    SRV_STORED_TRY(srv_store_source(store, order->client, order->source, job->message));
    SRV_STORED_TRY(srv_store_room(store, order->client, (size_t)submit_held(order), job->message));
    if (order->turns) client->weight = order->turns * (client->weight > 0 ? client->weight : 1);
    SRV_STORED_TRY(srv_store_now(store, &now));
    submit_job(order, now, job);
    srv_seal_job(seal, job, order->request, order->request_bytes);
    SRV_STORED_TRY(SRV_POST(store, SQL_JOB_PUT, order->id, order->client, order->operation,
                            srv_value_bytes(order->request, order->request_bytes), order->key,
                            srv_value_bytes(order->digest, SRV_DIGEST_BYTES), order->parts,
                            order->chained, part_us, srv_store_rank(now, part_us * order->parts),
                            now, job->held, srv_value_bytes(seal, sizeof seal), job->title,
                            job->version));
    return submit_count(store, job);
}

enum srv_stored srv_store_submit(struct srv_store *store, const struct srv_job_order *order,
                                 struct srv_job *job) {
    assert(order->parts >= 1 && order->cost_us >= 0 && order->digest &&
           strlen(order->id) < SRV_ID_BYTES && strlen(order->client) < SRV_NAME_BYTES &&
           strlen(order->operation) < SRV_NAME_BYTES);
    assert(!order->key || strlen(order->key) < SRV_NAME_BYTES);
    assert(!order->title || strlen(order->title) < SRV_TITLE_BYTES);
    *job = (struct srv_job){0};
    SRV_STORED_TRY(srv_store_begin(store));
    /* if two processes insert the same key at once, the unique index refuses the second, which
     * retries */
    enum srv_stored stored = order->key ? submit_known(store, order, job) : SRV_STORED_NONE;
    /* the same call may have been committed although the answer was lost */
    if (stored == SRV_STORED_NONE && store->unsure)
        stored = srv_store_find(store, SQL_JOB, order->id, job);
    if (stored == SRV_STORED_NONE) stored = submit_new(store, order, job);
    return srv_store_end(store, stored);
}

enum srv_stored srv_store_job(struct srv_store *store, const char *id, struct srv_job *job) {
    SRV_STORED_TRY(srv_store_look(store));
    enum srv_stored stored = srv_store_end(store, srv_store_find(store, SQL_JOB, id, job));
    if (stored != SRV_STORED || !job->flaw) return stored;
    SRV_STORED_TRY(srv_store_begin(store));
    stored = srv_store_lock(store, id, job);
    return srv_store_end(store, stored);
}

/* verifies a request; a failed or dismissed job has none */
static int request_whole(const struct srv_value field[], const char *id, const void *request,
                         size_t bytes) {
    (void)id;
    int kept = field[1].kind != SRV_SQL_WHOLE || field[1].whole <= SRV_JOB_SUCCESSFUL;
    return !kept || srv_seal_request_whole(field, request, bytes);
}

/* ends a job with a damaged request: it can neither be computed nor encoded */
static enum srv_stored request_condemn(struct srv_store *store, const char *id) {
    struct srv_job job;
    SRV_STORED_TRY(srv_store_find(store, SQL_JOB_LOCK, id, &job));
    if (job.state > SRV_JOB_SUCCESSFUL && !job.flaw) return SRV_STORED;
    if (!job.flaw) srv_row_job_fail(&job, "request");
    return srv_store_condemn(store, &job);
}

enum srv_stored srv_store_job_request(struct srv_store *store, const char *id, void **request,
                                      size_t *bytes) {
    enum srv_stored stored =
        srv_store_bytes(store, SQL_JOB_REQUEST, id, request_whole, request, bytes);
    if (stored != SRV_STORED_DAMAGED) return stored;
    SRV_STORED_TRY(srv_store_begin(store));
    stored = request_condemn(store, id);
    stored = srv_store_end(store, stored);
    return stored == SRV_STORED ? SRV_STORED_DAMAGED : stored;
}

static enum srv_stored list_after(struct srv_store *store, const char *client, const char *before,
                                  struct srv_row_jobs *rows) {
    struct srv_row_wholes created = {.count = 1};
    if (!before) return SRV_RUN(store, SQL_JOBS, srv_row_job, rows, client, rows->cap);
    SRV_STORED_TRY(SRV_RUN(store, SQL_JOB_CREATED, srv_row_wholes, &created, before, client));
    if (!created.rows) return SRV_STORED;
    return SRV_RUN(store, SQL_JOBS_BEFORE, srv_row_job, rows, client, rows->cap, before,
                   created.whole[0]);
}

static int list_suits(const struct srv_job_wish *wish, const struct srv_job *job) {
    if (wish->state < SRV_JOB_STATES && wish->state != job->state) return 0;
    if (wish->operation && strcmp(wish->operation, job->operation)) return 0;
    return !wish->title || strcasestr(job->title, wish->title);
}

/* fills the page from at most SRV_LIST_LOOKED jobs; `some` has space for LIST_ROWS */
static enum srv_stored list_page(struct srv_store *store, const char *client,
                                 const struct srv_job_wish *wish, struct srv_job some[],
                                 struct srv_job job[], int *count, char last[SRV_ID_BYTES]) {
    int any = wish->state == SRV_JOB_STATES && !wish->operation && !wish->title;
    int cap = any && wish->most < LIST_ROWS ? wish->most : LIST_ROWS;
    const char *before = wish->before;
    for (int looked = 0; looked < SRV_LIST_LOOKED; looked += cap) {
        struct srv_row_jobs rows = {.cap = cap, .job = some};
        SRV_STORED_TRY(list_after(store, client, before, &rows));
        last[0] = 0;
        for (int i = 0; i < rows.count; i++) {
            /* the time of a damaged job is not trusted: it is listed, and the list continues */
            if (!some[i].flaw && some[i].created < wish->since) return SRV_STORED;
            if (list_suits(wish, &some[i])) job[(*count)++] = some[i];
            if (*count < wish->most && i + 1 < cap) continue;
            memcpy(last, some[i].id, SRV_ID_BYTES);
            if (*count == wish->most) return SRV_STORED;
        }
        if (!last[0]) return SRV_STORED;
        before = last;
    }
    return SRV_STORED;
}

enum srv_stored srv_store_list(struct srv_store *store, const char *client,
                               const struct srv_job_wish *wish, struct srv_job job[], int *count,
                               char last[SRV_ID_BYTES]) {
    assert(wish->most >= 1 && wish->state >= 0 && wish->state <= SRV_JOB_STATES);
    struct srv_job *some = calloc(LIST_ROWS, sizeof *some);
    *count = 0;
    last[0] = 0;
    if (!some) return SRV_STORED_BROKEN;
    enum srv_stored stored = srv_store_look(store);
    if (stored == SRV_STORED)
        stored = srv_store_end(store, list_page(store, client, wish, some, job, count, last));
    if (stored != SRV_STORED) *count = 0;
    free(some);
    return stored;
}

int srv_store_filed(const struct srv_store *store, const struct srv_job *job) {
    return store->rules.files && job->begun > 0 &&
           (job->parts > 1 || !job->done || job->bytes > SRV_CHUNK_BYTES);
}

/* deletes its parts: a few now, many later with its results */
static enum srv_stored end_parts(struct srv_store *store, const struct srv_job *job) {
    if (job->bytes > 0 || job->begun > SRV_FEW_PARTS || srv_store_filed(store, job))
        return SRV_POST(store, SQL_REMOVAL_PUT, job->id, job->client, job->bytes);
    if (!job->begun) return SRV_STORED;
    return SRV_POST(store, SQL_PARTS_REMOVE, job->id);
}

enum srv_stored srv_store_job_end(struct srv_store *store, struct srv_job *job,
                                  enum srv_job_state state, const char *message) {
    assert(*job->id && state >= SRV_JOB_FAILED && state < SRV_JOB_STATES);
    struct srv_job was = *job;
    SRV_STORED_TRY(srv_store_now(store, &job->now));
    /* a job that has already ended keeps its time of expiry */
    if (srv_job_open(&was)) {
        job->finished = job->now;
        job->expires = job->now + store->rules.keep_us;
    }
    if (was.state != SRV_JOB_DISMISSED && was.state != SRV_JOB_FAILED)
        SRV_STORED_TRY(end_parts(store, &was));
    job->state = state;
    job->held = SRV_ROW_BYTES;
    job->waiting = 0;
    /* results are counted until they are deleted */
    SRV_STORED_TRY(srv_store_count_job(store, &was, job));
    job->bytes = 0;
    store->tally.ring |= SRV_RING_STOP | SRV_RING_ENDS;
    if (!message) return SRV_STORED;
    char text[SRV_REQUEST_HEAD_BYTES];
    snprintf(text, sizeof text, "%s", message);
    memcpy(job->message, text, sizeof text);
    return SRV_POST(store, SQL_JOB_END, job->id, state, text, job->finished, job->expires,
                    job->held, srv_value_bytes("", 0));
}

enum srv_stored srv_store_dismiss(struct srv_store *store, const char *id, struct srv_job *job) {
    SRV_STORED_TRY(srv_store_begin(store));
    enum srv_stored stored = srv_store_lock(store, id, job);
    if (stored == SRV_STORED && job->state != SRV_JOB_DISMISSED)
        stored =
            srv_store_job_end(store, job, SRV_JOB_DISMISSED, srv_job_open(job) ? "" : job->message);
    return srv_store_end(store, stored);
}
