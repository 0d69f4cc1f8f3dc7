/* A call on the store: its transaction, alone or among others of a batch, and its statements.
 * Leaves to others: the work of a call (store_jobs, store_leases, store_sweep, store_scenes).
 * Invariant: between begin and end a call's writes are kept or discarded together; no call
 * begins before the tables are known. */
#pragma once

#include "server/store/store_tally.h"

enum { SRV_STORE_AHEAD = 128, SRV_STORE_FLOORS = 64 };

/* The stored state of a claimed part. */
struct srv_store_held {
    struct srv_job job;
    long part_state, attempt;
};

/* The rows of the parts of single-part jobs that a batch is about to finish. One statement locks
 * and reads them when the first is needed. A row is used once. It stays valid while only finish,
 * claim and submit calls write: they never change a job whose only part another worker holds. */
struct srv_store_ahead {
    int leases, rows, read;
    const struct srv_lease *lease[SRV_STORE_AHEAD];
    struct srv_store_held held[SRV_STORE_AHEAD]; /* `rows` of them */
};

struct srv_store {
    struct srv_sql *sql;
    struct srv_store_rules rules;
    int looking;  /* the current call has no transaction */
    int together; /* the transaction of a batch is open */
    int settled;  /* the tables exist with this version's schema */
    int wrote;    /* the current call has written */
    int failed;   /* a statement of the transaction, or a call that had written, has failed */
    int unsure;   /* a commit was sent but its answer was lost: calls check whether they took
                     effect before they repeat anything */
    int ring;     /* pending notifications, SRV_RING_ bits */
    char crowded[SRV_NAME_BYTES]; /* a client with many changes not yet added to its row; "" = none
                                   */
    /* start of the next search for claims of a client, see claim_look */
    struct srv_store_floor {
        char client[SRV_NAME_BYTES];
        int64_t rank, full_ns, rest_ns; /* times: of the next look at all ranks, at the latest, and
                                           at the earliest */
    } floor[SRV_STORE_FLOORS];
    long workers;      /* processes that compute, at the last reading of figures; 0 = unknown */
    int64_t mended_ns; /* when a claim that found nothing last checked the sums */
    int64_t now;       /* us by the store's clock in this transaction; 0 = not read yet */
    struct srv_tally tally;
    struct srv_store_ahead ahead; /* empty unless a batch runs */
    struct {
        int64_t from; /* us: all jobs that expired earlier are deleted, except those locked by other
                         processes */
        int64_t seen; /* us by the store's clock at the last sweep; 0 = none yet */
        int64_t seen_ns; /* the same instant by the monotonic clock, ns */
        int64_t hold_ns; /* no job expires before this instant of the monotonic clock */
    } expiry;
};

/** Creates the tables if necessary, once the database is reachable. */
enum srv_stored srv_store_settle(struct srv_store *store);

/** Begins a call, with a transaction of its own unless it is one of a batch. */
enum srv_stored srv_store_begin(struct srv_store *store);

/** Begins a call that only reads, without a transaction unless it is one of a batch: each statement
 * sees what is committed when it runs, and no writer waits for it. */
enum srv_stored srv_store_look(struct srv_store *store);

/** Ends a call: its writes are kept if `stored` is SRV_STORED, and discarded otherwise. Returns
 * `stored`, or the error of the commit. If a call of a batch has writes to discard, the batch ends,
 * and its calls are run one by one. */
enum srv_stored srv_store_end(struct srv_store *store, enum srv_stored stored);

/** Adds a client's pending changes to its row; a call of its own. */
enum srv_stored srv_store_fold(struct srv_store *store, const char *name);

/** Runs a statement; `row`, if not NULL, is called for each row of the result. */
enum srv_stored srv_store_run(struct srv_store *store, enum srv_statement id,
                              const struct srv_value value[], int count, srv_row_fn *row,
                              void *context);

/**
 * Reads the store's clock, us since 1970, once per transaction; each further call returns a
 * microsecond more.
 *
 * SRV_STORED_BROKEN  another program has changed the tables while this one ran.
 */
enum srv_stored srv_store_now(struct srv_store *store, int64_t *now);

/** As srv_store_run, for a statement whose rows are not needed. Its failure may be reported by a
 * later statement, or at the end of the call. */
enum srv_stored srv_store_post(struct srv_store *store, enum srv_statement id,
                               const struct srv_value value[], int count);

/* Runs, or posts, a statement with the values that are listed at the end. */
#define SRV_RUN(store, id, row, context, ...)                                                      \
    srv_store_run((store), (id), SRV_VALUES(__VA_ARGS__), (row), (context))
#define SRV_POST(store, id, ...) srv_store_post((store), (id), SRV_VALUES(__VA_ARGS__))

/** A whole call: runs a statement with one parameter and returns one field of bytes, malloc'ed,
 * after `whole` has verified it. */
enum srv_stored srv_store_bytes(struct srv_store *store, enum srv_statement id, const char *name,
                                srv_whole_fn *whole, void **data, size_t *bytes);
