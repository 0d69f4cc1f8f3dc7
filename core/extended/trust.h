/* How long the digits of a trajectory hold: the same problem by its method and in 32 digits,
 * instant by instant.
 * Leaves to others: the samples that are answered (run).
 * Invariant: both runs see the same start, instants and limits; none is a step ahead of what is
 * compared but a block.
 */
#ifndef PEND_TRUST_H
#define PEND_TRUST_H

#include "core/integrate/method.h"

struct pend_trust;

/**
 * Prepares a comparison.
 *
 * trust      out; NULL on failure; ends with pend_trust_free.
 * method     the one whose digits are in doubt; its problem is solved anew. One of 32 digits is
 *            compared with itself at another tolerance and order: that ends no later than the
 *            digits of the less exact of the two.
 * problem    copied; its tree and its list of instants must outlive the comparison.
 * tolerance  rad, > 0: how far angles may be off.
 *
 * PEND_NO_MEMORY, and what pend_run_new returns.
 */
PEND_MUST_CHECK enum pend_status pend_trust_new(struct pend_trust **trust,
                                                const struct pend_method *method,
                                                const struct pend_problem *problem,
                                                double tolerance, struct pend_error *error);

/** Frees it and clears the pointer; NULL is accepted. */
void pend_trust_free(struct pend_trust **trust);

/**
 * Compares on, until the two have parted, the last instant is reached, or `work` is used up.
 *
 * work  about how many arm-evaluations to spend on each of the two before coming back.
 * done  set non-zero when there is nothing more to find out.
 *
 * What pend_run_next returns, of either run; that one has failed stays so.
 */
PEND_MUST_CHECK enum pend_status pend_trust_next(struct pend_trust *trust, double work, int *done,
                                                 struct pend_error *error);

/** The last instant up to which every angle was within the tolerance, s: among those compared so
 * far. */
double pend_trust_until(const struct pend_trust *trust);

/** How far both computations are, 0 .. 1. */
double pend_trust_progress(const struct pend_trust *trust);

/** Shows a checkpoint all that a comparison has in hand, as pend_run_carry. */
PEND_MUST_CHECK enum pend_status pend_trust_carry(struct pend_trust *trust,
                                                  struct pend_checkpoint *checkpoint);

#endif
