/* Periodic orbits: nonlinear modes of pendulums that lose nothing, orbits of driven ones, and
 * their branches, by shooting and pseudo-arclength continuation.
 * Leaves to others: the equations (orbit_form), multipliers (orbit_floquet), JSON (api).
 * Invariant: every orbit that is handed out came back to its start in a motion that was computed
 * apart from the search; how far it missed it is told. */
#ifndef PEND_ORBITS_H
#define PEND_ORBITS_H

#include "core/base/checkpoint.h"
#include "core/orbits/orbit_problem.h"

struct pend_orbits;

/**
 * Prepares a search.
 *
 * orbits   out; NULL on failure; released by pend_orbits_free.
 * problem  copied; what it points to outlives the search.
 *
 * PEND_INVALID    the pendulum has no such mode, or no such drive; it is on a cart.
 * PEND_NO_MEMORY  O(n^2); the failures of modes.
 */
PEND_MUST_CHECK enum pend_status pend_orbits_new(struct pend_orbits **orbits,
                                                 const struct pend_orbit_problem *problem,
                                                 struct pend_error *error);

/** Frees the memory and clears the pointer; NULL is accepted. */
void pend_orbits_free(struct pend_orbits **orbits);

/** Returns the bytes of a search, an upper bound. O(1). */
double pend_orbits_bytes(const struct pend_orbit_problem *problem);

/**
 * Goes on with the search, by a piece of about a quarter of a millisecond.
 *
 * found  out: what is to be taken now.
 *
 * PEND_NO_MEMORY
 * PEND_NO_CONVERGENCE  eigenvalues of a multiplier's matrix.
 */
PEND_MUST_CHECK enum pend_status pend_orbits_next(struct pend_orbits *orbits,
                                                  enum pend_orbits_found *found,
                                                  struct pend_error *error);

/** Returns the orbit or bifurcation that the last call has found. O(1). */
struct pend_orbit pend_orbits_orbit(const struct pend_orbits *orbits);

/** Returns how a search ended. O(1). */
enum pend_orbits_end pend_orbits_end(const struct pend_orbits *orbits);

/** Returns which part of its period the last orbits beyond the end take, of PEND_ORBITS_MEETS. */
int pend_orbits_part(const struct pend_orbits *orbits);

/** Returns where the branch turned back last without a fold, where orbits of another branch meet
 * it; PEND_ORBITS_KINDS: nowhere. O(1). */
enum pend_orbits_kind pend_orbits_turned(const struct pend_orbits *orbits);

/**
 * Returns how many equal branches on one joint, three or more, give the frequency of the mode more
 * than once; 0: none do. O(1).
 *
 * twin     out: the first arms of two of them, in the caller's order.
 * against  out, non-zero: in the orbits found these two swing against each other and all other arms
 *          hang still.
 */
int pend_orbits_twins(const struct pend_orbits *orbits, int twin[2], int *against);

/** Returns how many branches were left so far. O(1). */
int pend_orbits_left(const struct pend_orbits *orbits);

/** Returns the steps of all motions so far, and in *maps how many of these carried derivatives.
 * O(1). */
long pend_orbits_steps(const struct pend_orbits *orbits, long *maps);

/** Returns true between two steps along a branch and at the end, where pend_orbits_carry may be
 * called; in *steps how many steps there were. O(1). */
int pend_orbits_rests(const struct pend_orbits *orbits, long *steps);

/**
 * Shows a checkpoint the state of a search that rests. One that was just made of the same problem
 * and into which a checkpoint restored this state goes on with the same bits; what was found before
 * is its caller's.
 *
 * PEND_INVALID  the restored state is not that of such a search, which can only be freed then.
 */
PEND_MUST_CHECK enum pend_status pend_orbits_carry(struct pend_orbits *orbits,
                                                   struct pend_checkpoint *checkpoint);

/** Returns about which part of the way is done, 0 .. 1. O(1). */
double pend_orbits_progress(const struct pend_orbits *orbits);

#endif
