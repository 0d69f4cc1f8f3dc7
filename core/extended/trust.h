/* The time up to which a trajectory is accurate: the same problem is solved by the method and in 32
 * digits, and both solutions are compared at every requested instant.
 * Leaves to others: the samples of the response (run).
 * Invariant: both runs have the same start, instants and limits; each is at most one block ahead of
 * the comparison. */
#pragma once

#include "core/integrate/methods/method.h"

struct pend_trust;

/**
 * Prepares a comparison.
 *
 * trust      out; NULL on failure; released by pend_trust_free.
 * method     the method whose digits are checked. A method of 32 digits is compared with itself at
 *            another tolerance and order; the comparison then ends when the less accurate run
 *            exceeds the tolerance.
 * problem    copied; its tree and its list of instants must outlive the comparison.
 * tolerance  rad, > 0: the allowed error of angles.
 *
 * PEND_NO_MEMORY; also fails as pend_run_new does.
 */
PEND_MUST_CHECK enum pend_status pend_trust_new(struct pend_trust **trust,
                                                const struct pend_method *method,
                                                const struct pend_problem *problem,
                                                double tolerance, struct pend_error *error);
void pend_trust_free(struct pend_trust **trust);

/**
 * Continues the comparison until the two runs differ by more than the tolerance, the last instant
 * is reached, or `work` is used up.
 *
 * work  approximate number of arm-evaluations of each run in this call.
 * done  out: non-zero if the comparison is complete.
 *
 * The failures of pend_run_next, of either run; later calls return the same failure.
 */
PEND_MUST_CHECK enum pend_status pend_trust_next(struct pend_trust *trust, double work, int *done,
                                                 struct pend_error *error);

/** Returns the last compared instant, s, up to which every angle is within the tolerance. */
double pend_trust_until(const struct pend_trust *trust);

/** Returns the progress of the slower of the two runs, 0 .. 1. */
double pend_trust_progress(const struct pend_trust *trust);

/** Saves a comparison to a checkpoint or restores it; parameters and errors as pend_run_carry. */
PEND_MUST_CHECK enum pend_status pend_trust_carry(struct pend_trust *trust,
                                                  struct pend_checkpoint *checkpoint);
