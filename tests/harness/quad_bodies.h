/* The Lagrangian equations of a real pendulum in quadruple precision, with a dense mass matrix: the
 * reference for the general kernel.
 * Leaves to others: ideal pendulums in the paper's form (quad), random pendulums (bodies).
 * Invariant: no formula is shared with core; everything is in the fixed axes, by mass, first moment
 * and moment of inertia of each arm. */
#pragma once

#include "core/tree/loads.h"
#include "core/tree/tree.h"
#include "tests/harness/quad.h"

/* A state in quadruple precision; arrays of n in the tree's stored order. */
struct test_quad_state {
    const test_quad *phi, *rate; /* rad; rad/s */
    test_quad time;              /* s */
};

/* The forces of struct bodies_forces, in quadruple precision; n values each. */
struct test_quad_forces {
    test_quad *joint_along, *joint_across, *tip_along, *tip_across;
};

/**
 * phi'' and the forces in the arms: the mass matrix is the second derivative of the kinetic energy
 * sum of M |v|^2 / 2 + Re(conj(v) i h u phi') + J phi'^2 / 2, v the joints' velocities; forces are
 * the rates of change of momentum beyond each joint.
 *
 * loads   with terms; their numbers are exact doubles.
 * acc     out, n values.
 * forces  out; NULL to skip.
 *
 * O(n^3). Aborts if memory is short.
 */
void test_quad_bodies(const struct pend_tree *tree, const struct pend_loads *loads,
                      const struct test_quad_state *state, test_quad acc[],
                      const struct test_quad_forces *forces);

/** Writes n accelerations of a state. */
typedef void test_quad_fn(void *context, const struct test_quad_state *state, test_quad acc[]);

/** test_quad_move for a system of n coordinates with any accelerations. */
double test_quad_advance(int n, test_quad_fn *accelerate, void *context, test_quad phi[],
                         test_quad rate[], test_quad time, test_quad span, int parts);

/**
 * Advances a state by `span` seconds, of either sign, with an error far below that of doubles:
 * steps of the modified midpoint rule with 2, 4 .. 20 parts, extrapolated to step length 0.
 *
 * phi, rate  in and out, n values each.
 * time       s, at the start.
 * parts      steps of equal length; each should be no longer than a step of a power series of
 *            doubles.
 *
 * Returns the last correction of an angle, which bounds the error. 110 times the cost of
 * test_quad_bodies per step.
 */
double test_quad_move(const struct pend_tree *tree, const struct pend_loads *loads, test_quad phi[],
                      test_quad rate[], test_quad time, test_quad span, int parts);
