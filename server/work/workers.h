/* The threads that compute, and one that reads long bodies. Reading a body cannot be interrupted
 * for other tasks, so it does not occupy a worker.
 * Leaves to others: the computation (a task's run), the order (queue).
 * Invariant: a worker waits only for the queue. */
#pragma once

#include "server/work/fairness.h"

struct srv_workers;

/** Returns the number of processors that this process may use, at least 1. */
int srv_workers_default(void);

/**
 * Starts threads that take tasks from the queue and run them, and the reader.
 *
 * count   threads, >= 1.
 * queue   outlives the workers.
 * fairness  of the same queue; outlives the workers; NULL = none.
 *
 * PEND_NO_MEMORY  also if the threads cannot be started; then no thread is running, and the queue
 * is closed.
 */
PEND_MUST_CHECK enum pend_status srv_workers_new(struct srv_workers **workers, int count,
                                                 struct srv_queue *queue,
                                                 struct srv_fairness *fairness);

/** Closes the queue, waits until every task in it was run, and ends the threads. */
void srv_workers_free(struct srv_workers **workers);
