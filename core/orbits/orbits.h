/* Periodic orbits: nonlinear modes of conservative pendulums, orbits of driven pendulums, and
 * branches of both, by shooting and pseudo-arclength continuation.
 * Leaves to others: the equations (orbit_form), multipliers (orbit_floquet), JSON (api).
 * Invariant: every reported orbit returned to its start in a motion computed independently of the
 * search, and the remaining distance is reported. */
#pragma once

#include "core/base/checkpoint.h"
#include "core/orbits/orbit_problem.h"

struct pend_orbits;

/**
 * Prepares a search.
 *
 * orbits   out; NULL on failure; released by pend_orbits_free.
 * problem  copied; the data that it points to must outlive the search.
 *
 * PEND_INVALID    the pendulum has no such mode or drive, or is on a cart.
 * PEND_NO_MEMORY  O(n^2); also fails as modes does.
 */
PEND_MUST_CHECK enum pend_status pend_orbits_new(struct pend_orbits **orbits,
                                                 const struct pend_orbit_problem *problem,
                                                 struct pend_error *error);
void pend_orbits_free(struct pend_orbits **orbits);

/** Returns the bytes of a search, an upper bound. O(1). */
double pend_orbits_bytes(const struct pend_orbit_problem *problem);

/**
 * Continues the search by about a quarter of a millisecond.
 *
 * found  out: the kind of result that is available.
 *
 * PEND_NO_MEMORY
 * PEND_NO_CONVERGENCE  the multipliers did not converge.
 */
PEND_MUST_CHECK enum pend_status pend_orbits_next(struct pend_orbits *orbits,
                                                  enum pend_orbits_found *found,
                                                  struct pend_error *error);

/** Returns the orbit or bifurcation that the last call found. O(1). */
struct pend_orbit pend_orbits_orbit(const struct pend_orbits *orbits);

/** Returns how a search ended. O(1). */
enum pend_orbits_end pend_orbits_end(const struct pend_orbits *orbits);

/** Returns, for PEND_ORBITS_MEETS, the divisor m: orbits beyond the end have 1/m of the period. */
int pend_orbits_part(const struct pend_orbits *orbits);

/** Returns the kind of the last point at which the branch turned back without a fold, because
 * another branch meets it there; PEND_ORBITS_KINDS if there was no such point. O(1). */
enum pend_orbits_kind pend_orbits_turned(const struct pend_orbits *orbits);

/**
 * Returns the number of equal branches on one joint, three or more, that make the frequency of the
 * mode repeated; 0: none. O(1).
 *
 * twin     out: the first arms of two such branches, in the caller's order.
 * against  out, non-zero: in the orbits found these two swing against each other and all other arms
 *          hang still.
 */
int pend_orbits_twins(const struct pend_orbits *orbits, int twin[2], int *against);

/** Returns the number of branches left so far. O(1). */
int pend_orbits_left(const struct pend_orbits *orbits);

/** Returns the number of steps of all motions so far; *maps: the number of steps of motions with
 * derivatives. O(1). */
long pend_orbits_steps(const struct pend_orbits *orbits, long *maps);

/** Returns true between two steps along a branch and at the end, when pend_orbits_carry may be
 * called. *steps: the number of steps so far. O(1). */
int pend_orbits_rests(const struct pend_orbits *orbits, long *steps);

/**
 * Saves the state of a search between two steps to a checkpoint, or restores it. A search created
 * for the same problem and restored continues with the same bits. The caller keeps the orbits found
 * before.
 *
 * PEND_INVALID  the restored state does not belong to such a search, which can then only be freed.
 */
PEND_MUST_CHECK enum pend_status pend_orbits_carry(struct pend_orbits *orbits,
                                                   struct pend_checkpoint *checkpoint);

/** Returns the approximate fraction of the search that is done, 0 .. 1. O(1). */
double pend_orbits_progress(const struct pend_orbits *orbits);
