/* One of several motions as a problem of its own: its rows, its start, and the unknowns that it has
 * a part in.
 * Leaves to others: the search (fit), which begins all motions with what each finds alone.
 * Invariant: an outcome is only where to begin. */
#ifndef PEND_FIT_ALONE_H
#define PEND_FIT_ALONE_H

#include "core/fit/fit_problem.h"

struct fit_alone {
    struct pend_fit_problem problem;
    int run;   /* of the whole problem */
    int *from; /* of each unknown the index in the whole problem's list */
};

/** Takes run 0 .. runs - 1 out of a problem of several, which must outlive it; it may take half of
 * the iterations. NULL where there is no memory; released by free. O(rows columns). */
struct fit_alone *pend_fit_alone(const struct pend_fit_problem *problem, int run);

#endif
