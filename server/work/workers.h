/* The threads that compute, and one that reads long bodies: it shares the processors with them, so
 * that reading, which gives no turns, occupies no worker.
 * Leaves to others: what is computed (a task's run), in which order (queue).
 * Invariant: a worker waits for nothing but the queue. */
#ifndef SRV_WORKERS_H
#define SRV_WORKERS_H

#include "server/work/fairness.h"

struct srv_workers;

/** Processors that this process may use, at least 1. */
int srv_workers_default(void);

/**
 * Starts threads that take tasks from the queue and run them, and the reader.
 *
 * count   threads, >= 1.
 * queue   outlives the workers.
 * fairness  of the same queue; outlives the workers; NULL = none.
 *
 * PEND_NO_MEMORY  also when the threads cannot be had; no thread is left running then, and the
 * queue is closed.
 */
PEND_MUST_CHECK enum pend_status srv_workers_new(struct srv_workers **workers, int count,
                                                 struct srv_queue *queue,
                                                 struct srv_fairness *fairness);

/** Closes the queue, waits until every task in it was run, and ends the threads. */
void srv_workers_free(struct srv_workers **workers);

#endif
