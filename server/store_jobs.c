#include "server/store_jobs.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "server/store_quotas.h"
#include "server/store_rows.h"

enum srv_stored srv_store_find(struct srv_store *store, enum srv_statement id, const char *name, struct srv_job *job) {
    struct srv_row_jobs rows = {.cap = 1, .job = job};
    SRV_STORED_TRY(SRV_RUN(store, id, srv_row_job, &rows, srv_value_text(name)));
    return rows.count ? SRV_STORED : SRV_STORED_NONE;
}

int srv_job_open(const struct srv_job *job) { return job->state <= SRV_JOB_RUNNING; }

/* the key of a job that nobody will compute, or that is past its time, is free: what it says would be of no use */
static int submit_spent(const struct srv_job *job) {
    return job->state >= SRV_JOB_FAILED || (job->expires > 0 && job->expires < job->now);
}

static enum srv_stored submit_known(struct srv_store *store, const struct srv_job_order *order, struct srv_job *job) {
    struct srv_row_jobs rows = {.cap = 1, .job = job, .with_digest = 1};
    SRV_STORED_TRY(
        SRV_RUN(store, SQL_JOB_OF_KEY, srv_row_job, &rows, srv_value_text(order->client), srv_value_text(order->key)));
    if (!rows.count) return SRV_STORED_NONE;
    if (submit_spent(job)) {
        SRV_STORED_TRY(SRV_RUN(store, SQL_KEY_FREE, NULL, NULL, srv_value_text(job->id)));
        return SRV_STORED_NONE;
    }
    return memcmp(rows.digest, order->digest, SRV_DIGEST_BYTES) ? SRV_STORED_CLASH : SRV_STORED;
}

static enum srv_stored submit_new(struct srv_store *store, const struct srv_job_order *order,
                                  const struct srv_row_wholes *client, struct srv_job *job) {
    struct srv_row_jobs rows = {.cap = 1, .job = job};
    if (client->whole[0] > store->rules.client_jobs) {
        snprintf(job->message, sizeof job->message, "the client has max-client-jobs, %ld, open jobs",
                 store->rules.client_jobs);
        return SRV_STORED_QUOTA;
    }
    SRV_STORED_TRY(srv_store_source(store, order->client, order->source, job->message));
    SRV_STORED_TRY(srv_store_room(store, order->request_bytes, client->whole[1], job->message));
    SRV_STORED_TRY(SRV_RUN(store, SQL_JOB_PUT, srv_row_job, &rows, srv_value_text(order->id),
                           srv_value_text(order->client), srv_value_text(order->operation),
                           srv_value_bytes(order->request, order->request_bytes), srv_value_text(order->key),
                           srv_value_bytes(order->digest, SRV_DIGEST_BYTES), srv_value_whole(order->shards),
                           srv_value_whole(order->chained)));
    return srv_store_plain(store, SQL_RING);
}

enum srv_stored srv_store_submit(struct srv_store *store, const struct srv_job_order *order, struct srv_job *job) {
    struct srv_row_wholes client = {.count = 2};
    *job = (struct srv_job){0};
    SRV_STORED_TRY(srv_store_begin(store));
    /* the client's row is locked first, so that requests with one key come one after the other */
    enum srv_stored stored = SRV_RUN(store, SQL_CLIENT_ENTER, srv_row_wholes, &client, srv_value_text(order->client),
                                     srv_value_text(order->source ? order->source : order->client));
    int known = 0;
    if (stored == SRV_STORED && order->key) {
        stored = submit_known(store, order, job);
        known = stored != SRV_STORED_NONE;
        if (!known) stored = SRV_STORED;
    }
    if (stored == SRV_STORED && !known) stored = submit_new(store, order, &client, job);
    return srv_store_end(store, stored == SRV_STORED && !known, stored);
}

enum srv_stored srv_store_job(struct srv_store *store, const char *id, struct srv_job *job) {
    SRV_STORED_TRY(srv_store_begin(store));
    return srv_store_end(store, 1, srv_store_find(store, SQL_JOB, id, job));
}

enum srv_stored srv_store_request(struct srv_store *store, const char *id, void **request, size_t *bytes) {
    return srv_store_bytes(store, SQL_JOB_REQUEST, id, request, bytes);
}

enum srv_stored srv_store_list(struct srv_store *store, const char *client, const char *before, int most,
                               struct srv_job job[], int *count) {
    struct srv_row_jobs rows = {.cap = most, .job = job};
    *count = 0;
    SRV_STORED_TRY(srv_store_begin(store));
    enum srv_stored stored =
        before ? SRV_RUN(store, SQL_JOBS_BEFORE, srv_row_job, &rows, srv_value_text(client), srv_value_whole(most),
                         srv_value_text(before))
               : SRV_RUN(store, SQL_JOBS, srv_row_job, &rows, srv_value_text(client), srv_value_whole(most));
    stored = srv_store_end(store, 1, stored);
    if (stored == SRV_STORED) *count = rows.count;
    return stored;
}

enum srv_stored srv_store_job_end(struct srv_store *store, struct srv_job *job, enum srv_job_state state,
                                  const char *message) {
    struct srv_row_jobs rows = {.cap = 1, .job = job};
    int was_open = srv_job_open(job);
    if (state != SRV_JOB_SUCCESSFUL)
        SRV_STORED_TRY(SRV_RUN(store, SQL_SHARDS_REMOVE, NULL, NULL, srv_value_text(job->id)));
    if (was_open) SRV_STORED_TRY(srv_store_client(store, job->client, -1, 0, 0, NULL));
    char id[SRV_ID_BYTES];
    memcpy(id, job->id, sizeof id);
    SRV_STORED_TRY(SRV_RUN(store, SQL_JOB_END, srv_row_job, &rows, srv_value_text(id), srv_value_whole(state),
                           srv_value_text(message), srv_value_whole(store->rules.keep_us)));
    return srv_store_plain(store, SQL_RING);
}

enum srv_stored srv_store_dismiss(struct srv_store *store, const char *id, struct srv_job *job) {
    SRV_STORED_TRY(srv_store_begin(store));
    enum srv_stored stored = srv_store_find(store, SQL_JOB_LOCK, id, job);
    if (stored == SRV_STORED && job->state != SRV_JOB_DISMISSED)
        stored = srv_store_job_end(store, job, SRV_JOB_DISMISSED, srv_job_open(job) ? "" : job->message);
    return srv_store_end(store, stored == SRV_STORED, stored);
}
