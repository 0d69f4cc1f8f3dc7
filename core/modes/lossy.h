/* Small motions of a real pendulum that loses energy, without a matrix: all roots and shapes of
 * M x'' + C x' + K x = 0 about an equilibrium, O(n^2) in all.
 * Leaves to others: where it rests (rest), the modes without losses that it begins with (still),
 * few arms, whose dense matrices are as quick (damped). Invariant: 2 n roots are followed, and no
 * two of them become one; a root that is handed out solves the equations with its shape.
 *
 * Derivation. For a complex p the form p^2 M + p C + K of a tree is eliminated from the leaves on,
 * as `response` does it with p = i omega. Its determinant is the product of the pivots D, and so
 * sum D'/D, which the same sweep computes, is the logarithmic derivative of the polynomial whose
 * roots are wanted. Ehrlich's and Aberth's method (Math. Comp. 27, 1973) moves all roots at once,
 *     p_i <- p_i - N / (1 - N sum_j 1 / (p_i - p_j)),   N = 1 / sum D'/D,
 * beginning with the roots of p^2 + p x^T C x + omega^2 of the modes x without losses. The root and
 * its shape are then found to rounding by solving with the form at p: y = (form)^-1 (form)' x and
 * p <- p - y^T (form) y / y^T (form)' y, the symmetric form's Rayleigh quotient. */
#ifndef PEND_LOSSY_H
#define PEND_LOSSY_H

#include <complex.h>

#include "core/tree/loads.h"
#include "core/tree/tree.h"

struct pend_lossy;

/* What a step has come to. */
enum pend_lossy_stage { PEND_LOSSY_UNDER_WAY, PEND_LOSSY_MODE, PEND_LOSSY_DONE };

/**
 * Prepares the search for all modes.
 *
 * lossy  out; NULL on failure; released by pend_lossy_free.
 * phi    n angles of an equilibrium, rad, stored order.
 *
 * PEND_NO_MEMORY   n^2 numbers.
 */
PEND_MUST_CHECK enum pend_status pend_lossy_new(struct pend_lossy **lossy,
                                                const struct pend_tree *tree,
                                                const struct pend_loads *loads, const double phi[]);

/** Frees a search and clears the pointer; NULL is accepted. */
void pend_lossy_free(struct pend_lossy **lossy);

/**
 * Goes on with the search: some hundred sweeps over the tree.
 *
 * stage  out; PEND_LOSSY_MODE: `root`, 1/s, is one whose imaginary part is 0 or more, and shape, n
 *        values, its angles, of any size. Conjugates are not handed out.
 *
 * PEND_NOT_FINITE  the roots did not converge, or one does not solve the equations.
 */
PEND_MUST_CHECK enum pend_status pend_lossy_step(struct pend_lossy *lossy,
                                                 enum pend_lossy_stage *stage, double complex *root,
                                                 double complex shape[]);

#endif
