#include "server/store/store_tally.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "server/store/store_rows.h"

static enum srv_stored tally_run(struct srv_sql *sql, enum srv_statement id,
                                 const struct srv_value value[], int count, srv_row_fn *row,
                                 void *context) {
    return sql->driver->run(sql, (int)id, srv_statement_text[id], value, count, row, context);
}

/* changes are of no interest to who makes them */
static enum srv_stored tally_post(struct srv_sql *sql, enum srv_statement id,
                                  const struct srv_value value[], int count) {
    if (!sql->driver->post) return tally_run(sql, id, value, count, NULL, NULL);
    return sql->driver->post(sql, (int)id, srv_statement_text[id], value, count);
}

int srv_tally_valid(const struct srv_tally *tally) {
    int last = tally->count - 1, good = tally->count >= 0 && tally->count <= SRV_TALLY_CLIENTS &&
                                        tally->place >= 0 && tally->place < SRV_TALLY_PLACES;
    for (int i = 0; good && i < last; i++)
        good = strcmp(tally->client[i].name, tally->client[last].name) != 0;
    return good;
}

void srv_tally_clear(struct srv_tally *tally) {
    tally->count = tally->known = tally->ring = 0;
    tally->source[0] = '\0';
    tally->change = (struct srv_store_figures){0};
}

struct srv_tally_client *srv_tally_client(struct srv_tally *tally, const char *name) {
    /* the one that was asked for last is likely to be asked for again */
    for (int i = tally->count - 1; i >= 0; i--)
        if (!strcmp(tally->client[i].name, name)) return &tally->client[i];
    if (tally->count == SRV_TALLY_CLIENTS) return NULL;
    struct srv_tally_client *client = &tally->client[tally->count++];
    *client = (struct srv_tally_client){0};
    snprintf(client->name, sizeof client->name, "%s", name);
    assert(srv_tally_valid(tally));
    return client;
}

enum srv_stored srv_tally_count_anew(struct srv_sql *sql, const char *name) {
    struct srv_row_wholes locked = {.count = 1};
    struct srv_value value[] = {srv_value_text(name)};
    SRV_STORED_TRY(tally_run(sql, SQL_CLIENT_LOCK, value, 1, srv_row_wholes, &locked));
    return tally_run(sql, SQL_CLIENT_RECOUNT, value, 1, NULL, NULL);
}

enum srv_stored srv_tally_look(struct srv_tally *tally, struct srv_sql *sql, const char *name,
                               struct srv_tally_client **client) {
    struct srv_row_wholes row = {.count = 4};
    struct srv_value value[] = {srv_value_text(name)};
    struct srv_tally_client *found = *client = srv_tally_client(tally, name);
    if (!found) return SRV_STORED_AGAIN;
    if (found->known) return SRV_STORED;
    SRV_STORED_TRY(tally_run(sql, SQL_CLIENT, value, 1, srv_row_wholes, &row));
    if (row.flawed) {
        /* what this transaction has changed is counted with the rest */
        SRV_STORED_TRY(srv_tally_count_anew(sql, name));
        found->jobs = found->ready = found->bytes = found->scenes = found->scene_bytes = 0;
        row = (struct srv_row_wholes){.count = 4};
        SRV_STORED_TRY(tally_run(sql, SQL_CLIENT, value, 1, srv_row_wholes, &row));
    }
    if (row.flawed) return SRV_STORED_DAMAGED;
    found->known = 1;
    found->jobs_were = row.whole[0];
    found->bytes_were = row.whole[1];
    found->scenes_were = row.whole[2];
    found->scene_bytes_were = row.whole[3];
    return SRV_STORED;
}

enum { TALLY_SUMS = SRV_JOB_STATES + 4 };

/* The totals of all places. */
struct tally_row {
    struct srv_store_figures figures;
    int flawed; /* a sum is less than nothing, a row holds what cannot be added, or there is none at
                   all */
};

static enum srv_stored tally_row(void *context, const struct srv_value field[]) {
    struct tally_row *row = context;
    struct srv_store_figures *figures = &row->figures;
    for (int i = 0; i < SRV_JOB_STATES; i++) figures->jobs[i] = (long)field[i].whole;
    figures->parts = (long)field[SRV_JOB_STATES].whole;
    figures->bytes = field[SRV_JOB_STATES + 1].whole;
    figures->scenes = (long)field[SRV_JOB_STATES + 2].whole;
    figures->scene_bytes = field[SRV_JOB_STATES + 3].whole;
    row->flawed =
        !field[TALLY_SUMS].whole || field[TALLY_SUMS].whole != field[TALLY_SUMS + 1].whole;
    for (int i = 0; i < TALLY_SUMS; i++) row->flawed |= field[i].whole < 0;
    return SRV_STORED;
}

/* reads the totals of before this transaction; those that cannot have been counted are counted
 * anew, with what this transaction has changed so far */
