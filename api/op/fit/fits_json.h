/* Reading a fit from JSON: measurements, the camera, what is to be found.
 * Leaves to others: the fit (core/fit), its answer (op_fits).
 * Invariant: what was read holds no pointer into the document. */
#pragma once

#include "api/op/fit/fits_camera.h"

/**
 * Reads a fit.
 *
 * fit  out; must be cleared by api_fit_clear whatever is returned.
 *
 * PEND_INVALID    every fault was added to the problem.
 * PEND_NO_MEMORY  O(measurements).
 */
PEND_MUST_CHECK enum pend_status api_fit_read(struct api_fit *fit,
                                              const struct api_reading *reading);

/** Frees all of it. */
void api_fit_clear(struct api_fit *fit);

/**
 * Puts the knees of a loss: to standard deviations that are known, or to those that robust ones of
 * a fit's residuals say, from whose values a further fit then begins.
 *
 * result  of a fit; NULL = there is none yet.
 *
 * Returns whether a knee has changed by more than a hundredth. O(series + unknowns).
 */
int api_fit_bend(struct api_fit *fit, const struct pend_fit_result *result);

/** Puts the values of the unknowns into the pendulum, its start and its camera. PEND_NO_MEMORY. */
PEND_MUST_CHECK enum pend_status api_fit_put(struct api_fit *fit, const double value[]);
