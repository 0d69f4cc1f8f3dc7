/* Parameters of a pendulum from measurements: least squares over its motion, with the derivatives
 * of the motion, by Levenberg and Marquardt's method with geodesic acceleration.
 * Leaves to others: reading data and naming parameters (api), the motion (core/derivatives).
 * Invariant: a fit that is called converged is a minimum of the sum of squares, to first order, and
 * its motion follows the data. */
#ifndef PEND_FIT_H
#define PEND_FIT_H

#include "core/fit/fit_problem.h"

/* How a fit ended. */
enum pend_fit_end {
    PEND_FIT_CONVERGED,
    PEND_FIT_STRANGE, /* a minimum whose motion does not follow the data */
    PEND_FIT_STOPPED, /* the iterations were used up, or no step led down: no minimum */
};

enum { PEND_FIT_BLIND = 8 };

/* The outcome; all arrays belong to the fit. */
struct pend_fit_result {
    enum pend_fit_end end;
    long iterations, evaluations;
    const double *value; /* of the unknowns */
    const double *error; /* standard errors; infinite where the data do not tell, NaN of an unknown
                            that is at a bound */
    const double *correlation;    /* unknowns x unknowns; 0 where an error is not finite */
    const unsigned char *bounded; /* non-zero: at a bound */
    /* (model - data) / sigma, or in the data's unit where no sigma is known; [row * columns +
     * column], NaN where nothing was measured */
    const double *residual;
    double chi_squared;
    long freedom;     /* measurements less unknowns that were found */
    double follows;   /* s: the last row up to which the motion follows the data; NaN = none */
    double explained; /* 1 - sum of squares over that of the data about their mean */
    /* Directions that the data do not tell: relative changes of all unknowns together, the largest
     * of which is 1; [direction * unknowns + unknown]. */
    int blind;
    const double *direction;
};

struct pend_fit;

/**
 * Prepares a fit; the first step evaluates the motion.
 *
 * fit  out; NULL on failure; released by pend_fit_free.
 *
 * PEND_INVALID    no unknowns, fewer measurements than unknowns, instants that do not increase or
 *                 begin before `start`, a start that is not between its bounds.
 * PEND_NO_MEMORY
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
 * foretells them: a motion that is chaotic has too many minima otherwise.
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
