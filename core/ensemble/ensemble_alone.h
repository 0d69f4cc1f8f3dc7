/* Members whose joints may stick or hit stops: they run one after the other in the loop of pieces.
 * Leaves to others: the members' order and delivery (ensemble), the loop (core/integrate/pieces).
 * Invariant: the current member is in the workspace's `member` and in seat 0. */
#pragma once

#include "core/ensemble/ensemble_work.h"

/**
 * Rejects requests that pieces do not support. With controllers: exponents and horizons. With
 * joints that stick or hit stops: also negative durations, a bound, extremes and signs of forces.
 *
 * PEND_INVALID  error names an alternative.
 */
PEND_MUST_CHECK enum pend_status
pend_ensemble_alone_check(const struct pend_ensemble_problem *problem, struct pend_error *error);

/** Cancels the current member, if there is one. */
void pend_ensemble_alone_close(struct pend_ensemble *e);

/** Fills e->member with the tree's own numbers and with zeros, then with the start of member i. */
void pend_ensemble_fetch(struct pend_ensemble *e, long i, struct ensemble_queue *queue);

/**
 * Takes a step of the current member, or starts the next member. Reports its passages and rows and,
 * at its end, its outcome. A member that starts beyond a stop gets the status PEND_INVALID.
 *
 * PEND_NO_MEMORY  other failures become the member's status.
 */
PEND_MUST_CHECK enum pend_status pend_ensemble_alone_step(struct pend_ensemble *e,
                                                          struct ensemble_queue *queue);
