#include "server/store/store_class_sweep.h"

#include <assert.h>
#include <string.h>

enum { SWEEP_CODE = 6, SWEEP_CODE_OLD = 5 }; /* letters of a code */

enum srv_stored srv_store_class_erase(struct srv_store *store, const char *code) {
    assert(*code);
    SRV_STORED_TRY(SRV_POST(store, SQL_CLASS_ITEMS_REMOVE, srv_value_text(code)));
    SRV_STORED_TRY(SRV_POST(store, SQL_CLASS_PUPILS_REMOVE, srv_value_text(code)));
    store->tally.ring |= SRV_RING_ENDS;
    return SRV_POST(store, SQL_CLASS_REMOVE, srv_value_text(code));
}

/* The code of a room that has ended. */
struct row_ended {
    int rows;
    char code[SRV_NAME_BYTES];
};

static enum srv_stored row_ended(void *context, const struct srv_value field[]) {
    struct row_ended *row = context;
    srv_row_text(&field[0], row->code, sizeof row->code);
    row->rows++;
    return SRV_STORED;
}

enum srv_stored srv_store_class_sweep(struct srv_store *store, int64_t now, int *more) {
    struct row_ended ended = {0};
    assert(now > 0);
    SRV_STORED_TRY(SRV_RUN(store, SQL_CLASS_ENDED, row_ended, &ended, srv_value_whole(now)));
    if (!ended.rows) return SRV_STORED;
    /* a code that was altered names no room */
    if (strlen(ended.code) != SWEEP_CODE && strlen(ended.code) != SWEEP_CODE_OLD)
        return SRV_POST(store, SQL_CLASSES_NAMELESS, srv_value_whole(now));
    *more = 1;
    return srv_store_class_erase(store, ended.code);
}
