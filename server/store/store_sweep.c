/* Sweeping: returning parts with expired leases, deleting dismissed and expired jobs, erasing a
 * client's jobs; and the store's figures. Leaves to others: when to sweep (storage). Invariant: a
 * sweep works in small steps, so that no other call waits long; any process may sweep at any time;
 * no job is deleted before the time announced to its client. */
#include <assert.h>
#include <string.h>

#include "server/base/clock.h"
#include "server/store/store_class_pupils.h"
#include "server/store/store_files.h"
#include "server/store/store_jobs.h"
#include "server/store/store_rows.h"

/* Results up to SWEEP_SMALL bytes are deleted with their job, larger ones in steps. If the store's
 * clock gains more than SWEEP_JUMP_S on the monotonic clock between two sweeps, no job expires for
 * SWEEP_HOLD_S. */
enum { SWEEP_SMALL = 1 << 20, SWEEP_JUMP_S = 300, SWEEP_HOLD_S = 600 };

/* bytes of results per step */
enum { SWEEP_PIECE = 16 << 20 };

/* A dismissed or deleted job whose parts and results still exist. */
struct row_removal {
    int rows;
    char job[SRV_ID_BYTES], client[SRV_NAME_BYTES];
    int64_t bytes;
    const char *flaw;
};

static enum srv_stored row_removal(void *context, const struct srv_value field[]) {
    struct row_removal *removal = context;
    struct srv_row row = {field, NULL};
    srv_row_word(&row, 1, removal->job, sizeof removal->job, "job");
    srv_row_word(&row, 1, removal->client, sizeof removal->client, "client");
    removal->bytes = srv_row_whole(&row, 0, SRV_ROW_MOST, "bytes");
    removal->flaw = row.flaw;
    removal->rows++;
    return SRV_STORED;
}

/* deletes files of a job that no row names, because their worker died when the job had just ended;
 * only files older than any result, so that an empty store deletes no others */
static enum srv_stored sweep_files(struct srv_store *store) {
    char job[SRV_ID_BYTES];
    if (!store->rules.files ||
        !srv_files_old(store->rules.files, store->rules.keep_us / 1000000, job))
        return SRV_STORED;
    return SRV_POST(store, SQL_REMOVAL_LOST, job);
}

/* deletes some of a job's results, parts and files; the last step updates the client's
 * sums */
static enum srv_stored sweep_removal(struct srv_store *store, struct srv_store_sweep *sweep) {
    struct row_removal removal = {0};
    struct srv_row_wholes parts = {.count = 1};
    int chunks;
    SRV_STORED_TRY(SRV_RUN(store, SQL_REMOVAL, row_removal, &removal));
    if (!removal.rows) return sweep_files(store);
    sweep->more = 1;
    if (!*removal.job) return SRV_RUN(store, SQL_REMOVALS_NAMELESS, NULL, NULL);
    SRV_STORED_TRY(srv_blobs_drop(store, removal.job, &chunks));
    if (chunks) return SRV_STORED;
    SRV_STORED_TRY(SRV_RUN(store, SQL_PARTS_REMOVE_SOME, srv_row_wholes, &parts, removal.job));
    if (parts.rows == SQL_PARTS_REMOVED) return SRV_STORED;
    if (store->rules.files) {
        enum srv_stored dropped = srv_files_drop(store->rules.files, removal.job);
        sweep->more = dropped == SRV_STORED_AGAIN;
        if (dropped != SRV_STORED) return SRV_STORED;
    }
    SRV_STORED_TRY(SRV_POST(store, SQL_REMOVAL_END, removal.job));
    return removal.flaw ? srv_store_recount(store, removal.client)
                        : srv_store_count_bytes(store, removal.client, -removal.bytes);
}

/* updates the sums for a deleted job; large results count until they are deleted */
static enum srv_stored expired_count(struct srv_store *store, const struct srv_job *job,
                                     int large) {
    assert(!srv_job_open(job) && job->bytes >= 0 && job->held >= 0);
    store->tally.changes[job->state]--;
    SRV_STORED_TRY(
        srv_store_count_bytes(store, job->client, -job->held - (large ? 0 : job->bytes)));
    if (!large) return SRV_STORED;
    return SRV_POST(store, SQL_REMOVAL_PUT, job->id, job->client, job->bytes);
}

