/* A call on the store: its transaction, alone or among others of a batch, and its statements.
 * Leaves to others: what a call does (store_jobs, store_leases, store_sweep, store_scenes).
 * Invariant: between begin and end a call's writes stand or fall together; no call begins before the tables are known.
 */
#ifndef SRV_STORE_CALL_H
#define SRV_STORE_CALL_H

#include "server/store.h"
#include "server/store_statements.h"

struct srv_store {
    struct srv_sql *sql;
    struct srv_store_rules rules;
    int together; /* a batch's transaction is open: calls are savepoints in it */
    int settled;  /* the tables are there, as this version wants them */
};

/** Makes or migrates the tables, once the database can be reached. */
enum srv_stored srv_store_settle(struct srv_store *store);

/** Begins a call: a transaction of its own, or a savepoint in the batch's. */
enum srv_stored srv_store_begin(struct srv_store *store);

/** Ends a call: what it wrote stays or goes. Returns `stored`, or why it could not be ended. */
enum srv_stored srv_store_end(struct srv_store *store, int keep, enum srv_stored stored);

/** Runs a statement; row is called for each row that it answers with, or NULL. */
enum srv_stored srv_store_run(struct srv_store *store, enum srv_statement id, const struct srv_value value[], int count,
                              srv_row_fn *row, void *context);

/** Runs a statement that has neither values nor rows. */
enum srv_stored srv_store_plain(struct srv_store *store, enum srv_statement id);

/* Runs a statement with the values that are listed at the end. */
#define SRV_RUN(store, id, row, context, ...)                                                                          \
    srv_store_run((store), (id), (const struct srv_value[]){__VA_ARGS__},                                              \
                  (int)(sizeof(const struct srv_value[]){__VA_ARGS__} / sizeof(struct srv_value)), (row), (context))

/** A whole call of one statement, of one parameter, that answers with one field of bytes: malloc'ed, the caller's. */
enum srv_stored srv_store_bytes(struct srv_store *store, enum srv_statement id, const char *name, void **data,
                                size_t *bytes);

#endif
