/* Eigenvalues of a weighted tree by counting, to full relative accuracy.
 * Leaves to others: vectors (modes_vectors), merging several trees' values (modes).
 * Invariant: every value lies between two counted shifts, so that none is missed and none is found
 * twice. */
#pragma once

#include "core/modes/modes_kernel.h"

struct pend_values;

/**
 * Starts the search for the eigenvalues number first .. first + count - 1 of L x = lambda M x,
 * counted from the smallest.
 *
 * Multisection isolates them. Laguerre's iteration then converges to them, within the intervals
 * that the counts guarantee; its step follows from the sweep that counts. An eigenvalue takes about
 * 4 sweeps over the tree.
 *
 * values            out; NULL on failure; released by pend_values_free.
 * laplacian, value  must outlive the search; the laplacian must not change meanwhile.
 * value             out, count values > 0, 1/s^2, complete at the end of the search. The requested
 *                   eigenvalues must be positive: see pend_values_below.
 *
 * PEND_NO_MEMORY  O(count).
 */
PEND_MUST_CHECK enum pend_status pend_values_new(struct pend_values **values,
                                                 const struct pend_laplacian *laplacian, int first,
                                                 int count, double value[]);
void pend_values_free(struct pend_values **values);

/** Continues the search for at most about 64 sweeps; returns non-zero once all eigenvalues are
 * found. O(n), and O(count n) in all. */
int pend_values_step(struct pend_values *values);

/** Returns the number of eigenvalues below a shift, 1/s^2. O(n). */
int pend_values_below(const struct pend_laplacian *laplacian, double shift);
