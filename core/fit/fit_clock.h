/* The shifts of clocks: the sum of squares has a minimum in every swing.
 * Leaves to others: the minimum itself (fit).
 * Invariant: unknowns other than shifts are not changed. */
#pragma once

#include "core/fit/fit_state.h"

/**
 * Takes each unknown shift of a clock to the lowest of its minima within four swings, for the rows
 * of the window. Of minima that differ by less than the noise, as in a periodic motion, it takes
 * the nearest, and reports another one as the result's `twin`.
 *
 * whole  whether minima are compared after a step of all unknowns; else with the others fixed, and
 *        the nearest is taken unless another has less than half the sum of squares.
 * some   set to 1 if there is such an unknown; then slopes and residuals are not valid.
 *
 * PEND_NO_MEMORY  about 200 motions for each shift.
 */
PEND_MUST_CHECK enum pend_status pend_fit_clock_find(struct pend_fit *fit, int whole, int *some,
                                                     struct pend_error *error);
