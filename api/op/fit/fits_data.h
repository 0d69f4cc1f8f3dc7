/* The measurements of a fit, of one motion or of several, with their starts.
 * Leaves to others: what a table's columns are (api/csv), one run (fits_part), the rest of a
 * request for a fit (fits_json). Invariant: the rows of all runs stand in one table, in the order
 * of their time since the start of their run; runs that measure the same share its column.
 */
#pragma once

#include "api/op/fit/fits_camera.h"

/**
 * Reads `data`, and `initial` and `start` of each run.
 *
 * fit    whose pendulum was read.
 * shift  of the camera, s, as it is given.
 *
 * PEND_INVALID    every fault was added to the problem.
 * PEND_NO_MEMORY  O(rows (columns + log rows)).
 */
PEND_MUST_CHECK enum pend_status api_fit_read_data(struct api_fit *fit, double shift,
                                                   const struct api_reading *reading);
