/* The interface of integration methods: the problem to solve, and a table of functions and
 * properties for each method.
 * Leaves to others: the methods themselves (method_*), the time loop and the samples (run).
 * Invariant: a stepper belongs to one run; its arrays are in the tree's stored order. */
#pragma once

#include "core/base/checkpoint.h"
#include "core/tree/loads.h"
#include "core/tree/tree.h"

/* The wanted instants, strictly increasing or strictly decreasing. */
struct pend_times {
    long count;         /* >= 1 */
    double start, span; /* without a list instant i is start + i * span / divisor, so that decimal
                           grids stay decimal */
    double divisor;     /* > 0 */
    const double *list; /* count instants, or NULL; not owned */
};

/**
 * Returns instant i of the wanted instants, s; 0 <= i < count. O(1).
 */
double pend_times_at(const struct pend_times *times, long i);

/**
 * Fills in instants first .. first + count - 1, s, with the bits of pend_times_at. O(count).
 */
void pend_times_list(const struct pend_times *times, long first, int count, double t[]);

struct pend_problem {
    const struct pend_tree *tree; /* must outlive every run of it */
    struct pend_loads loads;      /* what acts on the tree */
    const double *phi,
        *rate; /* start at the first instant, n values each, stored order; copied by the run */
    /* the rounding errors of the start's doubles, n values each; NULL = 0; methods that compute in
     * doubles only ignore them */
    const double *phi_low, *rate_low;
    struct pend_times times;
    double rtol, atol; /* of the local error; 0 = the method's default */
    int atol_given;    /* non-zero: atol = 0 means 0, not the default */
    double step;       /* s, fixed-step methods only; 0 = the method's choice */
    long step_cap;     /* most steps a run may take, 0 = no limit */
    int no_turns;      /* non-zero: samples have angles without the whole turns of a huge start
                          (turns.h) */
    double accuracy;   /* of the answer, > 0: the run estimates how long it is kept (horizon.h); 0 =
                          no estimate */
    int no_drift;      /* non-zero: the energy's drift is not computed and is reported as 0 */
};

/* The least atol, as a part of rtol, that methods with one tolerance for each component use: a
 * component that passes through 0 has no relative error, so that its step size would tend to 0. */
#define PEND_METHOD_ATOL_LEAST 1e-6

enum {
    PEND_METHOD_LANDS =
        1, /* no dense output: a step ends at the next wanted instant at the latest */
    PEND_METHOD_TOLERANCES = 2, /* uses rtol and atol */
    PEND_METHOD_FIXED_STEP = 4, /* uses step */
    PEND_METHOD_LINEAR =
        8, /* solves (lin), not (aaa): `at` fills acc too, and forces are computed from it */
    PEND_METHOD_TERMS = 64,      /* takes the terms of real pendulums (loads) */
    PEND_METHOD_CONSERVES = 128, /* of these only what pend_terms_conserve is true of */
    PEND_METHOD_FORWARD = 256,   /* goes backwards only where nothing is lost: what grows fast there
                                    an implicit method would damp */
    PEND_METHOD_THETA = 32,      /* `at` fills theta too, with as many digits as the start had */
    PEND_METHOD_SERIES =
        16 /* `at` fills acc and force too, faster than the equations of motion would */
};

/* States at several instants of one step, time-major in stored order: phi[i * n + arm]. The
 * receiver owns the arrays.
 */
struct pend_points {
    double *phi, *rate; /* always wanted */
    double *acc;   /* rad/s^2, for methods with PEND_METHOD_LINEAR or PEND_METHOD_SERIES; NULL = not
                      wanted */
    double *force; /* N, for methods with PEND_METHOD_SERIES; NULL = not wanted */
    /* rad, phi + pi/2 with the digits of a small swing, which phi as a double does not hold; for
     * methods with
     * PEND_METHOD_THETA; NULL = not wanted */
    double *theta;
};

struct jets_state;
struct pend_jets;

enum { PEND_SERIES_BEYOND = 2 };

/* The power series about its start by which the last step was computed; valid until the next step.
 * If the problem has an accuracy, up to PEND_SERIES_BEYOND coefficients beyond the step's order are
 * known. */
struct pend_series {
    const struct pend_jets *jets;
    const struct jets_state *begin;
    int order, beyond; /* of the step; how many higher coefficients are known */
    int stands; /* the number of steps, this one and some before it, whose truncation errors are
                   taken to be this one's; 0: a later step stands for it */
    double unit, time,
        reached; /* s; time and reached are the step's ends, relative to the first instant */
};

/* A state from which the next step is to start, n values each in stored order; low parts NULL = 0.
 */
struct pend_start {
    double time; /* s, relative to the first instant */
    const double *phi, *phi_low, *rate, *rate_low;
};

/* The work of a stepper. Evaluations are sweeps over the whole tree: right-hand sides, or orders of
 * a series. */
struct pend_stepper_counts {
    long steps, rejected, evaluations;
};