static enum srv_stored tally_read(struct srv_tally *tally, struct srv_sql *sql) {
    struct tally_row row = {.flawed = 0};
    SRV_STORED_TRY(tally_run(sql, SQL_TOTALS, NULL, 0, tally_row, &row));
    if (row.flawed) {
        SRV_STORED_TRY(tally_run(sql, SQL_TOTALS_CLEAR, NULL, 0, NULL, NULL));
        SRV_STORED_TRY(tally_run(sql, SQL_TOTALS_RECOUNT, NULL, 0, NULL, NULL));
        tally->change = (struct srv_store_figures){0};
        SRV_STORED_TRY(tally_run(sql, SQL_TOTALS, NULL, 0, tally_row, &row));
    }
    tally->were = row.figures;
    tally->known = 1;
    return SRV_STORED;
}

enum srv_stored srv_tally_totals(struct srv_tally *tally, struct srv_sql *sql,
                                 struct srv_store_figures *figures) {
    if (!tally->known) SRV_STORED_TRY(tally_read(tally, sql));
    *figures = tally->were;
    for (int i = 0; i < SRV_JOB_STATES; i++) figures->jobs[i] += tally->change.jobs[i];
    figures->parts += tally->change.parts;
    figures->bytes += tally->change.bytes;
    figures->scenes += tally->change.scenes;
    figures->scene_bytes += tally->change.scene_bytes;
    return SRV_STORED;
}

enum srv_stored srv_tally_source(struct srv_tally *tally, struct srv_sql *sql, const char *source,
                                 int64_t *clients, int64_t *jobs, int64_t *bytes) {
    struct srv_row_wholes all = {.count = 4};
    struct srv_value value[] = {srv_value_text(source)};
    if (strcmp(tally->source, source) != 0) {
        SRV_STORED_TRY(tally_run(sql, SQL_SOURCE, value, 1, srv_row_wholes, &all));
        snprintf(tally->source, sizeof tally->source, "%s", source);
        tally->source_clients = all.whole[0];
        tally->source_jobs = all.whole[1];
        tally->source_bytes = all.whole[2];
        tally->source_open = all.whole[3];
    }
    *clients = tally->source_clients;
    *jobs = tally->source_jobs;
    *bytes = tally->source_bytes;
    for (int i = 0; i < tally->count; i++) {
        const struct srv_tally_client *client = &tally->client[i];
        if (strcmp(client->source, source) != 0) continue;
        *clients += client->bytes > 0 && !client->jobs_were && !client->bytes_were;
        *jobs += client->jobs;
        *bytes += client->bytes;
    }
    return SRV_STORED;
}

static int tally_order(const void *a, const void *b) {
    return strcmp(((const struct srv_tally_client *)a)->name,
                  ((const struct srv_tally_client *)b)->name);
}

static enum srv_stored tally_client(const struct srv_tally_client *client, struct srv_sql *sql) {
    int late = sql->driver->lists && client->jobs <= 0 && client->ready <= 0 && !client->scenes &&
               !client->scene_bytes;
    struct srv_value value[] = {srv_value_text(client->name),
                                srv_value_whole(client->turn),
                                srv_value_whole(client->jobs),
                                srv_value_whole(client->ready),
                                srv_value_whole(client->bytes),
                                srv_value_whole(client->scenes),
                                srv_value_whole(client->scene_bytes),
                                srv_value_text(client->source),
                                srv_value_whole(client->weight > 0 ? client->weight : 1)};
    if (!(client->turn | client->jobs | client->ready | client->bytes | client->scenes |
          client->scene_bytes))
        return SRV_STORED;
    if (late) return tally_post(sql, SQL_CLIENT_LATER, value, 5);
    SRV_STORED_TRY(tally_post(sql, SQL_CLIENT_CHANGE, value, 9));
    if (client->bytes >= 0 && client->scenes >= 0) return SRV_STORED;
    return tally_post(sql, SQL_CLIENT_LEAVES, value, 1);
}

static enum srv_stored tally_all(const struct srv_tally *tally, struct srv_sql *sql) {
    const struct srv_store_figures *change = &tally->change;
    struct srv_value value[] = {
        srv_value_whole(tally->place),    srv_value_whole(change->jobs[0]),
        srv_value_whole(change->jobs[1]), srv_value_whole(change->jobs[2]),
        srv_value_whole(change->jobs[3]), srv_value_whole(change->jobs[4]),
        srv_value_whole(change->parts),   srv_value_whole(change->bytes),
        srv_value_whole(change->scenes),  srv_value_whole(change->scene_bytes)};
    int64_t some = change->parts | change->bytes | change->scenes | change->scene_bytes;
    for (int i = 0; i < SRV_JOB_STATES; i++) some |= change->jobs[i];
    return some ? tally_post(sql, SQL_TOTALS_CHANGE, value, 10) : SRV_STORED;
}

enum srv_stored srv_tally_write(struct srv_tally *tally, struct srv_sql *sql) {
    assert(srv_tally_valid(tally));
    qsort(tally->client, (size_t)tally->count, sizeof tally->client[0], tally_order);
    for (int i = 0; i < tally->count; i++) SRV_STORED_TRY(tally_client(&tally->client[i], sql));
    SRV_STORED_TRY(tally_all(tally, sql));
    if (!tally->ring || sql->driver->lists) return SRV_STORED;
    return tally_run(sql, SQL_RING, NULL, 0, NULL, NULL);
}
