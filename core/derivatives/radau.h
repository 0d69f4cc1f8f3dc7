/* A step of Radau IIA of 7 stages and order 13: its stages by Newton's method, its error, and what
 * a neighbour's step would be. Leaves to others: coefficients (radau_table), derivatives of
 * accelerations (kernel_derivatives), lengths of steps and states inside them (method_radau).
 * Invariant: `begin`, `bent`, `gain` and the power belong to the last step; the next one uses
 * nothing else of it than its length.
 *
 * Source: Hairer and Wanner, Solving Ordinary Differential Equations II, IV.8. The stages differ
 * from the start by Z in the rates and by Q = h (c rate + a Z) in the angles, so that only the
 * rates are unknown: 0 = R = h a acc(phi + Q, rate + Z) - Z. With the derivatives K by the angles
 * and C by the rates at the start, Newton's method separates in the eigenvectors of 1/a, whose
 * eigenvalues are mu: with m = mu / h, (m - C - K / m) dW = m (to R),    dZ = from dW, one real
 * system and one complex one for each pair, of as many unknowns as arms. R is formed without 1/a,
 * so that its rounding does not grow. Orders 5 and 9 took more evaluations at every tolerance from
 * 1e-4 on, so that there is one order. */
#ifndef PEND_RADAU_H
#define PEND_RADAU_H

#include "core/derivatives/kernel_derivatives.h"
#include "core/derivatives/radau_table.h"
#include "core/integrate/methods/method.h"

/* angles as sums of two doubles, and rates; n values each */
struct radau_state {
    double *phi, *low, *rate;
};

/* what a checkpoint keeps beside rows of n */
struct radau_scalars {
    double time, reached; /* s, relative: the last step's ends */
    double last, size;    /* s: the last step's length, signed; the next one's, > 0 */
    double given, lost;   /* J, at the last step's start */
    double power_in[RADAU_STAGES], power_out[RADAU_STAGES]; /* W, at its stages */
};

struct radau {
    const struct derivatives_kernel *kernel;
    const struct pend_tree *tree;
    struct pend_loads loads;
    struct pend_terms none; /* of an ideal pendulum */
    int n, gives;           /* arms; drives and friction change the energy */
    int rough;              /* no step like the next one came before it */
    double start;           /* s, the first instant in the request's own time */
    double rtol, atol;
    struct pend_stepper_counts counts;
    struct radau_scalars *kept;
    struct radau_state begin, end, stage, near;
    double *bent, *gain;         /* Q and Z of the last step, n values a stage */
    double *try_bent, *try_gain; /* of a step that is tried */
    double *pull, *change;       /* accelerations of the stages, then R; dZ; n values a stage */
    double *first;               /* accelerations at the start */
    double *by_phi, *by_rate;    /* K and C, n rows of n */
    double *matrix[2]; /* the factors of the matrices, pole by pole: real and imaginary parts */
    double *sum[2];    /* right-hand sides */
    double *off_phi, *off_rate;              /* n, what the last step may be off by at its end */
    double *level_phi, *level_rate;          /* what errors are compared with */
    double *view_phi, *view_rate, *view_acc; /* n numbers with derivatives */
    int *swap;                               /* n a pole */
    struct derivatives_pass pass;
    void *work;
};

/** Adds `more` to a sum of two doubles: *high + *rest = x + low + more. */
static inline void radau_add(double x, double low, double more, double *high, double *rest) {
    double d = low + more, sum = x + d, part = sum - x;
    *high = sum;
    *rest = (x - (sum - part)) + (d - part);
}

/** Fills in the Lagrange polynomials of the nodes, with `zero` of the start too, at a part x of the
 * step. */
void pend_radau_weights(double x, int zero, double weight[RADAU_STAGES]);

/** Returns a weighted sum over the stages of the number of arm k. */
double pend_radau_sum(const struct radau *r, const double weight[RADAU_STAGES], const double rows[],
                      int k);

/** Fills in the state that differs by Q and Z from the start. */
void pend_radau_differ(const struct radau *r, const double bent[], const double gain[],
                       const struct radau_state *state);

/** What all tries of a step have in common, from `begin` at kept->time: accelerations there and
 * their derivatives. O(n^2). */
void pend_radau_begin(struct radau *r);

/**
 * Tries a step of h, s, signed, into try_bent and try_gain. O(n^3).
 *
 * longer  out: by what the next step's length is multiplied.
 *
 * Returns its error over what is allowed, infinite where its stages do not converge.
 */
double pend_radau_try(struct radau *r, double h, double *longer);

/** As the method's spread. */
void pend_radau_spread(struct radau *r, double phi[], double rate[]);

#endif
