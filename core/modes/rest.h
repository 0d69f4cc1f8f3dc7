/* Equilibria of real pendulums near given angles, in O(n) per step.
 * Leaves to others: motion about an equilibrium (damped, response), drives that depend on time.
 * Invariant: at an equilibrium the torques of gravity, springs, constant torques and a constant
 * acceleration of the pivot cancel at every arm, to the rounding error of the largest of them. */
#pragma once

#include "core/tree/loads.h"
#include "core/tree/tree.h"

/* Mass properties of an arm in its own frame: alone, or with the masses of its sub-tree as points
 * at the joints. */
struct rest_body {
    double mass;      /* kg, mass */
    double moment[2]; /* kg m, sum of m p about the joint, along and across the arm */
    double inertia;   /* kg m^2 about the joint */
};

/** Returns the mass properties of stored arm k without its sub-tree: tip, rod and body. O(1). */
struct rest_body pend_rest_arm(const struct pend_tree *tree, const struct pend_loads *loads, int k);

/** Returns the linear drag of the tip of stored arm k, N s/m, at small speeds, in the form of a
 * mass at the tip. */
struct rest_body pend_rest_drag(const struct pend_tree *tree, const struct pend_loads *loads,
                                int k);

/** Returns the damping of the joint of stored arm k at small rates r, N m s/rad: the torque of
 * damping and friction is -damper r. O(1). */
double pend_rest_damper(const struct pend_loads *loads, int k);

/** Returns the ratio of the joint's rate, rad/s, or the tip's speed, m/s, of stored arm k to the
 * limit below which pend_rest_damper and pend_rest_drag are valid: the larger ratio; 0 if there is
 * no limit. O(1). */
double pend_rest_beyond(const struct pend_loads *loads, int k, double rate, double speed);

/** Computes the point of its parent's frame, m, at which stored arm k > 0 is attached. O(1). */
void pend_rest_point(const struct pend_tree *tree, const struct pend_loads *loads, int k,
                     double point[2]);

/**
 * Adds to each arm's mass, first moment and inertia those of its sub-tree, whose arms count as
 * points at the joints.
 *
 * body  n, in: arms without their sub-trees. O(n).
 */
void pend_rest_gather(const struct pend_tree *tree, const struct pend_loads *loads,
                      struct rest_body body[]);

/** Computes the acceleration that acts on a mass, m/s^2: i g and the constant acceleration of the
 * pivot. O(1). */
void pend_rest_pull(const struct pend_loads *loads, double pull[2]);

/**
 * Computes the torques of the joints that hold a pendulum at rest at given angles.
 *
 * phi     n angles, rad, stored order.
 * torque  out, n: N m, for a cart N; 0 at an equilibrium.
 * size    out, n: the torque that holds the arm with its sub-tree horizontal, plus the torque of
 *         its spring at 1 rad; for a cart the weight. If both are 0, its inertia times 1/s^2.
 *
 * PEND_NO_MEMORY  O(n).
 */
PEND_MUST_CHECK enum pend_status pend_rest_torques(const struct pend_tree *tree,
                                                   const struct pend_loads *loads,
                                                   const double phi[], double torque[],
                                                   double size[]);

/**
 * Finds the equilibrium near a state, by Newton's method with an O(n) elimination. If that does not
 * converge, minimizes the potential energy from the start.
 *
 * phi     in: n angles to start from, rad, stored order; out: the equilibrium.
 * stable  out: non-zero if the potential energy is a minimum there, so that the equilibrium is
 *         stable; NULL if not needed.
 *
 * PEND_NO_MEMORY
 * PEND_NOT_FINITE neither 200 Newton steps nor 1000 minimizing ones converge; there may be no
 * equilibrium, if a constant torque turns an arm without a spring. O(n) per step. A start at an
 * equilibrium, even an unstable one, is returned unchanged.
 */
PEND_MUST_CHECK enum pend_status pend_rest_find(const struct pend_tree *tree,
                                                const struct pend_loads *loads, double phi[],
                                                int *stable, struct pend_error *error);
