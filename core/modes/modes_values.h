/* Eigenvalues of a weighted tree by counting, to full relative accuracy.
 * Leaves to others: vectors (modes_vectors), merging several trees' values (modes).
 * Invariant: every value lies in a bracket whose ends were counted, so none is missed and none
 * is doubled. */
#ifndef PEND_MODES_VALUES_H
#define PEND_MODES_VALUES_H

#include "core/modes/modes_template.h"

/* A search under way. */
struct pend_values;

/**
 * Begins to search for the eigenvalues number first .. first + count - 1 of L x = lambda M x,
 * counted from the smallest.
 *
 * Multisection isolates them; Laguerre's iteration, which each count yields at no further cost,
 * converges on them; the counts guard it. About 4 sweeps over the tree an eigenvalue.
 *
 * laplacian, value  must outlive the search; the laplacian is not to change.
 * value             out, count values > 0, 1/s^2, once the search is done. All of them must be
 *                   positive: see pend_values_below.
 *
 * PEND_NO_MEMORY  O(count).
 */
PEND_MUST_CHECK enum pend_status pend_values_new(struct pend_values **values,
                                                 const struct pend_laplacian *laplacian, int first,
                                                 int count, double value[]);

/** Searches on for at most about 64 sweeps; returns non-zero once all are found. O(n), O(count n)
 * in all. */
int pend_values_step(struct pend_values *values);

void pend_values_free(struct pend_values **values);

/** Number of eigenvalues below a shift. O(n). */
int pend_values_below(const struct pend_laplacian *laplacian, double shift);

#endif
