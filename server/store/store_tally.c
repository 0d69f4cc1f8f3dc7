#include "server/store/store_tally.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

PEND_VALIDATOR tally_valid(const struct srv_tally *tally) {
    int last = tally->count - 1, good = tally->count >= 0 && tally->count <= SRV_TALLY_CLIENTS &&
                                        tally->place >= 0 && tally->place < SRV_TALLY_PLACES;
    for (int i = 0; good && i < last; i++)
        good = strcmp(tally->client[i].name, tally->client[last].name) != 0;
    return good;
}

enum srv_stored srv_tally_client(struct srv_tally *tally, const char *name,
                                 struct srv_tally_client **client) {
    /* search backwards: the last client is likely to be needed again */
    for (int i = tally->count - 1; i >= 0; i--)
        if (!strcmp((*client = &tally->client[i])->name, name)) return SRV_STORED;
    if (tally->count == SRV_TALLY_CLIENTS) return SRV_STORED_AGAIN;
    *client = &tally->client[tally->count++];
    **client = (struct srv_tally_client){0};
    snprintf((*client)->name, sizeof(*client)->name, "%s", name);
    assert(tally_valid(tally));
    return SRV_STORED;
}

enum srv_stored srv_tally_count_anew(struct srv_tally *tally, const char *name) {
    struct srv_row_wholes locked = {.count = 1};
    struct srv_tally_client *client;
    SRV_STORED_TRY(srv_tally_client(tally, name, &client));
    SRV_STORED_TRY(SRV_SQL_RUN(tally->sql, SQL_CLIENT_LOCK, srv_row_wholes, &locked, name));
    client->jobs = client->ready = client->bytes = client->scenes = client->scene_bytes = 0;
    client->known = 0;
    return SRV_SQL_RUN(tally->sql, SQL_CLIENT_RECOUNT, NULL, NULL, name);
}

enum srv_stored srv_tally_count_all(struct srv_tally *tally) {
    SRV_STORED_TRY(SRV_SQL_RUN(tally->sql, SQL_TOTALS_CLEAR, NULL, NULL));
    tally->known = 0;
    memset(tally->changes, 0, sizeof tally->changes);
    return SRV_SQL_RUN(tally->sql, SQL_TOTALS_RECOUNT, NULL, NULL);
}

enum srv_stored srv_tally_look(struct srv_tally *tally, const char *name,
                               struct srv_tally_client **client) {
    SRV_STORED_TRY(srv_tally_client(tally, name, client));
    struct srv_tally_client *found = *client;
    for (int tries = 0; tries < 2 && !found->known; tries++) {
        struct srv_row_wholes row = {.count = 4};
        if (tries) SRV_STORED_TRY(srv_tally_count_anew(tally, name));
        SRV_STORED_TRY(SRV_SQL_RUN(tally->sql, SQL_CLIENT, srv_row_wholes, &row, name));
        found->known = !row.flawed;
        found->jobs_were = row.whole[0];
        found->bytes_were = row.whole[1];
        found->scenes_were = row.whole[2];
        found->scene_bytes_were = row.whole[3];
    }
    return found->known ? SRV_STORED : SRV_STORED_DAMAGED;
}

/* adds up the rows of totals; they are valid unless a sum is negative, a row has an invalid number,
 * or there is no row */
static enum srv_stored tally_row(void *context, const struct srv_value field[]) {
    struct srv_tally *tally = context;
    int64_t rows = field[SRV_TALLY_SUMS].whole, good = field[SRV_TALLY_SUMS + 1].whole;
    tally->known = rows && rows == good;
    for (int i = 0; i < SRV_TALLY_SUMS; i++) {
        tally->were[i] = field[i].whole;
        tally->known &= tally->were[i] >= 0;
    }
    return SRV_STORED;
}

enum srv_stored srv_tally_total(struct srv_tally *tally, int which, int64_t *sum) {
    assert(which >= 0 && which < SRV_TALLY_SUMS);
    if (!tally->known) SRV_STORED_TRY(SRV_SQL_RUN(tally->sql, SQL_TOTALS, tally_row, tally));
    if (!tally->known) {
        SRV_STORED_TRY(srv_tally_count_all(tally));
        SRV_STORED_TRY(SRV_SQL_RUN(tally->sql, SQL_TOTALS, tally_row, tally));
        tally->known = 1;
    }
    *sum = tally->were[which] + tally->changes[which];
    return SRV_STORED;
}

enum srv_stored srv_tally_source(struct srv_tally *tally, const char *source, int64_t *clients,
                                 int64_t *jobs, int64_t *bytes) {
    struct srv_row_wholes all = {.count = 4};
    if (strcmp(tally->source, source) != 0) {
        SRV_STORED_TRY(SRV_SQL_RUN(tally->sql, SQL_SOURCE, srv_row_wholes, &all, source));
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

static enum srv_stored tally_client(const struct srv_tally_client *c, struct srv_sql *sql) {
    if (!(c->turn | c->jobs | c->ready | c->bytes | c->scenes | c->scene_bytes)) return SRV_STORED;
    if (sql->driver->lists && c->jobs <= 0 && c->ready <= 0 && !(c->scenes | c->scene_bytes))
        return SRV_SQL_POST(sql, SQL_CLIENT_LATER, c->name, c->turn, c->jobs, c->ready, c->bytes);
    SRV_STORED_TRY(SRV_SQL_POST(sql, SQL_CLIENT_CHANGE, c->name, c->turn, c->jobs, c->ready,
                                c->bytes, c->scenes, c->scene_bytes, c->source,
                                c->weight > 0 ? c->weight : 1));
    if (c->bytes >= 0 && c->scenes >= 0) return SRV_STORED;
    return SRV_SQL_POST(sql, SQL_CLIENT_LEAVES, c->name);
}

enum srv_stored srv_tally_write(struct srv_tally *tally) {
    struct srv_value value[1 + SRV_TALLY_SUMS] = {srv_value_whole(tally->place)};
    int64_t some = 0;
    assert(tally_valid(tally));
    qsort(tally->client, (size_t)tally->count, sizeof tally->client[0], tally_order);
    for (int i = 0; i < tally->count; i++)
        SRV_STORED_TRY(tally_client(&tally->client[i], tally->sql));
    for (int i = 0; i < SRV_TALLY_SUMS; i++) {
        some |= tally->changes[i];
        value[1 + i] = srv_value_whole(tally->changes[i]);
    }
    if (some)
        SRV_STORED_TRY(tally->sql->driver->post(tally->sql, SQL_TOTALS_CHANGE,
                                                srv_statement_text[SQL_TOTALS_CHANGE], value,
                                                1 + SRV_TALLY_SUMS));
    if (!tally->ring || tally->sql->driver->lists) return SRV_STORED;
    return SRV_SQL_RUN(tally->sql, SQL_RING, NULL, NULL);
}
