/* Eight derivatives of an ideal pendulum with known motion: a linear recurrence whose coefficients
 * are plain numbers, for each instruction set.
 * Leaves to others: the motion, memory, the choice of parameters (ideal).
 * Invariant: a derivative does not depend on the other lanes; a kernel is called only on a
 * processor that has its instruction set. */
#pragma once

#include "core/derivatives/ideal_system.h"

struct ideal_kernel {
    /** Computes everything else that the derivatives need of the motion, from its rates and forces:
     * cosines and sines of `known->system.angle`, and the factorization. O(n order^2). */
    void (*know)(const struct ideal_known *known);
    /** Computes the series of a group. Returns the longest step in units for which each of its
     * derivatives keeps the tolerance, as in the general kernel (kernel_derivatives.h); NaN if a
     * coefficient is not finite. O(n order^2). */
    double (*expand)(const struct ideal_known *known, const struct ideal_group *group, double unit,
                     double log_rtol, double log_atol);
    /** Computes the state at the end of a step of x units. O(n order). */
    void (*advance)(const struct ideal_known *known, const struct ideal_group *group, double unit,
                    double x);
    /** Computes the group's `out` x units after the start: phi and rate, and acc and force if `all`
     * is not 0. O(n order). */
    void (*values)(const struct ideal_known *known, const struct ideal_group *group, double unit,
                   double x, int all);
};

extern const struct ideal_kernel pend_kernel_ideal_base;
#ifdef __x86_64__
extern const struct ideal_kernel pend_kernel_ideal_avx2, pend_kernel_ideal_avx512;
#endif

/** Returns the kernel of the best instruction set of this processor. O(1). */
const struct ideal_kernel *pend_kernel_ideal(void);
