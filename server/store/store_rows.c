#include "server/store/store_rows.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "server/store/store_seals.h"

struct srv_value srv_value_whole(int64_t whole) {
    return (struct srv_value){SRV_SQL_WHOLE, whole, NULL, 0};
}

struct srv_value srv_value_text(const char *text) {
    return (struct srv_value){text ? SRV_SQL_STRING : SRV_SQL_NULL, 0, text,
                              text ? strlen(text) : 0};
}

struct srv_value srv_value_bytes(const void *data, size_t bytes) {
    return (struct srv_value){data ? SRV_SQL_BYTES : SRV_SQL_NULL, 0, data, bytes};
}

enum srv_stored srv_row_wholes(void *context, const struct srv_value field[]) {
    struct srv_row_wholes *row = context;
    assert(row->count >= 0 && row->count <= 4);
    for (int i = 0; i < row->count && !row->rows; i++) {
        int good = field[i].kind == SRV_SQL_WHOLE;
        row->flawed |= !good || field[i].whole < 0 || field[i].whole > SRV_ROW_MOST;
        row->whole[i] = good ? field[i].whole : 0;
    }
    row->rows++;
    return SRV_STORED;
}

enum srv_stored srv_row_bytes(void *context, const struct srv_value field[]) {
    struct srv_row_bytes *row = context;
    if (field[0].kind != SRV_SQL_BYTES) return SRV_STORED_DAMAGED;
    if (!row->whole(field + 1, row->name, field[0].data, field[0].bytes)) return SRV_STORED_DAMAGED;
    row->data = malloc(field[0].bytes + 1);
    if (!row->data) return SRV_STORED_BROKEN;
    if (field[0].bytes) memcpy(row->data, field[0].data, field[0].bytes);
    row->bytes = field[0].bytes;
    return SRV_STORED;
}

void srv_row_text(const struct srv_value *field, char text[], size_t cap) {
    assert(cap > 0);
    snprintf(text, cap, "%s",
             field->kind == SRV_SQL_STRING && field->data ? (const char *)field->data : "");
}

int64_t srv_row_whole(const struct srv_value *field, int64_t least, int64_t most,
                      const char *column, const char **flaw) {
    assert(least <= most && *column);
    if (field->kind == SRV_SQL_WHOLE && field->whole >= least && field->whole <= most)
        return field->whole;
    if (!*flaw) *flaw = column;
    return least;
}

void srv_row_word(const struct srv_value *field, size_t least, char text[], size_t cap,
                  const char *column, const char **flaw) {
    assert(cap > least && *column);
    int good = field->kind == SRV_SQL_STRING && field->data && field->bytes >= least &&
               field->bytes < cap && strlen(field->data) == field->bytes;
    memcpy(text, good ? field->data : "", good ? field->bytes + 1 : 1);
    if (!good && !*flaw) *flaw = column;
}

/* what the numbers of a job's row say together */
static const char *row_job_flaw(const struct srv_job *job) {
    int over = job->state > SRV_JOB_RUNNING;
    if (job->done > job->parts) return "done";
    if (!over && job->begun - job->waiting < job->done) return "begun";
    if (job->state == SRV_JOB_SUCCESSFUL && job->done < job->parts) return "state";
    if (job->state == SRV_JOB_ACCEPTED && job->done) return "state";
    if (!job->created) return "created";
    if (over != (job->finished > 0)) return "finished";
    return over != (job->expires > 0) ? "expires" : NULL;
}

void srv_row_job_fail(struct srv_job *job, const char *flaw) {
    assert(flaw && *flaw);
    job->flaw = flaw;
    job->state = SRV_JOB_FAILED;
    job->parts = 1;
    job->done = job->begun = job->waiting = 0;
    job->started = job->finished = job->expires = 0;
    job->title[0] = job->version[0] = 0;
    snprintf(job->message, sizeof job->message,
             "the store's record of this job is damaged (%s): submit the job again", flaw);
}

static_assert(SRV_ROW_JOB + 2 <= SRV_SQL_PARAMETERS, "a row of a job and a part fits");

