/* Parameters of a pendulum from measurements: least squares over its motion, with the derivatives
 * of the motion, by Levenberg and Marquardt's method with geodesic acceleration.
 * Leaves to others: reading data and naming parameters (api), the motion (core/derivatives).
 * Invariant: a fit that is called converged is a minimum of the sum of squares, to first order or,
 * where the slopes do not say it, to second, that no bound holds wrongly, and its motion follows
 * the data. */
#ifndef PEND_FIT_H
#define PEND_FIT_H

#include "core/fit/fit_problem.h"
#include "core/fit/fit_result.h"

struct pend_fit;

/**
 * Prepares a fit; the first step evaluates the motion.
 *
 * fit  out; NULL on failure; released by pend_fit_free.
 *
 * PEND_INVALID    no unknowns, fewer measurements than unknowns, instants that decrease or
 *                 begin before the start of their run, rows out of their order, a start that is
 * beyond its bounds. PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status pend_fit_new(struct pend_fit **fit,
                                              const struct pend_fit_problem *problem,
                                              struct pend_error *error);

/** Frees a fit and clears the pointer; NULL is accepted. */
void pend_fit_free(struct pend_fit **fit);

/**
 * Takes one iteration.
 *
 * The fit begins with the first swing and takes in later rows as far as what it has found so far
 * foretells them: a motion that is chaotic has too many minima otherwise. An unknown that runs into
 * a bound is put there, and stays as long as the sum of squares falls that way; once, the search
 * goes on from inside of all bounds, and the lower minimum is kept. One that does not converge by
 * half of the iterations, or where the residuals are ten times the noise, begins again by multiple
 * shooting, from what quarters of the first swings say together, where every one of at most 8 arms
 * is seen often enough, no mode is counted, the camera's shift is known and there is one run.
 *
 * done  out: non-zero once the result is there.
 *
 * PEND_NO_MEMORY; what pend_run_new says of the start.
 */
PEND_MUST_CHECK enum pend_status pend_fit_step(struct pend_fit *fit, int *done,
                                               struct pend_error *error);

/** Returns the result, once it is there. O(1). */
struct pend_fit_result pend_fit_result(const struct pend_fit *fit);

/** Returns how much of the data the fit has taken in, 0 .. 1. O(1). */
double pend_fit_progress(const struct pend_fit *fit);

/** Returns the bytes that a fit takes, about. O(harmonics). */
double pend_fit_bytes(const struct pend_fit_problem *problem);

/** Returns true if the invariants hold. O(1). For assertions. */
int pend_fit_valid(const struct pend_fit *fit);

#endif
