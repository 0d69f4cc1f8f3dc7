/* Eigenvectors of a weighted tree for eigenvalues that are known to full precision.
 * Leaves to others: eigenvalues (modes_values), branches that are alike (modes_symmetry), signs
 * (modes_store).
 * Invariant: vectors are orthogonal in the mass inner product, and their residuals are zero, both
 * to round-off. */
#pragma once

#include "core/modes/modes_kernel.h"

struct pend_vectors;

/**
 * Starts the computation of eigenvectors of mass norm 1.
 *
 * A twisted factorization computes each vector independently. Vectors with close eigenvalues are
 * then made orthogonal by Gram-Schmidt; if they were almost parallel, inverse iteration precedes.
 *
 * vectors    out; NULL on failure; released by pend_vectors_free.
 * laplacian  must outlive the computation, as must the arrays.
 * count      number of vectors.
 * value      `count` eigenvalues, ascending, to full relative precision.
 * lead       the node whose angle is to be positive.
 * vector     out, count pointers to n angles each, complete once the computation is done.
 *
 * PEND_NO_MEMORY  O(n), and O(g n) for g close neighbours.
 */
PEND_MUST_CHECK enum pend_status pend_vectors_new(struct pend_vectors **vectors,
                                                  const struct pend_laplacian *laplacian, int count,
                                                  const double value[], int lead, double *vector[]);

/**
 * Continues the computation by a group of vectors, or by one step of the orthogonalization of a
 * vector. O(n) per step, O(count n) in total, and O(g n) more for a vector with g close neighbours.
 *
 * done  out: non-zero once all vectors are complete.
 *
 * PEND_NO_CONVERGENCE  no vector orthogonal to the others was found; no tree is known for which
 *                      this happens.
 */
PEND_MUST_CHECK enum pend_status pend_vectors_step(struct pend_vectors *vectors, int *done);

/** Frees a computation, not the vectors, and clears the pointer; NULL is accepted. */
void pend_vectors_free(struct pend_vectors **vectors);
