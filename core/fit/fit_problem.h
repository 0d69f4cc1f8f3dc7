/* Measurements of a pendulum, and what is to be found from them.
 * Leaves to others: the model (fit_model), the minimum (fit).
 * Invariant: all pointers belong to the caller. */
#ifndef PEND_FIT_PROBLEM_H
#define PEND_FIT_PROBLEM_H

#include "core/derivatives/derivatives.h"

/* What is measured in a column: an angle of an arm, a coordinate of its tip, as the camera has it,
 * a rate, rad/s, which does not go along with an unknown shift of time, or the angular frequency of
 * a mode about hanging, rad/s, which is in the first row. */
enum pend_fit_kind { PEND_FIT_PHI, PEND_FIT_X, PEND_FIT_Y, PEND_FIT_RATE, PEND_FIT_MODE };

/* the most arms of a pendulum whose modes are measured */
enum { PEND_FIT_MODE_ARMS = 30 };

/* Arms in the caller's order. */
struct pend_fit_column {
    enum pend_fit_kind kind;
    int arm;            /* of a mode its number, the slowest of those that swing is 0 */
    double sigma;       /* of one measurement, in the data's unit; 0 = not known */
    const double *each; /* the same a row, all above 0, instead of sigma; NULL = there is none */
    const double *data; /* a number a row, rad or the camera's unit; NaN = not measured */
};

/** Whether the standard deviations of a column's measurements are known. O(1). */
static inline int pend_fit_known(const struct pend_fit_column *column) {
    return column->each || column->sigma > 0;
}

/** Returns the standard deviation of a measurement, 1 where it is not known. O(1). */
static inline double pend_fit_sigma(const struct pend_fit_column *column, long row) {
    if (column->each) return column->each[row];
    return column->sigma > 0 ? column->sigma : 1;
}

/* The camera's place x + i y = origin + scale e^{i rotation} z. */
enum pend_fit_camera {
    PEND_FIT_SCALE,    /* units of the camera per m */
    PEND_FIT_ROTATION, /* rad */
    PEND_FIT_ORIGIN_X, /* of the pivot, in the camera's unit */
    PEND_FIT_ORIGIN_Y,
    PEND_FIT_SHIFT, /* s, by which the motion's time is ahead of the instants of the data */
    PEND_FIT_CAMERA
};

/* What is to be found; the bounds may be infinite. */
struct pend_fit_unknown {
    int camera;               /* enum pend_fit_camera; -1 = a parameter of the pendulum */
    struct pend_parameter by; /* of the pendulum */
    double start, low, high;  /* low <= start <= high, low < high */
};

/* All pointers must outlive the fit. */
struct pend_fit_problem {
    int n;                       /* arms */
    const double *length, *mass; /* the caller's order, as the tree was made */
    const unsigned char *bare;
    const int *parent, *order; /* order: of the stored arms, as pend_tree has it */
    struct pend_loads loads;
    const double *phi, *rate; /* start, stored order */
    double start;             /* s, when it is there: not after the first row, shifted */
    double camera[PEND_FIT_CAMERA];
    long rows;
    const double *t; /* s, strictly increasing */
    int columns;
    const struct pend_fit_column *column;
    int unknowns;
    const struct pend_fit_unknown *unknown;
    double rtol;    /* of the motion, as of the taylor method */
    int iterations; /* most, 1 .. */
    long step_cap;  /* of a motion, 0 = none; it is lowered to what a tame one may take */
};

#endif
