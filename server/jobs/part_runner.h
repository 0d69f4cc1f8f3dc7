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
 * Creates a runner without its thread.
 *
 * service  must outlive it.
 * parts    number of parts that are held at a time, not counting small ones; 0 = this process
 *          computes no jobs.
 *
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status srv_part_runner_new(struct srv_part_runner **runner,
                                                     struct srv_service *service, int parts);

/** Starts the runner's thread; service->storage must exist. PEND_NO_MEMORY if the thread cannot be
 * created. */
PEND_MUST_CHECK enum pend_status srv_part_runner_start(struct srv_part_runner *runner);

/** Frees a runner that was not started, or has drained. */
void srv_part_runner_free(struct srv_part_runner **runner);

/** Notifies the runner that there may be parts to claim or jobs that have ended, in any process.
 * Any thread; called by the storage. rings: bits of SRV_RING_. */
void srv_part_runner_news(struct srv_part_runner *runner, int rings);

/** Stops the parts of a job that was dismissed in this process, each at its next turn. Any thread.
 */
void srv_part_runner_dismiss(struct srv_part_runner *runner, const char *job);

/** Returns for how many seconds the store has had no part to compute and this process has held
 * none; 0 if there are parts, or the store does not answer. */
double srv_part_runner_idle(struct srv_part_runner *runner);

/**
 * Stops claiming, and returns the held parts to the store, each at its next turn. To be called
 * again every few milliseconds.
 *
 * Returns 1 once no part is held, or if the store is unreachable: then the leases expire.
 */
int srv_part_runner_drain(struct srv_part_runner *runner);
