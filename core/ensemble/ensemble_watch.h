/* What happens inside a step of a member: crossings of the bound, forces at their largest and at
 * zero, rows on the way.
 * Leaves to others: which steps may hold such a thing (kernel_ensemble), where members start and
 * end (ensemble).
 * Invariant: what is found does not depend on where the steps begin and end, beyond rounding. */
#ifndef PEND_ENSEMBLE_WATCH_H
#define PEND_ENSEMBLE_WATCH_H

#include "core/ensemble/ensemble_work.h"

/** Prepares what is watched of lane i for the member that starts in it. O(n). */
void pend_ensemble_watch_start(struct pend_ensemble *e, int i);

/**
 * Notes the crossings in the step that lane i just took.
 *
 * Returns where in the step, from 0 to 1, the member is to end by them; infinity if it is not.
 */
double pend_ensemble_watch_bound(struct pend_ensemble *e, int i);

/** Notes the extremes and changes of sign of the forces up to `part` of the step, 0 < part <= 1. */
void pend_ensemble_watch_force(struct pend_ensemble *e, int i, double part);

/** Hands out the rows that lie in the step of lane i, no later than `until`, s. */
void pend_ensemble_watch_rows(struct pend_ensemble *e, int i, double until);

/** The state at `part` of the step of lane i, into the outcome's arrays. */
void pend_ensemble_watch_state(struct pend_ensemble *e, int i, double part);

/** Time at `part` of the step of lane i, s. */
double pend_ensemble_watch_time(const struct pend_ensemble *e, int i, double part);

#endif
