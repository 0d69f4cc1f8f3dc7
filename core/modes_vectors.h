/* Eigenvectors of a weighted tree for eigenvalues that are known to full precision.
 * Leaves to others: eigenvalues (modes_values), branches that are alike (modes_symmetry), signs (modes_store).
 * Invariant: vectors are orthogonal in the mass inner product to round-off, and so small in residual. */
#ifndef PEND_MODES_VECTORS_H
#define PEND_MODES_VECTORS_H

#include "core/modes_kernel.h"

/**
 * Eigenvectors of mass norm 1.
 *
 * A twisted factorization makes each vector by itself; those whose eigenvalues are near each other are then made
 * orthogonal by Gram-Schmidt, and iterated anew where they came out almost parallel.
 *
 * count   number of vectors.
 * value   their eigenvalues, ascending, to full relative precision.
 * lead    the node whose angle is to be positive.
 * vector  out, count pointers to n angles each.
 *
 * PEND_NO_MEMORY       O(n).
 * PEND_NO_CONVERGENCE  never seen: no vector orthogonal to the others was found.
 * O(count n), and O(g n) more for a vector with g near neighbours.
 */
PEND_MUST_CHECK enum pend_status pend_modes_vectors(const struct pend_laplacian *laplacian, int count,
                                                    const double value[], int lead, double *vector[]);

#endif
