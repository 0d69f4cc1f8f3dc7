/* One of several motions as a separate problem: its rows, its start, and the unknowns on which it
 * depends.
 * Leaves to others: the search (fit), which starts all motions from their separate solutions.
 * Invariant: a separate solution is only a start. */
#pragma once

#include "core/fit/fit_problem.h"

struct fit_alone {
    struct pend_fit_problem problem;
    int run;   /* index of the run in the whole problem */
    int *from; /* for each unknown, its index in the whole problem */
};

/** Extracts a run, 0 .. runs - 1, from a problem of several, which must outlive it; it gets half of
 * the iterations. Returns NULL if memory is short; released by free. O(rows columns). */
struct fit_alone *pend_fit_alone(const struct pend_fit_problem *problem, int run);
