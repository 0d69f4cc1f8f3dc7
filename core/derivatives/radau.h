/* A step of Radau IIA of 7 stages and order 13: its stages by Newton's method, its error, and the
 * step of a neighbour. Leaves to others: coefficients (radau_table), derivatives of accelerations
 * (kernel_derivatives), lengths of steps and states inside them (method_radau).
 * Invariant: `begin`, `bent`, `gain` and the power belong to the last step; the next step uses only
 * these and the length of the last step.
 *
 * Source: Hairer and Wanner, Solving Ordinary Differential Equations II, IV.8. The stages differ
 * from the start by Z in the rates and by Q = h (c rate + a Z) in the angles, so that only the
 * rates are unknown: 0 = R = h a acc(phi + Q, rate + Z) - Z. With the derivatives K with respect to
 * the angles and C with respect to the rates at the start, Newton's method separates in the
 * eigenvectors of 1/a, whose eigenvalues are mu: with m = mu / h, (m - C - K / m) dW = m (to R), dZ
 * = from dW: one real system, and one complex system for each complex pair, each with as many
 * unknowns as there are arms. R is computed without 1/a, so that its rounding does not grow. There
 * is only one order, because orders 5 and 9 took more evaluations at every tolerance from 1e-4
 * on. */
#pragma once

#include "core/derivatives/kernel_derivatives.h"
#include "core/derivatives/radau_table.h"
#include "core/integrate/methods/method.h"

/* angles as sums of two doubles, and rates; n values each */
struct radau_state {
    double *phi, *low, *rate;
};

/* the scalars of a checkpoint, which precede its rows of n */
struct radau_scalars {
    double time, reached; /* s, relative to `start`: start and end of the last step */
    double last, size;    /* s: length of the last step, signed; length of the next step, > 0 */
    double given, lost;   /* J, work of drives and heat of friction up to the start of the last
                           * step */
    double power_in[RADAU_STAGES], power_out[RADAU_STAGES]; /* W, power of drives and of friction at
                                                             * the stages of the last step */
};

struct radau {
    const struct derivatives_kernel *kernel;
    const struct pend_tree *tree;
    struct pend_loads loads;
    struct pend_terms none; /* an empty list of terms, for an ideal pendulum */
    int n, gives;           /* number of arms; non-zero if drives or friction change the energy */
    int rough;              /* the previous step was not similar to the next one */
    double start;           /* s, the first instant in the time of the request */
    double rtol, atol;
    struct pend_stepper_counts counts;
    struct radau_scalars *kept;
    struct radau_state begin, end, stage, near;
    double *bent, *gain;         /* Q and Z of the last step, n values per stage */
    double *try_bent, *try_gain; /* Q and Z of the tried step */
    double *pull, *change;       /* accelerations of the stages, then R; dZ; n values per stage */
    double *first;               /* accelerations at the start */
    double *by_phi, *by_rate;    /* K and C, n rows of n */
    double *matrix[2]; /* factors of the matrices for each pole: real and imaginary parts */
    double *sum[2];    /* right-hand sides */
    double *off_phi, *off_rate;              /* n estimated errors each, at the end of the last
                                              * step */
    double *level_phi, *level_rate;          /* the unit of errors */
    double *view_phi, *view_rate, *view_acc; /* n numbers with derivatives each */
    int *swap;                               /* row exchanges: n per pole */
    struct derivatives_pass pass;
    void *work;
};

/** Adds `more` to a sum of two doubles: *high + *rest = x + low + more. */
static inline void radau_add(double x, double low, double more, double *high, double *rest) {
    double d = low + more, sum = x + d, part = sum - x;
    *high = sum;
    *rest = (x - (sum - part)) + (d - part);
}

/** Computes the Lagrange polynomials of the nodes, including the start if `zero`, at a fraction x
 * of the step. */
void pend_radau_weights(double x, int zero, double weight[RADAU_STAGES]);

/** Returns a weighted sum over the stages, for arm k. */
double pend_radau_sum(const struct radau *r, const double weight[RADAU_STAGES], const double rows[],
                      int k);

/** Computes the state that differs from the start of the step by Q and Z. */
void pend_radau_differ(const struct radau *r, const double bent[], const double gain[],
                       const struct radau_state *state);

/** Computes the data that all tries of a step share: the accelerations at its start, `begin` at
 * kept->time, and their derivatives. O(n^2). */
void pend_radau_begin(struct radau *r);

/**
 * Tries a step of length h, s, signed; the results go into try_bent and try_gain. O(n^3).
 *
 * longer  out: factor for the length of the next step.
 *
 * Returns its error relative to the allowed error; infinite if its stages do not converge.
 */
double pend_radau_try(struct radau *r, double h, double *longer);

/** Implements the method's `spread`. */
void pend_radau_spread(struct radau *r, double phi[], double rate[]);
