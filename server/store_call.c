#include "server/store_call.h"

#include <stdlib.h>

#include "server/store_rows.h"
#include "server/store_schema.h"

enum { TRIES = 5 };

enum srv_stored srv_store_run(struct srv_store *store, enum srv_statement id, const struct srv_value value[], int count,
                              srv_row_fn *row, void *context) {
    return store->sql->driver->run(store->sql, (int)id, srv_statement_text[id], value, count, row, context);
}

enum srv_stored srv_store_plain(struct srv_store *store, enum srv_statement id) {
    return srv_store_run(store, id, NULL, 0, NULL, NULL);
}

enum srv_stored srv_store_settle(struct srv_store *store) {
    SRV_STORED_TRY(srv_schema_settle(store->sql));
    store->settled = 1;
    return SRV_STORED;
}

enum srv_stored srv_store_begin(struct srv_store *store) {
    if (!store->settled) SRV_STORED_TRY(srv_store_settle(store));
    return srv_store_plain(store, store->together ? SQL_SAVE : SQL_BEGIN);
}

enum srv_stored srv_store_end(struct srv_store *store, int keep, enum srv_stored stored) {
    enum srv_stored ended;
    if (!keep && store->together) {
        ended = srv_store_plain(store, SQL_BACK);
        if (ended == SRV_STORED) ended = srv_store_plain(store, SQL_UNSAVE);
    } else if (!keep) {
        srv_store_plain(store, SQL_ROLLBACK);
        ended = SRV_STORED;
    } else {
        ended = srv_store_plain(store, store->together ? SQL_UNSAVE : SQL_COMMIT);
        if (ended != SRV_STORED && !store->together) srv_store_plain(store, SQL_ROLLBACK);
    }
    return ended == SRV_STORED ? stored : ended;
}

enum srv_stored srv_store_bytes(struct srv_store *store, enum srv_statement id, const char *name, void **data,
                                size_t *bytes) {
    struct srv_row_bytes row = {0};
    *data = NULL;
    *bytes = 0;
    SRV_STORED_TRY(srv_store_begin(store));
    enum srv_stored stored = SRV_RUN(store, id, srv_row_bytes, &row, srv_value_text(name));
    if (stored == SRV_STORED && !row.data) stored = SRV_STORED_NONE;
    stored = srv_store_end(store, 1, stored);
    if (stored == SRV_STORED) {
        *data = row.data;
        *bytes = row.bytes;
    } else
        free(row.data);
    return stored;
}

/* failures after which a batch's transaction is not to be trusted */
static int store_hard(enum srv_stored stored) { return stored >= SRV_STORED_FULL; }

/* a full disk is tried twice: what the first try found in the way may be given back before the second */
static void store_single(struct srv_store *store, struct srv_store_call *call) {
    for (int i = 0; i < TRIES; i++) {
        call->stored = call->run(store, call);
        if (call->stored != SRV_STORED_AGAIN && (call->stored != SRV_STORED_FULL || i)) break;
    }
}

void srv_store_together(struct srv_store *store, struct srv_store_call *const calls[], int count) {
    enum srv_stored stored = count > 1 && store->settled ? srv_store_plain(store, SQL_BEGIN) : SRV_STORED_AGAIN;
    if (stored == SRV_STORED) {
        store->together = 1;
        for (int i = 0; i < count && !store_hard(stored); i++)
            stored = calls[i]->stored = calls[i]->run(store, calls[i]);
        store->together = 0;
        stored = store_hard(stored) ? stored : srv_store_plain(store, SQL_COMMIT);
        if (stored == SRV_STORED) return;
        srv_store_plain(store, SQL_ROLLBACK);
    }
    for (int i = 0; i < count; i++) store_single(store, calls[i]);
}
