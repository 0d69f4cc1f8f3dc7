/* A call on the store: its transaction, alone or among others of a batch, and its statements.
 * Leaves to others: the work of a call (store_jobs, store_leases, store_sweep, store_scenes).
 * Invariant: between begin and end a call's writes are kept or discarded together; no call
 * begins before the tables are known. */
#ifndef SRV_STORE_CALL_H
#define SRV_STORE_CALL_H

#include "server/store/store_tally.h"

enum { SRV_STORE_AHEAD = 128 };

/* What the store says of a part that is held. */
struct srv_store_held {
    struct srv_job job;
    long part_state, attempt;
};

/* The rows of parts that a batch is going to end, of jobs of one part: locked and read by one
 * statement when the first of them is asked for. A row is good once, and as long as nothing was
 * written but by calls that finish, claim or submit: none of these changes a job whose only part
 * somebody else holds. */
struct srv_store_ahead {
    int leases, rows, read;
    const struct srv_lease *lease[SRV_STORE_AHEAD];
    struct srv_store_held held[SRV_STORE_AHEAD]; /* `rows` of them */
};

struct srv_store {
    struct srv_sql *sql;
    const struct srv_blobs *blobs; /* where results lie */
    struct srv_store_rules rules;
    int looking;  /* the call that runs has no transaction */
    int together; /* a batch's transaction is open */
    int settled;  /* the tables are there, as this version wants them */
    int wrote;    /* the call that runs has changed something */
    int failed;   /* a statement of the transaction has failed, or a call that has written something
                   */
    int unsure;   /* a commit was sent, and its answer was lost: its calls look whether they took
                     effect before they do anything again */
    int ring;     /* whom transactions that have ended are to wake, SRV_RING_ */
    char crowded[SRV_NAME_BYTES]; /* a client of which many changes are not in its row; "" = none */
    long workers;      /* processes that compute, when figures were last read; 0 = unknown */
    int64_t mended_ns; /* when sums were last looked at because a claim found nothing */
    int64_t now;       /* us by the store's clock, in this transaction; 0 = not known yet */
    struct srv_tally tally;
    struct srv_store_ahead ahead; /* empty unless a batch runs */
    struct {
        int64_t from; /* us: no job that expired before is left but those that other processes had
                         locked */
        int64_t seen; /* us by the store's clock at the last sweep, 0 = there was none */
        int64_t seen_ns; /* by the monotonic clock, then */
        int64_t hold_ns; /* no job expires before this instant of the monotonic clock */
    } expiry;
};

/** Returns true if a store has a driver, and its call and its batch do not contradict each other.
 * O(1). */
int srv_store_valid(const struct srv_store *store);

/** Makes the tables where there are none, once the database can be reached. */
enum srv_stored srv_store_settle(struct srv_store *store);

/** Begins a call, with a transaction of its own unless it is one of a batch. */
enum srv_stored srv_store_begin(struct srv_store *store);

/** Begins a call of one statement, which reads: without a transaction where a statement is one by
 * itself. */
enum srv_stored srv_store_look(struct srv_store *store);

/**
 * Ends a call: what it wrote stays if `stored` is SRV_STORED, and goes otherwise. Returns `stored`,
 * or why it could not be ended. A call of a batch that wrote something which is to go ends the
 * batch: its calls are then run one by one.
 */
enum srv_stored srv_store_end(struct srv_store *store, enum srv_stored stored);

/** Puts the changes of a client that are not in its row yet into it; a call of its own. */
enum srv_stored srv_store_fold(struct srv_store *store, const char *name);

/** Runs a statement; row is called for each row that it answers with, or NULL. */
enum srv_stored srv_store_run(struct srv_store *store, enum srv_statement id,
                              const struct srv_value value[], int count, srv_row_fn *row,
                              void *context);

/**
 * The store's clock, us since 1970: read once in a transaction, and a microsecond later at every
 * call.
 *
 * SRV_STORED_BROKEN  another program has changed the tables while this one ran.
 */
enum srv_stored srv_store_now(struct srv_store *store, int64_t *now);

/**
 * As srv_store_run, of a statement whose rows are of no interest: its failure may be that of a
 * later one, or of the call's end.
 */
enum srv_stored srv_store_post(struct srv_store *store, enum srv_statement id,
                               const struct srv_value value[], int count);

/* Run, or post, a statement with the values that are listed at the end. */
#define SRV_RUN(store, id, row, context, ...)                                                      \
    srv_store_run((store), (id), SRV_VALUES(__VA_ARGS__), (row), (context))
#define SRV_POST(store, id, ...) srv_store_post((store), (id), SRV_VALUES(__VA_ARGS__))

/** A whole call of one statement, of one parameter, that answers with one field of bytes:
 * malloc'ed, the caller's; and with what `whole` judges them by. */
enum srv_stored srv_store_bytes(struct srv_store *store, enum srv_statement id, const char *name,
                                srv_whole_fn *whole, void **data, size_t *bytes);

#endif
