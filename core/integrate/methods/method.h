/* The interface of integration methods: the problem to solve, and a table of functions and
 * properties for each method.
 * Leaves to others: the methods themselves (method_*), the time loop and the samples (run).
 * Invariant: a stepper belongs to one run; its arrays are in the tree's stored order. */
#pragma once

#include "core/base/checkpoint.h"
#include "core/tree/loads.h"
#include "core/tree/tree.h"

/* The requested instants, strictly increasing or strictly decreasing. */
struct pend_times {
    long count;         /* >= 1 */
    double start, span; /* s; without a list, instant i is start + i * span / divisor, so that
                         * decimal grids stay decimal */
    double divisor;     /* > 0 */
    const double *list; /* `count` instants, s, or NULL; not owned */
};

/** Returns the requested instant i, s; 0 <= i < count. O(1). */
double pend_times_at(const struct pend_times *times, long i);

/** Fills in instants first .. first + count - 1, s, with the bits of pend_times_at. O(count). */
void pend_times_list(const struct pend_times *times, long first, int count, double t[]);

struct pend_problem {
    const struct pend_tree *tree; /* must outlive every run of the problem */
    struct pend_loads loads;      /* gravity and other loads */
    const double *phi,
        *rate; /* state at the first instant, n values each, stored order; copied by the run */
    /* rounding errors of the initial state, n values each; NULL = 0; ignored by methods that
     * compute in doubles only */
    const double *phi_low, *rate_low;
    struct pend_times times;
    double rtol, atol; /* tolerances of the local error; 0 = the method's default */
    int atol_given;    /* non-zero: atol = 0 means 0, not the default */
    double step;       /* s, for fixed-step methods only; 0 = the method's choice */
    long step_cap;     /* maximum number of steps of a run, 0 = no limit */
    int no_turns;      /* non-zero: samples have angles without the whole turns of a huge start
                        * (turns.h) */
    double accuracy;   /* required accuracy of the samples, > 0: the run estimates up to when it
                        * holds (horizon.h); 0 = no estimate */
    int no_drift;      /* non-zero: the drift of the energy is not computed, and is reported as 0 */
};

/* The smallest atol, relative to rtol, in methods with one tolerance for each component: when a
 * component passes through 0, a relative tolerance alone would reduce the step to 0. */
#define PEND_METHOD_ATOL_LEAST 1e-6

enum {
    PEND_METHOD_LANDS = 1,      /* no dense output: steps end exactly at requested instants */
    PEND_METHOD_TOLERANCES = 2, /* uses rtol and atol */
    PEND_METHOD_FIXED_STEP = 4, /* uses step */
    PEND_METHOD_LINEAR =
        8, /* solves (lin), not (aaa): `at` also fills acc, from which forces are computed */
    PEND_METHOD_TERMS = 64,      /* supports the terms of real pendulums (loads) */
    PEND_METHOD_CONSERVES = 128, /* supports only terms for which pend_terms_conserve is true */
    PEND_METHOD_FORWARD = 256,   /* integrates backwards only without dissipation, whose growth an
                                  * implicit method would damp */
    PEND_METHOD_EXTENDED = 512,  /* about 32 digits */
    PEND_METHOD_THETA = 32,      /* `at` also fills theta, with as many digits as the initial state
                                  * has */
    PEND_METHOD_SERIES =
        16 /* `at` also fills acc and force, faster than from the equations of motion */
};

/* States at several instants of one step, time-major in stored order: phi[i * n + arm]. The
 * receiver owns the arrays. */
struct pend_points {
    double *phi, *rate; /* always required */
    double *acc;   /* rad/s^2, for methods with PEND_METHOD_LINEAR or PEND_METHOD_SERIES; NULL if
                    * not needed */
    double *force; /* N, for methods with PEND_METHOD_SERIES; NULL if not needed */
    /* rad, phi + pi/2; for a small swing with more correct digits than phi; for methods with
     * PEND_METHOD_THETA; NULL if not needed */
    double *theta;
};

struct jets_state;
struct pend_jets;

enum { PEND_SERIES_BEYOND = 2 };

/* The power series of the last step, about its start; valid until the next step. If the problem has
 * an accuracy, up to PEND_SERIES_BEYOND coefficients beyond the step's order are known. */
struct pend_series {
    const struct pend_jets *jets;
    const struct jets_state *begin;
    int order, beyond; /* order of the step; number of known higher coefficients */
    int stands; /* number of steps, up to this one, that are given the truncation error of this
                 * step; 0: a later step gives it to this one */
    double unit, time, reached; /* s; unit; start and end of the step, relative to the first
                                 * instant */
};

/* A state from which the next step starts, n values each in stored order; low parts may be NULL,
 * which is 0. */
struct pend_start {
    double time; /* s, relative to the first instant */
    const double *phi, *phi_low, *rate, *rate_low;
};

/* The work of a stepper. An evaluation is a sweep over the whole tree: a right-hand side, or one
 * order of a series. */
