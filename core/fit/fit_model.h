/* What a pendulum with given values of its unknowns would have been measured as, and how that
 * changes with each of them.
 * Leaves to others: the minimum (fit).
 * Invariant: the problem is not changed; rows beyond the window are 0. */
#ifndef PEND_FIT_MODEL_H
#define PEND_FIT_MODEL_H

#include "core/fit/fit_problem.h"

/* Workspace of a model; one block. */
struct fit_model {
    const struct pend_fit_problem *problem;
    int parameters;                   /* unknowns that are the pendulum's */
    struct pend_parameter *parameter; /* of these */
    double *length, *mass, *value, *phi, *rate;
    double *t;                  /* `start` and the rows, or the rows */
    int before;                 /* 1 if `start` is before the first row */
    double *seen[3], *slope[3]; /* phi, x, y of a block of rows, and their derivatives */
    long block;
    int wants[3]; /* which of these are measured */
    double *room; /* of phi, x and y of plain samples, and their instants */
    double camera[PEND_FIT_CAMERA];
};

/** Makes a workspace in `memory`, or only counts its bytes where that is NULL. */
size_t pend_fit_model_lay(struct fit_model *model, const struct pend_fit_problem *problem,
                          char *memory);

/**
 * Residuals (model - data) / sigma of the first `rows` rows for values of the unknowns.
 *
 * residual  out, rows x columns of the problem; 0 where nothing was measured and beyond `rows`.
 * slope     out, [(row * columns + column) * unknowns + unknown]; NULL = not wanted.
 *
 * PEND_NO_MEMORY, PEND_INVALID, PEND_NOT_FINITE, PEND_STEP_TOO_SMALL, PEND_TOO_MANY_STEPS  there
 * is no such motion.
 */
PEND_MUST_CHECK enum pend_status pend_fit_model_at(struct fit_model *model, const double value[],
                                                   long rows, double residual[], double slope[],
                                                   struct pend_error *error);

#endif
