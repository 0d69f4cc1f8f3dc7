/* Measurements of one or several motions of a pendulum, the unknowns to estimate, and the result.
 * Leaves to others: the model (fit_model), the minimum (fit).
 * Invariant: all pointers of a problem belong to the caller, all arrays of a result to the fit. */
#pragma once

#include "core/derivatives/derivatives.h"

/* The quantity of a column. Amplitudes and periods are those of one arm that swings freely from
 * the state at that instant, without friction. */
enum pend_fit_kind {
    PEND_FIT_PHI, /* rad, an angle of an arm */
    PEND_FIT_X,   /* a coordinate of its tip, in the camera's unit */
    PEND_FIT_Y,
    PEND_FIT_RATE,      /* a coordinate of the arm's tip, in the camera's unit */
    PEND_FIT_MODE,      /* rad/s, in the first row: the angular frequency of a mode about hanging */
    PEND_FIT_PASSAGE,   /* the arm passes the angle `data`, rad, at the row's instant; sigma in s */
    PEND_FIT_ALONG,     /* m/s^2, of an accelerometer on the arm: outwards, gravity included */
    PEND_FIT_ACROSS,    /* m/s^2, across the arm, counterclockwise */
    PEND_FIT_AMPLITUDE, /* rad */
    PEND_FIT_PERIOD,    /* s */
    PEND_FIT_CART,      /* m, the position of the cart on its rail */
    PEND_FIT_KINDS
};

/* The minimized function: the sum of squares, or the sum of one of SciPy's robust losses. */
enum pend_fit_loss { PEND_FIT_SQUARES, PEND_FIT_SOFT_L1, PEND_FIT_HUBER, PEND_FIT_CAUCHY };

/* largest number of arms if modes are measured */
enum { PEND_FIT_MODE_ARMS = 30 };

/* A column of measurements; arms in the caller's order. */
struct pend_fit_column {
    enum pend_fit_kind kind;
    int arm;            /* for a mode its index; 0 is the slowest swinging mode */
    double sigma;       /* standard deviation of a measurement, in the data's unit; 0 = not known */
    const double *each; /* one standard deviation > 0 per row, instead of sigma; NULL = none */
    const double *data; /* one number per row, rad or the camera's unit; NaN = not measured */
    int joint;          /* non-zero: an angle or a rate is relative to the parent arm */
    int zero;           /* 1 + index of the offset that the instrument adds; 0 = none */
    double at;          /* m, of an accelerometer: its distance from the joint; < 0 = at the tip */
    int still;          /* non-zero: the accelerometer removes gravity */
    int clock;          /* 1 + index of the shift of the instrument's clock, in the same list: its
                         * measurement at t belongs to the motion at t + shift; 0 = none */
};

/** Returns the arm to which a column's angle or rate is relative; -1 = a fixed direction. O(1). */
static inline int pend_fit_base(const struct pend_fit_column *column, const int parent[]) {
    return column->joint ? parent[column->arm] : -1;
}

/** Returns whether the standard deviations of a column's measurements are known. O(1). */
static inline int pend_fit_known(const struct pend_fit_column *column) {
    return column->each || column->sigma > 0;
}

/** Returns the standard deviation of a measurement; 1 if it is not known. O(1). */
static inline double pend_fit_sigma(const struct pend_fit_column *column, long row) {
    if (column->each) return column->each[row];
    return column->sigma > 0 ? column->sigma : 1;
}

/* The camera sees the position z = x + i y, m, of its plane of motion at d + d k |d|^2 / reach^2
 * from its center, where d = origin + scale e^{i rotation} w / (1 + tilt . w) - center and
 * w = x + i (1 + stretch) y. */
enum pend_fit_camera {
    PEND_FIT_SCALE,    /* units of the camera per m */
    PEND_FIT_ROTATION, /* rad */
    PEND_FIT_ORIGIN_X, /* position of the pivot, in the camera's unit */
    PEND_FIT_ORIGIN_Y,
    PEND_FIT_SHIFT,  /* s, the motion's time minus the time of the data */
    PEND_FIT_TILT_X, /* 1/m */
    PEND_FIT_TILT_Y,
    PEND_FIT_STRETCH,
    PEND_FIT_DISTORTION, /* k above */
    PEND_FIT_CAMERA
};

/* An unknown to estimate; its bounds may be infinite. */
struct pend_fit_unknown {
    int camera;               /* enum pend_fit_camera; from PEND_FIT_CAMERA on a number of an
                               * instrument; -1 = a parameter of the pendulum */
    struct pend_parameter by; /* the parameter of the pendulum */
    double start, low, high;  /* low <= start <= high, low < high */
    int run;                  /* for an initial angle or rate, the run to which it belongs, from 0;
                               * otherwise unused */
};

/* A problem; all pointers must outlive the fit. */
struct pend_fit_problem {
    int n;                       /* arms, and a cart as the last one */
    const double *length, *mass; /* m and kg, in the caller's order, as given to pend_tree_new */
    const unsigned char *bare;
    const int *parent, *order; /* order: as in pend_tree, for the stored arms */
    struct pend_loads loads;
    int runs;                 /* number of motions, each with its own start; 0 = one */
    const double *phi, *rate; /* initial states, runs x n, stored order */
    const double *start; /* s, instant of each start, at most the run's first row, shifted; NULL =
                          * 0 */
    double camera[PEND_FIT_CAMERA];
    double center[2], reach; /* of the lens, in the camera's unit; reach > 0 if it is distorted */
    int zeros; /* number of values of instruments: offsets, rad, rad/s or m/s^2; shifts, s */
    const double *zero; /* the values of instruments */
    long rows;          /* rows are sorted by the time since the start of their run */
    const double *t;    /* s, not decreasing within a run; rows of one instant are adjacent */
    const int *run;     /* the run of each row; NULL = one run */
    int columns;
    const struct pend_fit_column *column;
    int unknowns;
    const struct pend_fit_unknown *unknown;
    enum pend_fit_loss loss;
    const double *knee; /* for each column, the residual above which the loss is below the square; 0
                         * = none; NULL = none for all columns */
    double rtol;        /* tolerance of the motion, as for the taylor method */
    int iterations;     /* maximum number of iterations, >= 1 */
    long step_cap;      /* maximum steps of a motion, 0 = no limit; lowered for ordinary motions */
};

