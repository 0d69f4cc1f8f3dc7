/* Predicted measurements of a pendulum for given values of the unknowns, and their derivatives.
 * Leaves to others: the minimum (fit).
 * Invariant: the problem is not changed; rows beyond the window are 0. */
#pragma once

#include "core/fit/fit_number.h"

/* A measured row: its time of the motion, s, and the column, if this has its own clock; -1 = all
 * columns without one. */
struct fit_model_pair {
    double t;
    long row;
    int column;
};

/* Workspace of a model; one block. */
struct fit_model {
    const struct pend_fit_problem *problem;
    int parameters;                   /* number of unknowns of the pendulum and the start */
    struct pend_parameter *parameter; /* these unknowns as parameters */
    int *place;                       /* index of each unknown among the parameters; -1 = none */
    struct fit_model_pair *pair;      /* the measured rows of a run, in the order of time */
    long *first;                      /* for each instant of the run, its first pair */
    long instants, start, way;        /* number of instants; index of the start among them; 1 if a
                                       * motion goes forwards from there, -1 if it goes backwards */
    double *length, *mass, *value, *phi, *rate;
    double *t, *list;        /* the instants of the run, and those of a motion, s */
    double motions;          /* so far: motions of all rows with derivatives */
    double decay;            /* 1/s, due to friction, at the start values */
    int modes;               /* whether frequencies of modes are needed */
    double *omega, *near;    /* mode frequencies, rad/s; with a changed unknown */
    double *lean;            /* n x unknowns: derivatives of the frequencies */
    double *beside;          /* values at a finite-difference step */
    struct fit_seen seen;    /* quantities of a block of rows */
    double *slope[FIT_SEEN]; /* derivatives of `seen` with respect to the parameters; NULL = not
                              * needed */
    long block;
    double *room; /* the instants of a motion without derivatives */
    double *zero; /* numbers of the instruments */
};

/** Lays out a workspace in `memory`, or only counts its bytes if `memory` is NULL. */
size_t pend_fit_model_lay(struct fit_model *model, const struct pend_fit_problem *problem,
                          char *memory);

/**
 * Computes the residuals (model - data) / sigma of the first `rows` rows for values of the
 * unknowns.
 *
 * residual  out, rows x columns of the problem; 0 without a measurement and beyond `rows`.
 * slope     out, [(row * columns + column) * unknowns + unknown]; NULL if not needed.
 *
 * PEND_NO_MEMORY, PEND_INVALID, PEND_NOT_FINITE, PEND_STEP_TOO_SMALL, PEND_TOO_MANY_STEPS
 * the motion cannot be computed for these values.
 */
PEND_MUST_CHECK enum pend_status pend_fit_model_at(struct fit_model *model, const double value[],
                                                   long rows, double residual[], double slope[],
                                                   struct pend_error *error);
