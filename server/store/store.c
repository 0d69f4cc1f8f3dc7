#include "server/store/store.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "server/store/store_call.h"

enum pend_status srv_store_open(struct srv_store **store, const char *url,
                                const struct srv_store_rules *rules, struct pend_error *error) {
    static const struct srv_sql_driver *const drivers[] = {&srv_sql_sqlite, &srv_sql_postgres};
    const struct srv_sql_driver *driver = NULL;
    struct srv_store *made = NULL;
    enum pend_status status = PEND_OK;
    *store = NULL;
    for (size_t i = 0; i < sizeof drivers / sizeof *drivers; i++)
        if (!strncmp(url, drivers[i]->scheme, strlen(drivers[i]->scheme))) driver = drivers[i];
    if (!driver)
        return pend_fail(error, PEND_INVALID, -1, 0,
                         "wants sqlite:PATH or postgresql://..., got \"%.80s\"", url);
    if (!(made = calloc(1, sizeof *made)))
        return pend_fail(error, PEND_NO_MEMORY, -1, 0, "out of memory");
    made->rules = *rules;
    made->tally.place =
        driver->shared
            ? (int)(((unsigned)getpid() ^ (unsigned)((uintptr_t)made >> 8)) % SRV_TALLY_PLACES)
            : 0;
    status = driver->open(&made->sql, url, rules->role, error);
    made->tally.sql = made->sql;
    if (status == PEND_OK) {
        enum srv_stored stored = srv_store_settle(made);
        int waits = stored == SRV_STORED_AWAY && driver->distant;
        if (stored != SRV_STORED && !waits)
            status =
                pend_fail(error, PEND_INVALID, -1, 0,
                          "the tables of the store cannot be used: %.180s", made->sql->complaint);
    }
    if (status == PEND_OK)
        *store = made;
    else
        srv_store_close(&made);
    return status;
}

void srv_store_close(struct srv_store **store) {
    struct srv_store *gone = *store;
    *store = NULL;
    if (!gone) return;
    if (gone->sql) gone->sql->driver->close(gone->sql);
    free(gone);
}

const char *srv_store_complaint(const struct srv_store *store) { return store->sql->complaint; }

int srv_store_batch(const struct srv_store *store) { return store->sql->driver->batch; }

int srv_store_listen(struct srv_store *store, int timeout_ms, int wake) {
    return store->sql->driver->listen(store->sql, timeout_ms, wake);
}

enum srv_stored srv_store_carries(struct srv_store *store, int64_t *connections, int64_t *workers) {
    struct srv_row_wholes row = {.count = 2};
    SRV_STORED_TRY(srv_store_begin(store));
    enum srv_stored stored = SRV_RUN(store, SQL_CARRIES, srv_row_wholes, &row);
    *connections = row.whole[0];
    *workers = row.whole[1];
    return srv_store_end(store, stored);
}

int srv_store_distant(const struct srv_store *store) { return store->sql->driver->distant; }

int srv_store_settled(const struct srv_store *store) { return store->settled; }
