/* A motion with its derivatives with respect to eight parameters: the general kernel, in numbers
 * with derivatives, for each instruction set.
 * Leaves to others: the choice of parameters, steps and instants (derivatives).
 * Invariant: a number is a value and, from DERIVATIVES_FIRST on, eight derivatives; a kernel is
 * called only on a processor that has its instruction set. */
#pragma once

#include <stddef.h>

#include "core/tree/loads.h"
#include "core/tree/tree.h"

enum { DERIVATIVES_LANES = 16, DERIVATIVES_FIRST = 8, DERIVATIVES_PASS = 8 };

/* The memory of a motion. All arrays are numbers, n each in stored order, aligned to 64 bytes. A
 * number has DERIVATIVES_LANES doubles; those between value and derivatives are unused. */
struct derivatives_pass {
    const struct pend_tree *tree;
    const struct pend_terms *terms; /* terms; for an ideal pendulum an empty list */
    int order;
    double start;                                /* s, time of the first instant */
    double *len, *mass, *gravity;                /* gravity is one number */
    double *value;                               /* values of the terms, terms->count */
    double *phi, *phi_low, *rate, *rate_low;     /* state at the start of a step */
    double *end_phi, *end_low, *end_rate, *slow; /* state at the end of the step; `slow` is the
                                                  * low-order part of the rates */
    double *series;                              /* kernel->count numbers */
    double *place;     /* kernel->count numbers to order 1, which `observe` uses */
    double *share;     /* doubles: 1 / (j + 1), order + 2 values */
    double time, unit; /* s: start of the series, relative to the first instant; unit, a power of
                        * two */
    int pressed;       /* the series of the forces has been computed */
};

/* A state and derived quantities: arrays of n numbers, NULL if not needed; energies are one number
 * each. Across, along and joint forces are defined as in struct bodies_forces. */
struct derivatives_view {
    double *phi, *rate; /* required */
    double *acc, *force;
    double *z_re, *z_im, *zd_re, *zd_im, *zdd_re, *zdd_im;
    double *joint_along, *joint_across, *tip_across;
    double *kinetic, *potential;
};

struct derivatives_kernel {
    /** Returns how many numbers a series needs up to an order, for `series` and `place`.
     * O(harmonics). */
    size_t (*count)(const struct pend_terms *terms, int n, int order);
    /**
     * Expands about the start of the step, in pass->unit.
     *
     * log_rtol, log_atol  binary logarithms of the tolerances, as of the taylor method.
     *
     * Returns the step in units within which the value and every derivative keep the tolerance; a
     * derivative smaller than 2^-40 of the motion counts as 2^-40 of the motion. NaN if a
     * coefficient is not finite. O(n order^2).
     */
    double (*expand)(const struct derivatives_pass *pass, double log_rtol, double log_atol);
    /** Computes the series of the forces along the arms, after `expand`; takes a quarter of its
     * time. O(n order^2). */
    void (*press)(const struct derivatives_pass *pass);
    /** Computes the state at the end of a step of x units. O(n order). */
    void (*advance)(const struct derivatives_pass *pass, double x);
    /** Computes phi, rate and, on request, acc and force x units after the start; the force
     * requires `press`. O(n order). */
    void (*values)(const struct derivatives_pass *pass, double x,
                   const struct derivatives_view *view);
    /** Computes all other quantities of the view from its phi and rate; with `dynamics` also acc
     * and force. time: s, on the time axis of the request. Accelerations of tips and forces at
     * joints require `dynamics`. O(n). */
    void (*observe)(const struct derivatives_pass *pass, double time, int dynamics,
                    const struct derivatives_view *view);
};

extern const struct derivatives_kernel pend_kernel_derivatives_base;
#ifdef __x86_64__
extern const struct derivatives_kernel pend_kernel_derivatives_avx2, pend_kernel_derivatives_avx512;
#endif

/** Returns the kernel of the best instruction set of this processor. O(1). */
const struct derivatives_kernel *pend_kernel_derivatives(void);
