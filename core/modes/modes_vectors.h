/* Eigenvectors of a weighted tree for eigenvalues that are known to full precision.
 * Leaves to others: eigenvalues (modes_values), branches that are alike (modes_symmetry), signs
 * (modes_store).
 * Invariant: vectors are orthogonal in the mass inner product to round-off, and so small in
 * residual. */
#ifndef PEND_MODES_VECTORS_H
#define PEND_MODES_VECTORS_H

#include "core/modes/modes_template.h"

/* A computation under way. */
struct pend_vectors;

/**
 * Begins to compute eigenvectors of mass norm 1.
 *
 * A twisted factorization makes each vector by itself; those whose eigenvalues are near each other
 * are then made orthogonal by Gram-Schmidt, and iterated anew where they came out almost parallel.
 *
 * laplacian  must outlive the computation, as the arrays must.
 * count      number of vectors.
 * value      their eigenvalues, ascending, to full relative precision.
 * lead       the node whose angle is to be positive.
 * vector     out, count pointers to n angles each, complete once the computation is done.
 *
 * PEND_NO_MEMORY  O(n), and O(g n) for g near neighbours.
 */
PEND_MUST_CHECK enum pend_status pend_vectors_new(struct pend_vectors **vectors,
                                                  const struct pend_laplacian *laplacian, int count,
                                                  const double value[], int lead, double *vector[]);

/**
 * Computes on: a group of vectors, or a part of what makes one orthogonal. O(n) a step, O(count n)
 * in all, and O(g n) more for a vector with g near neighbours.
 *
 * done  set non-zero once all vectors are there.
 *
 * PEND_NO_CONVERGENCE  never seen: no vector orthogonal to the others was found.
 */
PEND_MUST_CHECK enum pend_status pend_vectors_step(struct pend_vectors *vectors, int *done);

void pend_vectors_free(struct pend_vectors **vectors);

#endif
