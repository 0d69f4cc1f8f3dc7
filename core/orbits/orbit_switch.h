/* The direction of a branch that crosses another branch or begins on it.
 * Leaves to others: finding the bifurcation, and the orbits of the other branch (orbit_change).
 * Invariant: the direction is orthogonal to the branch that is left. */
#pragma once

#include "core/orbits/orbit_newton.h"

/**
 * Switches to the equations of the orbits that begin at a bifurcation; the unknowns keep their
 * meaning.
 *
 * Returns false if no orbits of a supported kind begin there: at folds, at torus bifurcations, and
 * beyond the largest number of drive periods.
 */
int pend_orbit_switch_form(struct orbit_form *form, enum pend_orbits_kind kind);

/**
 * Computes the direction of the other branch from J at the bifurcation: of the plane spanned by the
 * two directions in which the equations change least, the direction orthogonal to the branch.
 *
 * newton  has evaluated its new equations at the bifurcation.
 * branch  approximate direction of the branch that is left, in the unknowns; not changed.
 * side    < 0 to get the direction whose largest entry is negative.
 * out     2 x unknowns: at its start the direction, its largest entry of size 1.
 * found   out: zero if the equations change in all directions except one, so that they have no
 *         second branch here.
 *
 * PEND_NO_MEMORY  O(unknowns^3).
 */
PEND_MUST_CHECK enum pend_status pend_orbit_switch_direction(struct orbit_newton *newton,
                                                             const double branch[], int side,
                                                             double out[], int *found);
