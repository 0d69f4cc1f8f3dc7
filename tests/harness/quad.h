/* The paper's dense matrix form in quadruple precision: the reference for every fast or
 * double-precision computation.
 * Leaves to others: trees (harness/trees).
 * Invariant: no formula is shared with core; a 113-bit significand if the compiler has one. */
#pragma once

#include "core/tree/loads.h"
#include "core/tree/tree.h"

#if defined(__x86_64__) || defined(__i386__)
typedef __float128 test_quad;
#else
typedef long double test_quad; /* 113 bits on arm64 and riscv64 */
#endif

/** Elementary functions of a test_quad. */
test_quad test_quad_sin(test_quad x);
test_quad test_quad_cos(test_quad x);
test_quad test_quad_sqrt(test_quad x);
test_quad test_quad_tanh(test_quad x);
test_quad test_quad_abs(test_quad x);

/** A decimal number of any length, to all digits of a test_quad. */
test_quad test_quad_read(const char *text);

/**
 * (aaa) and (bbb) as printed: M = diag(e^{-i phi} l) S^T diag(m) S diag(l e^{i phi}), Cholesky of
 * Re M.
 *
 * tree        arrays in its stored order; the parameters are exact doubles.
 * acc, force  out, n values each.
 * O(n^3), about 0.15 s for n = 200. Aborts if memory is short.
 */
void test_quad_dynamics(const struct pend_tree *tree, const struct pend_loads *loads,
                        const double phi[], const double rate[], test_quad acc[],
                        test_quad force[]);

/** M(phi) = Re + i Im of (aaa), kg m^2, n x n row-major, rounded to doubles. O(n^2). */
void test_quad_inertia(const struct pend_tree *tree, const double phi[], double re[], double im[]);

/** (lin): A = g Re(0)^-1 diag(l (S^T m)), 1/s^2, and its inverse, s^2, for gravity != 0; n x n
 * row-major, rounded to doubles; either may be NULL. O(n^3). */
void test_quad_linearization(const struct pend_tree *tree, double gravity, double a[],
                             double a_inverse[]);

/** Solves a x = b, a symmetric and positive definite, n x n, by Cholesky in place of its lower
 * triangle; b becomes x. O(n^3). */
void test_quad_solve(int n, test_quad a[], test_quad b[]);

/** Largest |x - exact| relative to the largest |exact| (0 if all are 0); NaN if any value is. */
double test_quad_gap(int n, const double x[], const test_quad exact[]);
