/* Forces and torques that a known motion needs: inverse dynamics of a real pendulum, leaves to
 * root. Leaves to others: accelerations (core/bodies). Invariant: no matrix and no division, so
 * that joints that hold are as any other. */
#ifndef PEND_BALANCE_H
#define PEND_BALANCE_H

#include <complex.h>

#include "core/bodies/bodies.h"
#include "core/tree/loads.h"

/** Returns where arm k hangs on its parent, in the parent's frame, m; not of a cart. O(1). */
double complex pend_balance_hangs(const struct pend_tree *tree, const struct pend_loads *loads,
                                  int k);

/** Returns the mass of arm k, kg, its first moment, kg m, in its frame, and the inertia about its
 * joint, kg m^2. O(1). */
double pend_balance_masses(const struct pend_tree *tree, const struct pend_loads *loads, int k,
                           double complex *moment, double *inertia);

/* A moving state; arrays of n values, stored order. */
struct pend_moving {
    double time; /* s, in the time of the drives */
    const double *phi, *rate, *acc;
};

/** Bytes of memory that pend_balance needs. */
size_t pend_balance_bytes(const struct pend_tree *tree);

/**
 * Forces and torques of a motion whose accelerations are given.
 *
 * loads   with terms.
 * memory  pend_balance_bytes bytes, aligned to 16.
 * torque  out, n values: the whole torque of the joint on its arm, N m (of a cart the force along
 *         the rail, N) less all that springs, friction in terms, drives and inputs give there. It
 * is what a joint that holds, or slides by Coulomb's law, exerts. NULL = not wanted. forces  out,
 * as of pend_bodies_at; NULL = not wanted.
 *
 * Newton and Euler for each arm in its own joint: F = M a + h U + sum F_c - f, and the torque is
 * J (phi'' + 2 gamma phi') + Im(conj(u) [conj(h) a + sum conj(p_c) F_c - l f]) and those of its
 * children's joints (core/theory.md). O(n + harmonics).
 */
void pend_balance(const struct pend_tree *tree, const struct pend_loads *loads,
                  const struct pend_moving *state, void *memory, double torque[],
                  const struct bodies_forces *forces);

#endif
