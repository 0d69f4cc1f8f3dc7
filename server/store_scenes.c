/* Scenes in the store: kept as long as somebody keeps them, read.
 * Leaves to others: what a scene says, and how its id is found (scenes).
 * Invariant: a scene that was kept never changes; it goes with the last of its keepers, and no link that a keeper was
 * given is dead before. */
#include <stdlib.h>
#include <string.h>

#include "server/store_call.h"
#include "server/store_rows.h"

/* whether one more scene is within the bounds of a client and of its source */
static enum srv_stored scene_room(struct srv_store *store, const char *client, const char *source) {
    const struct srv_store_rules *rules = &store->rules;
    struct srv_row_wholes own = {.count = 1}, all = {.count = 1};
    SRV_STORED_TRY(SRV_RUN(store, SQL_KEEPERS_OF, srv_row_wholes, &own, srv_value_text(client)));
    if (own.whole[0] >= rules->client_scenes) return SRV_STORED_QUOTA;
    if (!rules->source_scenes || !strcmp(client, source)) return SRV_STORED;
    SRV_STORED_TRY(SRV_RUN(store, SQL_KEEPERS_FROM, srv_row_wholes, &all, srv_value_text(source)));
    return all.whole[0] < rules->source_scenes ? SRV_STORED : SRV_STORED_QUOTA;
}

static enum srv_stored scene_keeper(struct srv_store *store, const char *id, const char *client, int *keeps) {
    struct srv_row_wholes row = {.count = 1};
    SRV_STORED_TRY(SRV_RUN(store, SQL_KEEPER, srv_row_wholes, &row, srv_value_text(id), srv_value_text(client)));
    *keeps = row.whole[0] > 0;
    return SRV_STORED;
}

/* one more keeps a scene that is there and locked */
static enum srv_stored scene_keep(struct srv_store *store, const char *id, const char *client, const char *source,
                                  size_t bytes) {
    int keeps;
    if (!source) source = client;
    SRV_STORED_TRY(scene_keeper(store, id, client, &keeps));
    if (keeps) return SRV_STORED;
    SRV_STORED_TRY(scene_room(store, client, source));
    return SRV_RUN(store, SQL_KEEPER_PUT, NULL, NULL, srv_value_text(id), srv_value_text(client),
                   srv_value_text(source), srv_value_whole((int64_t)bytes));
}

/* locks a scene, so that nobody takes away what another keeps just now */
static enum srv_stored scene_lock(struct srv_store *store, const char *id) {
    struct srv_row_wholes row = {.count = 0};
    SRV_STORED_TRY(SRV_RUN(store, SQL_SCENE_LOCK, srv_row_wholes, &row, srv_value_text(id)));
    return row.rows ? SRV_STORED : SRV_STORED_NONE;
}

static enum srv_stored scene_put(struct srv_store *store, const char *id, const char *client, const char *source,
                                 const void *body, size_t bytes) {
    struct srv_row_wholes put = {.count = 1};
    struct srv_row_bytes there = {0};
    enum srv_stored found = scene_lock(store, id);
    if (found == SRV_STORED) {
        SRV_STORED_TRY(SRV_RUN(store, SQL_SCENE, srv_row_bytes, &there, srv_value_text(id)));
        int same = there.bytes == bytes && (!bytes || !memcmp(there.data, body, bytes));
        free(there.data);
        return same ? scene_keep(store, id, client, source, bytes) : SRV_STORED_CLASH;
    }
    if (found != SRV_STORED_NONE) return found;
    SRV_STORED_TRY(
        SRV_RUN(store, SQL_SCENE_PUT, srv_row_wholes, &put, srv_value_text(id), srv_value_bytes(body, bytes)));
    return put.rows ? scene_keep(store, id, client, source, bytes) : SRV_STORED_AGAIN;
}

enum srv_stored srv_store_scene_put(struct srv_store *store, const char *id, const char *client, const char *source,
                                    const void *body, size_t bytes) {
    SRV_STORED_TRY(srv_store_begin(store));
    enum srv_stored stored = scene_put(store, id, client, source, body, bytes);
    return srv_store_end(store, stored == SRV_STORED, stored);
}

enum srv_stored srv_store_scene_keep(struct srv_store *store, const char *id, const char *client, const char *source) {
    struct srv_row_wholes size = {.count = 1};
    SRV_STORED_TRY(srv_store_begin(store));
    enum srv_stored stored = scene_lock(store, id);
    if (stored == SRV_STORED) stored = SRV_RUN(store, SQL_SCENE_SIZE, srv_row_wholes, &size, srv_value_text(id));
    if (stored == SRV_STORED) stored = scene_keep(store, id, client, source, (size_t)size.whole[0]);
    return srv_store_end(store, stored == SRV_STORED, stored);
}

static enum srv_stored scene_drop(struct srv_store *store, const char *id, const char *client) {
    struct srv_row_wholes left = {.count = 1};
    int keeps;
    SRV_STORED_TRY(scene_lock(store, id));
    SRV_STORED_TRY(scene_keeper(store, id, client, &keeps));
    if (!keeps) return SRV_STORED_CLASH;
    SRV_STORED_TRY(SRV_RUN(store, SQL_KEEPER_REMOVE, NULL, NULL, srv_value_text(id), srv_value_text(client)));
    SRV_STORED_TRY(SRV_RUN(store, SQL_KEEPERS, srv_row_wholes, &left, srv_value_text(id)));
    return left.whole[0] ? SRV_STORED : SRV_RUN(store, SQL_SCENE_REMOVE, NULL, NULL, srv_value_text(id));
}

enum srv_stored srv_store_scene_drop(struct srv_store *store, const char *id, const char *client) {
    SRV_STORED_TRY(srv_store_begin(store));
    enum srv_stored stored = scene_drop(store, id, client);
    return srv_store_end(store, stored == SRV_STORED, stored);
}

enum srv_stored srv_store_scene(struct srv_store *store, const char *id, void **body, size_t *bytes) {
    return srv_store_bytes(store, SQL_SCENE, id, body, bytes);
}
