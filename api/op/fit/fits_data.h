/* The measurements of a fit, of one motion or of several, with their starts.
 * Leaves to others: the meaning of a table's columns (api/csv), one run (fits_part), the rest of a
 * request for a fit (fits_json).
 * Invariant: one table contains the rows of all runs, in the order of the time since the start of
 * their run; runs that measure the same quantity share its column. */
#pragma once

#include "api/op/fit/fits_camera.h"

/**
 * Reads `data`, and `initial` and `start` of each run.
 *
 * fit    its pendulum must be read.
 * shift  time shift of the camera, s, as given.
 *
 * PEND_INVALID    every error was added to the problem.
 * PEND_NO_MEMORY  O(rows (columns + log rows)).
 */
PEND_MUST_CHECK enum pend_status api_fit_read_data(struct api_fit *fit, double shift,
                                                   const struct api_reading *reading);
