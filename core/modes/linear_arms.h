/* The arms of a real pendulum in small motions about an equilibrium: the constants of the
 * linearized equations.
 * Leaves to others: the equilibrium (rest), solving the equations (still, lossy, damped, response).
 * Invariant: the constants are those at the given angles, even if these are not an equilibrium. */
#pragma once

#include "core/tree/loads.h"
#include "core/tree/tree.h"

/* Constants of an arm. The angle of a cart, arm 0, is its position on the rail in m, and the units
 * of its constants change accordingly. Vectors have x and y in the fixed frame. They are
 * derivatives of positions with respect to the arm's angle: i times the position in the arm's
 * frame, rotated. */
struct linear_arm {
    int parent;
    int holder; /* the arm relative to which its joint turns it: the parent, or -1 for the ground */
    double mass, moment[2], inertia; /* kg, kg m, kg m^2: of the arm without its sub-tree */
    double drag, lever[2], span;     /* drag, N s/m; vector to the tip, m; its squared length,
                                      * m^2 */
    double fall;                     /* N m/rad: stiffness of gravity, with the sub-tree */
    double spring, damper;           /* spring, N m/rad, and damper, N m s/rad, of the joint */
    double place[2];                 /* m, derivative of the joint's position with respect to the
                                      * parent's angle */
    double whole[2], wind[2];        /* kg m, N s: first moments of mass and of drag of the arm with
                                      * its sub-tree */
    double whole_mass;               /* kg: mass of the arm with its sub-tree */
    double whole_inertia, wind_inertia; /* kg m^2, N m s: of the arm with its sub-tree, whose arms
                                         * count as points at the tip */
};

struct linear_arms {
    int n;
    double drag_per_mass; /* 1/s */
    struct linear_arm *arm;
};

/**
 * Computes the constants.
 *
 * arms  out; released by pend_linear_arms_clear, also after a failure.
 * phi   n angles, rad, stored order; a cart's position in m.
 *
 * PEND_NO_MEMORY  O(n).
 */
PEND_MUST_CHECK enum pend_status pend_linear_arms_init(struct linear_arms *arms,
                                                       const struct pend_tree *tree,
                                                       const struct pend_loads *loads,
                                                       const double phi[]);
void pend_linear_arms_clear(struct linear_arms *arms);
