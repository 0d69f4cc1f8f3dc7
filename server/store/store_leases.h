/* Parts of jobs under leases: extending leases, finishing, failing and returning parts, and the
 * results.
 * Leaves to others: claiming parts (store_claims), jobs as a whole (store_jobs), finding leases
 * that ran out (store_sweep).
 * Invariant: a part's result is accepted once, from the attempt that holds it. */
#ifndef SRV_STORE_LEASES_H
#define SRV_STORE_LEASES_H

#include "server/store/store_call.h"

/**
 * Returns parts to those that wait, in a call that has begun: SQL_PARTS_MOST at most.
 *
 * worker  the holder of the parts; or NULL: parts whose lease ran out, which counts against them.
 * before  and had run out by then, us by the store's clock; without a worker only.
 * sweep   counts the parts and jobs that changed.
 * found   out: the number of parts that were found.
 */
enum srv_stored srv_store_back(struct srv_store *store, const char *worker, int64_t before,
                               struct srv_store_sweep *sweep, int *found);

#endif
