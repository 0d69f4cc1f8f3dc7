/* Parts of jobs under leases: extended, finished or failed, given back; and the results.
 * Leaves to others: claiming them (store_claims), jobs as a whole (store_jobs), finding leases that
 * ran out (store_sweep).
 * Invariant: a part's result is taken once, from the attempt that holds it. */
#ifndef SRV_STORE_LEASES_H
#define SRV_STORE_LEASES_H

#include "server/store/store_call.h"

/**
 * Lets parts wait again, in a call that has begun: SQL_PARTS_MOST at most.
 *
 * worker  whose; or NULL: those whose lease ran out, which counts against them.
 * before  and had run out by then, us by the store's clock; without a worker only.
 * sweep   counts what became of them.
 * found   out: how many there were.
 */
enum srv_stored srv_store_back(struct srv_store *store, const char *worker, int64_t before,
                               struct srv_store_sweep *sweep, int *found);

#endif
