/* Exchanges that need a computation: from the cache, by joining one under way, or through the
 * queue, api_call and back.
 * Leaves to others: the threads (workers), their order (queue), who shares what (inflight), what
 * is computed (api), who is told (the exchange's finish).
 * Invariant: every exchange that comes in goes out through its finish, once; a stream's finish
 * comes again for each pause. */
#ifndef SRV_COMPUTE_H
#define SRV_COMPUTE_H

#include "server/work/exchange.h"

/**
 * Queues an exchange whose route names an operation; it comes back through its finish, answered.
 * Where the queue has no room that happens before this returns, with a 503 or a 429.
 */
void srv_compute_begin(struct srv_exchange *exchange);

/**
 * Ends the waiting of an exchange that was queued, or the reading of a stream; the computation ends
 * too where nobody else waits for it. The exchange's finish is called where the connection waits
 * for that, now or, while a worker reads the request, soon.
 *
 * Any thread; may be called for an exchange that is answered already, and does nothing then.
 */
void srv_compute_leave(struct srv_exchange *exchange, enum srv_stop why);

#endif
