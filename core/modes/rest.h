/* Where a real pendulum can rest: an equilibrium near given angles, in O(n) a step.
 * Leaves to others: motion about it (damped, response), drives that depend on time.
 * Invariant: at an equilibrium the torques of gravity, springs, constant torques and a constant
 * acceleration of the pivot cancel at every arm, to the rounding error of the largest of them. */
#ifndef PEND_REST_H
#define PEND_REST_H

#include "core/tree/loads.h"
#include "core/tree/tree.h"

/* Masses of an arm in its own frame: alone, or with all that hangs on it as points. */
struct rest_body {
    double mass;      /* kg */
    double moment[2]; /* kg m, sum of m p about the joint, along and across the arm */
    double inertia;   /* kg m^2 about the joint */
};

/** The masses of stored arm k alone: its tip, its rod, its body. O(1). */
struct rest_body pend_rest_arm(const struct pend_tree *tree, const struct pend_loads *loads, int k);

/** The drag of the tip of stored arm k in the place of a mass there, N s/m, at small speeds. */
struct rest_body pend_rest_drag(const struct pend_tree *tree, const struct pend_loads *loads,
                                int k);

/** The damping of the joint of stored arm k at small rates, N m s/rad: -damper r is the torque of
 * all that rubs in it. O(1). */
double pend_rest_damper(const struct pend_loads *loads, int k);

/** How fast the joint of stored arm k turns, rad/s, or its tip moves, m/s, over the speed up to
 * which pend_rest_damper and pend_rest_drag hold: the larger; 0 where they hold at any. O(1). */
double pend_rest_beyond(const struct pend_loads *loads, int k, double rate, double speed);

/** The point, m, of its parent's frame at which stored arm k > 0 hangs. O(1). */
void pend_rest_point(const struct pend_tree *tree, const struct pend_loads *loads, int k,
                     double point[2]);

/**
 * Adds to every arm's mass, first moment and inertia those of the arms that hang on it, as points
 * at their joints.
 *
 * body  n, in: arms alone. O(n).
 */
void pend_rest_gather(const struct pend_tree *tree, const struct pend_loads *loads,
                      struct rest_body body[]);

/** What pulls on a mass, m/s^2: i g and the constant acceleration of the pivot. O(1). */
void pend_rest_pull(const struct pend_loads *loads, double pull[2]);

/**
 * Computes the torques of the joints that hold a pendulum at rest where it is.
 *
 * phi     n angles, rad, stored order.
 * torque  out, n: N m, N of a cart; 0 at an equilibrium.
 * size    out, n: what holds the arm and all that it carries horizontally, and its spring bent by 1
 *         rad; of a cart the weight. Of a pendulum without either its inertia times 1/s^2.
 *
 * PEND_NO_MEMORY  O(n).
 */
PEND_MUST_CHECK enum pend_status pend_rest_torques(const struct pend_tree *tree,
                                                   const struct pend_loads *loads,
                                                   const double phi[], double torque[],
                                                   double size[]);

/**
 * Finds the equilibrium near a state, by Newton's method with the tree's own elimination; where
 * that leads nowhere, downhill from there, which ends where the potential energy is a minimum.
 *
 * phi     in: n angles to start from, rad, stored order; out: the equilibrium.
 * stable  out: non-zero if the potential energy is a minimum there, so that a push is answered by
 *         a torque back; NULL = not wanted.
 *
 * PEND_NO_MEMORY
 * PEND_NOT_FINITE 200 steps do not converge, nor 1000 downhill: there may be none, where a constant
 *                 torque turns an arm without a spring on and on.
 * O(n) a step. An equilibrium at which the pendulum starts stays, though it may be unstable.
 */
PEND_MUST_CHECK enum pend_status pend_rest_find(const struct pend_tree *tree,
                                                const struct pend_loads *loads, double phi[],
                                                int *stable, struct pend_error *error);

#endif
