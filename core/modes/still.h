/* Small motions of a real pendulum that loses nothing, without a matrix: all modes about an
 * equilibrium, O(n) a count of eigenvalues and O(n) a step of a vector.
 * Leaves to others: where it rests (rest), friction and drag (damped), ideal pendulums, which have
 * quicker forms (modes).
 * Invariant: modes are sorted by omega^2; as many are found as there are coordinates, because each
 * is bracketed by its number.
 *
 * Derivation. T = K - s M, s = omega^2, acts on the angles x of the arms. An arm adds to the form
 * x^T T x what its own masses have at the displacement w of its joint and its own angle x,
 *     -s (m |w|^2 + 2 <w, i h> x + J x^2) + g x^2 + k (x - x_p)^2,
 * h its first moment as it lies, g what gravity gives back, k its spring. From the leaves on, x is
 * eliminated: with D the coefficient of x^2 and <a, w> x that of x, what is left is a form of w and
 * x_p, P - a a^T / D, k a / D, k - k^2 / D; and w = w_p + i p x_p turns it into one of the
 * parent's. By Sylvester's law as many D are negative as eigenvalues are below s. */
#ifndef PEND_STILL_H
#define PEND_STILL_H

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

/** Frees a search and clears the pointer; NULL is accepted. */
void pend_still_free(struct pend_still **still);

/** Returns how many eigenvalues are below s, (rad/s)^2. O(n). */
int pend_still_below(struct pend_still *still, double s);

/**
 * Goes on with the search: some hundred sweeps over the tree.
 *
 * square  n, out: omega^2 in ascending order, once all are found; below 0 where a mode grows.
 * vector  n x n, out, mode-major: the angles of mode j at j n, of unit size in the mass matrix and
 *         orthogonal in it; the memory is used from the first call on.
 *
 * Returns non-zero once all is found. All in all O(n^2), and O(n) more for each pair of modes that
 * are alike to seven digits of the largest omega^2.
 */
int pend_still_step(struct pend_still *still, double square[], double vector[]);

#endif
