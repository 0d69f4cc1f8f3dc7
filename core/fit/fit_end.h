/* The result of a fit at the end of its search.
 * Leaves to others: the search (fit).
 * Invariant: a fit has converged only at a minimum of the sum of squares within the bounds whose
 * motion follows the data. */
#pragma once

#include "core/fit/fit_state.h"

/**
 * Computes the result at the fit's inner numbers, and marks it as ready.
 *
 * PEND_NO_MEMORY; also fails as pend_fit_model_at does.
 */
PEND_MUST_CHECK enum pend_status pend_fit_end(struct pend_fit *fit, struct pend_error *error);
