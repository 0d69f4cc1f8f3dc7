/* Tip positions, velocities, accelerations, energies and forces from angles, rates and angular
 * accelerations.
 * Leaves to others: finding the accelerations (dynamics).
 * Invariant: no allocation; arms in the tree's stored order; outputs never alias inputs. */
#pragma once

#include "core/tree/loads.h"
#include "core/tree/tree.h"

/** J; the potential energy V = g sum m_k Im z_k is 0 at the pivot's height. */
struct pend_energy {
    double kinetic, potential;
};

/**
 * Unit vectors e^{i phi}, within 1 ulp of the larger component for angles up to 1e6 rad.
 *
 * phi     n angles, rad.
 * re, im  out, n values each.
 * O(n).
 */
void pend_kinematics_units(int n, const double phi[], double re[], double im[]);

/**
 * Tip positions z = S [l e^{i phi}].
 *
 * phi     n angles, rad.
 * re, im  out, n values each, m.
 * O(n).
 */
void pend_kinematics_position(const struct pend_tree *tree, const double phi[], double re[],
                              double im[]);

/** Tip velocities z' = S [i phi' l e^{i phi}], m/s. O(n). */
void pend_kinematics_velocity(const struct pend_tree *tree, const double phi[], const double rate[],
                              double re[], double im[]);

/** Tip accelerations z'' = S [(i phi'' - phi'^2) l e^{i phi}], m/s^2. O(n). */
void pend_kinematics_acceleration(const struct pend_tree *tree, const double phi[],
                                  const double rate[], const double acc[], double re[],
                                  double im[]);

/** Kinetic energy sum m_k |z'_k|^2 / 2 and potential energy g sum m_k Im z_k. O(n), compensated
 * sums. */
struct pend_energy pend_kinematics_energy(const struct pend_tree *tree,
                                          const struct pend_loads *loads, const double phi[],
                                          const double rate[]);

/**
 * pend_kinematics_energy of several states, rows of n. Cheaper for small trees, whose unit vectors
 * are computed together. A state's energy has the same bits as if computed alone.
 *
 * energy  out, count values.
 */
void pend_kinematics_energies(const struct pend_tree *tree, const struct pend_loads *loads,
                              int count, const double phi[], const double rate[],
                              struct pend_energy energy[]);

/** Scale to which an energy drift is compared, J: the sum over arms of |g| l_k (S^T m)_k, plus the
 * given kinetic energy. */
double pend_kinematics_energy_scale(const struct pend_tree *tree, const struct pend_loads *loads,
                                    double kinetic);

/**
 * Compression forces (bbb) for given accelerations, which need not solve (aaa): lambda_k = Re e^{-i
 * phi_k} sum over the sub-tree of m_p (z''_p + i g). N. O(n).
 *
 * force  out, n values; also for motions that do not solve (aaa), such as the linearized one.
 */
void pend_kinematics_force(const struct pend_tree *tree, const struct pend_loads *loads,
                           const double phi[], const double rate[], const double acc[],
                           double force[]);
