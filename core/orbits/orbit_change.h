/* Bifurcations between two neighbouring orbits of a branch: finding them, and leaving the branch
 * there for another one.
 * Leaves to others: multipliers (orbit_floquet), steps along the branch (orbit_branch).
 * Invariant: what is answered as a bifurcation is an orbit of the branch. */
#ifndef PEND_ORBIT_CHANGE_H
#define PEND_ORBIT_CHANGE_H

#include "core/orbits/orbit_search.h"

/** Begins with the next border that lies between the last orbit and the next, in their order along
 * the branch; without one the branch goes on. O(n). */
void pend_orbit_change_next(struct pend_orbits *o);

/**
 * Goes on from an orbit between the two that was found: on one side of the border, or at it.
 *
 * found  out: a bifurcation, once it is as close as wanted.
 *
 * The failures of pend_orbit_form_set.
 */
PEND_MUST_CHECK enum pend_status pend_orbit_change_between(struct pend_orbits *o,
                                                           enum pend_orbits_found *found,
                                                           struct pend_error *error);

/**
 * The look at half of the orbit at a bifurcation tells of what kind it is.
 *
 * found  out: the bifurcation.
 *
 * PEND_NO_MEMORY
 * PEND_NO_CONVERGENCE
 * O(n^3).
 */
PEND_MUST_CHECK enum pend_status pend_orbit_change_halved(struct pend_orbits *o,
                                                          enum pend_orbits_found *found);

/** Goes on where no orbit was found between the two, as pend_orbit_change_between. */
PEND_MUST_CHECK enum pend_status pend_orbit_change_lost(struct pend_orbits *o,
                                                        enum pend_orbits_found *found,
                                                        struct pend_error *error);

/** Leaves the branch at the bifurcation to which the equations are set: looks at it by the
 * equations of the other branch. O(n). */
void pend_orbit_change_leave(struct pend_orbits *o);

/**
 * The look has seen in which direction the other branch leaves: goes there.
 *
 * PEND_NO_MEMORY  O(n^3).
 */
PEND_MUST_CHECK enum pend_status pend_orbit_change_looked(struct pend_orbits *o);

/** Looks for an orbit of the branch that begins at a bifurcation, at the next distance from it.
 * O(n). */
void pend_orbit_change_aside(struct pend_orbits *o);

/** Returns true if the orbit found is so far from the bifurcation that it need not belong to the
 * branch that begins there. O(n). */
int pend_orbit_change_far(const struct pend_orbits *o);

#endif
