/* What a problem must fulfil before it is integrated.
 * Leaves to others: the integration (run), what a method demands of it (method).
 * Invariant: the problem is changed only where zeros stand for a method's defaults. */
#ifndef PEND_RUN_CHECK_H
#define PEND_RUN_CHECK_H

#include <stdint.h>
#include <string.h>

#include "core/method.h"

/**
 * True where `count` numbers are all finite.
 *
 * x - x is +0 just there; the bits are gathered because that loop vectorises. O(count).
 */
static inline int pend_run_finite(const double x[], long count) {
    uint64_t bad = 0;
    for (long i = 0; i < count; i++) {
        double zero = x[i] - x[i];
        uint64_t bits;
        memcpy(&bits, &zero, sizeof bits);
        bad |= bits;
    }
    return !bad;
}

/**
 * Checks a problem and puts the method's defaults in the place of zeros.
 *
 * PEND_INVALID  tolerances out of the method's range, times not monotonic, a state that is not finite; error says
 * which. O(n + number of instants).
 */
PEND_MUST_CHECK enum pend_status pend_run_check(const struct pend_method *method, struct pend_problem *problem,
                                                struct pend_error *error);

#endif
