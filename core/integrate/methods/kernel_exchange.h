/* The work of drives and the heat of friction in a step of a fast kernel's series: integrals of
 * their power at twelve Gauss-Legendre nodes at once, compiled for each instruction set.
 * Leaves to others: sums over steps (exchange), pendulums whose power has a series (jets).
 * Invariant: no allocation, no series of a product.
 *
 * The product of two series to order k has twice as many orders. They matter if a drive is fast
 * compared with the pendulum: cutting them off at order 25 lost 5e-9 of the energy's scale in 5 s
 * at 1000 rad/s. Twelve nodes integrate the first 24 orders exactly. Later orders decrease as the
 * step's last coefficients or as x^k / k!; their error is below 1e-16 of the power. Compared with
 * the series of the product, a run of 2 arms takes 1.2 times less time, of one arm 1.3 times less
 * (bench_bodies). */
#pragma once

#include "core/base/isa.h"
#include "core/taylor/jets/jets.h"

struct exchange_given {
    double work, heat; /* J */
};

struct exchange_kernel {
    /**
     * Computes the work and the heat from the start of the expansion to x units after it.
     *
     * jets   suitable for pend_exchange_at_nodes, expanded with `loads` to at least `order`.
     * unit   s, unit of the expansion.
     *
     * O(n order).
     */
    struct exchange_given (*given)(const struct pend_jets *jets, const struct pend_loads *loads,
                                   double unit, int order, double x);
};

PEND_ISA_EACH(struct exchange_kernel, pend_kernel_exchange);

/** Returns non-zero if the kernel supports the power of a pendulum: viscous friction, a moving
 * pivot and, with up to eight arms, torques. Otherwise the power is computed as a series
 * (pend_jets_power). O(1). */
static inline int pend_exchange_at_nodes(const struct pend_jets *jets) {
    const struct jets_loads *loads = &jets->loads;
    if (!jets->real || jets->general) return 0;
    // for bodies, the force of the pivot has no series
    if (loads->bodies) return !loads->moves && loads->terms->one[PEND_TERM_DRAG_PER_MASS] < 0;
    return jets->system.n <= PEND_JETS_PAD ||
           (!loads->drives && loads->terms->row[PEND_TERM_TORQUE] < 0);
}
