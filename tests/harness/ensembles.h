/* A run of an ensemble from its first to its last member, for tests and benches.
 * Leaves to others: what is computed. */
#pragma once

#include "core/ensemble/ensemble.h"

/** Computes the members first .. first + count - 1; fails as pend_ensemble_go does. */
static inline enum pend_status test_ensemble_run(struct pend_ensemble *ensemble, long first,
                                                 long count) {
    enum pend_status status = PEND_OK;
    int done = 0;
    pend_ensemble_begin(ensemble, first, count);
    while (status == PEND_OK && !done) status = pend_ensemble_go(ensemble, 1 << 20, &done);
    return status;
}