/** Returns the typical size of a quantity in a motion of about a radian, in the data's unit. scale:
 * of the camera. O(arms). */
double pend_fit_size(const struct pend_fit_problem *problem, enum pend_fit_kind kind, double scale);

/** Returns the number of arms, without a cart. O(1). */
static inline int pend_fit_arms(const struct pend_fit_problem *problem) {
    return problem->n - pend_terms_cart(problem->loads.terms);
}

/** Returns the number of motions. O(1). */
static inline int pend_fit_runs(const struct pend_fit_problem *problem) {
    return problem->runs > 1 ? problem->runs : 1;
}

/** Returns the motion of a row, from 0. O(1). */
static inline int pend_fit_run(const struct pend_fit_problem *problem, long row) {
    return problem->run ? problem->run[row] : 0;
}

/** Returns the instant of the start of a motion, s. O(1). */
static inline double pend_fit_start(const struct pend_fit_problem *problem, int run) {
    return problem->start ? problem->start[run] : 0;
}

/** Returns the time from the start of a row's motion to the row, s, including the camera's given
 * shift. O(1). */
static inline double pend_fit_since(const struct pend_fit_problem *problem, long row) {
    return problem->t[row] + problem->camera[PEND_FIT_SHIFT] -
           pend_fit_start(problem, pend_fit_run(problem, row));
}

/** Checks counts, the order of rows, and bounds. PEND_INVALID  O(rows columns + the squared number
 * of rows of one instant). */
PEND_MUST_CHECK enum pend_status pend_fit_check(const struct pend_fit_problem *problem,
                                                struct pend_error *error);

/* One of several motions as a problem of its own, whose solution is only a start. */
struct fit_alone {
    struct pend_fit_problem problem;
    int run;   /* the motion's index in the whole problem */
    int *from; /* for each unknown its index in the whole problem */
};

/** Extracts a run, 0 .. runs - 1, from a problem of several, which must outlive it; it gets half of
 * the iterations. Returns NULL if memory is short; released by free. O(rows columns). */
struct fit_alone *pend_fit_alone(const struct pend_fit_problem *problem, int run);

/* ---- the result of a fit */

/* How a fit ended. */
enum pend_fit_end {
    PEND_FIT_CONVERGED,
    PEND_FIT_STRANGE, /* a minimum, but its motion does not follow the data */
    PEND_FIT_STOPPED, /* no minimum: the iterations were used up, or no step decreased the sum of
                       * squares */
    PEND_FIT_AWAY,    /* no minimum: an unknown diverged and is not identifiable */
};

/* Whether the model fits the data. */
enum pend_fit_model {
    PEND_FIT_ACCEPTED,
    PEND_FIT_UNDECIDED, /* no minimum, or no test could reject the model */
    PEND_FIT_REJECTED
};

enum { PEND_FIT_BLIND = 8 };

/* The outcome; all arrays belong to the fit. */
struct pend_fit_result {
    enum pend_fit_end end;
    long iterations, evaluations;
    const double *value; /* values of the unknowns */
    const double *error; /* Standard errors, infinite if not identifiable. At a bound: the error
                          * that the unknown would have without the bound, or NaN if it cannot be
                          * distinguished from others. NaN too if no sigma is given and no degree of
                          * freedom is left. */
    const double *correlation;    /* unknowns x unknowns; 0 if an error is not finite */
    const unsigned char *bounded; /* non-zero: at a bound */
    /* (model - data) / sigma, or in the data's unit if no sigma is given; [row * columns + column],
     * NaN if not measured */
    const double *residual;
    double chi_squared;
    long freedom;          /* number of measurements minus number of unknowns found */
    const double *follows; /* s, per run: the time of the last row up to which the motion follows
                            * the data; NaN = none */
    int away;              /* the unknown that diverged, -1 = none */
    int twin;              /* the shift of a clock that could also be `other`; -1 = none */
    double other;          /* s */
    double explained;      /* fraction explained: 1 - sum of squares over the sum of squares of the
                            * data about their mean */
    enum pend_fit_model model;
    double p_value;       /* p-value of chi-squared; NaN without sigmas or degrees of freedom */
    double watson;        /* Durbin-Watson statistic of the residuals; NaN without adjacent rows */
    double alike;         /* p-value of the residuals' autocorrelation; NaN with few rows */
    double widened;       /* factor by which standard errors grew; infinite: withheld */
    double effective;     /* the number of independent measurements with the same information */
    const double *spread; /* for each column, the robust standard deviation of its residuals */
    double beyond;        /* a residual beyond this many spreads is an outlier; may be infinite */
    long outliers;        /* number of outliers */
    /* Directions that are not identifiable: relative changes of all unknowns together, the largest
     * of which is 1; [direction * unknowns + unknown]. */
    int blind;
    const double *direction;
};
