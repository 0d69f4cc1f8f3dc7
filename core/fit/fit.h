/* Parameters of a pendulum from measurements: least squares over its motion and the motion's
 * derivatives, by Levenberg and Marquardt's method with geodesic acceleration.
 * Leaves to others: reading data and naming parameters (api), the motion (core/derivatives).
 * Invariant: a converged fit is a minimum of the sum of squares within the bounds, to first or, if
 * the slopes are not sufficient, to second order, and its motion follows the data. */
#pragma once

#include "core/fit/fit_problem.h"

struct pend_fit;

/**
 * Prepares a fit; the first step evaluates the motion.
 *
 * fit  out; NULL on failure; released by pend_fit_free.
 *
 * PEND_INVALID    no unknowns, fewer measurements than unknowns, instants that decrease or
 *                 begin before the start of their run, rows out of order, a start outside its
 *                 bounds. PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status pend_fit_new(struct pend_fit **fit,
                                              const struct pend_fit_problem *problem,
                                              struct pend_error *error);
void pend_fit_free(struct pend_fit **fit);

/**
 * Takes one iteration.
 *
 * The fit starts with the first swing and adds later rows while the current values predict them,
 * because all rows of a chaotic motion have too many minima. An unknown that reaches a bound is
 * fixed there while the sum of squares decreases in that direction. The search restarts once from
 * inside all bounds; the lower minimum is kept. If the search does not converge within half of the
 * iterations, or the residuals are ten times the noise, it restarts by multiple shooting
 * (fit_pieces.h).
 *
 * done  out: non-zero once the result is complete.
 *
 * PEND_NO_MEMORY; the failures of pend_run_new for the start.
 */
PEND_MUST_CHECK enum pend_status pend_fit_step(struct pend_fit *fit, int *done,
                                               struct pend_error *error);

/** Returns the result, once it is complete. O(1). */
struct pend_fit_result pend_fit_result(const struct pend_fit *fit);

/** Returns the estimated fraction of the work that is done, 0 .. 1; it never falls, and is 0 until
 * the motion of all rows was computed. O(1). */
double pend_fit_progress(const struct pend_fit *fit);

/** Returns the approximate bytes of a fit. O(harmonics). */
double pend_fit_bytes(const struct pend_fit_problem *problem);
