#include "server/store/store_call.h"

#include <assert.h>
#include <stdlib.h>
#include <time.h>
#include <string.h>

#include "server/base/clock.h"

/* UNSURE_NS: delay before a reconnection; LOST_NS: longest failed call that is repeated */
enum { TRIES = 5, UNSURE_NS = 200000000, LOST_NS = 1000000000 };

static_assert(SRV_TALLY_CLIENTS >= (int)SQL_EXPIRED_MOST + (int)SQL_PARTS_MOST,
              "a sweep may change the sums of as many clients as it finds jobs and parts");
static_assert((int)SRV_TALLY_CLIENTS >= SRV_STORE_AHEAD, "a batch may have a client for each part");

PEND_VALIDATOR store_valid(const struct srv_store *store) {
    const struct srv_store_ahead *ahead = &store->ahead;
    return store->sql && store->sql->driver && !(store->looking && store->together) &&
           (store->settled || !store->together) && ahead->leases >= 0 &&
           ahead->leases <= SRV_STORE_AHEAD && ahead->rows >= 0 && ahead->rows <= SRV_STORE_AHEAD;
}

/* true if rows that were read ahead stay valid after this statement */
static int call_spares(enum srv_statement id) {
    switch (id) {
    case SQL_JOB_PUT:
    case SQL_KEY_FREE:
    case SQL_JOB_CLAIM:
    case SQL_PART_FIRST:
    case SQL_PART_EXTEND:
    case SQL_RESULT_PUT:
    case SQL_PART_END:
    case SQL_JOB_SUCCEED:
        return 1;
    default:
        return srv_statement_text[id][0] == 'S';
    }
}

/* updates the state of the current call, and the rows that were read ahead, for a statement */
static void call_notes(struct srv_store *store, enum srv_statement id) {
    store->wrote |= srv_statement_text[id][0] != 'S';
    if (!call_spares(id)) store->ahead.leases = store->ahead.rows = 0;
}

enum srv_stored srv_store_run(struct srv_store *store, enum srv_statement id,
                              const struct srv_value value[], int count, srv_row_fn *row,
                              void *context) {
    assert(store_valid(store) && (unsigned)id < SQL_COUNT && count <= SRV_SQL_PARAMETERS);
    call_notes(store, id);
    enum srv_stored stored = store->sql->driver->run(store->sql, (int)id, srv_statement_text[id],
                                                     value, count, row, context);
    store->failed |= stored != SRV_STORED;
    return stored;
}

enum srv_stored srv_store_post(struct srv_store *store, enum srv_statement id,
                               const struct srv_value value[], int count) {
    assert(store_valid(store) && (unsigned)id < SQL_COUNT && count <= SRV_SQL_PARAMETERS);
    call_notes(store, id);
    enum srv_stored stored =
        store->sql->driver->post(store->sql, (int)id, srv_statement_text[id], value, count);
    store->failed |= stored != SRV_STORED;
    return stored;
}

enum srv_stored srv_store_settle(struct srv_store *store) {
    SRV_STORED_TRY(srv_schema_settle(store->sql));
    store->settled = 1;
    return SRV_STORED;
}

static enum srv_stored store_open(struct srv_store *store) {
    store->tally.count = store->tally.known = store->tally.ring = 0;
    store->tally.source[0] = '\0';
    memset(store->tally.changes, 0, sizeof store->tally.changes);
    store->now = 0;
    store->failed = 0;
    store->ahead.leases = store->ahead.rows = store->ahead.read = 0;
    return SRV_POST(store, SQL_BEGIN);
}

/* recounts the sums of clients whose sums a transaction could not update */
static enum srv_stored store_mend(struct srv_store *store) {
    struct srv_tally tally = store->tally;
    SRV_STORED_TRY(store_open(store));
    enum srv_stored stored = SRV_STORED;
    for (int i = 0; i < tally.count && stored == SRV_STORED; i++)
        stored = srv_tally_count_anew(&store->tally, tally.client[i].name);
    if (stored == SRV_STORED) stored = srv_tally_count_all(&store->tally);
    if (stored == SRV_STORED) stored = SRV_RUN(store, SQL_COMMIT, NULL, NULL);
    if (stored == SRV_STORED) return SRV_STORED_AGAIN;
    SRV_RUN(store, SQL_ROLLBACK, NULL, NULL);
    return stored;
}

static enum srv_stored store_commit(struct srv_store *store) {
    enum srv_stored stored = srv_tally_write(&store->tally);
    if (stored == SRV_STORED) {
        stored = SRV_RUN(store, SQL_COMMIT, NULL, NULL);
        store->unsure |= stored == SRV_STORED_AWAY;
    }
    if (stored == SRV_STORED) store->ring |= store->tally.ring;
    if (stored != SRV_STORED) SRV_RUN(store, SQL_ROLLBACK, NULL, NULL);
    return stored == SRV_STORED_DAMAGED ? store_mend(store) : stored;
}

int srv_store_rings(const struct srv_store *store) {
    return store->sql->driver->lists ? store->ring : 0;
}

void srv_store_ring(struct srv_store *store, int rings) {
    rings &= store->ring;
    store->ring &= ~rings;
    if (rings & SRV_RING_WORK) SRV_RUN(store, SQL_RING_WORK, NULL, NULL);
    if (rings & SRV_RING_STOP) SRV_RUN(store, SQL_RING_STOP, NULL, NULL);
    if (rings & SRV_RING_ENDS) SRV_RUN(store, SQL_RING, NULL, NULL);
}

