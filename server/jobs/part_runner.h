/* Jobs computed by the workers: parts are claimed from the store, run in turns on the queue's
 * lowest level, and kept.
 * Leaves to others: what a part computes (api/call/part), who may hold it (store), the threads
 * (workers, storage).
 * Invariant: a part is kept by the attempt that holds its lease, or not at all; whoever waits
 * goes first. */
#ifndef SRV_PART_RUNNER_H
#define SRV_PART_RUNNER_H

#include "server/work/service.h"

struct srv_part_runner;

/**
 * A runner that does nothing yet.
 *
 * service  outlives it.
 * parts    that are held at a time, but for small ones; 0 = this process computes no jobs.
 *
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status srv_part_runner_new(struct srv_part_runner **runner,
                                                     struct srv_service *service, int parts);

/** Starts it, once service->storage is there. PEND_NO_MEMORY when its thread cannot be had. */
PEND_MUST_CHECK enum pend_status srv_part_runner_start(struct srv_part_runner *runner);

/** Frees a runner that was not started, or has drained. */
void srv_part_runner_free(struct srv_part_runner **runner);

/** There may be something to claim or to stop, by whomever. Any thread; the storage's news. */
void srv_part_runner_news(void *runner);

/** A job was dismissed in this process: what runs of it stops at its next turn. Any thread. */
void srv_part_runner_dismiss(struct srv_part_runner *runner, const char *job);

/** Seconds since when the store had nothing to compute and nothing was held here; 0 while there
 * is, or nobody knows. */
double srv_part_runner_idle(struct srv_part_runner *runner);

/**
 * Claims nothing more and gives back what runs, each at its next turn. To be called again every few
 * milliseconds.
 *
 * Returns 1 when nothing is held any more, or the store cannot be told: then the leases run out.
 */
int srv_part_runner_drain(struct srv_part_runner *runner);

#endif
