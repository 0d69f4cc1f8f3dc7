/* Checks of a problem before it is integrated.
 * Leaves to others: the integration (run), a method's ranges (method).
 * Invariant: a problem is changed only by replacing zeros with the method's defaults. */
#pragma once

#include <stdint.h>
#include <string.h>

#include "core/integrate/methods/method.h"

/** Returns `bad` or-ed with the bits of x - x, which are 0 if and only if x is finite. */
static inline uint64_t pend_run_gather(uint64_t bad, double x) {
    double zero = x - x;
    uint64_t bits;
    memcpy(&bits, &zero, sizeof bits);
    return bad | bits;
}

/**
 * Returns true if `count` numbers are all finite.
 *
 * The loop takes eight numbers at a time and does not end early, so that compilers vectorize it.
 * O(count).
 */
static inline int pend_run_finite(const double x[], long count) {
    enum { SIDE = 8 };
    uint64_t any = 0;
    long i = 0;
    if (count >= SIDE) {
        uint64_t bad[SIDE] = {0};
        for (; i + SIDE <= count; i += SIDE)
            for (int k = 0; k < SIDE; k++) bad[k] = pend_run_gather(bad[k], x[i + k]);
        for (int k = 0; k < SIDE; k++) any |= bad[k];
    }
    for (; i < count; i++) any = pend_run_gather(any, x[i]);
    return !any;
}

/**
 * Checks that lengths and masses are normal numbers, whose inverses can be formed: at least
 * 2.3e-308.
 *
 * PEND_INVALID  error names it. O(n).
 */
PEND_MUST_CHECK enum pend_status pend_run_check_tree(const struct pend_tree *tree,
                                                     struct pend_error *error);

/**
 * Checks a problem and replaces zeros with the method's defaults.
 *
 * PEND_INVALID  tolerances out of the method's range, times not monotonic, a state that is not
 *               finite; error names it.
 * O(n), and O(number of instants) for a list or a very fine grid.
 */
PEND_MUST_CHECK enum pend_status pend_run_check(const struct pend_method *method,
                                                struct pend_problem *problem,
                                                struct pend_error *error);
