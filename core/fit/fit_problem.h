/* Measurements of a pendulum, of one motion or of several, and what is to be found from them.
 * Leaves to others: the model (fit_model), the minimum (fit).
 * Invariant: all pointers belong to the caller. */
#pragma once

#include "core/derivatives/derivatives.h"

/* What is measured in a column: an angle of an arm, a coordinate of its tip, as the camera has it,
 * a rate, rad/s, which does not go along with an unknown shift of time, or the angular frequency of
 * a mode about hanging, rad/s, which is in the first row. */
enum pend_fit_kind { PEND_FIT_PHI, PEND_FIT_X, PEND_FIT_Y, PEND_FIT_RATE, PEND_FIT_MODE };

/* What is made least: the sum of squares, or of what SciPy's robust losses make of them. */
enum pend_fit_loss { PEND_FIT_SQUARES, PEND_FIT_SOFT_L1, PEND_FIT_HUBER, PEND_FIT_CAUCHY };

/* the most arms of a pendulum whose modes are measured */
enum { PEND_FIT_MODE_ARMS = 30 };

/* Arms in the caller's order. */
struct pend_fit_column {
    enum pend_fit_kind kind;
    int arm;            /* of a mode its number, the slowest of those that swing is 0 */
    double sigma;       /* of one measurement, in the data's unit; 0 = not known */
    const double *each; /* the same a row, all above 0, instead of sigma; NULL = there is none */
    const double *data; /* a number a row, rad or the camera's unit; NaN = not measured */
    int joint;          /* of an angle or a rate: it counts from the arm that this one hangs on */
    int zero; /* of an angle or a rate: 1 + the number of the zero that is added; 0 = none */
};

/** Returns the arm that a column's angle or rate counts from; -1 = a fixed direction. O(1). */
static inline int pend_fit_base(const struct pend_fit_column *column, const int parent[]) {
    return column->joint ? parent[column->arm] : -1;
}

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
    int camera;               /* enum pend_fit_camera; from PEND_FIT_CAMERA on a zero of the
                                 instrument; -1 = a parameter of the pendulum */
    struct pend_parameter by; /* of the pendulum */
    double start, low, high;  /* low <= start <= high, low < high */
    int run;                  /* of an angle or a rate: whose start, from 0; else without meaning */
};

/* All pointers must outlive the fit. */
struct pend_fit_problem {
    int n;                       /* arms */
    const double *length, *mass; /* the caller's order, as the tree was made */
    const unsigned char *bare;
    const int *parent, *order; /* order: of the stored arms, as pend_tree has it */
    struct pend_loads loads;
    int runs;                 /* motions, each with a start of its own; 0 = one */
    const double *phi, *rate; /* their starts, runs x n, stored order */
    const double *start; /* s, when each is there: not after its first row, shifted; NULL = 0 */
    double camera[PEND_FIT_CAMERA];
    int zeros;          /* numbers that instruments add to angles, rad, and rates, rad/s */
    const double *zero; /* `zeros` */
    long rows;          /* in the order of their time since the start of their run */
    const double
        *t; /* s, not decreasing within a run: those of one instant are next to each other */
    const int *run; /* of each row; NULL = there is one */
    int columns;
    const struct pend_fit_column *column;
    int unknowns;
    const struct pend_fit_unknown *unknown;
    enum pend_fit_loss loss;
    const double *knee; /* of each column, a residual from which on the loss is less than its
                           square; 0 = none; NULL = none has one */
    double rtol;        /* of the motion, as of the taylor method */
    int iterations;     /* most, 1 .. */
    long step_cap;      /* of a motion, 0 = none; it is lowered to what a tame one may take */
};

/** How many motions there are. O(1). */
static inline int pend_fit_runs(const struct pend_fit_problem *problem) {
    return problem->runs > 1 ? problem->runs : 1;
}

/** Of which motion a row is, from 0. O(1). */
static inline int pend_fit_run(const struct pend_fit_problem *problem, long row) {
    return problem->run ? problem->run[row] : 0;
}

/** When the start of a motion is there, s. O(1). */
static inline double pend_fit_start(const struct pend_fit_problem *problem, int run) {
    return problem->start ? problem->start[run] : 0;
}

/** A row's time since the start of its motion, s, by the camera's shift as it was given. O(1). */
static inline double pend_fit_since(const struct pend_fit_problem *problem, long row) {
    return problem->t[row] + problem->camera[PEND_FIT_SHIFT] -
           pend_fit_start(problem, pend_fit_run(problem, row));
}

/** Checks counts, the order of rows, and bounds. PEND_INVALID  O(rows columns + rows of one instant
 * squared). */
PEND_MUST_CHECK enum pend_status pend_fit_check(const struct pend_fit_problem *problem,
                                                struct pend_error *error);
