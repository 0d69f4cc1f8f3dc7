/* Starts of a fit that are taken from its data: what of them is sought, and what stays as it is.
 * Leaves to others: how the data say them (core/fit/fit_start), unknowns that were named
 * (fits_unknowns).
 * Invariant: a number of a start that was taken from the data is sought, unless the request says
 * that it is fixed or too few measurements are there; the answer names both kinds. */
#pragma once

#include "api/op/fit/fits_camera.h"

/** The problem, once the start is settled; it points into `fit`. */
struct pend_fit_problem api_fit_problem(const struct api_fit *fit);

/**
 * Settles the start, once data, unknowns and camera were read: the camera and the starts of runs
 * without `initial` are taken from the data. Angles and rates that are found there become unknowns
 * behind the others, but for those of the list `fixed`, which may say what they are.
 *
 * Every fault is added to the problem. PEND_NO_MEMORY  O(arms runs rows columns).
 */
PEND_MUST_CHECK enum pend_status api_fit_settle(struct api_fit *fit, const struct api_value *fixed,
                                                struct api_problem *problem);

/** Takes camera and starts from the data again where they were, once those have changed, and
 * unknowns whose start is NaN. PEND_NO_MEMORY  O(arms runs rows columns). */
PEND_MUST_CHECK enum pend_status api_fit_guess(struct api_fit *fit);

/** Writes `freed`, the unknowns that no one named, and `fixed`, the numbers that stayed as they
 * were. O(arms (runs + terms) unknowns). */
PEND_MUST_CHECK enum pend_status api_fit_write_fixed(const struct api_fit *fit,
                                                     struct api_buffer *out);
