/* Reads a request for a fit from JSON: measurements, the camera and the unknowns.
 * Leaves to others: the fit (core/fit), its answer (op_fits).
 * Invariant: the parsed fit contains no pointer into the document. */
#pragma once

#include "api/op/fit/fits_camera.h"

/**
 * Reads a fit.
 *
 * fit  out; must be cleared by api_fit_clear, also after a failure.
 *
 * PEND_INVALID    every error was added to the problem.
 * PEND_NO_MEMORY  O(measurements).
 */
PEND_MUST_CHECK enum pend_status api_fit_read(struct api_fit *fit,
                                              const struct api_reading *reading);
void api_fit_clear(struct api_fit *fit);

/**
 * Sets the knees of a loss: from the given standard deviations, or from robust estimates of a fit's
 * residuals. In the second case the next fit starts from the values of that fit.
 *
 * result  the result of a fit; NULL = none yet.
 *
 * Returns whether a knee has changed by more than a hundredth. O(series + unknowns).
 */
int api_fit_bend(struct api_fit *fit, const struct pend_fit_result *result);

/** Copies the values of the unknowns into the pendulum, its start and its camera. PEND_NO_MEMORY.
 */
PEND_MUST_CHECK enum pend_status api_fit_put(struct api_fit *fit, const double value[]);
