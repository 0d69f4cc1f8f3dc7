/* Members whose joints may stick or hit, one after the other through the loop of pieces.
 * Leaves to others: the members' order and delivery (ensemble), the loop (core/integrate/pieces).
 * Invariant: the member under way is in the workspace's `member` and in seat 0. */
#pragma once

#include "core/ensemble/ensemble_work.h"

/**
 * Refuses what is not computed for some motions in pieces: exponents and horizons with controllers;
 * for joints that stick or hit also times backward, a bound, forces' extremes and signs.
 *
 * PEND_INVALID  error names the way out.
 */
PEND_MUST_CHECK enum pend_status
pend_ensemble_alone_check(const struct pend_ensemble_problem *problem, struct pend_error *error);

/** Drops the member under way, if there is one. */
void pend_ensemble_alone_close(struct pend_ensemble *e);

/** Fills e->member with the tree's own numbers and zeros, then with the start of member i. */
void pend_ensemble_fetch(struct pend_ensemble *e, long i, struct ensemble_queue *queue);

/**
 * Takes a step of the member under way, or of the next one; reports its passages, its rows, and at
 * its end its outcome. A start beyond a stop has the status PEND_INVALID.
 *
 * PEND_NO_MEMORY  the other failures are the member's.
 */
PEND_MUST_CHECK enum pend_status pend_ensemble_alone_step(struct pend_ensemble *e,
                                                          struct ensemble_queue *queue);
