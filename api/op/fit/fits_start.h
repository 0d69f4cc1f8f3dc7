/* Starts of a fit that are estimated from its data: which of their numbers become unknowns.
 * Leaves to others: the estimates (core/fit/fit_start), named unknowns (fits_camera).
 * Invariant: an estimated number becomes an unknown, unless the request fixes it or there are too
 * few measurements; the answer lists both kinds. */
#pragma once

#include "api/op/fit/fits_camera.h"

/** Returns the problem for core, after api_fit_settle; it points into `fit`. */
struct pend_fit_problem api_fit_problem(const struct api_fit *fit);

/**
 * Completes the start, after data, unknowns and camera were read: estimates the camera, and the
 * starts of runs without `initial`, from the data. Estimated angles and rates become unknowns after
 * the others, except those of the list `fixed`, which may give their values.
 *
 * Every error is added to the problem. PEND_NO_MEMORY  O(arms runs rows columns).
 */
PEND_MUST_CHECK enum pend_status api_fit_settle(struct api_fit *fit, const struct api_value *fixed,
                                                struct api_problem *problem);

/** Repeats the estimates of camera and starts after the data have changed, and estimates unknowns
 * whose start is NaN. PEND_NO_MEMORY  O(arms runs rows columns). */
PEND_MUST_CHECK enum pend_status api_fit_guess(struct api_fit *fit);

/** Writes `freed`, the unknowns that the request does not name, and `fixed`, the numbers that are
 * not unknowns. O(arms (runs + terms) unknowns). */
PEND_MUST_CHECK enum pend_status api_fit_write_fixed(const struct api_fit *fit,
                                                     struct api_buffer *out);
