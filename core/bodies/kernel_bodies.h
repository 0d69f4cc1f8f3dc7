/* The general kernel for one pendulum in doubles, by instruction set.
 * Leaves to others: memory (bodies), several pendulums in lanes (ensemble), more digits (extended).
 * Invariant: a kernel is called only on a processor that has its instruction set. */
#pragma once

#include "core/bodies/bodies_system.h"
#include "core/tree/loads.h"

/* A state in stored order: n angles, rad, with their low-order parts or NULL; n angular velocities,
 * rad/s; the time as a sum of two doubles, s. */
struct bodies_state {
    const double *phi, *phi_low, *rate;
    double time, late;
};

struct bodies_kernel {
    /**
     * Computes all orders: rate_1 .. rate_order and force_0, in powers of t / unit.
     *
     * system  arrays padded to eight arms; len, mass and value are set.
     * unit    s, a power of two of either sign.
     * order   >= 1.
     */
    void (*orders)(const struct bodies_system *system, const struct bodies_state *state,
                   double gravity, double unit, int order);
    /** Computes the series of forces along the arms, orders 1 .. order - 1, after `orders`. O(n
     * order^2). */
    void (*forces)(const struct bodies_system *system, int order);
    /** Computes the power of drives and of friction as series in the same variable, after `orders`:
     * coefficients 0 .. count - 1, J times unit^2, where count is order .. 2 order - 1. O(n order
     * count). */
    void (*power)(const struct bodies_system *system, double unit, int order, int count,
                  double work[], double heat[]);
    /** Returns the longest step in units, at most `far`, that dry friction at the joints allows,
     * after `orders` to at least order 4. O(n). */
    double (*reach)(const struct bodies_system *system, double far);
};

extern const struct bodies_kernel pend_kernel_bodies_base;
#ifdef __x86_64__
extern const struct bodies_kernel pend_kernel_bodies_avx2, pend_kernel_bodies_avx512;
#endif

/** Returns the kernel of the best instruction set of this processor. O(1). */
const struct bodies_kernel *pend_kernel_bodies(void);
