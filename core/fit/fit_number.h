/* One measurement as a function of the motion: its value, and its derivatives with respect to all
 * that it depends on.
 * Leaves to others: the motion and its derivatives with respect to the unknowns (fit_model).
 * Invariant: nothing is allocated or changed. */
#pragma once

#include "core/fit/fit_problem.h"

/* The numbers that a measurement depends on: quantities of the motion, which are those of enum
 * pend_derived up to the acceleration of a tip, and those of a cart; then the arm's length,
 * gravity, the frequency of a mode, and the camera's numbers. */
enum {
    FIT_CART = PEND_DERIVED_ZDD_IM + 1,
    FIT_CART_SPEED,
    FIT_SEEN,
    FIT_LENGTH = FIT_SEEN,
    FIT_GRAVITY,
    FIT_OMEGA,
    FIT_CAMERA,
    FIT_TERMS = PEND_FIT_CAMERA + 2
};

/* The quantities of a block of rows. */
struct fit_seen {
    const struct pend_fit_problem *problem;
    double *value[FIT_SEEN]; /* index row * arms + arm, caller's order; for a cart: row; NULL =
                              * none */
    double camera[PEND_FIT_CAMERA];
    const double *length, *zero, *omega; /* m; the instruments' offsets; rad/s, modes at hanging */
    double gravity, swing;               /* m/s^2; rad/s, a typical frequency of a swing */
    int lens;                            /* the camera is tilted or distorted, or may be */
};

/* A measurement; its derivatives with respect to quantities are multiplied by `lead`. */
struct fit_number {
    double value, lead;
    int terms, seen, what[FIT_TERMS]; /* `seen`: of quantities, which come first */
    size_t at[FIT_TERMS];             /* index of a quantity in the block; number of a mode */
    double by[FIT_TERMS];
};

/** Returns the quantities that a kind of measurement depends on, a bit each. O(1). */
unsigned pend_fit_number_needs(enum pend_fit_kind kind);

/** Returns the quantity that is the time derivative of another one; -1 = none is available. */
int pend_fit_number_pace(int what);

/**
 * Computes a measurement of row `row` of the block. `data` is the measured value. For a passage it
 * is the angle, and the computed value is the time, s, by which the motion passes too early: the
 * remaining angle divided by the rate, as atan(w u / v) / w, which is bounded at turning points.
 * O(1).
 */
void pend_fit_number(const struct fit_seen *seen, const struct pend_fit_column *column, double data,
                     size_t row, struct fit_number *number);
