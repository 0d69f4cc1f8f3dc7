/* Parts of jobs under leases: extending leases, finishing, failing and returning parts, and the
 * results.
 * Leaves to others: claiming parts (store_claims), jobs as a whole (store_jobs), when to look for
 * expired leases (store_sweep).
 * Invariant: a part's result is accepted once, from the attempt that holds it. */
#pragma once

#include "server/store/store_call.h"

/**
 * Returns at most SQL_PARTS_MOST parts to the queue, within a call.
 *
 * worker  the holder of the parts; NULL: parts with expired leases, which counts against them.
 * before  without a worker: only leases that expired before this instant, us by the store's clock.
 * sweep   counts the parts and jobs that changed.
 * found   out: number of parts found.
 */
enum srv_stored srv_store_back(struct srv_store *store, const char *worker, int64_t before,
                               struct srv_store_sweep *sweep, int *found);