/* deletes a job, together with its parts and results if they are small */
static enum srv_stored expired_remove(struct srv_store *store, const struct srv_job *job) {
    /* a failed or dismissed job already has a removal if it needs one */
    int kept = job->state == SRV_JOB_SUCCESSFUL,
        large = kept && (job->bytes > SWEEP_SMALL || job->begun > SRV_FEW_PARTS ||
                         srv_store_filed(store, job));
    SRV_STORED_TRY(expired_count(store, job, large));
    if (kept && !large && job->bytes > 0) SRV_STORED_TRY(srv_blobs_drop(store, job->id, NULL));
    if (kept && !large) SRV_STORED_TRY(SRV_POST(store, SQL_PARTS_REMOVE, job->id));
    return SRV_POST(store, SQL_JOBS_REMOVE, job->id);
}

/* false for a while after the store's clock jumped ahead */
static int sweep_trusts(struct srv_store *store, int64_t now) {
    int64_t now_ns = srv_clock_now(), passed_us = (now_ns - store->expiry.seen_ns) / 1000;
    if (store->expiry.seen &&
        now - store->expiry.seen > passed_us + (int64_t)SWEEP_JUMP_S * 1000000)
        store->expiry.hold_ns = now_ns + (int64_t)SWEEP_HOLD_S * 1000000000;
    store->expiry.seen = now;
    store->expiry.seen_ns = now_ns;
    return now_ns >= store->expiry.hold_ns;
}

static enum srv_stored sweep_expired(struct srv_store *store, int64_t now,
                                     struct srv_store_sweep *sweep) {
    struct srv_job job[SQL_EXPIRED_MOST];
    struct srv_row_jobs rows = {.cap = SQL_EXPIRED_MOST, .job = job};
    if (!sweep_trusts(store, now)) return SRV_STORED;
    SRV_STORED_TRY(srv_store_class_sweep(store, now, &sweep->more));
    SRV_STORED_TRY(
        SRV_RUN(store, SQL_JOBS_EXPIRED, srv_row_job, &rows, store->expiry.from, SQL_EXPIRED_MOST));
    /* The next step skips the range of deleted jobs. When nothing is left, the whole range is
     * examined again, because jobs that other processes had locked were skipped. */
    store->expiry.from = 0;
    for (int64_t i = 0, bytes = 0; i < rows.count && bytes <= SWEEP_PIECE; i++) {
        if (job[i].flaw) continue;
        SRV_STORED_TRY(expired_remove(store, &job[i]));
        bytes += job[i].bytes > SWEEP_SMALL ? 0 : job[i].bytes;
        store->expiry.from = job[i].expires;
        sweep->more = 1;
        sweep->expired++;
    }
    /* a damaged job is first marked as failed, and deleted when that job expires */
    for (int i = 0; i < rows.count; i++)
        if (job[i].flaw) SRV_STORED_TRY(srv_store_condemn(store, &job[i]));
    return rows.nameless ? SRV_RUN(store, SQL_JOBS_NAMELESS, NULL, NULL) : SRV_STORED;
}

static enum srv_stored row_changed(void *context, const struct srv_value field[]) {
    srv_row_text(&field[0], context, SRV_NAME_BYTES);
    return SRV_STORED;
}

/* adds pending changes to the rows of their clients, one client per transaction */
static enum srv_stored sweep_changes(struct srv_store *store) {
    enum srv_stored stored = SRV_STORED;
    char name[SRV_NAME_BYTES] = "", was[SRV_NAME_BYTES];
    /* with many processes, about one does this each second */
    if (store->workers > 1 && srv_clock_now() / 1000 % store->workers) return SRV_STORED;
    for (int more = store->sql->driver->lists, i = 0; more && stored == SRV_STORED && i < 64; i++) {
        SRV_STORED_TRY(srv_store_look(store));
        memcpy(was, name, sizeof was);
        stored = srv_store_end(store, SRV_RUN(store, SQL_CHANGED, row_changed, name, was));
        more = strcmp(was, name) != 0;
        if (more && stored == SRV_STORED) stored = srv_store_fold(store, name);
    }
    return stored;
}