enum srv_stored srv_row_job(void *context, const struct srv_value field[]) {
    struct srv_row_jobs *rows = context;
    assert(rows->count >= 0 && rows->count <= rows->cap);
    if (rows->count == rows->cap) return SRV_STORED;
    struct srv_job *job = &rows->job[rows->count];
    const char *flaw = NULL;
    srv_row_word(&field[0], 1, job->id, sizeof job->id, "id", &flaw);
    if (flaw) return SRV_STORED;
    rows->count++;
    srv_row_word(&field[1], 1, job->client, sizeof job->client, "client", &flaw);
    srv_row_word(&field[2], 1, job->operation, sizeof job->operation, "operation", &flaw);
    job->state =
        (enum srv_job_state)srv_row_whole(&field[3], 0, SRV_JOB_STATES - 1, "state", &flaw);
    job->parts = (long)srv_row_whole(&field[4], 1, SRV_ROW_MOST, "parts", &flaw);
    job->done = (long)srv_row_whole(&field[5], 0, SRV_ROW_MOST, "done", &flaw);
    job->created = srv_row_whole(&field[6], 0, SRV_ROW_LATEST, "created", &flaw);
    job->started = srv_row_whole(&field[7], 0, SRV_ROW_LATEST, "started", &flaw);
    job->finished = srv_row_whole(&field[8], 0, SRV_ROW_LATEST, "finished", &flaw);
    job->expires = srv_row_whole(&field[9], 0, SRV_ROW_LATEST, "expires", &flaw);
    job->now = field[10].whole;
    job->bytes = srv_row_whole(&field[11], 0, SRV_ROW_MOST, "bytes", &flaw);
    srv_row_word(&field[12], 0, job->message, sizeof job->message, "message", &flaw);
    job->begun = (long)srv_row_whole(&field[13], 0, job->parts, "begun", &flaw);
    job->waiting = (long)srv_row_whole(&field[14], 0, job->begun, "waiting", &flaw);
    job->chained = (int)srv_row_whole(&field[15], 0, 1, "chained", &flaw);
    job->held = srv_row_whole(&field[16], 0, SRV_ROW_MOST, "held", &flaw);
    if (rows->with_digest) {
        int good = field[SRV_ROW_JOB].kind == SRV_SQL_BYTES &&
                   field[SRV_ROW_JOB].bytes == SRV_DIGEST_BYTES;
        /* one that is damaged is no request's: whoever uses the key again is told of a clash */
        memset(rows->digest, 0, SRV_DIGEST_BYTES);
        if (good) memcpy(rows->digest, field[SRV_ROW_JOB].data, SRV_DIGEST_BYTES);
    }
    srv_row_word(&field[17], 0, job->title, sizeof job->title, "title", &flaw);
    srv_row_word(&field[18], 0, job->version, sizeof job->version, "version", &flaw);
    if (!flaw && !srv_seal_job_whole(job, &field[19])) flaw = "seal";
    const char *unread = NULL;
    job->notify =
        (enum srv_notify)srv_row_whole(&field[20], 0, SRV_NOTIFY_COUNT - 1, "notify", &unread);
    /* somebody may have wished to be told, and is */
    if (unread) job->notify = SRV_NOTIFY_WANTED, flaw = unread;
    job->notify_attempts =
        (long)srv_row_whole(&field[21], 0, SRV_ROW_MOST, "notify_attempts", &flaw);
    job->notify_status = (int)srv_row_whole(&field[22], 0, 999, "notify_status", &flaw);
    job->flaw = flaw ? flaw : row_job_flaw(job);
    if (job->flaw) srv_row_job_fail(job, job->flaw);
    if (rows->with_lease) {
        const char *part = NULL;
        rows->part_state = (long)srv_row_whole(&field[SRV_ROW_JOB], 0, 2, "state", &part);
        rows->attempt =
            (long)srv_row_whole(&field[SRV_ROW_JOB + 1], 0, SRV_ROW_MOST, "attempt", &part);
    }
    return SRV_STORED;
}
