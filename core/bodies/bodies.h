/* Accelerations and forces of a real pendulum at one state, in O(n).
 * Leaves to others: ideal pendulums, which have faster forms (dynamics), series of any order
 * (jets).
 * Invariant: no allocation; arms in the tree's stored order. */
#pragma once

#include <stddef.h>

#include "core/bodies/kernel_bodies.h"
#include "core/tree/loads.h"
#include "core/tree/tree.h"

/* Forces in an arm, N, n values each, in the arm's own frame; NULL if not needed. The parent or the
 * pivot exerts (joint_along, joint_across) on the arm at its joint; the arm exerts (tip_along,
 * tip_across) on the mass and the children at its tip. Along is positive if the arm is compressed,
 * across is counterclockwise. tip_along is the lambda of the paper. For a cart, both pairs are the
 * force of the rail on it, along and across the rail. The force along the rail is the sum of the
 * cart's spring, damping, friction and drive. */
struct bodies_forces {
    double *joint_along, *joint_across, *tip_along, *tip_across;
};

/** Returns the bytes of scratch that pend_bodies_at needs. O(harmonics). */
size_t pend_bodies_bytes(const struct pend_tree *tree, const struct pend_terms *terms);

/**
 * Computes angular accelerations and forces of a moving pendulum.
 *
 * tree    n arms; all arrays in the tree's stored order.
 * loads   with terms; gravity of any finite value.
 * state   phi, rate, and the time at which drives are evaluated.
 * work    pend_bodies_bytes bytes, aligned to 64; contents on entry are ignored.
 * acc     out, n values, rad/s^2; may be the array of rates.
 * forces  out; NULL to skip.
 *
 * The general kernel's order 0 (core/theory.md). Cannot fail; values that overflow are not finite.
 * O(n + harmonics), no allocation.
 */
void pend_bodies_at(const struct pend_tree *tree, const struct pend_loads *loads,
                    const struct bodies_state *state, void *work, double acc[],
                    const struct bodies_forces *forces);

/**
 * Computes angular accelerations, and the power of non-conservative terms.
 *
 * work   as for pend_bodies_at, like the other parameters.
 * given  out, W: the power of drives and of a moving pivot.
 * lost   out, W: the power dissipated by friction and drag.
 */
void pend_bodies_power_at(const struct pend_tree *tree, const struct pend_loads *loads,
                          const struct bodies_state *state, void *work, double acc[], double *given,
                          double *lost);

/**
 * Places a system of doubles in memory, with space for series up to an order.
 *
 * system  out: all members except the series rate, force, turn_re and turn_im.
 * memory  pend_bodies_system_bytes(tree, terms, order) bytes, aligned to 64.
 */
void pend_bodies_system(struct bodies_system *system, const struct pend_tree *tree,
                        const struct pend_loads *loads, int order, void *memory);
size_t pend_bodies_system_bytes(const struct pend_tree *tree, const struct pend_terms *terms,
                                int order);
