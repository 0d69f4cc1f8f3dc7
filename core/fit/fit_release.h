/* Active bounds of a fit: whether they remain active, and restarts from inside.
 * Leaves to others: the search (fit), inner numbers (fit_bounds).
 * Invariant: a bound is released only if the sum of squares decreases inwards. */
#pragma once

#include "core/fit/fit_state.h"

/** Removes unknowns from `held` if the sum of squares decreases inwards; gain: its decrease by a
 * step of all that are not fixed. After pend_fit_state_free. PEND_NO_MEMORY  O(measurements
 * unknowns^2).
 */
PEND_MUST_CHECK enum pend_status pend_fit_release_let(struct pend_fit *fit, double *gain);

/**
 * Takes the step to the minimum within the bounds predicted by the slopes, or a fraction of that
 * step. This is needed because inner numbers approach a bound only slowly. An unknown that reaches
 * its bound, or approaches it to a thousandth of its standard error, is fixed there, and the others
 * are adjusted. No effect if the sum of squares is flat.
 *
 * squares   the sum of squares of all rows; is lowered.
 * variance  of a residual; the covariance is that of pend_fit_state_free.
 * put       out: non-zero if there is another active bound, or the sum of squares is lower.
 *
 * PEND_NO_MEMORY  four motions at most.
 */
PEND_MUST_CHECK enum pend_status pend_fit_release_put(struct pend_fit *fit, double *squares,
                                                      double variance, int *put);

/** Moves unknowns at bounds inside, by their inner numbers: released ones by a Gauss-Newton step,
 * with `all` every unknown by its standard error, or to its initial value. variance: of a residual;
 * the covariance is that of pend_fit_state_free. Returns their number. O(measurements unknowns). */
int pend_fit_release_move(struct pend_fit *fit, int all, double variance);

/** Computes initial inner numbers. An unknown whose start is at a bound is moved inside by its
 * uncertainty from the first `rows`. PEND_NO_MEMORY  one motion if a start is at a bound. */
PEND_MUST_CHECK enum pend_status pend_fit_release_begin(struct pend_fit *fit, long rows);
