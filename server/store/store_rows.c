#include "server/store/store_rows.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static_assert((int)SQL_COUNT <= (int)SRV_SQL_STATEMENTS, "a connection keeps every statement");

const char *const srv_statement_text[SQL_COUNT] = {
#define X(name, text) text,
    STATEMENTS(X)
#undef X
};

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

struct srv_value srv_value_same(struct srv_value value) {
    return value;
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

int64_t srv_row_whole(struct srv_row *row, int64_t least, int64_t most, const char *column) {
    const struct srv_value *field = row->next++;
    assert(least <= most && *column);
    if (field->kind == SRV_SQL_WHOLE && field->whole >= least && field->whole <= most)
        return field->whole;
    if (!row->flaw) row->flaw = column;
    return least;
}

void srv_row_word(struct srv_row *row, size_t least, char text[], size_t cap, const char *column) {
    const struct srv_value *field = row->next++;
    assert(cap > least && *column);
    int good = field->kind == SRV_SQL_STRING && field->data && field->bytes >= least &&
               field->bytes < cap && strlen(field->data) == field->bytes;
    memcpy(text, good ? field->data : "", good ? field->bytes + 1 : 1);
    if (!good && !row->flaw) row->flaw = column;
}

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

static_assert(SRV_ROW_JOB + 4 <= SRV_SQL_PARAMETERS, "a row of a claim fits");

/* the fields of JOB_COLUMNS after the id */
static void row_job_read(struct srv_job *job, struct srv_row *row) {
    srv_row_word(row, 1, job->client, sizeof job->client, "client");
    srv_row_word(row, 1, job->operation, sizeof job->operation, "operation");
    job->state = (enum srv_job_state)srv_row_whole(row, 0, SRV_JOB_STATES - 1, "state");
    job->parts = (long)srv_row_whole(row, 1, SRV_ROW_MOST, "parts");
    job->done = (long)srv_row_whole(row, 0, SRV_ROW_MOST, "done");
    job->created = srv_row_whole(row, 0, SRV_ROW_LATEST, "created");
    job->started = srv_row_whole(row, 0, SRV_ROW_LATEST, "started");
    job->finished = srv_row_whole(row, 0, SRV_ROW_LATEST, "finished");
    job->expires = srv_row_whole(row, 0, SRV_ROW_LATEST, "expires");
    job->now = row->next++->whole;
    job->bytes = srv_row_whole(row, 0, SRV_ROW_MOST, "bytes");
    srv_row_word(row, 0, job->message, sizeof job->message, "message");
    job->begun = (long)srv_row_whole(row, 0, job->parts, "begun");
    job->waiting = (long)srv_row_whole(row, 0, job->begun, "waiting");
    job->chained = (int)srv_row_whole(row, 0, 1, "chained");
    job->held = srv_row_whole(row, 0, SRV_ROW_MOST, "held");
    srv_row_word(row, 0, job->title, sizeof job->title, "title");
    srv_row_word(row, 0, job->version, sizeof job->version, "version");
    if (!row->flaw && !srv_seal_job_whole(job, row->next)) row->flaw = "seal";
    row->next++;
}

enum srv_stored srv_row_job(void *context, const struct srv_value field[]) {
    struct srv_row_jobs *rows = context;
    assert(rows->count >= 0 && rows->count <= rows->cap);
    if (rows->count == rows->cap) return SRV_STORED;
    struct srv_job *job = &rows->job[rows->count];
    struct srv_row row = {field, NULL};
    srv_row_word(&row, 1, job->id, sizeof job->id, "id");
    rows->nameless |= row.flaw != NULL;
    if (row.flaw) return SRV_STORED;
    rows->count++;
    row_job_read(job, &row);
    job->flaw = row.flaw ? row.flaw : row_job_flaw(job);
    if (job->flaw) srv_row_job_fail(job, job->flaw);
    if (rows->with_digest) {
        /* a damaged digest matches no request, so reusing the key is a clash */
        int good = row.next->kind == SRV_SQL_BYTES && row.next->bytes == SRV_DIGEST_BYTES;
        memset(rows->digest, 0, SRV_DIGEST_BYTES);
        if (good) memcpy(rows->digest, row.next->data, SRV_DIGEST_BYTES);
    }
    if (rows->with_part) {
        rows->part_state = (long)srv_row_whole(&row, 0, 2, "state");
        rows->attempt = (long)srv_row_whole(&row, 0, SRV_ROW_MOST, "attempt");
    }
    return SRV_STORED;
}
