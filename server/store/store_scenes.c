/* Scenes in the store: storing, reading and deleting them.
 * Leaves to others: the contents of a scene, and its id (scenes).
 * Invariant: a stored scene is immutable; it is deleted when the last client that stored it removes
 * it.
 */
#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "server/store/store_jobs.h"
#include "server/store/store_rows.h"

/* checks the quotas of a client and of its source for one more scene; anew: no client stores it yet
 */
static enum srv_stored scene_room(struct srv_store *store, const char *client, const char *source,
                                  size_t bytes, int anew) {
    const struct srv_store_rules *rules = &store->rules;
    struct srv_row_wholes all = {.count = 1};
    SRV_STORED_TRY(srv_store_room_scene(store, client, bytes + SRV_ROW_BYTES, anew));
    if (!rules->source_scenes || !strcmp(client, source)) return SRV_STORED;
    SRV_STORED_TRY(SRV_RUN(store, SQL_KEEPERS_FROM, srv_row_wholes, &all, source));
    if (all.whole[0] < rules->source_scenes) return SRV_STORED;
    srv_sql_complain(store->sql, "the clients of your address together have max-address-clients "
                                 "times max-client-scenes scenes; DELETE scenes that are no longer "
                                 "needed");
    return SRV_STORED_QUOTA;
}

/* changes the number of a client's scenes by one, up or down */
static enum srv_stored scene_count(struct srv_store *store, const char *name, const char *source,
                                   int count, size_t bytes) {
    assert(count == 1 || count == -1);
    struct srv_tally_client *client;
    SRV_STORED_TRY(srv_tally_client(&store->tally, name, &client));
    client->scenes += count;
    client->scene_bytes += count * (int64_t)(bytes + SRV_ROW_BYTES);
    if (source) snprintf(client->source, sizeof client->source, "%s", source);
    return SRV_STORED;
}

static void scene_count_all(struct srv_store *store, int count, size_t bytes) {
    assert(count == 1 || count == -1);
    store->tally.changes[SRV_TALLY_SCENES] += count;
    store->tally.changes[SRV_TALLY_SCENE_BYTES] += count * (int64_t)(bytes + SRV_ROW_BYTES);
}

static enum srv_stored scene_keeper(struct srv_store *store, const char *id, const char *client,
                                    int *keeps) {
    struct srv_row_wholes row = {.count = 1};
    SRV_STORED_TRY(SRV_RUN(store, SQL_KEEPER, srv_row_wholes, &row, id, client));
    *keeps = row.whole[0] > 0;
    return SRV_STORED;
}

static enum srv_stored scene_keeper_put(struct srv_store *store, const char *id, const char *client,
                                        const char *source, size_t bytes) {
    SRV_STORED_TRY(SRV_POST(store, SQL_KEEPER_PUT, id, client, source, bytes));
    return scene_count(store, client, source, 1, bytes);
}

static enum srv_stored scene_keep(struct srv_store *store, const char *id, const char *client,
                                  const char *source, size_t bytes) {
    int keeps;
    SRV_STORED_TRY(scene_keeper(store, id, client, &keeps));
    if (keeps) return SRV_STORED;
    SRV_STORED_TRY(scene_room(store, client, source, bytes, 0));
    return scene_keeper_put(store, id, client, source, bytes);
}

/* locks a scene, so that no other process deletes it */
static enum srv_stored scene_lock(struct srv_store *store, const char *id, size_t *bytes) {
    struct srv_row_wholes row = {.count = 1};
    SRV_STORED_TRY(SRV_RUN(store, SQL_SCENE_LOCK, srv_row_wholes, &row, id));
    *bytes = (size_t)row.whole[0];
    return row.rows ? SRV_STORED : SRV_STORED_NONE;
}

static enum srv_stored scene_new(struct srv_store *store, const char *id, const char *client,
                                 const char *source, const void *body, size_t bytes) {
    struct srv_row_wholes put = {.count = 1};
    unsigned char seal[API_SEAL_BYTES];
    SRV_STORED_TRY(scene_room(store, client, source, bytes, 1));
    srv_seal_scene(seal, id, body, bytes);
    SRV_STORED_TRY(SRV_RUN(store, SQL_SCENE_PUT, srv_row_wholes, &put, id,
                           srv_value_bytes(body, bytes), srv_value_bytes(seal, sizeof seal)));
    if (!put.rows) return SRV_STORED_AGAIN;
    scene_count_all(store, 1, bytes);
    return scene_keeper_put(store, id, client, source, bytes);
}

