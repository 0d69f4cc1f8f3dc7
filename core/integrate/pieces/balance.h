/* Inverse dynamics of a real pendulum: the forces and torques of a known motion, from leaves to
 * root.
 * Leaves to others: accelerations (core/bodies).
 * Invariant: no matrix and no division, so joints that hold need no special case. */
#pragma once

#include <complex.h>

#include "core/bodies/bodies.h"
#include "core/tree/loads.h"

/** Returns e^(i phi), for phi up to 1e12 rad, with the same bits on every machine. O(1). */
double complex pend_balance_turn(double phi);

/** Returns the position of arm k's joint in its parent's frame, m; arm k is not on a cart. O(1). */
double complex pend_balance_hangs(const struct pend_tree *tree, const struct pend_loads *loads,
                                  int k);

/** Returns the mass of arm k, kg, and in its frame the first moment, kg m, and the inertia about
 * its joint, kg m^2. O(1). */
double pend_balance_masses(const struct pend_tree *tree, const struct pend_loads *loads, int k,
                           double complex *moment, double *inertia);

/* A state with accelerations; arrays of n values in stored order. */
struct pend_moving {
    double time; /* s, in the time of the drives */
    const double *phi, *rate, *acc;
};

/** Returns the bytes of memory that pend_balance needs. */
size_t pend_balance_bytes(const struct pend_tree *tree);

/**
 * Computes the forces and torques of a motion with known accelerations.
 *
 * loads   with terms.
 * memory  pend_balance_bytes bytes, aligned to 16.
 * torque  out, n values: the torque of the joint on its arm, N m (for a cart the force along the
 *         rail, N), without springs, friction in terms, drives and inputs: the torque of a joint
 *         that holds, or slides by Coulomb's law. NULL = not needed.
 * forces  out, as for pend_bodies_at; NULL = not needed.
 *
 * Newton and Euler for each arm in its own joint: F = M a + h U + sum F_c - f, and the torque is
 * J (phi'' + 2 gamma phi') + Im(conj(u) [conj(h) a + sum conj(p_c) F_c - l f]) and those of its
 * children's joints (core/theory.md). O(n + harmonics).
 */
void pend_balance(const struct pend_tree *tree, const struct pend_loads *loads,
                  const struct pend_moving *state, void *memory, double torque[],
                  const struct bodies_forces *forces);
