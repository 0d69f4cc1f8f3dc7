/* One step of a trajectory in numbers of 62 digits, by instruction set.
 * Leaves to others: memory, tolerances, the time loop (method_quad).
 * Invariant: the same bits in every instruction set. */
#ifndef PEND_KERNEL_QUAD_H
#define PEND_KERNEL_QUAD_H

#include <stddef.h>

#include "core/tree/loads.h"
#include "core/tree/tree.h"

/* Numbers are four doubles each, those of an arm behind each other. */
struct quad_series {
    const struct pend_tree *tree;
    int order;
    int precise; /* coefficients from this order on are so small that their first two doubles are
                    enough */
    struct pend_loads loads; /* what acts on the tree */
    double start, time; /* s, whose sum is where the step begins in the time of drives; as exact */
    double unit;        /* s, a power of two */
    double *phi, *rate; /* where the step begins: 4 n doubles each */
    double *phi_end, *rate_end; /* where it ends */
    double *numbers;            /* the series and the tree system, aligned to 64 */
};

/* The values of all arms at an instant; acc, force and theta may be NULL. */
struct quad_values {
    double *phi, *rate, *acc, *force, *theta;
};

struct quad_kernel {
    /** Doubles that `numbers` needs; terms: NULL for ideal pendulums. */
    size_t (*count)(const struct pend_terms *terms, int n, int order);
    /** Expands about the start; returns the longest step, in units, or NaN where a number is not
     * finite. */
    double (*expand)(const struct quad_series *series, double log_rtol, double log_atol);
    /** Computes the end of a step from `time` to `reached`, s, both taken as exact. */
    void (*advance)(const struct quad_series *series, double time, double reached);
    /** Values at an instant t of a step that begins at `time`, rounded. */
    void (*values)(const struct quad_series *series, double time, double t,
                   const struct quad_values *values);
    /** The power of drives, and what friction and the air take, of a real pendulum, as series about
     * the start: `order` coefficients each, J times unit^2, rounded. */
    void (*power)(const struct quad_series *series, double work[], double heat[]);
};

extern const struct quad_kernel pend_kernel_quad_base;
#ifdef __x86_64__
extern const struct quad_kernel pend_kernel_quad_avx2, pend_kernel_quad_avx512;
#endif

#endif
