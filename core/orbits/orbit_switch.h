/* From a branch to the one that crosses it or begins on it: the direction in which it leaves.
 * Leaves to others: finding the bifurcation, and the orbits of the other branch (orbit_change).
 * Invariant: the direction is at right angles to the branch that is left. */
#ifndef PEND_ORBIT_SWITCH_H
#define PEND_ORBIT_SWITCH_H

#include "core/orbits/orbit_newton.h"

/**
 * Turns the equations into those of the orbits that begin at a bifurcation; the unknowns keep their
 * meaning.
 *
 * Returns false where none begin, or none that are looked for: at folds, where a pair of complex
 * multipliers begins to grow, and beyond the most periods of the drive.
 */
int pend_orbit_switch_form(struct orbit_form *form, enum pend_orbits_kind kind);

/**
 * The direction of the other branch, from the J of a look at the bifurcation: of the two directions
 * in which the equations change least, what is at right angles to the branch.
 *
 * newton  has looked at the bifurcation by its new equations.
 * branch  unknowns: about the direction of the branch that is left; kept.
 * side    < 0: the direction with a negative largest entry.
 * out     2 x unknowns: at its begin the direction, its largest entry of size 1.
 * found   out: zero where the equations change in all directions but one: the orbits that begin
 *         there are no solutions of them.
 *
 * PEND_NO_MEMORY  O(unknowns^3).
 */
PEND_MUST_CHECK enum pend_status pend_orbit_switch_direction(struct orbit_newton *newton,
                                                             const double branch[], int side,
                                                             double out[], int *found);

/** Returns the arm that gravity and springs move most at the start of an orbit that was looked at
 * between two rests. O(n). */
int pend_orbit_switch_turning(const struct orbit_newton *newton);

#endif
