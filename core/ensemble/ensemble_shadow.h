/* The neighbour of a member, from which its largest Lyapunov exponent is estimated.
 * Leaves to others: the steps, which both take together (kernel_ensemble).
 * Invariant: the neighbour stays near enough for a linear law, and far enough to be told from
 * rounding. */
#ifndef PEND_ENSEMBLE_SHADOW_H
#define PEND_ENSEMBLE_SHADOW_H

#include "core/ensemble/ensemble_work.h"

/** Puts the neighbour of the member that starts in lane i into lane i + 1. O(n). */
void pend_ensemble_shadow_start(struct pend_ensemble *e, int i);

/**
 * After a step of lane i: brings the neighbour back to the first distance, along the line to it,
 * once that has changed much. O(n).
 */
void pend_ensemble_shadow_step(struct pend_ensemble *e, int i);

/** 1/s: the logarithm of the neighbour's growth up to the end of the step, over the time; NaN
 * where that is 0. */
double pend_ensemble_shadow_exponent(const struct pend_ensemble *e, int i);

#endif