enum srv_stored srv_store_sweep(struct srv_store *store, int64_t *looked,
                                struct srv_store_sweep *sweep) {
    int64_t now = 0;
    int late = 0;
    assert(!looked || *looked >= 0);
    *sweep = (struct srv_store_sweep){0};
    SRV_STORED_TRY(sweep_changes(store));
    SRV_STORED_TRY(srv_store_begin(store));
    enum srv_stored stored = srv_store_now(store, &now);
    int64_t before = looked ? *looked : now;
    if (stored == SRV_STORED) stored = srv_store_back(store, NULL, before, sweep, &late);
    if (stored == SRV_STORED && looked) *looked = now;
    if (stored == SRV_STORED) stored = sweep_removal(store, sweep);
    if (stored == SRV_STORED) stored = sweep_expired(store, now, sweep);
    sweep->more |= late == SQL_PARTS_MOST;
    return srv_store_end(store, stored);
}

/* erases one job of a client, which may already be gone */
static enum srv_stored erase_job(struct srv_store *store, const char *id) {
    struct srv_job job;
    enum srv_stored stored = srv_store_lock(store, id, &job);
    if (stored == SRV_STORED_NONE) return SRV_STORED;
    SRV_STORED_TRY(stored);
    if (srv_job_open(&job)) SRV_STORED_TRY(srv_store_job_end(store, &job, SRV_JOB_DISMISSED, NULL));
    return expired_remove(store, &job);
}

enum srv_stored srv_store_erase_jobs(struct srv_store *store, const char *client, int most,
                                     int *count) {
    struct srv_job job[SRV_ERASE_MOST];
    struct srv_row_jobs rows = {.cap = SRV_ERASE_MOST, .job = job};
    *count = 0;
    assert(most >= 1 && most <= SRV_ERASE_MOST);
    SRV_STORED_TRY(srv_store_begin(store));
    enum srv_stored stored = SRV_RUN(store, SQL_JOBS, srv_row_job, &rows, client, most);
    for (int i = 0; i < rows.count && stored == SRV_STORED; i++)
        stored = erase_job(store, job[i].id);
    if (stored == SRV_STORED) *count = rows.count;
    return srv_store_end(store, stored);
}

enum srv_stored srv_store_figures(struct srv_store *store, struct srv_store_figures *figures) {
    const struct srv_sql_driver *driver = store->sql->driver;
    struct srv_row_wholes more = {.count = 3};
    int64_t sum[SRV_TALLY_SUMS] = {0};
    SRV_STORED_TRY(srv_store_begin(store));
    enum srv_stored stored = SRV_RUN(store, SQL_FIGURES, srv_row_wholes, &more);
    for (int i = 0; i < SRV_TALLY_SUMS && stored == SRV_STORED; i++)
        stored = srv_tally_total(&store->tally, i, &sum[i]);
    *figures = (struct srv_store_figures){.parts = (long)sum[SRV_TALLY_PARTS],
                                          .bytes = sum[SRV_TALLY_BYTES],
                                          .scenes = (long)sum[SRV_TALLY_SCENES],
                                          .scene_bytes = sum[SRV_TALLY_SCENE_BYTES],
                                          .workers = (long)more.whole[0],
                                          .connections = (long)more.whole[1],
                                          .oldest_us = more.whole[2]};
    for (int i = 0; i < SRV_JOB_STATES; i++) figures->jobs[i] = (long)sum[i];
    store->workers = figures->workers;
    if (figures->bytes + SRV_ROW_BYTES > store->rules.all_bytes)
        figures->full = "the store is full: max-store-bytes";
    else if (driver->room && stored == SRV_STORED && !driver->room(store->sql, SRV_ROW_BYTES))
        figures->full = "the store's disk is full";
    return srv_store_end(store, stored);
}
