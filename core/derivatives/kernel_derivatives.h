/* A motion with its derivatives by eight parameters: the general kernel in numbers that carry them,
 * by instruction set.
 * Leaves to others: which parameters, steps and instants there are (derivatives).
 * Invariant: a number is a value and, from DERIVATIVES_FIRST on, eight derivatives; an unsupported
 * set is never called. */
#ifndef PEND_KERNEL_DERIVATIVES_H
#define PEND_KERNEL_DERIVATIVES_H

#include <stddef.h>

#include "core/tree/loads.h"
#include "core/tree/tree.h"

enum { DERIVATIVES_LANES = 16, DERIVATIVES_FIRST = 8, DERIVATIVES_PASS = 8 };

/* What a motion is computed in. All arrays are numbers, n each in stored order, aligned to 64
 * bytes: DERIVATIVES_LANES doubles of which those between value and derivatives are not used. */
struct derivatives_pass {
    const struct pend_tree *tree;
    const struct pend_terms *terms; /* of an ideal pendulum those that have no row */
    int order;
    double start;                                /* s, of the first instant */
    double *len, *mass, *gravity;                /* gravity is one number */
    double *value;                               /* of the terms, terms->count */
    double *phi, *phi_low, *rate, *rate_low;     /* at the start of a step */
    double *end_phi, *end_low, *end_rate, *slow; /* at its end; `slow` is the rates' rounding */
    double *series;                              /* kernel->count numbers */
    double *place;     /* kernel->count numbers for order 1, of `observe` */
    double *share;     /* doubles: 1 / (j + 1), order + 2 of them */
    double time, unit; /* s, of the series' start, from the first instant; s, a power of two */
    int pressed;       /* the series of the forces is there */
};

/* A state and what follows from it: arrays of n numbers, NULL = not wanted; energies are one
 * number each. Across, along and joint forces as struct bodies_forces has them. */
struct derivatives_view {
    double *phi, *rate; /* always there */
    double *acc, *force;
    double *z_re, *z_im, *zd_re, *zd_im, *zdd_re, *zdd_im;
    double *joint_along, *joint_across, *tip_across;
    double *kinetic, *potential;
};

struct derivatives_kernel {
    /** Numbers of a series to an order, for `series` and `place`. O(harmonics). */
    size_t (*count)(const struct pend_terms *terms, int n, int order);
    /**
     * Expands about the start of the step, in pass->unit.
     *
     * log_rtol, log_atol  binary logarithms of the tolerances, as of the taylor method.
     *
     * Returns the step in units within which the value and every derivative keep the tolerance; a
     * derivative that is below 2^-40 of the motion counts as that large. NaN where a coefficient
     * is not finite. O(n order^2).
     */
    double (*expand)(const struct derivatives_pass *pass, double log_rtol, double log_atol);
    /** The series of the forces along the arms, after `expand`: a quarter of what that takes.
     * O(n order^2). */
    void (*press)(const struct derivatives_pass *pass);
    /** The state at the end of a step of x units. O(n order). */
    void (*advance)(const struct derivatives_pass *pass, double x);
    /** phi, rate and, where wanted, acc and force x units after the start; the force after `press`.
     * O(n order). */
    void (*values)(const struct derivatives_pass *pass, double x,
                   const struct derivatives_view *view);
    /**
     * Everything else of the view from its phi and rate, and acc and force where `dynamics` asks
     * for them: O(n). time: s, the request's own. Accelerations of tips and forces at joints need
     * `dynamics`.
     */
    void (*observe)(const struct derivatives_pass *pass, double time, int dynamics,
                    const struct derivatives_view *view);
};

extern const struct derivatives_kernel pend_kernel_derivatives_base;
#ifdef __x86_64__
extern const struct derivatives_kernel pend_kernel_derivatives_avx2, pend_kernel_derivatives_avx512;
#endif

/** Returns the kernel of the best instruction set that runs here. O(1). */
const struct derivatives_kernel *pend_kernel_derivatives(void);

#endif
