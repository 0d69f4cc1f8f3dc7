/* A fit under way, and how it looks at the data with the values that it has.
 * Leaves to others: the search (fit), what is told at its end (fit_end), bounds (fit_release).
 * Invariant: slopes and residuals are those of the last look; one block of memory. */
#pragma once

#include "core/fit/fit_alone.h"
#include "core/fit/fit_model.h"
#include "core/fit/fit_pieces.h"
#include "core/fit/fit_result.h"
#include "core/fit/fit_told.h"

struct fit_search; /* the library's part of a search */

struct pend_fit {
    struct pend_fit_problem problem;
    struct fit_model model;
    struct fit_search *search;
    long window;             /* rows taken in */
    long reached;            /* the most that were */
    int here;                /* iterations in this window */
    int begun, ready;        /* the workspace is at the window; the result is there */
    enum pend_status status; /* of the last evaluation at an iterate */
    int starved;             /* memory was refused: no result is what it would have been */
    struct pend_error failure;
    double *inner, *value, *error, *correlation, *residual, *slope, *direction, *covariance, *size;
    double *follows, *spread;  /* of each run, of each column */
    double lag[2];             /* the residuals' autocorrelations */
    double swing;              /* s, about the time of one */
    double *origin;            /* inner numbers where the search began */
    struct fit_pieces *pieces; /* while the motion is looked at in pieces */
    int apt, cut;              /* it can be, or has runs; it was, or they were alone */
    struct fit_alone *alone;   /* while runs are fitted alone */
    struct pend_fit *single;   /* the search of that one */
    double *found, told;       /* inner numbers that runs found; what the best of them explained */
    double *best;              /* inner numbers of the lowest sum of squares of all rows */
    double least;              /* that sum; infinite before there is one */
    double variance;           /* of a residual of all rows at the last look; 0 = not known */
    int inside;                /* unknowns at bounds were begun again inside */
    int anew;                  /* the search began again where a fall was foretold */
    unsigned char *bounded, *held; /* at a bound; for the last look, counted as constant */
    signed char *edge, *edged;     /* put to its low bound, -1, or its high one, 1; at `best` */
    struct pend_fit_result result;
};

/** The value of an unknown at an inner number, or its bound where it was put there. O(1). */
double pend_fit_state_outer(const struct pend_fit *fit, int j, double inner);

/** Says of a motion that is not there, or takes too many steps, what that means for a fit, and the
 * way out. Returns the status. */
enum pend_status pend_fit_state_wild(const struct pend_fit *fit, enum pend_status status,
                                     struct pend_error *error);

/** Says why what is told by slopes could not be had: memory, or slopes that are no numbers. Returns
 * the status. */
enum pend_status pend_fit_state_lost(enum pend_status status, struct pend_error *error);

/** Slopes and residuals of the first rows at the fit's inner numbers; the unknowns that are at
 * bounds are `held`. What pend_fit_model_at says. */
PEND_MUST_CHECK enum pend_status pend_fit_state_look(struct pend_fit *fit, long rows,
                                                     struct pend_error *error);

/** The sum of squares of the first rows of the last look, and how many measurements are in them.
 * O(measurements). */
double pend_fit_state_squares(const struct pend_fit *fit, long rows, long *count);

/** Variance of a residual: 1 where every sigma is known, else as large as it is. O(columns). */
double pend_fit_state_variance(const struct pend_fit *fit, double squares, long freedom);

/** Whether all standard deviations are known. O(columns). */
int pend_fit_state_known(const struct pend_fit *fit);

/** What the slopes and residuals of the last look tell, `held` unknowns being constant. As
 * pend_fit_told_init. */
PEND_MUST_CHECK enum pend_status pend_fit_state_tell(const struct pend_fit *fit,
                                                     struct fit_told *told);

/**
 * The covariance as it is where no unknown were held by a bound: the one that is there is as
 * uncertain as the data leave it, and the others with it. Where the data do not tell it apart from
 * others it is that of what is held. Then says which are there: `bounded`, and `held` the same.
 *
 * PEND_NOT_FINITE, PEND_NO_MEMORY  as pend_fit_told_init.
 */
PEND_MUST_CHECK enum pend_status pend_fit_state_free(struct pend_fit *fit);

/** Whether nothing that a step may gain, `gain`, is worth it: less than a millionth of the sum of
 * squares of all rows, or of one measurement's own, or a step of less than a hundredth of its
 * standard error. O(measurements). */
int pend_fit_state_flat(const struct pend_fit *fit, double gain, double squares);

/** The measurements' own squares: of a column of one, whose mean says nothing, there is no other
 * scale. O(measurements). */
double pend_fit_state_size(const struct pend_fit *fit);

/** The sum of squares of the data about their mean, or what is left of it by rounding; angles by
 * whole turns less, as residuals are. O(measurements). */
double pend_fit_state_total(const struct pend_fit *fit);