enum srv_stored srv_store_fold(struct srv_store *store, const char *name) {
    assert(*name && store->sql->driver->lists);
    SRV_STORED_TRY(srv_store_begin(store));
    /* not synced to disk: if the database fails, the pending changes still exist */
    enum srv_stored stored = SRV_POST(store, SQL_SOON);
    if (stored == SRV_STORED) stored = SRV_POST(store, SQL_CHANGES_FOLD, name);
    if (stored == SRV_STORED) stored = SRV_POST(store, SQL_CLIENT_LEAVES, name);
    return srv_store_end(store, stored);
}

enum srv_stored srv_store_begin(struct srv_store *store) {
    if (!store->settled) SRV_STORED_TRY(srv_store_settle(store));
    assert(store_valid(store) && !store->looking);
    enum srv_stored stored = store->together ? SRV_STORED : store_open(store);
    store->wrote = 0;
    return stored;
}

enum srv_stored srv_store_look(struct srv_store *store) {
    if (store->together || !store->settled) return srv_store_begin(store);
    assert(!store->looking);
    store->wrote = 0;
    store->now = 0;
    SRV_STORED_TRY(store->sql->driver->post(store->sql, -1, "{look}", NULL, 0));
    store->looking = 1;
    return SRV_STORED;
}

enum srv_stored srv_store_end(struct srv_store *store, enum srv_stored stored) {
    assert(store_valid(store) && !(store->looking && store->wrote));
    if (store->looking) {
        store->looking = 0;
        return stored;
    }
    if (store->together) {
        store->failed |= stored != SRV_STORED && store->wrote;
        return stored;
    }
    if (stored == SRV_STORED) return store_commit(store);
    SRV_RUN(store, SQL_ROLLBACK, NULL, NULL);
    return stored;
}

enum srv_stored srv_store_now(struct srv_store *store, int64_t *now) {
    struct srv_row_wholes row = {.count = 2};
    if (!store->now) {
        SRV_STORED_TRY(SRV_RUN(store, SQL_NOW, srv_row_wholes, &row));
        /* another program changed the tables while this one ran */
        if (row.whole[1] != SRV_SCHEMA) {
            store->settled = 0;
            store->failed = 1;
            return srv_schema_other(store->sql, row.whole[1]);
        }
        store->now = row.whole[0];
    }
    assert(store->now > 0);
    *now = store->now++;
    return SRV_STORED;
}

enum srv_stored srv_store_bytes(struct srv_store *store, enum srv_statement id, const char *name,
                                srv_whole_fn *whole, void **data, size_t *bytes) {
    struct srv_row_bytes row = {.name = name, .whole = whole};
    *data = NULL;
    *bytes = 0;
    SRV_STORED_TRY(srv_store_look(store));
    enum srv_stored stored = SRV_RUN(store, id, srv_row_bytes, &row, name);
    if (stored == SRV_STORED && !row.data) stored = SRV_STORED_NONE;
    stored = srv_store_end(store, stored);
    if (stored == SRV_STORED) {
        *data = row.data;
        *bytes = row.bytes;
    } else
        free(row.data);
    return stored;
}

/* runs a call; repeats it if the disk was full (the first attempt may free space), if the answer to
 * its commit was lost, and once if the connection was found to be lost */
static void store_single(struct srv_store *store, struct srv_store_call *call) {
    for (int64_t i = 0, begun = srv_clock_now(); i < TRIES; i++) {
        call->stored = call->run(store, call);
        if (call->stored == SRV_STORED_AWAY && store->unsure) {
            nanosleep(&(struct timespec){.tv_nsec = UNSURE_NS}, NULL);
            continue;
        }
        int once = call->stored == SRV_STORED_FULL ||
                   (call->stored == SRV_STORED_AWAY && srv_clock_now() - begun < LOST_NS);
        if (call->stored != SRV_STORED_AGAIN && (i || !once)) break;
    }
}

/* runs the calls of a batch; SRV_STORED if all are committed */
static enum srv_stored store_batch(struct srv_store *store, struct srv_store_call *const calls[],
                                   int count) {
    SRV_STORED_TRY(store_open(store));
    // the parts that the batch will finish, if reading their rows at once pays
    struct srv_store_ahead *ahead = &store->ahead;
    for (int i = 0; i < count && store->sql->driver->lists && ahead->leases < SRV_STORE_AHEAD; i++)
        if (calls[i]->finish && calls[i]->finish->parts == 1)
            ahead->lease[ahead->leases++] = calls[i]->finish;
    if (ahead->leases == 1) ahead->leases = 0;
    store->together = 1;
    for (int i = 0; i < count && !store->failed; i++) {
        calls[i]->stored = calls[i]->run(store, calls[i]);
        store->failed |= store->wrote && calls[i]->stored >= SRV_STORED_FULL;
    }
    store->together = 0;
    if (!store->failed) return store_commit(store);
    SRV_RUN(store, SQL_ROLLBACK, NULL, NULL);
    return SRV_STORED_AGAIN;
}

void srv_store_together(struct srv_store *store, struct srv_store_call *const calls[], int count) {
    assert(store_valid(store) && !store->together && !store->looking);
    int done = count > 1 && store->settled && store_batch(store, calls, count) == SRV_STORED;
    for (int i = 0; i < count && !done; i++) store_single(store, calls[i]);
    store->unsure = 0;
    if (store->crowded[0]) srv_store_fold(store, store->crowded);
    store->crowded[0] = '\0';
}
