/* The paper's matrix equations (aaa), (bbb) and (lin) as they are printed, computed through GSL:
 * the independent check of the fast forms.
 * Leaves to others: fast computation (dynamics).
 * Invariant: shares no formula with dynamics; arms in the tree's stored order. */
#ifndef PEND_REFERENCE_H
#define PEND_REFERENCE_H

#include "core/tree/loads.h"
#include "core/tree/tree.h"

/**
 * M(phi) = diag(e^{-i phi} l) S^T diag(m) S diag(l e^{i phi}), kg m^2.
 *
 * re, im  out, n x n row-major.
 * O(n^3) in the plain form of the paper.
 */
PEND_MUST_CHECK enum pend_status pend_reference_mass_matrix(const struct pend_tree *tree,
                                                            const double phi[], double re[],
                                                            double im[]);

/**
 * (aaa) and (bbb) by a Cholesky factorization of Re M. Parameters as pend_dynamics.
 *
 * force  out, or NULL to skip. acc and force may not be input arrays.
 *
 * PEND_NO_MEMORY  allocates O(n^2).
 * PEND_NOT_FINITE Re M is numerically not positive definite.
 * O(n^3).
 */
PEND_MUST_CHECK enum pend_status pend_reference_dynamics(const struct pend_tree *tree,
                                                         const struct pend_loads *loads,
                                                         const double phi[], const double rate[],
                                                         double acc[], double force[]);

/**
 * A = g Re(0)^{-1} diag(l (S^T m)) of (lin) and its inverse, 1/s^2 and s^2.
 *
 * a, a_inverse  out, n x n row-major, either may be NULL.
 *
 * PEND_INVALID    the inverse is wanted at gravity 0.
 * PEND_NO_MEMORY  allocates O(n^2).
 * PEND_NOT_FINITE Re(0) is numerically not positive definite.
 * O(n^3).
 */
PEND_MUST_CHECK enum pend_status pend_reference_linearization(const struct pend_tree *tree,
                                                              const struct pend_loads *loads,
                                                              double a[], double a_inverse[]);

#endif
