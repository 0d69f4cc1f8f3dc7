/* Eigenvalues of a weighted tree by counting, to full relative accuracy.
 * Leaves to others: vectors (modes_vectors), merging several trees' values (modes).
 * Invariant: every value lies in a bracket whose ends were counted, so none is missed and none is doubled. */
#ifndef PEND_MODES_VALUES_H
#define PEND_MODES_VALUES_H

#include "core/modes_kernel.h"

/**
 * The eigenvalues number first .. first + count - 1 of L x = lambda M x, counted from the smallest.
 *
 * Multisection isolates them; Laguerre's iteration, which each count yields at no further cost, converges on them; the
 * counts guard it. About 4 sweeps over the tree an eigenvalue.
 *
 * value  out, count values > 0, 1/s^2. All of them must be positive: see pend_modes_values_below.
 *
 * PEND_NO_MEMORY  O(count).
 * O(count n).
 */
PEND_MUST_CHECK enum pend_status pend_modes_values(const struct pend_laplacian *laplacian, int first, int count,
                                                   double value[]);

/** Number of eigenvalues below a shift. O(n). */
int pend_modes_values_below(const struct pend_laplacian *laplacian, double shift);

#endif
