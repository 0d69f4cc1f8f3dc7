/* Real pendulums whose derivatives follow from a motion that is known, as those of ideal ones do.
 * A body whose center is on its arm moves as two points do, m c / l at the tip and m (1 - c / l)
 * at the joint, with J' = I - m c (l - c) about both of them: what J' asks for and torques in the
 * joints are forces across arms whose derivatives need no products of series.
 * Leaves to others: memory (ideal), arithmetic (kernel_ideal).
 * Invariant: which pendulum and which parameters there are decides, so that all passes of a motion
 * go one way. */
#ifndef PEND_IDEAL_LOADS_H
#define PEND_IDEAL_LOADS_H

#include "core/derivatives/ideal_system.h"
#include "core/derivatives/parameter.h"
#include "core/tree/loads.h"
#include "core/tree/tree.h"

/**
 * Returns non-zero if the derivatives of a pendulum by these parameters follow from its motion:
 * without terms always; with rods, bodies whose centers are on their arms, viscous friction,
 * springs and torques in the joints and a pivot that moves as it is told, unless a drive is
 * differentiated by, or there are bodies that are next to nothing beside what hangs on them: the
 * system of theirs is solved in a form that would lose digits there. O(count + n times the arms
 * that an arm carries), with bodies; no allocation.
 */
int pend_ideal_suits(const struct pend_tree *tree, const struct pend_loads *loads, int count,
                     const struct pend_parameter parameter[]);

/** Fills in the masses, inertias, friction and springs of a real pendulum. O(n). */
void pend_ideal_load(struct ideal_known *known, const struct pend_tree *tree,
                     const struct pend_loads *loads);

/** The unit `seed` of a derivative by a length or a term, in a lane of a group. O(1). */
void pend_ideal_vary(struct ideal_known *known, struct ideal_group *group, int lane,
                     const struct pend_tree *tree, const struct pend_loads *loads,
                     struct pend_parameter by, double seed);

#endif
