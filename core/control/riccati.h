/* Gains that minimize the sum of q x^2 + r u^2 of a linear system x_{k+1} = A x_k + B u_k.
 * Leaves to others: the system, and the effect of the gains (loop).
 * Invariant: matrices are row-major; inputs are not changed.
 *
 * Derivation. The stabilizing solution of X = Q + A^T X (I + G X)^-1 A, G = B R^-1 B^T, is the
 * limit of H in W = I + G H,  G <- G + A W^-1 G A^T,  H <- H + A^T H W^-1 A,  A <- A W^-1 A, which
 * begins with H = Q and squares the closed loop in each step (Chu, Fan, Lin and Wang, Int. J.
 * Control 77, 2004). Two steps of Newton's method follow, X = sum (A_c^T)^k (Q + K^T R K) A_c^k
 * with A_c = A - B K. Their residuals, X and K are sums of two doubles: with one motor for six arms
 * doubles alone keep 5 digits of K, as the QZ method of SciPy does, although the rounding of A
 * changes only the twelfth. Then all digits are right. */
#pragma once

#include "core/base/status.h"

/** out (n x m) = keep out + op(a) op(b), where op transposes if ta or tb is non-zero; k is the
 * inner dimension. O(n k m). */
void pend_product(int n, int k, int m, const double a[], int ta, const double b[], int tb,
                  double keep, double out[]);

/**
 * Computes the gains K of u = -K x.
 *
 * n, m   states and inputs, >= 1.
 * a, b   n x n and n x m.
 * q, r   n weights >= 0 and m weights > 0.
 * gains  out, m x n.
 *
 * PEND_NO_MEMORY
 * PEND_NO_CONVERGENCE  no gains make the loop stable.
 * O(n^3) a step, about 10 to 25 steps.
 */
PEND_MUST_CHECK enum pend_status pend_riccati(int n, int m, const double a[], const double b[],
                                              const double q[], const double r[], double gains[]);
