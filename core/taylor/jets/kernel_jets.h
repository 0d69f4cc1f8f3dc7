/* The series kernels of one tree, by instruction set.
 * Leaves to others: memory, angles (jets).
 * Invariant: a kernel is called only on a processor that has its instruction set. */
#ifndef PEND_KERNEL_JETS_H
#define PEND_KERNEL_JETS_H

#include "core/taylor/jets_system.h"
#include "core/tree/loads.h"

/* Sums of two doubles a value, as phi and phi' are carried from step to step; n values each,
 * padded with zeros to a multiple of 8: whole vectors of arms are read. */
struct jets_state {
    double *phi, *phi_low, *rate, *rate_low;
    double time, late; /* s, the request's own time as a sum of two, at which drives are taken */
};

/** Puts the time of a state, s, as the sum of a start and of what has passed since. */
static inline void jets_state_time(struct jets_state *state, double start, double since) {
    double sum = start + since, part = sum - start;
    state->time = sum;
    state->late = (start - (sum - part)) + (since - part);
}

/* Arrays for values: n values an instant, NULL = not wanted. */
struct jets_values {
    double *phi, *rate, *acc, *force;
};

/* The last terms of a step's series, from which those behind them are foretold. */
enum { JETS_FITTED = 6, JETS_FORETOLD = 6 };

struct jets_left {
    int from, beyond; /* the order of the first of JETS_FITTED terms; how many of these the step has
                         left out */
    double x, power;  /* the step in units, and x^from */
};

struct jets_kernel {
    /**
     * All orders: rate_0 .. rate_order and force_0 .. force_{order - 1}, in powers of t / unit.
     *
     * system  one tree; trees of up to 8 arms need a stride of 8.
     * order   >= 1.
     */
    void (*orders)(const struct jets_system *system, const struct jets_state *state,
                   const struct pend_loads *loads, double unit, int order);
    /**
     * The state x units after `from`, as sums of two doubles.
     */
    void (*advance)(const struct jets_system *system, int order, double x, double unit,
                    const struct jets_state *from, const struct jets_state *to);
    /**
     * The step in units: the longest at which the first term of phi that is left out, as each of
     * four trailing terms foretells it, is below rtol times the motion of the step, judged by its
     * leading terms, or below atol. Four, because a symmetric start makes three of four vanish.
     * 2^1000 where all are zero, NaN where one is not finite.
     *
     * log_rtol, log_atol  binary logarithms.
     */
    double (*reach)(const struct jets_system *system, int order, double log_rtol, double log_atol);
    /**
     * The values x[i] units after `from`, i = 0 .. count - 1, in rows of n. phi and rate are always
     * wanted. A row's bits do not depend on the other rows.
     */
    void (*values)(const struct jets_system *system, int order, const double x[], int count,
                   double unit, const struct jets_state *from, const struct jets_values *values);
    /**
     * What small errors of the angles, rad, and of the rates, rad/s, become x units after the state
     * expanded about, to first order; of systems that keep answers. Returns the largest error of a
     * force at the start, N.
     *
     * phi, rate  in and out; padded with zeros to a multiple of 8.
     */
    double (*spread)(const struct jets_system *system, const struct pend_loads *loads,
                     const struct jets_spread *how, double phi[], double rate[]);
    /**
     * The sums of the terms that a step left out, of the rates and of the angles over x, in units:
     * an array of a value a seat, in the order of seats, padded to a multiple of 8.
     */
    void (*left)(const struct jets_system *system, const struct jets_left *left, double rate[],
                 double phi[]);
    /**
     * The work of drives and the heat of friction per unit of time, as series of the same powers,
     * after `orders`, of a system with loads: the coefficients of order 0 .. order - 1, J times
     * unit^2. O(n order^2).
     */
    void (*power)(const struct jets_system *system, int order, double work[], double heat[]);
    /**
     * The forces along the arms of orders below `order`, of a system with torques, where their
     * real parts in fixed axes are. O(n order^2).
     */
    void (*along)(const struct jets_system *system, int order);
};

extern const struct jets_kernel pend_kernel_jets_base;
#ifdef __x86_64__
extern const struct jets_kernel pend_kernel_jets_avx2, pend_kernel_jets_avx512;
#endif

#endif
