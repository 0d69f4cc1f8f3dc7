/* Samples of a run: states, accelerations, forces, positions and energies at the requested
 * instants. Leaves to others: steps and the choice of instants (run).
 * Invariant: an instant's bits do not depend on the other instants of its group. */
#pragma once

#include "core/integrate/run/run_work.h"
#include "core/integrate/run/samples.h"

/** Appends the next `due` listed instants, which lie inside the last step, to a block of samples.
 * O(due n), plus the cost of the method's `at`. */
void pend_run_sample(struct pend_run *run, struct pend_samples *samples, int due);

/* The first value of a block that is not finite; row is the number of rows if all are finite. */
struct run_flaw {
    long row;
    int arm; /* the caller's number from 0; -1 = the value belongs to no single arm */
    const char *what;
};

/** Finds the first row of a block with a number that is not finite. O(numbers of the block). */
struct run_flaw pend_run_find_flaw(const struct pend_run *run, const struct pend_samples *samples);
