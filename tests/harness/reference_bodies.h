/* The Lagrangian equations of a real pendulum with a dense mass matrix, through GSL: the
 * independent check of the general kernel.
 * Leaves to others: anything that has to be fast.
 * Invariant: shares no formula with bodies; arms in the tree's stored order. */
#ifndef PEND_REFERENCE_BODIES_H
#define PEND_REFERENCE_BODIES_H

#include "core/bodies/bodies.h"

/**
 * phi'' and the forces in the arms, from points: every arm is three of them, its tip's mass, the
 * middle of its rod and the center of its body, with inertias of their own. The mass matrix is sum
 * of m Re(conj(B_j) B_k), B the derivatives of the points' places, and forces are the sums of m
 * (z'' + i g) and of what the air does, over what hangs on a joint.
 *
 * Parameters as pend_bodies_at.
 *
 * PEND_NO_MEMORY  allocates O(n^2).
 * PEND_NOT_FINITE the mass matrix is numerically not positive definite.
 * O(n^3).
 */
PEND_MUST_CHECK enum pend_status pend_reference_bodies(const struct pend_tree *tree,
                                                       const struct pend_loads *loads,
                                                       const struct bodies_state *state,
                                                       double acc[],
                                                       const struct bodies_forces *forces);

#endif
