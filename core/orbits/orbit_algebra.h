/* Dense linear algebra of periodic orbits: linear equations and Floquet multipliers.
 * Leaves to others: where the matrices come from (orbits).
 * Invariant: the only file of this folder that knows the GNU Scientific Library; matrices are
 * row-major. */
#ifndef PEND_ORBIT_ALGEBRA_H
#define PEND_ORBIT_ALGEBRA_H

#include <stddef.h>

#include "core/base/status.h"

struct orbit_algebra;

/**
 * Prepares workspaces.
 *
 * algebra  out; NULL on failure; released by pend_orbit_algebra_free.
 * rows     the most rows of a matrix, >= 1.
 *
 * PEND_NO_MEMORY  O(rows^2).
 */
PEND_MUST_CHECK enum pend_status pend_orbit_algebra_new(struct orbit_algebra **algebra, int rows);

/** Frees workspaces and clears the pointer; NULL is accepted. */
void pend_orbit_algebra_free(struct orbit_algebra **algebra);

/** Returns the bytes of pend_orbit_algebra_new. O(1). */
double pend_orbit_algebra_bytes(int rows);

/**
 * Solves A X = B by Householder's factors of A.
 *
 * n      rows, at most those of the workspace.
 * A      n x n; kept.
 * count  columns of B.
 * B      n x count; becomes X.
 *
 * Returns true if X is finite: a column of zeros gives none. O(n^3 + n^2 count).
 */
int pend_orbit_solve(struct orbit_algebra *algebra, int n, const double A[], int count, double B[]);

/**
 * The two directions in which a matrix makes vectors least, by its singular values.
 *
 * n      rows, 2 .. those of the workspace.
 * A      n x n; kept.
 * size   out, the three smallest singular values, smallest first; the last one of two rows is
 *        infinite.
 * least  out, 2 x n: the directions of the first two, of unit size, at right angles.
 *
 * PEND_NO_MEMORY
 * PEND_NO_CONVERGENCE  also of a matrix that is not finite.
 * O(n^3), by Jacobi's rotations.
 */
PEND_MUST_CHECK enum pend_status pend_orbit_least(struct orbit_algebra *algebra, int n,
                                                  const double A[], double size[3], double least[]);

/**
 * Eigenvalues of a general matrix.
 *
 * A       n x n, n >= 0; kept.
 * re, im  out, n; pairs that belong together are neighbours.
 *
 * PEND_NO_MEMORY
 * PEND_NO_CONVERGENCE also of a matrix that is not finite.
 * O(n^3).
 */
PEND_MUST_CHECK enum pend_status pend_orbit_eigenvalues(struct orbit_algebra *algebra, int n,
                                                        const double A[], double re[], double im[]);

/**
 * The eigenvalues that tell the multipliers of an orbit between two rests, one for each pair of
 * reciprocal multipliers.
 *
 * A motion back in time mirrors the rates, R = diag(1, -1). Where the orbit rests after a half of
 * its period, whose derivative is Q, the whole period's is R Q^{-1} R Q; and where it passes the
 * rest of the pendulum after a quarter, which turns the sign of all angles back, the half period's
 * is that. With R A R = A^{-1} the upper left block of such a product A has the eigenvalue
 * (x + 1 / x) / 2 for every pair x, 1 / x of A. One of them belongs to the orbit itself: the
 * gradient of the energy is its left eigenvector. It is taken away.
 *
 * n         arms.
 * phi_by    n x 2 n, the angles at the end by angles and rates of the start; rate_by the rates.
 * gradient  n, of the potential energy at the start.
 * omega     rad/s, a rate that makes rates and angles alike.
 * work      8 n^2 numbers.
 * re, im    out, n - 1.
 *
 * PEND_NO_MEMORY
 * PEND_NO_CONVERGENCE also where Q is singular or the gradient is 0.
 * O(n^3).
 */
PEND_MUST_CHECK enum pend_status pend_orbit_mirrored(struct orbit_algebra *algebra, int n,
                                                     const double phi_by[], const double rate_by[],
                                                     const double gradient[], double omega,
                                                     double work[], double re[], double im[]);

/**
 * The eigenvalues of a matrix but for two that are known with their vectors: those of an orbit
 * without a drive, which leaves alone the flow and, on the other side, the energy.
 *
 * n      rows, >= 2.
 * A      n x n; changed.
 * left   n, an eigenvector on the left; right  n, one on the right, at right angles to it; changed.
 * v      room for n numbers.
 * re, im out, n - 2.
 *
 * PEND_NO_MEMORY
 * PEND_NO_CONVERGENCE  also where one of the two is 0.
 * O(n^3).
 */
PEND_MUST_CHECK enum pend_status pend_orbit_kept(struct orbit_algebra *algebra, int n, double A[],
                                                 const double left[], double right[], double v[],
                                                 double re[], double im[]);

#endif
