/* Where the results of parts lie: today in rows of the database.
 * Leaves to others: who may write them (store_leases), when they go (store_sweep).
 * Invariant: what is put is there once the transaction is committed, and never before. */
#ifndef SRV_STORE_BLOBS_H
#define SRV_STORE_BLOBS_H

#include "server/store/store_call.h"

/* A place for results. Its functions are called in a call that has begun. */
struct srv_blobs {
    /** Keeps the result of a part that is held. */
    enum srv_stored (*put)(struct srv_store *store, const struct srv_lease *lease, const char *data,
                           size_t bytes);
    /** Reads a chunk as srv_store_chunk; *bytes stays 0 unless it is whole. */
    enum srv_stored (*get)(struct srv_store *store, const char *job, long part, long chunk,
                           void *data, size_t *bytes);
    /** Removes results of a job. more: out, 1 = only a piece of them has gone; NULL: they are
     * small, and all go. */
    enum srv_stored (*drop)(struct srv_store *store, const char *job, int *more);
};

extern const struct srv_blobs srv_blobs_rows;

#endif