struct pend_method {
    const char *name;    /* as in the API: "taylor" */
    const char *summary; /* one sentence for the documentation */
    unsigned flags;
    double rtol_default, rtol_min, rtol_max; /* 0 where PEND_METHOD_TOLERANCES is not set */
    /* the default of atol is rtol / atol_divisor, or 0 if atol_divisor is 0 */
    double atol_divisor, atol_min, atol_max;
    double step_min, step_max;          /* s; 0 where PEND_METHOD_FIXED_STEP is not set */
    const struct pend_method *extended; /* the same method in numbers of about 32 digits, with
                                           rounded results; NULL = none */

    /** Makes a stepper at the problem's first instant; NULL on failure. The caller has checked the
     * problem (run_check). */
    enum pend_status (*open)(void **stepper, const struct pend_problem *problem,
                             struct pend_error *error);
    /**
     * Takes one accepted step towards `limit` (s, relative to the first instant; its sign is the
     * direction). With PEND_METHOD_LANDS `limit` is the next wanted instant, which steps reach
     * exactly and never pass; otherwise it is the last wanted instant, which a step may pass.
     * *reached becomes the time after the step, relative to the first instant. On failure
     * error->time is relative too and the text contains no time: the run adds both.
     */
    enum pend_status (*step)(void *stepper, double limit, double *reached,
                             struct pend_error *error);
    /**
     * Fills in the states at `count` instants t (s, relative to the first instant, monotonic)
     * inside the last step; with PEND_METHOD_LANDS only at its end. At the end of the step the
     * state is exactly the one that the next step starts from. An instant's bits do not depend on
     * the other instants in the call. Before the first step it is called for linear methods only.
     */
    void (*at)(void *stepper, const double t[], int count, const struct pend_points *points);
    /** Returns the work since `open`. O(1). */
    struct pend_stepper_counts (*counts)(const void *stepper);
    /**
     * Fills in the work of drives and the heat of friction since `open`, J, at `count` instants
     * inside the last step or at its end, as `at`; of real pendulums whose energy is not conserved.
     * NULL for a method that takes none of these.
     */
    void (*exchange)(const void *stepper, const double t[], int count, double work[],
                     double heat[]);
    /** Gives the last step as a power series of doubles; NULL if the method has no such series. */
    void (*series)(const void *stepper, struct pend_series *series);
    /**
     * Carries a small error of the state at the start of the last step to its end, to first order,
     * and adds to it what the step's own error may be; n values each, rad and rad/s. NULL where the
     * horizon has to follow the motion by power series of its own.
     */
    void (*spread)(void *stepper, double phi[], double rate[]);
    /**
     * Shows a checkpoint everything that steps have changed since `open`. A stepper that was just
     * opened for the same problem and into which a checkpoint restored this state continues with
     * the same bits, including `at` inside the last step. Restored bytes may have been altered: the
     * stepper then refuses the checkpoint, or computes wrong numbers and does no other harm. NULL
     * if the method's state cannot be saved.
     */
    void (*carry)(void *stepper, struct pend_checkpoint *checkpoint);
    /**
     * Ends the last step at t, relative to the first instant and inside the step; what it gave and
     * lost is that up to t. NULL for a method that takes no motions in pieces.
     */
    void (*cut)(void *stepper, double t);
    /** Returns the state at the end of the last step, which lives until the next one. NULL as
     * `cut`. */
    struct pend_start (*end)(const void *stepper);
    /** Changes the state that the next step starts from; see pend_start. NULL as `cut`. */
    void (*put)(void *stepper, const struct pend_start *start);
    /** Frees a stepper and clears the pointer; NULL is accepted. */
    void (*close)(void **stepper);
};

/** Shows the counters of a stepper to a checkpoint, as pend_checkpoint_counts. */
void pend_stepper_counts_carry(struct pend_stepper_counts *counts,
                               struct pend_checkpoint *checkpoint);

/* Each method has a file method_X.c; the three of GSL share method_gsl.c. */
extern const struct pend_method pend_method_taylor, pend_method_ode23, pend_method_rkf45,
    pend_method_rk8pd, pend_method_msadams, pend_method_linear, pend_method_symplectic,
    pend_method_radau;

/* pend_method_taylor.extended points to this one */
extern const struct pend_method pend_method_taylor_extended;

/**
 * Returns a method's default of the absolute tolerance for a relative one, rad and rad/s. O(1).
 */
static inline double pend_method_atol(const struct pend_method *method, double rtol) {
    return method->atol_divisor > 0 ? rtol / method->atol_divisor : 0;
}

/**
 * Returns the method of a name, or NULL. The names are those of the API: taylor ode23 rkf45 rk8pd
 * msadams symplectic linear radau.
 */
const struct pend_method *pend_method_find(const char *name);

/**
 * Returns method number i of the table, from 0, or NULL beyond its end; the first is the default.
 */
const struct pend_method *pend_method_at(int i);
