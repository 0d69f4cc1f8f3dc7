/* Scenes in the store: kept for ever, read.
 * Leaves to others: what a scene says, and how its id is found (scenes).
 * Invariant: a scene that was kept never changes. */
#include <stdlib.h>
#include <string.h>

#include "server/store_call.h"
#include "server/store_rows.h"

static enum srv_stored scene_put(struct srv_store *store, const char *id, const char *client, const void *body,
                                 size_t bytes) {
    struct srv_row_wholes count = {.count = 1}, put = {.count = 1};
    struct srv_row_bytes there = {0};
    SRV_STORED_TRY(SRV_RUN(store, SQL_SCENE, srv_row_bytes, &there, srv_value_text(id)));
    if (there.data) {
        int same = there.bytes == bytes && (!bytes || !memcmp(there.data, body, bytes));
        free(there.data);
        return same ? SRV_STORED : SRV_STORED_CLASH;
    }
    SRV_STORED_TRY(SRV_RUN(store, SQL_SCENES_OF, srv_row_wholes, &count, srv_value_text(client)));
    if (count.whole[0] >= store->rules.client_scenes) return SRV_STORED_QUOTA;
    SRV_STORED_TRY(SRV_RUN(store, SQL_SCENE_PUT, srv_row_wholes, &put, srv_value_text(id), srv_value_text(client),
                           srv_value_bytes(body, bytes)));
    return put.rows ? SRV_STORED : SRV_STORED_AGAIN;
}

enum srv_stored srv_store_scene_put(struct srv_store *store, const char *id, const char *client, const void *body,
                                    size_t bytes) {
    SRV_STORED_TRY(srv_store_begin(store));
    enum srv_stored stored = scene_put(store, id, client, body, bytes);
    return srv_store_end(store, stored == SRV_STORED, stored);
}

enum srv_stored srv_store_scene(struct srv_store *store, const char *id, void **body, size_t *bytes) {
    return srv_store_bytes(store, SQL_SCENE, id, body, bytes);
}
