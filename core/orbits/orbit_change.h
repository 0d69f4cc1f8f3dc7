/* Bifurcations between two neighbouring orbits of a branch: locating them, and switching to another
 * branch there.
 * Leaves to others: multipliers (orbit_floquet), steps along the branch (orbit_branch).
 * Invariant: a reported bifurcation is an orbit of the branch. */
#pragma once

#include "core/orbits/orbit_search.h"

/** Starts to locate the next boundary between the last orbit and the next one, in order along the
 * branch. If there is no boundary, the branch continues. O(n). */
void pend_orbit_change_next(struct pend_orbits *o);

/**
 * Continues with an orbit found between the two: on one side of the boundary, or at it.
 *
 * found  out: a bifurcation, once it is located accurately enough.
 *
 * Fails as pend_orbit_form_set does.
 */
PEND_MUST_CHECK enum pend_status pend_orbit_change_between(struct pend_orbits *o,
                                                           enum pend_orbits_found *found,
                                                           struct pend_error *error);

/**
 * Determines the kind of a bifurcation from the motion over half of its period.
 *
 * found  out: the bifurcation.
 *
 * PEND_NO_MEMORY
 * PEND_NO_CONVERGENCE
 * O(n^3).
 */
PEND_MUST_CHECK enum pend_status pend_orbit_change_halved(struct pend_orbits *o,
                                                          enum pend_orbits_found *found);

/** Continues if no orbit was found between the two, as pend_orbit_change_between. */
PEND_MUST_CHECK enum pend_status pend_orbit_change_lost(struct pend_orbits *o,
                                                        enum pend_orbits_found *found,
                                                        struct pend_error *error);

/** Prepares to leave the branch at the current bifurcation: evaluates the equations of the other
 * branch there. O(n). */
void pend_orbit_change_leave(struct pend_orbits *o);

/**
 * Switches to the other branch, whose direction has been computed.
 *
 * PEND_NO_MEMORY  O(n^3).
 */
PEND_MUST_CHECK enum pend_status pend_orbit_change_looked(struct pend_orbits *o);

/** Starts the search for an orbit of the branch that begins at a bifurcation, at the next distance
 * from it. O(n). */
void pend_orbit_change_aside(struct pend_orbits *o);

/** Returns true if the orbit found is so far from the bifurcation that it may belong to another
 * branch. O(n). */
int pend_orbit_change_far(const struct pend_orbits *o);
