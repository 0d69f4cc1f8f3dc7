/* Storage of the results of parts; currently rows of the database.
 * Leaves to others: who may write them (store_leases), when they are deleted (store_sweep).
 * Invariant: a result is visible once its transaction is committed, never before. */
#pragma once

#include "server/store/store_call.h"

/* A storage of results. Its functions run within a call that has begun. */
struct srv_blobs {
    /** Stores the result of a leased part. */
    enum srv_stored (*put)(struct srv_store *store, const struct srv_lease *lease, const char *data,
                           size_t bytes);
    /** Reads a chunk as srv_store_chunk; *bytes stays 0 if it is damaged. */
    enum srv_stored (*get)(struct srv_store *store, const char *job, long part, long chunk,
                           void *data, size_t *bytes);
    /** Deletes results of a job. more: out, 1 = some remain; NULL: they are small, delete all. */
    enum srv_stored (*drop)(struct srv_store *store, const char *job, int *more);
};

extern const struct srv_blobs srv_blobs_rows;
