/* Accelerations and forces of a real pendulum at one state, in O(n).
 * Leaves to others: ideal pendulums, which have quicker forms (dynamics), series of any order
 * (jets), the matrix form (reference).
 * Invariant: no allocation; arms in the tree's stored order. */
#ifndef PEND_BODIES_H
#define PEND_BODIES_H

#include <stddef.h>

#include "core/bodies/kernel_bodies.h"
#include "core/tree/loads.h"
#include "core/tree/tree.h"

/* Forces in an arm, N, n values each, in the arm's own frame; NULL = not wanted. The base exerts
 * (joint_along, joint_across) on the arm at its joint; the arm exerts (tip_along, tip_across) on
 * what is at its tip: the mass there and the arms that hang there. Along is positive where the arm
 * is compressed, across is counterclockwise. tip_along is the lambda of the paper. Those of a cart,
 * at both ends, are the force of the rail on it, along the rail and across it; the force along it
 * is the sum of those that the cart's spring, damping, friction and drive exert. */
struct bodies_forces {
    double *joint_along, *joint_across, *tip_along, *tip_across;
};

/** Bytes of scratch that pend_bodies_at needs. O(harmonics). */
size_t pend_bodies_bytes(const struct pend_tree *tree, const struct pend_terms *terms);

/**
 * Angular accelerations and forces of a moving pendulum.
 *
 * tree    n arms; all arrays in the tree's stored order.
 * loads   with terms; gravity of any finite value.
 * state   phi, rate, and the time, at which drives are taken.
 * work    pend_bodies_bytes bytes, aligned to 64; contents on entry do not matter.
 * acc     out, n values, rad/s^2; may be the array of rates.
 * forces  out; NULL to skip.
 *
 * The general kernel's order 0 (core/theory.md). Cannot fail; what overflows is not finite. O(n +
 * harmonics), no allocation.
 */
void pend_bodies_at(const struct pend_tree *tree, const struct pend_loads *loads,
                    const struct bodies_state *state, void *work, double acc[],
                    const struct bodies_forces *forces);

/**
 * Angular accelerations, and the power of what changes the energy.
 *
 * work     as of pend_bodies_at, which has the other parameters.
 * given    out, W: what drives do and a moving pivot does.
 * lost     out, W: what friction and the air take.
 */
void pend_bodies_power_at(const struct pend_tree *tree, const struct pend_loads *loads,
                          const struct bodies_state *state, void *work, double acc[], double *given,
                          double *lost);

/**
 * Lays a system of doubles into memory, with room for series up to an order.
 *
 * system  out: all of it, but for rate, force, turn_re and turn_im, which are series too.
 * memory  pend_bodies_system_bytes(tree, terms, order) bytes, aligned to 64.
 */
void pend_bodies_system(struct bodies_system *system, const struct pend_tree *tree,
                        const struct pend_loads *loads, int order, void *memory);
size_t pend_bodies_system_bytes(const struct pend_tree *tree, const struct pend_terms *terms,
                                int order);

#endif
