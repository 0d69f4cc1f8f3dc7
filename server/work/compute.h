/* Answers exchanges whose route names an operation: from the cache, by sharing another exchange's
 * computation, or by a task that runs api_call on a worker, a millisecond at a time.
 * Leaves to others: the threads (workers), the order of tasks (queue), sharing (inflight), sending
 * what was computed (delivery), the computation itself (api).
 * Invariant: `finish` is called exactly once for every exchange; for the reader of a stream once
 * more after each pause. */
#pragma once

#include "server/work/exchange.h"

/** Queues an exchange whose route names an operation, and whose account is set. Its finish is
 * called once it is answered: before this returns, with 503 or 429, if the queue is full. */
void srv_compute_begin(struct srv_exchange *exchange);

/**
 * Removes an exchange from its computation or its stream; a computation without waiting exchanges
 * ends too. If the connection waits for the exchange's `finish`, it is called now or, if a worker
 * is reading the request, by that worker.
 *
 * Any thread. No effect on an exchange that is answered already.
 */
void srv_compute_leave(struct srv_exchange *exchange, enum srv_stop why);
