/* The steps of a search along a branch.
 * Leaves to others: bifurcations between two orbits (orbit_change), the first orbit (orbits).
 * Invariant: an orbit is accepted only if a motion from its start returns there; a step is accepted
 * only if the branch turns little in it. */
#pragma once

#include "core/orbits/orbit_change.h"

/**
 * Continues the search by one piece of work: Newton's method, the motion that checks an orbit, or
 * the step after that motion.
 *
 * work  as in pend_derivatives_next.
 *
 * PEND_NO_MEMORY
 * PEND_NO_CONVERGENCE  the eigenvalues did not converge.
 */
PEND_MUST_CHECK enum pend_status pend_orbit_branch_next(struct pend_orbits *o, double work,
                                                        enum pend_orbits_found *found,
                                                        struct pend_error *error);
