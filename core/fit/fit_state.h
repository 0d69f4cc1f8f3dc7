/* The state of a running fit, and the evaluation of the model at its current values.
 * Leaves to others: the search (fit), the result (fit_end), bounds (fit_release). Invariant: slopes
 * and residuals are those of the last evaluation; the state is one block of memory. */
#pragma once

#include "core/fit/fit_model.h"
#include "core/fit/fit_pieces.h"
#include "core/fit/fit_told.h"

struct fit_search; /* the state of GSL's solver */

struct pend_fit {
    struct pend_fit_problem problem;
    struct fit_model model;
    struct fit_search *search;
    long window;             /* number of rows in the window */
    int here;                /* number of iterations in this window */
    int begun, ready;        /* the solver works on this window; the result is complete */
    enum pend_status status; /* status of the last evaluation of the search's current point */
    int starved;             /* an allocation failed, so no result is valid */
    struct pend_error failure;
    double *inner, *value, *error, *correlation, *residual, *slope, *direction, *covariance, *size;
    double *follows, *spread;  /* one number per run; one number per column */
    double lag[2];             /* the residuals' autocorrelations */
    double swing;              /* s, approximate time of a swing */
    double *origin;            /* inner numbers at the start of the search */
    struct fit_pieces *pieces; /* multiple shooting while it runs */
    int apt, cut;              /* whether multiple shooting or separate fits of runs are possible;
                                * whether one of them was used */
    struct fit_alone *alone;   /* the run that is fitted separately */
    struct pend_fit *single;   /* the search of that run */
    double *found, told;       /* inner numbers found for the separate runs; fraction explained by
                                * the best of them */
    double *best;              /* inner numbers at the lowest sum of squares of all rows so far */
    double least;              /* the lowest sum of squares; infinite before there is one */
    double variance;           /* of a residual at the last evaluation of all rows; 0 = unknown */
    int inside;                /* unknowns at bounds were moved inside for a new search */
    int anew;                  /* the search was restarted for a predicted decrease */
    int clocked;               /* shifts of clocks were tried for all rows */
    unsigned char *bounded, *held; /* flags: at a bound; fixed in the last evaluation */
    signed char *edge, *edged;     /* which bound an unknown is fixed at: -1 low, 1 high; the same
                                    * at `best` */
    struct pend_fit_result result;
};

/** Returns the value of an unknown at an inner number, or its bound if it is fixed there. O(1). */
double pend_fit_state_outer(const struct pend_fit *fit, int j, double inner);

/** Sets the error for a motion that cannot be computed or takes too many steps, and suggests a
 * remedy. Returns the status. */
enum pend_status pend_fit_state_wild(const struct pend_fit *fit, enum pend_status status,
                                     struct pend_error *error);

/** Sets the error for slopes that cannot be decomposed (memory, not finite). Returns the status. */
enum pend_status pend_fit_state_lost(enum pend_status status, struct pend_error *error);

/** Computes slopes and residuals of the first rows at the fit's inner numbers; unknowns at bounds
 * become `held`. Errors as pend_fit_model_at. */
PEND_MUST_CHECK enum pend_status pend_fit_state_look(struct pend_fit *fit, long rows,
                                                     struct pend_error *error);

/** Returns the sum of squares of the first rows at the last evaluation, and the number of
 * measurements in them. O(measurements). */
double pend_fit_state_squares(const struct pend_fit *fit, long rows, long *count);

/** Returns the variance of a residual: 1 if every sigma is known, else an estimate. O(columns). */
double pend_fit_state_variance(const struct pend_fit *fit, double squares, long freedom);

/** Returns whether all standard deviations are known. O(columns). */
int pend_fit_state_known(const struct pend_fit *fit);

/** Decomposes the slopes of the last evaluation, with the `held` unknowns fixed. Errors as
 * pend_fit_told_init. */
PEND_MUST_CHECK enum pend_status pend_fit_state_tell(const struct pend_fit *fit,
                                                     struct fit_told *told);

/**
 * Computes the covariance as if no unknown were fixed at a bound, so that an unknown at a bound has
 * its own uncertainty. If the data cannot distinguish it from others, it stays fixed in the
 * covariance. Sets `bounded`, and `held` equal to it.
 *
 * PEND_NOT_FINITE, PEND_NO_MEMORY  as pend_fit_told_init.
 */
PEND_MUST_CHECK enum pend_status pend_fit_state_free(struct pend_fit *fit);

/** Returns whether a step's decrease of the sum of squares, `gain`, is negligible. It is if it is
 * below a millionth of the sum of squares of all rows, or of the measurement itself in a column
 * with one measurement, or if the step is below a hundredth of its standard error.
 * O(measurements). */
int pend_fit_state_flat(const struct pend_fit *fit, double gain, double squares);

/** Returns the sum of the squared measurements of columns with one measurement, whose mean gives no
 * scale. O(measurements). */
double pend_fit_state_size(const struct pend_fit *fit);

/** Returns the sum of squares of the data about their mean, at least its rounding error. Whole
 * turns are removed from angles, as in residuals. O(measurements). */
double pend_fit_state_total(const struct pend_fit *fit);
