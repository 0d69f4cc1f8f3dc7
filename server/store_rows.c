#include "server/store_rows.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct srv_value srv_value_whole(int64_t whole) {
    return (struct srv_value){SRV_SQL_WHOLE, whole, NULL, 0};
}

struct srv_value srv_value_text(const char *text) {
    return (struct srv_value){text ? SRV_SQL_STRING : SRV_SQL_NULL, 0, text, text ? strlen(text) : 0};
}

struct srv_value srv_value_bytes(const void *data, size_t bytes) {
    return (struct srv_value){data ? SRV_SQL_BYTES : SRV_SQL_NULL, 0, data, bytes};
}

enum srv_stored srv_row_wholes(void *context, const struct srv_value field[]) {
    struct srv_row_wholes *row = context;
    for (int i = 0; i < row->count && !row->rows; i++) row->whole[i] = field[i].whole;
    row->rows++;
    return SRV_STORED;
}

enum srv_stored srv_row_bytes(void *context, const struct srv_value field[]) {
    struct srv_row_bytes *row = context;
    row->data = malloc(field[0].bytes + 1);
    if (!row->data) return SRV_STORED_BROKEN;
    if (field[0].bytes) memcpy(row->data, field[0].data, field[0].bytes);
    row->bytes = field[0].bytes;
    return SRV_STORED;
}

void srv_row_text(const struct srv_value *field, char text[], size_t cap) {
    snprintf(text, cap, "%s", field->data ? (const char *)field->data : "");
}

enum srv_stored srv_row_job(void *context, const struct srv_value field[]) {
    struct srv_row_jobs *rows = context;
    if (rows->count == rows->cap) return SRV_STORED;
    struct srv_job *job = &rows->job[rows->count++];
    srv_row_text(&field[0], job->id, sizeof job->id);
    srv_row_text(&field[1], job->client, sizeof job->client);
    srv_row_text(&field[2], job->operation, sizeof job->operation);
    job->state = (enum srv_job_state)field[3].whole;
    job->shards = (long)field[4].whole;
    job->done = (long)field[5].whole;
    job->created = field[6].whole;
    job->started = field[7].whole;
    job->finished = field[8].whole;
    job->expires = field[9].whole;
    job->now = field[10].whole;
    job->bytes = field[11].whole;
    srv_row_text(&field[12], job->message, sizeof job->message);
    job->begun = (long)field[13].whole;
    job->waiting = (long)field[14].whole;
    job->chained = field[15].whole != 0;
    job->held = field[16].whole;
    if (rows->with_digest && field[SRV_ROW_JOB].bytes == SRV_DIGEST_BYTES)
        memcpy(rows->digest, field[SRV_ROW_JOB].data, SRV_DIGEST_BYTES);
    if (rows->with_lease) {
        rows->shard_state = (long)field[SRV_ROW_JOB].whole;
        rows->attempt = (long)field[SRV_ROW_JOB + 1].whole;
    }
    return SRV_STORED;
}
