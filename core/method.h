/* What an integrator is: a problem to solve, and one self-describing descriptor a method.
 * Leaves to others: the methods themselves (method_*), the time loop and the samples (run).
 * Invariant: a stepper belongs to one run; its arrays are in the tree's stored order. */
#ifndef PEND_METHOD_H
#define PEND_METHOD_H

#include "core/tree.h"

/* The instants that are wanted, strictly monotonic, forwards or backwards. */
struct pend_times {
    long count;         /* >= 1 */
    double start, span; /* without a list instant i is start + i * span / divisor, so that decimal grids stay decimal */
    double divisor;     /* > 0 */
    const double *list; /* count instants, or NULL; not owned */
};

/**
 * Instant i of the wanted instants, s. i from 0 to count - 1. O(1).
 */
double pend_times_at(const struct pend_times *times, long i);

struct pend_problem {
    const struct pend_tree *tree; /* must outlive every run of it */
    double gravity;               /* m/s^2 */
    const double *phi, *rate;     /* start at the first instant, n values each, stored order; copied by the run */
    struct pend_times times;
    double rtol, atol; /* of the local error; 0 = the method's default */
    double step;       /* s, fixed-step methods only; 0 = the method's choice */
    long step_cap;     /* most steps a run may take, 0 = no limit */
};

enum {
    PEND_METHOD_LANDS = 1,      /* no dense output: each step must be cut at the next wanted instant */
    PEND_METHOD_TOLERANCES = 2, /* obeys rtol and atol */
    PEND_METHOD_FIXED_STEP = 4, /* obeys step */
    PEND_METHOD_LINEAR = 8 /* solves (lin), not (aaa): accelerations and forces come from the method's own motion */
};

/* State at one instant handed out by a stepper; arrays of n values in stored order. */
struct pend_point {
    double *phi, *rate;
    double *acc; /* filled by methods with PEND_METHOD_LINEAR only */
};

struct pend_stepper_counts {
    long steps, rejected, evaluations;
};

struct pend_method {
    const char *name;    /* as in the contract: "taylor" */
    const char *summary; /* one sentence for the documentation */
    unsigned flags;
    double rtol_default, rtol_min, rtol_max; /* 0 where PEND_METHOD_TOLERANCES is not set */
    double atol_default, atol_min, atol_max;

    /** Makes a stepper at the problem's first instant; NULL on failure. */
    enum pend_status (*open)(void **stepper, const struct pend_problem *problem, struct pend_error *error);
    /**
     * Takes one accepted step towards `limit` (s, relative to the first instant; its sign is the direction) and not
     * beyond it where PEND_METHOD_LANDS is set; *reached becomes the time after the step, relative to the first
     * instant.
     */
    enum pend_status (*step)(void *stepper, double limit, double *reached, struct pend_error *error);
    /** The state at time t relative to the first instant, inside the last step (dense output), or at its end. */
    void (*at)(void *stepper, double t, struct pend_point *point);
    struct pend_stepper_counts (*counts)(const void *stepper);
    void (*close)(void **stepper);
};

/**
 * The method of a name, or NULL. The names are the contract's: taylor ode23 rkf45 rk8pd msadams linear.
 */
const struct pend_method *pend_method_find(const char *name);

/**
 * Method number i of the table, from 0, or NULL beyond its end; the first is the default.
 */
const struct pend_method *pend_method_at(int i);

#endif
