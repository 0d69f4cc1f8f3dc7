/* Undamped small motions of a real pendulum without a matrix: all modes about an equilibrium, O(n)
 * per count of eigenvalues and O(n) per step of a vector.
 * Leaves to others: the equilibrium (rest), friction and drag (damped), ideal pendulums, which have
 * faster forms (modes).
 * Invariant: modes are sorted by omega^2; there are as many as coordinates, because each eigenvalue
 * is enclosed by counting.
 *
 * Derivation. T = K - s M, s = omega^2, acts on the angles x of the arms. With the displacement w
 * of its joint and its angle x, an arm adds to the form x^T T x
 *     -s (m |w|^2 + 2 <w, i h> x + J x^2) + g x^2 + k (x - x_p)^2,
 * h its first moment in fixed axes, g the stiffness of gravity, k its spring. From the leaves on, x
 * is eliminated. With D the coefficient of x^2 and <a, w> that of x, what remains is a form in w
 * and x_p with the coefficients P - a a^T / D, k a / D and k - k^2 / D; substituting w = w_p + i p
 * x_p gives a form for the parent. By Sylvester's law as many D are negative as eigenvalues are
 * below s. */
#pragma once

#include "core/tree/loads.h"
#include "core/tree/tree.h"

struct pend_still;

/**
 * Prepares the search for all modes.
 *
 * still  out; NULL on failure; released by pend_still_free.
 * phi    n angles of an equilibrium, rad, stored order.
 *
 * PEND_NO_MEMORY  O(n) numbers.
 */
PEND_MUST_CHECK enum pend_status pend_still_new(struct pend_still **still,
                                                const struct pend_tree *tree,
                                                const struct pend_loads *loads, const double phi[]);
void pend_still_free(struct pend_still **still);

/** Returns the number of eigenvalues below s, (rad/s)^2. O(n). */
int pend_still_below(struct pend_still *still, double s);

/**
 * Continues the search by some hundred sweeps over the tree.
 *
 * square  n, out: omega^2 in ascending order, once all are found; negative for growing modes.
 * vector  n x n, out, mode-major: the angles of mode j at j n, of unit size in the mass matrix and
 *         orthogonal in it; the memory is used from the first call on.
 *
 * Returns non-zero once all are found. O(n^2) in total, and O(n) more for each pair of modes whose
 * omega^2 agree to seven digits of the largest.
 */
int pend_still_step(struct pend_still *still, double square[], double vector[]);
