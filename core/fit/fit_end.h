/* What a fit tells once its search is over.
 * Leaves to others: the search (fit).
 * Invariant: it says converged only at a minimum of the sum of squares that no bound holds wrongly,
 * and whose motion follows the data.
 */
#ifndef PEND_FIT_END_H
#define PEND_FIT_END_H

#include "core/fit/fit_state.h"

/**
 * Fills in the result at the fit's inner numbers, and marks it as ready.
 *
 * PEND_NO_MEMORY; what pend_fit_model_at says of a motion that is not there.
 */
PEND_MUST_CHECK enum pend_status pend_fit_end(struct pend_fit *fit, struct pend_error *error);

#endif
