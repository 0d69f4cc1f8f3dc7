/* What an integrator is: a problem to solve, and one self-describing descriptor a method.
 * Leaves to others: the methods themselves (method_*), the time loop and the samples (run).
 * Invariant: a stepper belongs to one run; its arrays are in the tree's stored order. */
#ifndef PEND_METHOD_H
#define PEND_METHOD_H

#include "core/base/checkpoint.h"
#include "core/tree/loads.h"
#include "core/tree/tree.h"

/* The instants that are wanted, strictly monotonic, forwards or backwards. */
struct pend_times {
    long count;         /* >= 1 */
    double start, span; /* without a list instant i is start + i * span / divisor, so that decimal
                           grids stay decimal */
    double divisor;     /* > 0 */
    const double *list; /* count instants, or NULL; not owned */
};

/**
 * Instant i of the wanted instants, s. i from 0 to count - 1. O(1).
 */
double pend_times_at(const struct pend_times *times, long i);

/**
 * Instants first .. first + count - 1, s, the same numbers as one by one. O(count).
 */
void pend_times_list(const struct pend_times *times, long first, int count, double t[]);

struct pend_problem {
    const struct pend_tree *tree; /* must outlive every run of it */
    struct pend_loads loads;      /* what acts on the tree */
    const double *phi,
        *rate; /* start at the first instant, n values each, stored order; copied by the run */
    /* what rounding to doubles has left of the start, n values each; NULL = nothing; methods
     * that carry no more than doubles do not look */
    const double *phi_low, *rate_low;
    struct pend_times times;
    double rtol, atol; /* of the local error; 0 = the method's default */
    int atol_given;    /* non-zero: atol is meant as it stands, 0 included */
    double step;       /* s, fixed-step methods only; 0 = the method's choice */
    long step_cap;     /* most steps a run may take, 0 = no limit */
    int no_turns; /* angles are handed out as the run has them: less the whole turns of a huge start
                     (turns.h) */
    double accuracy; /* of the answer, > 0: the run estimates how long it is kept (horizon.h); 0 =
                        nobody asks */
    int no_drift;    /* nobody asks for the energy's drift: it is not looked at, and told as 0 */
};

/* The least atol that methods with one tolerance for each component obey, as a part of rtol: a
 * component that passes 0 has no relative error, and would hold a step up for ever. */
#define PEND_METHOD_ATOL_LEAST 1e-6

enum {
    PEND_METHOD_LANDS = 1, /* no dense output: each step must be cut at the next wanted instant */
    PEND_METHOD_TOLERANCES = 2, /* obeys rtol and atol */
    PEND_METHOD_FIXED_STEP = 4, /* obeys step */
    PEND_METHOD_LINEAR =
        8, /* solves (lin), not (aaa): `at` fills acc too, forces follow from that motion */
    PEND_METHOD_THETA = 32, /* `at` fills theta too, of as many digits as the start had */
    PEND_METHOD_SERIES =
        16 /* `at` fills acc and force too, cheaper than evaluating the equations */
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

/* The last step as the power series that it was taken by, about its start; valid until the next
 * step. Of a problem that names an accuracy, PEND_SERIES_BEYOND coefficients are known beyond
 * the order that the step has. */
struct pend_series {
    const struct pend_jets *jets;
    const struct jets_state *begin;
    int order;
    double unit, time,
        reached; /* s; time and reached are the step's ends, relative to the first instant */
};

/* Evaluations are sweeps over the whole tree: right-hand sides, or orders of a series; work is
 * measured in them. */
struct pend_stepper_counts {
    long steps, rejected, evaluations;
};

struct pend_method {
    const char *name;    /* as in the contract: "taylor" */
    const char *summary; /* one sentence for the documentation */
    unsigned flags;
    double rtol_default, rtol_min, rtol_max; /* 0 where PEND_METHOD_TOLERANCES is not set */
    /* the default of atol is rtol over atol_divisor, or 0 where that is 0 */
    double atol_divisor, atol_min, atol_max;
    double step_min, step_max;          /* s; 0 where PEND_METHOD_FIXED_STEP is not set */
    const struct pend_method *extended; /* the same in numbers of about 32 digits, answers rounded;
                                           NULL = there is none */

    /** Makes a stepper at the problem's first instant; NULL on failure. The run has checked the
     * problem. */
    enum pend_status (*open)(void **stepper, const struct pend_problem *problem,
                             struct pend_error *error);
    /**
     * Takes one accepted step towards `limit` (s, relative to the first instant; its sign is the
     * direction): the next wanted instant where PEND_METHOD_LANDS is set, never to be passed and to
     * be reached exactly; else the last wanted instant, which a step may pass. *reached becomes the
     * time after the step, relative to the first instant. On failure error->time is relative too
     * and the text names no time: the run adds both.
     */
    enum pend_status (*step)(void *stepper, double limit, double *reached,
                             struct pend_error *error);
    /**
     * The states at `count` instants t (s, relative to the first instant, monotonic) inside the
     * last step; with
     * PEND_METHOD_LANDS only at its end. The end of the step gives exactly the state that the next
     * step starts from. An instant's bits do not depend on the others in the call. Before the first
     * step only linear methods are asked.
     */
    void (*at)(void *stepper, const double t[], int count, const struct pend_points *points);
    struct pend_stepper_counts (*counts)(const void *stepper);
    /** The last step as a power series of doubles; NULL where steps are not. */
    void (*series)(const void *stepper, struct pend_series *series);
    /**
     * Shows a checkpoint all that steps have changed since `open`; where the checkpoint puts it
     * back, into a stepper that was just opened for the same problem, that one goes on as this one
     * would have, `at` inside the last step too, bit for bit. What is put back may have been
     * altered: it refuses the checkpoint, or harms nothing but the numbers. NULL: it cannot be told
     * from outside.
     */
    void (*carry)(void *stepper, struct pend_checkpoint *checkpoint);
    void (*close)(void **stepper);
};

/** Shows a checkpoint the counters of a stepper, as pend_checkpoint_counts. */
void pend_stepper_counts_carry(struct pend_stepper_counts *counts,
                               struct pend_checkpoint *checkpoint);

/* One a file, method_X.c; the three of GSL share method_gsl.c. */
extern const struct pend_method pend_method_taylor, pend_method_ode23, pend_method_rkf45,
    pend_method_rk8pd, pend_method_msadams, pend_method_linear, pend_method_symplectic;

/* what pend_method_taylor.extended points to */
extern const struct pend_method pend_method_taylor_extended;
/* and the same in numbers of about 62 digits */
extern const struct pend_method pend_method_taylor_quad;

/**
 * The absolute tolerance that a method takes for a relative one where none is given, rad and rad/s.
 * O(1).
 */
static inline double pend_method_atol(const struct pend_method *method, double rtol) {
    return method->atol_divisor > 0 ? rtol / method->atol_divisor : 0;
}

/**
 * The method of a name, or NULL. The names are the contract's: taylor ode23 rkf45 rk8pd msadams
 * symplectic linear.
 */
const struct pend_method *pend_method_find(const char *name);

/**
 * Method number i of the table, from 0, or NULL beyond its end; the first is the default.
 */
const struct pend_method *pend_method_at(int i);

#endif
