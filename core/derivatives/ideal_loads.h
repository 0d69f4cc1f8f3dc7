/* Real pendulums whose derivatives can be computed from a known motion, like those of ideal
 * pendulums. A body with its center on its arm is equivalent to two points, m c / l at the tip and
 * m (1 - c / l) at the joint, with the inertia J' = I - m c (l - c). The terms of J' and torques in
 * the joints are forces across arms, whose derivatives need no products of series.
 * Leaves to others: memory (ideal), arithmetic (kernel_ideal).
 * Invariant: the choice depends on the pendulum and the parameters, so that all passes of a motion
 * use one kernel. */
#pragma once

#include "core/derivatives/ideal_system.h"
#include "core/derivatives/parameter.h"
#include "core/tree/loads.h"
#include "core/tree/tree.h"

/** Returns non-zero if the derivatives of a pendulum with respect to these parameters can be
 * computed from its motion. This is always true without terms. With terms, these are supported:
 * rods, bodies with centers on their arms, viscous friction, springs and torques in the joints, and
 * a moving pivot. Not supported: parameters of a drive, and bodies that are negligible compared
 * with their load, for which the system would lose digits. O(count), and with bodies O(n times the
 * number of arms on one arm) more; no allocation. */
int pend_ideal_suits(const struct pend_tree *tree, const struct pend_loads *loads, int count,
                     const struct pend_parameter parameter[]);

/** Sets the masses, inertias, friction and springs of a real pendulum. O(n). */
void pend_ideal_load(struct ideal_known *known, const struct pend_tree *tree,
                     const struct pend_loads *loads);

/** Sets the derivative with respect to a length or a term in one lane of a group, in multiples of
 * its unit `seed`. O(1). */
void pend_ideal_vary(struct ideal_known *known, struct ideal_group *group, int lane,
                     const struct pend_tree *tree, const struct pend_loads *loads,
                     struct pend_parameter by, double seed);
