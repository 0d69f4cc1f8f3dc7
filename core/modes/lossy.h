/* Small motions of a damped real pendulum without a matrix: all roots and shapes of M x'' + C x' +
 * K x = 0 about an equilibrium, O(n^2) in total.
 * Leaves to others: the equilibrium (rest), the undamped modes as initial values (still), few arms,
 * for which dense matrices are as fast (damped).
 * Invariant: 2 n distinct roots are iterated; a returned root and its shape solve the equations.
 *
 * Derivation. For a complex p, a sweep from the leaves eliminates the form p^2 M + p C + K of a
 * tree, as `response` does for p = i omega. The determinant of the form is the product of the
 * pivots D. So sum D'/D, which the same sweep computes, is the logarithmic derivative of the
 * characteristic polynomial. Ehrlich's and Aberth's method (Math. Comp. 27, 1973) moves all roots
 * at once,
 *     p_i <- p_i - N / (1 - N sum_j 1 / (p_i - p_j)),   N = 1 / sum D'/D,
 * starting from the roots of p^2 + p x^T C x + omega^2 for the undamped modes x. The root and its
 * shape are then refined to rounding by solving with the form at p: y = (form)^-1 (form)' x and p
 * <- p - y^T (form) y / y^T (form)' y, the Rayleigh quotient of the symmetric form. */
#pragma once

#include <complex.h>

#include "core/tree/loads.h"
#include "core/tree/tree.h"

struct pend_lossy;

/* The result of a step. */
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
void pend_lossy_free(struct pend_lossy **lossy);

/**
 * Continues the search by some hundred sweeps over the tree.
 *
 * stage  out; PEND_LOSSY_MODE: `root`, 1/s, has an imaginary part >= 0, and shape contains its n
 *        angles, of any scale. Conjugates are not returned.
 *
 * PEND_NOT_FINITE  the roots did not converge, or a root does not solve the equations.
 */
PEND_MUST_CHECK enum pend_status pend_lossy_step(struct pend_lossy *lossy,
                                                 enum pend_lossy_stage *stage, double complex *root,
                                                 double complex shape[]);
