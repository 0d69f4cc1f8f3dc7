/* What drives give and friction takes within a step of a quick kernel's series, as integrals of
 * their power: at twelve Gauss-Legendre nodes side by side, compiled for each instruction set.
 * Leaves to others: sums over steps (exchange), pendulums whose power has a series (jets).
 * Invariant: no allocation, no series of a product. The product of two series to order k has
 * twice as many orders, and of a drive that is quick beside the pendulum they matter: cut off at
 * order 25 they lost 5e-9 of the energy's scale in 5 s at 1000 rad/s. Twelve nodes integrate the
 * first 24 orders as they are, and later ones, which fall off as the step's last coefficients or
 * as x^k / k!, to below 1e-16 of the power. Beside the product's series, 2 arms of a run take 1.2
 * times less, one 1.3 times less (bench_bodies). */
#pragma once

#include "core/base/isa.h"
#include "core/taylor/jets/jets.h"

struct exchange_given {
    double work, heat; /* J */
};

struct exchange_kernel {
    /**
     * What was given and lost from the start of the expansion to x units after it.
     *
     * jets   pend_exchange_at_nodes, expanded to `order` at least with `loads`.
     * unit   s, of the expansion.
     *
     * O(n order).
     */
    struct exchange_given (*given)(const struct pend_jets *jets, const struct pend_loads *loads,
                                   double unit, int order, double x);
};

PEND_ISA_EACH(struct exchange_kernel, pend_kernel_exchange);

/** Non-zero if the kernel takes the power of a pendulum: viscous friction, a pivot that moves, and
 * of up to eight arms torques; all others have series (pend_jets_power). O(1). */
static inline int pend_exchange_at_nodes(const struct pend_jets *jets) {
    const struct jets_loads *loads = &jets->loads;
    if (!jets->real || jets->general) return 0;
    // bodies have their pivot's force from what their series leave out
    if (loads->bodies) return !loads->moves && loads->terms->one[PEND_TERM_DRAG_PER_MASS] < 0;
    return jets->system.n <= PEND_JETS_PAD ||
           (!loads->drives && loads->terms->row[PEND_TERM_TORQUE] < 0);
}
