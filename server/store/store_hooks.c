/* Hooks: whom the end of a job is to be told, until it was.
 * Leaves to others: making a hook due (store_jobs), what is sent, and sending it (hooks, courier).
 * Invariant: a hook that was kept with its job is due from the job's end until an attempt has said
 * how it went, whatever dies meanwhile; two processes never hold one at the same time. */
#include <assert.h>
#include <string.h>

#include "server/store/store_jobs.h"
#include "server/store/store_rows.h"

/* Hooks that are due, locked. */
struct row_hooks {
    int count, most;
    struct srv_hook *hook;
};

static enum srv_stored row_hook(void *context, const struct srv_value field[]) {
    struct row_hooks *rows = context;
    struct srv_row row = {field, NULL};
    if (rows->count == rows->most) return SRV_STORED;
    struct srv_hook *hook = &rows->hook[rows->count++];
    *hook = (struct srv_hook){.attempt = 1};
    srv_row_word(&row, 1, hook->job.id, sizeof hook->job.id, "job");
    srv_row_word(&row, 1, hook->url, sizeof hook->url, "url");
    hook->attempt = 1 + (long)srv_row_whole(&row, 0, SRV_ROW_MOST, "attempts");
    if (row.flaw) hook->url[0] = 0;
    /* a source that cannot be read is nobody's */
    srv_row_word(&row, 0, hook->source, sizeof hook->source, "source");
    return SRV_STORED;
}

/* reads the job of a hook and holds it for a while. A hook whose job has gone goes too, and so does
 * one that nobody can have written: *good is 0 for both */
static enum srv_stored take_one(struct srv_store *store, int64_t lease_us, struct srv_hook *hook,
                                int *good) {
    char id[SRV_ID_BYTES];
    *good = 0;
    memcpy(id, hook->job.id, sizeof id);
    if (!id[0]) return SRV_RUN(store, SQL_HOOKS_NAMELESS, NULL, NULL);
    enum srv_stored stored = srv_store_find(store, SQL_JOB, id, &hook->job);
    *good = stored == SRV_STORED && hook->url[0] && !srv_job_open(&hook->job);
    if (stored == SRV_STORED && hook->job.flaw) stored = srv_store_condemn(store, &hook->job);
    if (stored != SRV_STORED && stored != SRV_STORED_NONE) return stored;
    if (!*good) return SRV_RUN(store, SQL_HOOK_REMOVE, NULL, NULL, id);
    return SRV_RUN(store, SQL_HOOK_TAKE, NULL, NULL, id, lease_us);
}

/* a name that no client has stands for none, and for a source one that none has */
static struct srv_value take_busy(const char *const busy[SRV_HOOKS_BUSY], int i) {
    return srv_value_text(busy[i] ? busy[i] : i < SRV_HOOKS_CLIENTS ? "" : " ");
}

enum srv_stored srv_store_hooks_take(struct srv_store *store, int64_t lease_us,
                                     const char *const busy[SRV_HOOKS_BUSY], int most,
                                     struct srv_hook hook[], int *count) {
    assert(lease_us > 0 && most >= 1);
    struct row_hooks rows = {.most = most, .hook = hook};
    *count = 0;
    SRV_STORED_TRY(srv_store_begin(store));
    enum srv_stored stored =
        SRV_RUN(store, SQL_HOOKS_DUE, row_hook, &rows, most, take_busy(busy, 0), take_busy(busy, 1),
                take_busy(busy, 2), take_busy(busy, 3), take_busy(busy, 4), take_busy(busy, 5));
    for (int i = 0; i < rows.count && stored == SRV_STORED; i++) {
        int good;
        stored = take_one(store, lease_us, &hook[i], &good);
        if (stored == SRV_STORED && good) hook[(*count)++] = hook[i];
    }
    stored = srv_store_end(store, stored);
    if (stored != SRV_STORED) *count = 0;
    return stored == SRV_STORED && !*count ? SRV_STORED_NONE : stored;
}

/* writes how an attempt went, of a hook and a job that are locked */
static enum srv_stored told_write(struct srv_store *store, const char *id, long attempt,
                                  enum srv_notify notify, int64_t after_us, int status) {
    SRV_STORED_TRY(SRV_RUN(store, SQL_JOB_NOTIFIED, NULL, NULL, id, notify, attempt, status));
    if (notify != SRV_NOTIFY_WANTED) return SRV_RUN(store, SQL_HOOK_REMOVE, NULL, NULL, id);
    return SRV_RUN(store, SQL_HOOK_LATER, NULL, NULL, id, after_us);
}

enum srv_stored srv_store_hook_told(struct srv_store *store, const char *id, long attempt,
                                    enum srv_notify notify, int64_t after_us, int status) {
    assert(attempt >= 1 && notify != SRV_NOTIFY_NONE && after_us >= 0 && status >= 0);
    struct srv_row_wholes row = {.count = 1};
    struct srv_job job;
    SRV_STORED_TRY(srv_store_begin(store));
    /* the job's row first, as everybody does who writes both */
    enum srv_stored stored = srv_store_find(store, SQL_JOB_LOCK, id, &job);
    if (stored == SRV_STORED_NONE) stored = SRV_STORED_LOST;
    if (stored == SRV_STORED) stored = SRV_RUN(store, SQL_HOOK_ATTEMPTS, srv_row_wholes, &row, id);
    if (stored == SRV_STORED && (!row.rows || row.whole[0] != attempt)) stored = SRV_STORED_LOST;
    if (stored == SRV_STORED) stored = told_write(store, id, attempt, notify, after_us, status);
    return srv_store_end(store, stored);
}
