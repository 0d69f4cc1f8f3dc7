/* The neighbour of a member; the growth of its distance gives the member's largest Lyapunov
 * exponent.
 * Leaves to others: the steps, which the member and its neighbour take together (kernel_ensemble).
 * Invariant: the distance is small enough for a linear law, and large enough to stand out from
 * rounding. */
#pragma once

#include "core/ensemble/ensemble_work.h"

/** Puts the neighbour of the member that starts in lane i into lane i + 1. O(n). */
void pend_ensemble_shadow_start(struct pend_ensemble *e, int i);

/** After a step of lane i: if the distance has changed much, moves the neighbour back to the
 * initial distance, along the line through both states. O(n). */
void pend_ensemble_shadow_step(struct pend_ensemble *e, int i);

/** Returns the logarithm of the growth of the neighbour's distance up to the end of the step,
 * divided by the time, 1/s; NaN if the time is 0. */
double pend_ensemble_shadow_exponent(const struct pend_ensemble *e, int i);
