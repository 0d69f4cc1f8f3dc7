/* Multiple shooting: the motion in pieces of a swing, whose starts are unknown as well and whose
 * joints are residuals with a weight that grows. A motion that is chaotic has a sum of squares with
 * many minima; that of its pieces has few, and they lead to the lowest.
 * Leaves to others: the search of the whole motion (fit), which goes on from what is found here.
 * Invariant: an outcome is only where to begin, and is never told as a minimum. */
#ifndef PEND_FIT_PIECES_H
#define PEND_FIT_PIECES_H

#include "core/fit/fit_problem.h"

struct fit_pieces;

/**
 * Whether the motion can be cut: of at most 8 arms every one is seen in half of the rows, by its
 * angle or by the tips at its ends; there is one run, no mode is measured and the time's shift is
 * known; and there are rows for two pieces, and as many measurements in those that are cut as
 * unknowns.
 *
 * swing  s, about the time of one.
 *
 * O(arms rows columns).
 */
int pend_fit_pieces_apt(const struct pend_fit_problem *problem, double swing);

/**
 * Cuts the motion; the joints begin where the data have them.
 *
 * pieces  out; NULL on failure; released by pend_fit_pieces_free.
 * problem outlives it; apt.
 * inner   of the unknowns, where to begin.
 *
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status pend_fit_pieces_new(struct fit_pieces **pieces,
                                                     const struct pend_fit_problem *problem,
                                                     double swing, const double inner[]);

/** Frees the pieces and clears the pointer; NULL is accepted. */
void pend_fit_pieces_free(struct fit_pieces **pieces);

/**
 * Takes one iteration.
 *
 * done         out: non-zero once the joints are as tight as they get.
 * evaluations  the motions that were computed are added.
 *
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status pend_fit_pieces_step(struct fit_pieces *pieces, int *done,
                                                      long *evaluations);

/** Returns the inner numbers of the unknowns, which belong to the pieces. O(1). */
const double *pend_fit_pieces_inner(const struct fit_pieces *pieces);

/** Returns the bytes that pieces take, about; 0 where there are none. O(arms rows columns). */
double pend_fit_pieces_bytes(const struct pend_fit_problem *problem, double swing);

#endif
