/* Multiple shooting: divides the motion into pieces of a fraction of a swing. The states at their
 * starts are additional unknowns, and the gaps between them are residuals whose weight grows. The
 * sum of squares of a chaotic motion has many minima; that of its pieces has few, which lead to the
 * lowest.
 * Leaves to others: the search with the whole motion (fit), which continues from the result.
 * Invariant: the result is only an initial value, never reported as a minimum. */
#pragma once

#include "core/fit/fit_problem.h"

struct fit_pieces;

/**
 * Returns whether multiple shooting is possible: at most 8 arms, each measured in half of the rows,
 * by its angle or by the tips at its ends; one run, no measured mode, a known time shift; rows for
 * two pieces, and in the divided rows as many measurements as unknowns. swing: s, approximate time
 * of one. O(arms rows columns).
 */
int pend_fit_pieces_apt(const struct pend_fit_problem *problem, double swing);

/** Divides the motion into pieces; initial joints come from the data, `inner` are initial values of
 * the unknowns. The problem must outlive the pieces, and be suitable. PEND_NO_MEMORY */
PEND_MUST_CHECK enum pend_status pend_fit_pieces_new(struct fit_pieces **pieces,
                                                     const struct pend_fit_problem *problem,
                                                     double swing, const double inner[]);
void pend_fit_pieces_free(struct fit_pieces **pieces);

/** Takes one iteration, and adds the number of computed motions; done: non-zero once the gaps have
 * their final weight. PEND_NO_MEMORY */
PEND_MUST_CHECK enum pend_status pend_fit_pieces_step(struct fit_pieces *pieces, int *done,
                                                      long *evaluations);

/** Returns the inner numbers of the unknowns, which remain owned by the pieces. O(1). */
const double *pend_fit_pieces_inner(const struct fit_pieces *pieces);

/** Returns the approximate memory of the pieces in bytes; 0 if multiple shooting is not possible.
 * O(arms rows columns). */
double pend_fit_pieces_bytes(const struct pend_fit_problem *problem, double swing);
