/* The store of modes: memory, the mass inner product, and the stated rule for signs and bases.
 * Leaves to others: computing eigenvalues and vectors (modes_gsl, modes).
 * Invariant: rotations stay inside groups of frequencies that agree to round-off. */
#ifndef PEND_MODES_STORE_H
#define PEND_MODES_STORE_H

#include "core/modes.h"

/**
 * Room for count modes of n arms in one block; the arrays are not set.
 *
 * modes    out; NULL on failure.
 * vectors  non-zero to have room for vectors and their norms.
 *
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status pend_modes_alloc(struct pend_modes **modes, int count, int n, int vectors);

/**
 * Re(0) x without a matrix: masses times tip displacements, summed over the sub-trees.
 *
 * x        n angles, stored order.
 * product  out, n values; not the same array as x.
 * O(n).
 */
void pend_modes_mass_apply(const struct pend_tree *tree, const double x[], double product[]);

/**
 * Square root of x^T Re(0) x.
 *
 * x     n angles, stored order.
 * tips  n doubles of scratch.
 * O(n).
 */
double pend_modes_mass_norm(const struct pend_tree *tree, const double x[], double tips[]);

/**
 * Gives every multiple frequency its stated basis, scales every vector to mass norm 1 and fixes its sign.
 *
 * modes     omega ascending, vectors mass-orthogonal and of mass norm about 1.
 * multiple  frequencies are one multiple frequency when the largest is at most this much above the least, relatively.
 * bound     no entry of a vector is larger than omega times this; 0 when nothing is known.
 * scratch   n doubles; NULL when every vector's mass norm is 1 already.
 * O(count n), and O(g^2 n) for a frequency of multiplicity g.
 */
void pend_modes_settle(struct pend_modes *modes, const struct pend_tree *tree, double multiple, double bound,
                       double scratch[]);

#endif
