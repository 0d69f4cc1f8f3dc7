/* What a pendulum with given values of its unknowns would have been measured as, and how that
 * changes with each of them.
 * Leaves to others: the minimum (fit).
 * Invariant: the problem is not changed; rows beyond the window are 0. */
#pragma once

#include "core/fit/fit_problem.h"

/* Workspace of a model; one block. */
struct fit_model {
    const struct pend_fit_problem *problem;
    int parameters;                   /* unknowns that are the pendulum's or of the run's start */
    struct pend_parameter *parameter; /* of these */
    int *place;                       /* of every unknown its number among these; -1 = it is none */
    long *row;                        /* of the run's instants, the first row of each */
    double *length, *mass, *value, *phi, *rate;
    double *t;                  /* the start and the run's rows, or these, in the motion's time */
    long rows;                  /* that are looked at */
    int before;                 /* 1 if the start is before the first row */
    int shifts;                 /* the time's shift is unknown */
    int modes;                  /* modes are measured */
    double *omega, *near;       /* of all modes, rad/s, and of those of a pendulum next to it */
    double *lean;               /* n x unknowns: how they change */
    double *beside;             /* values next to those that are looked at */
    double *seen[4], *slope[4]; /* phi, x, y, rate of a block of rows, and their derivatives */
    double *pace[3];            /* their derivatives by time, where the time's shift is unknown */
    long block;
    int wants[4]; /* which of these are measured */
    double *room; /* of phi, x and y of plain samples, and their instants */
    double camera[PEND_FIT_CAMERA];
    double *zero; /* of instruments */
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
