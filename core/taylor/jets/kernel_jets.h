/* The series kernels of one tree, for each instruction set.
 * Leaves to others: memory, angles (jets).
 * Invariant: a kernel is called only on a processor that has its instruction set. */
#pragma once

#include "core/taylor/jets_system.h"
#include "core/tree/loads.h"

/* A state in which each value is a sum of two doubles, because rounding would otherwise accumulate
 * from step to step. n values each, padded with zeros to a multiple of 8, because kernels read
 * whole vectors. */
struct jets_state {
    double *phi, *phi_low, *rate, *rate_low;
    double time, late; /* s, in the time of the request, as a sum of two doubles; drives are
                        * evaluated at this time */
};

/** Sets the time of a state, s, to the sum of a start and the elapsed time. */
static inline void jets_state_time(struct jets_state *state, double start, double since) {
    double sum = start + since, part = sum - start;
    state->time = sum;
    state->late = (start - (sum - part)) + (since - part);
}

/* Output arrays: n values per instant; NULL if not needed. */
struct jets_values {
    double *phi, *rate, *acc, *force;
};

/* Number of a series' last terms to which the recurrence is fitted, and of later terms that it
 * extrapolates. */
enum { JETS_FITTED = 6, JETS_FORETOLD = 6 };

struct jets_left {
    int from, beyond; /* the order of the first of JETS_FITTED terms; how many of these exceed the
                       * step's order */
    double x, power;  /* the step in units, and x^from */
};

struct jets_kernel {
    /**
     * Computes all orders: rate_0 .. rate_order and force_0 .. force_{order - 1}, in powers of t /
     * unit.
     *
     * system  one tree; trees of up to 8 arms need a stride of 8.
     * order   >= 1.
     */
    void (*orders)(const struct jets_system *system, const struct jets_state *state,
                   const struct pend_loads *loads, double unit, int order);
    /** Computes the state x units of time after `from`, as sums of two doubles. */
    void (*advance)(const struct jets_system *system, int order, double x, double unit,
                    const struct jets_state *from, const struct jets_state *to);
    /**
     * Returns the step in units: the longest for which the first neglected term of phi is below
     * rtol times the motion of the step, or below atol. The term is extrapolated from each of the
     * last four terms, because for a symmetric start three of four vanish; the motion is estimated
     * from the first four. 2^1000 if all terms are zero, NaN if one is not finite.
     *
     * log_rtol, log_atol  binary logarithms.
     */
    double (*reach)(const struct jets_system *system, int order, double log_rtol, double log_atol);
    /** The values x[i] units after `from`, i = 0 .. count - 1, in rows of n. phi and rate are
     * required. A row's bits do not depend on the other rows. */
    void (*values)(const struct jets_system *system, int order, const double x[], int count,
                   double unit, const struct jets_state *from, const struct jets_values *values);
    /**
     * Propagates small errors of the angles, rad, and of the rates, rad/s, to x units after the
     * state of the expansion, to first order. Requires stored responses (pend_jets_answers).
     * Returns the largest error of a force at the start, N.
     *
     * phi, rate  in and out; padded with zeros to a multiple of 8.
     */
    double (*spread)(const struct jets_system *system, const struct pend_loads *loads,
                     const struct jets_spread *how, double phi[], double rate[]);
    /** Computes the sums of the terms that a step neglected: of the rates, in units, and of the
     * angles, divided by x; one value per arm, padded to a multiple of 8. */
    void (*left)(const struct jets_system *system, const struct jets_left *left, double rate[],
                 double phi[]);
    /** Computes the work of drives and the heat of friction per unit of time, as series in the same
     * variable, for a system with loads, after `orders`: coefficients 0 .. order - 1, J times
     * unit^2. O(n order^2). */
    void (*power)(const struct jets_system *system, int order, double work[], double heat[]);
    /** Replaces the real parts of the forces in fixed axes by the forces along the arms, for orders
     * below `order` of a system with torques. O(n order^2). */
    void (*along)(const struct jets_system *system, int order);
};

extern const struct jets_kernel pend_kernel_jets_base;
#ifdef __x86_64__
extern const struct jets_kernel pend_kernel_jets_avx2, pend_kernel_jets_avx512;
#endif