struct pend_stepper_counts {
    long steps, rejected, evaluations;
};

struct pend_method {
    const char *name;    /* name in the API, e.g. "taylor" */
    const char *summary; /* one sentence for the documentation */
    unsigned flags;
    double rtol_default, rtol_min, rtol_max; /* 0 without PEND_METHOD_TOLERANCES */
    /* the default of atol is rtol / atol_divisor, or 0 if atol_divisor is 0 */
    double atol_divisor, atol_min, atol_max;
    double step_min, step_max;          /* s; 0 without PEND_METHOD_FIXED_STEP */
    const struct pend_method *extended; /* the same method in about 32 digits, with rounded results;
                                         * NULL = none */

    /** Creates a stepper at the problem's first instant; NULL on failure. The caller has checked
     * the problem (run_check). */
    enum pend_status (*open)(void **stepper, const struct pend_problem *problem,
                             struct pend_error *error);
    /** Takes one accepted step towards `limit` (s, relative to the first instant; its sign is the
     * direction). With PEND_METHOD_LANDS, `limit` is the next requested instant, which steps reach
     * exactly and never pass. Otherwise it is the last requested instant, which a step may pass.
     * *reached becomes the time after the step, relative to the first instant. On failure
     * error->time is relative too, and the text contains no time; the run adds it. */
    enum pend_status (*step)(void *stepper, double limit, double *reached,
                             struct pend_error *error);
    /** Fills in the states at `count` instants t (s, relative to the first instant, monotonic)
     * inside the last step; with PEND_METHOD_LANDS only at its end. At the end of the step the
     * state is exactly the one that the next step starts from. An instant's bits do not depend on
     * the other instants in the call. Before the first step it is called for linear methods
     * only. */
    void (*at)(void *stepper, const double t[], int count, const struct pend_points *points);
    /** Returns the number of evaluations since `open`. O(1). */
    struct pend_stepper_counts (*counts)(const void *stepper);
    /** Fills in the work of drives and the heat of friction since `open`, J, at the same instants
     * as `at` accepts, for real pendulums whose energy is not conserved. NULL if a method does not
     * support these. */
    void (*exchange)(const void *stepper, const double t[], int count, double work[],
                     double heat[]);
    /** Returns the last step as a power series of doubles; NULL if the method has no such
     * series. */
    void (*series)(const void *stepper, struct pend_series *series);
    /** Propagates a small error of the state from the start of the last step to its end, to first
     * order, and adds the estimated error of the step itself; n values each, rad and rad/s. NULL if
     * the method cannot; then the horizon computes power series of the motion itself. */
    void (*spread)(void *stepper, double phi[], double rate[]);
    /** Saves everything that steps have changed since `open` to a checkpoint, or restores it. A
     * stepper that is newly opened for the same problem and then restored continues with the same
     * bits, including `at` inside the last step. If the bytes were altered, the stepper refuses the
     * checkpoint or computes wrong values, but does no other harm. NULL if the method's state
     * cannot be saved. */
    void (*carry)(void *stepper, struct pend_checkpoint *checkpoint);
    /** Shortens the last step so that it ends at t, s, relative to the first instant and inside the
     * step. Its work and heat then end at t. NULL if a method does not support motions in
     * pieces. */
    void (*cut)(void *stepper, double t);
    /** Returns the state at the end of the last step, valid until the next step. With `end` alone a
     * method supports pieces that end at known instants. NULL if it supports none. */
    struct pend_start (*end)(const void *stepper);
    /** Replaces the state from which the next step starts; see pend_start. NULL if `cut` is. */
    void (*put)(void *stepper, const struct pend_start *start);
    /** Frees a stepper and clears the pointer; NULL is accepted. */
    void (*close)(void **stepper);
};

/** Saves the counters of a stepper to a checkpoint, or restores them, as pend_checkpoint_counts. */
void pend_stepper_counts_carry(struct pend_stepper_counts *counts,
                               struct pend_checkpoint *checkpoint);

/* Each method has a file method_X.c; the three methods of GSL share method_gsl.c. */
extern const struct pend_method pend_method_taylor, pend_method_ode23, pend_method_rkf45,
    pend_method_rk8pd, pend_method_msadams, pend_method_linear, pend_method_symplectic,
    pend_method_radau;

/* pend_method_taylor.extended points to this method */
extern const struct pend_method pend_method_taylor_extended;

/** Returns a method's default absolute tolerance for a relative tolerance, rad and rad/s. O(1). */
static inline double pend_method_atol(const struct pend_method *method, double rtol) {
    return method->atol_divisor > 0 ? rtol / method->atol_divisor : 0;
}

/** Returns the method with a name, or NULL. The names are those of the API: taylor ode23 rkf45
 * rk8pd msadams symplectic linear radau. */
const struct pend_method *pend_method_find(const char *name);

/** Returns method number i of the table, from 0, or NULL beyond its end; the first is the
 * default. */
const struct pend_method *pend_method_at(int i);
