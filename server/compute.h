/* Exchanges that need a worker: into the queue, through api_call piece by piece, and out as an answer.
 * Leaves to others: the threads (workers), what is computed (api), who is told (the exchange's finish).
 * Invariant: every exchange that comes in goes out through its finish, once. */
#ifndef SRV_COMPUTE_H
#define SRV_COMPUTE_H

#include "server/exchange.h"

/**
 * Queues an exchange whose route names an operation; it comes back through its finish, answered. Where the queue has no
 * room that happens before this returns, with a 503.
 */
void srv_compute_queue(struct srv_exchange *exchange);

/**
 * Ends the waiting or the computation of an exchange that was queued and whose finish was not called yet; the caller
 * sees to the latter. It comes back soon: at once if it was waiting, else after the piece that is under way.
 */
void srv_compute_stop(struct srv_exchange *exchange, enum srv_stop why);

#endif
