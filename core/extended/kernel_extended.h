/* One step of a trajectory in numbers of 32 digits, for each instruction set.
 * Leaves to others: its start and end (extended).
 * Invariant: the same bits in every instruction set with fused multiply-add. */
#pragma once

#include <stddef.h>

#include "core/base/isa.h"
#include "core/tree/terms.h"

/* A state: n values in each array. */
struct extended_state {
    double *phi, *phi_low, *rate, *rate_low; /* angles, rad, and rates, rad/s: sums of two
                                              * doubles */
    double time;                             /* s; taken as exact */
};

struct extended_motion {
    int n, order;
    int precise; /* above this order one double suffices for a coefficient */
    const int *parent, *end;
    double log_rtol, log_atol;      /* binary logarithms */
    struct extended_state from, to; /* start and end of the step */
    const double *len, *mass;
    double gravity, unit, stop;     /* s: next unit, end of the trajectory; unit and stop - time
                                     * have one sign */
    double start;                   /* s, time 0 in the time of drives; taken as exact */
    const struct pend_terms *terms; /* terms of real pendulums; NULL = ideal pendulums */
    double *value;                  /* values of the terms */
    double *share;                  /* 1 / (j + 1) of order j, up to order + 1 */
    double *series; /* rate, force, turn_re, turn_im, orders 0 .. order + 1, then scratch */
};

enum { EXTENDED_DONE = 1, EXTENDED_BAD = 2 };

/* Values of all arms at several instants, instant i of arm k at [i * n + k]. phi and rate are
 * required; the others may be NULL. */
struct extended_values {
    double *phi, *phi_low, *rate, *rate_low, *acc, *force;
};

struct extended_kernel {
    int width; /* number of doubles in a vector: the most instants that `values` accepts */
    /** Returns the number of doubles that `series` needs; terms: NULL for ideal pendulums. */
    size_t (*series_count)(const struct pend_terms *terms, int n, int order);
    /**
     * Takes one step, which never goes beyond `stop`.
     *
     * Returns flags: EXTENDED_DONE if `stop` is reached, EXTENDED_BAD if a value is not finite or
     * the time does not advance.
     */
    int (*step)(struct extended_motion *motion);
    /**
     * Computes the values at `count` instants t, s, inside the last step; to be called before
     * `from` and `to` are swapped.
     *
     * unit  s, unit of that step.
     */
    void (*values)(const struct extended_motion *motion, double unit, int count, const double t[],
                   const struct extended_values *to);
    /**
     * Computes the power of drives, and of friction and drag, of a real pendulum as series about
     * the start of the last step: `order` coefficients each, J times unit^2, rounded.
     *
     * unit  s, unit of that step.
     */
    void (*power)(const struct extended_motion *motion, double unit, double work[], double heat[]);
};

PEND_ISA_EACH(struct extended_kernel, pend_kernel_extended);
