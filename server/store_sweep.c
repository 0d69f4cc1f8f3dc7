/* Sweeping: what ran out, was dismissed or is past its time; and what is in the store, in figures.
 * Leaves to others: when to sweep (runner).
 * Invariant: a sweep takes a piece at a time, so that no other call waits long; any process may, at any time. */
#include "server/store_jobs.h"
#include "server/store_leases.h"
#include "server/store_quotas.h"
#include "server/store_rows.h"

static enum srv_stored row_id(void *context, const struct srv_value field[]) {
    srv_row_text(&field[0], context, SRV_ID_BYTES);
    return SRV_STORED;
}

/* takes a piece of a job's results away; the last piece settles the client's account */
static enum srv_stored sweep_results(struct srv_store *store, const struct srv_job *job, int *emptied) {
    struct srv_row_wholes gone = {.count = 1};
    SRV_STORED_TRY(SRV_RUN(store, SQL_RESULTS_REMOVE, srv_row_wholes, &gone, srv_value_text(job->id)));
    *emptied = gone.rows < SQL_CHUNKS_MOST;
    if (!*emptied) return SRV_STORED;
    SRV_STORED_TRY(srv_store_client(store, job->client, 0, -job->bytes, 0, NULL));
    return SRV_RUN(store, SQL_JOB_EMPTY, NULL, NULL, srv_value_text(job->id));
}

static enum srv_stored sweep_dismissed(struct srv_store *store, struct srv_store_sweep *sweep) {
    char id[SRV_ID_BYTES] = "";
    struct srv_job job;
    int emptied;
    SRV_STORED_TRY(srv_store_run(store, SQL_JOB_UNCLEAN, NULL, 0, row_id, id));
    if (!*id) return SRV_STORED;
    SRV_STORED_TRY(srv_store_find(store, SQL_JOB_LOCK, id, &job));
    sweep->more = 1;
    return sweep_results(store, &job, &emptied);
}

static enum srv_stored sweep_expired(struct srv_store *store, struct srv_store_sweep *sweep) {
    char id[SRV_ID_BYTES] = "";
    struct srv_job job;
    SRV_STORED_TRY(srv_store_run(store, SQL_JOB_EXPIRED, NULL, 0, row_id, id));
    if (!*id) return SRV_STORED;
    SRV_STORED_TRY(srv_store_find(store, SQL_JOB_LOCK, id, &job));
    sweep->more = 1;
    /* one with results is dismissed first, which takes them away piece by piece */
    if (job.bytes > 0)
        return job.state == SRV_JOB_SUCCESSFUL ? srv_store_job_end(store, &job, SRV_JOB_DISMISSED, "") : SRV_STORED;
    SRV_STORED_TRY(SRV_RUN(store, SQL_SHARDS_REMOVE, NULL, NULL, srv_value_text(id)));
    return SRV_RUN(store, SQL_JOB_REMOVE, NULL, NULL, srv_value_text(id));
}

enum srv_stored srv_store_sweep(struct srv_store *store, int64_t *looked, struct srv_store_sweep *sweep) {
    struct srv_row_wholes now = {.count = 1};
    int late = 0;
    *sweep = (struct srv_store_sweep){0};
    SRV_STORED_TRY(srv_store_begin(store));
    enum srv_stored stored = srv_store_run(store, SQL_NOW, NULL, 0, srv_row_wholes, &now);
    int64_t before = looked ? *looked : now.whole[0];
    if (stored == SRV_STORED) stored = srv_store_back(store, NULL, before, sweep, &late);
    if (stored == SRV_STORED && looked) *looked = now.whole[0];
    if (stored == SRV_STORED) stored = sweep_dismissed(store, sweep);
    if (stored == SRV_STORED) stored = sweep_expired(store, sweep);
    if (stored == SRV_STORED && !sweep->more) stored = srv_store_plain(store, SQL_CLIENTS_LEAVE);
    sweep->more |= late == SQL_SHARDS_MOST;
    return srv_store_end(store, stored == SRV_STORED, stored);
}

static enum srv_stored row_figures(void *context, const struct srv_value field[]) {
    struct srv_store_figures *figures = context;
    if (field[0].whole < 0 || field[0].whole >= SRV_JOB_STATES) return SRV_STORED_BROKEN;
    figures->jobs[field[0].whole] = (long)field[1].whole;
    figures->bytes += field[2].whole;
    figures->shards += (long)field[3].whole;
    return SRV_STORED;
}

enum srv_stored srv_store_figures(struct srv_store *store, struct srv_store_figures *figures) {
    *figures = (struct srv_store_figures){0};
    SRV_STORED_TRY(srv_store_begin(store));
    return srv_store_end(store, 1, srv_store_run(store, SQL_FIGURES, NULL, 0, row_figures, figures));
}
