/* Computes jobs: claims their parts from the store, runs them on the workers at the queue's last
 * level, and stores the results.
 * Leaves to others: what a part computes (api/call/part), leases (store), the threads
 * (workers, storage).
 * Invariant: the result of a part is stored only by the attempt that holds its lease; requests that
 * wait for a worker are computed first. */
#pragma once

#include "server/work/service.h"

struct srv_part_runner;

/**
 * Makes a runner, without its thread.
 *
 * service  outlives it.
 * parts    number of parts that are held at a time, not counting small ones; 0 = this process
 *          computes no jobs.
 *
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status srv_part_runner_new(struct srv_part_runner **runner,
                                                     struct srv_service *service, int parts);

/** Starts it, once service->storage is there. PEND_NO_MEMORY when its thread cannot be had. */
PEND_MUST_CHECK enum pend_status srv_part_runner_start(struct srv_part_runner *runner);

/** Frees a runner that was not started, or has drained. */
void srv_part_runner_free(struct srv_part_runner **runner);

/** True when a runner's counts are within their bounds; for assertions, under its lock. O(1). */
int srv_part_runner_valid(const struct srv_part_runner *runner);

/** Says that there may be parts to claim or jobs that have ended, in any process. Any thread; the
 * storage calls it. rings: bits of SRV_RING_. */
void srv_part_runner_news(struct srv_part_runner *runner, int rings);

/** Stops the parts of a job that was dismissed in this process, each at its next turn. Any thread.
 */
void srv_part_runner_dismiss(struct srv_part_runner *runner, const char *job);

/** Returns for how many seconds the store has had no part to compute and this process has held
 * none; 0 if there are parts, or the store does not answer. */
double srv_part_runner_idle(struct srv_part_runner *runner);

/**
 * Stops claiming and gives back the parts that are held, each at its next turn. To be called again
 * every few milliseconds.
 *
 * Returns 1 when no part is held, or the store is out of reach: then the leases run out.
 */
int srv_part_runner_drain(struct srv_part_runner *runner);
