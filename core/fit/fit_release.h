/* Bounds that hold a fit: whether they do rightly, and where a search goes on within.
 * Leaves to others: the search (fit), inner numbers (fit_bounds).
 * Invariant: a bound is let go of only where the sum of squares falls inwards. */
#ifndef PEND_FIT_RELEASE_H
#define PEND_FIT_RELEASE_H

#include "core/fit/fit_state.h"

/**
 * Takes unknowns out of `held` whose slope leads inwards: a bound holds nothing there.
 *
 * gain  out: what a step of all unknowns that are not held could take from the sum of squares.
 *
 * After pend_fit_state_free. PEND_NO_MEMORY  O(measurements unknowns^2).
 */
PEND_MUST_CHECK enum pend_status pend_fit_release_let(struct pend_fit *fit, double *gain);

/**
 * Takes the step to the least of the sum of squares within the bounds, as the slopes foretell it,
 * or a part of it: inner numbers only creep up to a bound, and along a narrow valley towards one.
 * An unknown that reaches its bound, or comes to within a thousandth of its standard error, stays
 * there, and the others go along with it. Nothing is done where the sum of squares is flat.
 *
 * squares   the sum of squares of all rows; is lowered.
 * variance  of a residual; the covariance is that of pend_fit_state_free.
 * put       out: non-zero if there is a bound more, or the sum of squares is lower.
 *
 * PEND_NO_MEMORY  four motions at most.
 */
PEND_MUST_CHECK enum pend_status pend_fit_release_put(struct pend_fit *fit, double *squares,
                                                      double variance, int *put);

/**
 * Puts unknowns at bounds inside, by their inner numbers: those that are no longer held as far as
 * the data lead to first order, `all` of them as far as their standard error, or to where they
 * began.
 *
 * variance  of a residual; the covariance is that of pend_fit_state_free.
 *
 * Returns how many were moved. O(measurements unknowns).
 */
int pend_fit_release_move(struct pend_fit *fit, int all, double variance);

/**
 * Inner numbers to begin with. An unknown whose start is at a bound begins inside, as far as the
 * first `rows` leave it unknown there.
 *
 * PEND_NO_MEMORY  one motion where a start is at a bound.
 */
PEND_MUST_CHECK enum pend_status pend_fit_release_begin(struct pend_fit *fit, long rows);

#endif