static enum srv_stored scene_put(struct srv_store *store, const char *id, const char *client,
                                 const char *source, const void *body, size_t bytes) {
    struct srv_row_bytes there = {.name = id, .whole = srv_seal_scene_whole};
    size_t kept;
    enum srv_stored found = scene_lock(store, id, &kept);
    if (found == SRV_STORED_NONE) return scene_new(store, id, client, source, body, bytes);
    SRV_STORED_TRY(found);
    found = SRV_RUN(store, SQL_SCENE, srv_row_bytes, &there, id);
    int same = there.data && there.bytes == bytes && (!bytes || !memcmp(there.data, body, bytes));
    free(there.data);
    SRV_STORED_TRY(found);
    return same ? scene_keep(store, id, client, source, bytes) : SRV_STORED_CLASH;
}

enum srv_stored srv_store_scene_put(struct srv_store *store, const char *id, const char *client,
                                    const char *source, const void *body, size_t bytes) {
    SRV_STORED_TRY(srv_store_begin(store));
    return srv_store_end(store,
                         scene_put(store, id, client, source ? source : client, body, bytes));
}

enum srv_stored srv_store_scene_keep(struct srv_store *store, const char *id, const char *client,
                                     const char *source) {
    size_t bytes;
    SRV_STORED_TRY(srv_store_begin(store));
    enum srv_stored stored = scene_lock(store, id, &bytes);
    if (stored == SRV_STORED)
        stored = scene_keep(store, id, client, source ? source : client, bytes);
    return srv_store_end(store, stored);
}

static enum srv_stored scene_drop(struct srv_store *store, const char *id, const char *client) {
    struct srv_row_wholes left = {.count = 1};
    size_t bytes;
    int keeps;
    SRV_STORED_TRY(scene_lock(store, id, &bytes));
    SRV_STORED_TRY(scene_keeper(store, id, client, &keeps));
    if (!keeps) return SRV_STORED_CLASH;
    SRV_STORED_TRY(SRV_POST(store, SQL_KEEPER_REMOVE, id, client));
    SRV_STORED_TRY(scene_count(store, client, NULL, -1, bytes));
    SRV_STORED_TRY(SRV_RUN(store, SQL_KEEPERS, srv_row_wholes, &left, id));
    if (left.whole[0]) return SRV_STORED;
    scene_count_all(store, -1, bytes);
    return SRV_POST(store, SQL_SCENE_REMOVE, id);
}

enum srv_stored srv_store_scene_drop(struct srv_store *store, const char *id, const char *client) {
    SRV_STORED_TRY(srv_store_begin(store));
    enum srv_stored stored = scene_drop(store, id, client);
    /* the same call may have been committed although its reply was lost */
    int done = store->unsure && (stored == SRV_STORED_NONE || stored == SRV_STORED_CLASH);
    return srv_store_end(store, done ? SRV_STORED : stored);
}

struct row_kept {
    int count;
    char id[SQL_KEPT_MOST][SRV_ID_BYTES];
};

static enum srv_stored row_kept(void *context, const struct srv_value field[]) {
    struct row_kept *rows = context;
    struct srv_row row = {field, NULL};
    if (rows->count == SQL_KEPT_MOST) return SRV_STORED;
    srv_row_word(&row, 1, rows->id[rows->count], SRV_ID_BYTES, "scene");
    rows->count += !row.flaw;
    return SRV_STORED;
}

static enum srv_stored erase_scenes(struct srv_store *store, const char *client, int most,
                                    int *count) {
    struct row_kept rows = {0};
    SRV_STORED_TRY(SRV_RUN(store, SQL_KEEPERS_OF, row_kept, &rows, client));
    if (rows.count > most) rows.count = most;
    for (int i = 0; i < rows.count; i++) {
        enum srv_stored stored = scene_drop(store, rows.id[i], client);
        if (stored == SRV_STORED_CLASH) continue; /* another process removed it */
        if (stored != SRV_STORED_NONE) {
            SRV_STORED_TRY(stored);
            continue;
        }
        /* the scene was deleted from the tables by hand */
        SRV_STORED_TRY(SRV_POST(store, SQL_KEEPER_REMOVE, rows.id[i], client));
        SRV_STORED_TRY(srv_tally_count_anew(&store->tally, client));
    }
    *count = rows.count;
    return SRV_STORED;
}

enum srv_stored srv_store_erase_scenes(struct srv_store *store, const char *client, int most,
                                       int *count) {
    *count = 0;
    SRV_STORED_TRY(srv_store_begin(store));
    return srv_store_end(store, erase_scenes(store, client, most, count));
}

enum srv_stored srv_store_scene(struct srv_store *store, const char *id, void **body,
                                size_t *bytes) {
    return srv_store_bytes(store, SQL_SCENE, id, srv_seal_scene_whole, body, bytes);
}
