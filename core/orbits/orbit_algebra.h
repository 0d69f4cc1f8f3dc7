/* Dense linear algebra of periodic orbits: linear equations and Floquet multipliers.
 * Leaves to others: the matrices (orbits).
 * Invariant: only this file of the directory uses the GNU Scientific Library; matrices are
 * row-major. */
#pragma once

#include "core/base/status.h"

struct orbit_algebra;

/**
 * Prepares workspaces.
 *
 * algebra  out; NULL on failure; released by pend_orbit_algebra_free.
 * rows     largest number of rows of a matrix, >= 1.
 *
 * PEND_NO_MEMORY  O(rows^2).
 */
PEND_MUST_CHECK enum pend_status pend_orbit_algebra_new(struct orbit_algebra **algebra, int rows);
void pend_orbit_algebra_free(struct orbit_algebra **algebra);

/** Returns the bytes of pend_orbit_algebra_new. O(1). */
double pend_orbit_algebra_bytes(int rows);

/**
 * Solves A X = B by Householder's factors of A.
 *
 * n      rows, at most those of the workspace.
 * A      n x n; not changed.
 * count  columns of B.
 * B      n x count; becomes X.
 *
 * Returns true if X is finite; false if A has a column of zeros. O(n^3 + n^2 count).
 */
int pend_orbit_solve(struct orbit_algebra *algebra, int n, const double A[], int count, double B[]);

/**
 * Computes the two right singular vectors of the smallest singular values of a matrix.
 *
 * n      rows, 2 .. those of the workspace.
 * A      n x n; not changed.
 * size   out, the three smallest singular values, smallest first; for two rows the last one is
 *        infinite.
 * least  out, 2 x n: the singular vectors of the first two, orthonormal.
 *
 * PEND_NO_MEMORY
 * PEND_NO_CONVERGENCE  also for a matrix that is not finite.
 * O(n^3), by Jacobi's rotations.
 */
PEND_MUST_CHECK enum pend_status pend_orbit_least(struct orbit_algebra *algebra, int n,
                                                  const double A[], double size[3], double least[]);

/**
 * Computes the eigenvalues of a general matrix.
 *
 * A       n x n, n >= 0; not changed.
 * re, im  out, n; complex pairs are adjacent.
 *
 * PEND_NO_MEMORY
 * PEND_NO_CONVERGENCE also for a matrix that is not finite.
 * O(n^3).
 */
PEND_MUST_CHECK enum pend_status pend_orbit_eigenvalues(struct orbit_algebra *algebra, int n,
                                                        const double A[], double re[], double im[]);

/**
 * Computes the eigenvalues that determine the multipliers of an orbit between two states of rest,
 * one for each pair of reciprocal multipliers.
 *
 * Time reversal changes the sign of the rates, R = diag(1, -1). If the orbit is at rest after half
 * of its period, whose derivative is Q, the derivative of the whole period is R Q^{-1} R Q. If it
 * passes the equilibrium after a quarter of its period, with the derivative Q, this product is that
 * of the half period. With R A R = A^{-1} the upper left block of such a product A has the
 * eigenvalue (x + 1 / x) / 2 for every pair x, 1 / x of A. One of them belongs to the orbit itself,
 * with the gradient of the energy as left eigenvector; it is removed.
 *
 * n         arms.
 * phi_by    n x 2 n, derivatives of the angles at the end with respect to angles and rates at the
 *           start; rate_by: the same of the rates.
 * gradient  n, of the potential energy at the start.
 * omega     rad/s, divides rates to make them comparable with angles.
 * work      8 n^2 numbers.
 * re, im    out, n - 1.
 *
 * PEND_NO_MEMORY
 * PEND_NO_CONVERGENCE also if Q is singular or the gradient is 0. O(n^3).
 */
PEND_MUST_CHECK enum pend_status pend_orbit_mirrored(struct orbit_algebra *algebra, int n,
                                                     const double phi_by[], const double rate_by[],
                                                     const double gradient[], double omega,
                                                     double work[], double re[], double im[]);

/**
 * Computes the eigenvalues of a matrix except two with known eigenvectors: those of the flow
 * (right) and of the energy (left) of an orbit without a drive.
 *
 * n      rows, >= 2.
 * A      n x n; changed.
 * left   n, a left eigenvector; right  n, a right eigenvector, orthogonal to it; both changed.
 * v      space for n numbers. re, im  out, n - 2.
 *
 * PEND_NO_MEMORY
 * PEND_NO_CONVERGENCE  also if an eigenvector is 0.
 * O(n^3).
 */
PEND_MUST_CHECK enum pend_status pend_orbit_kept(struct orbit_algebra *algebra, int n, double A[],
                                                 const double left[], double right[], double v[],
                                                 double re[], double im[]);
