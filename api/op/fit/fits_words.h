/* Sentences about the end of a fit and the directions that the data do not determine.
 * Leaves to others: the numbers of an answer (op_fits).
 * Invariant: a sentence about a failure names a remedy. */
#pragma once

#include "api/base/buffer.h"
#include "api/op/fit/fits_camera.h"

/** Writes `status` and `message`. PEND_NO_MEMORY  O(rows runs). */
PEND_MUST_CHECK enum pend_status api_fit_write_end(const struct api_fit *fit,
                                                   const struct pend_fit_result *result,
                                                   struct api_buffer *out);

/** Writes a sentence about an undetermined direction, one number per unknown, the largest of which
 * is 1, as an item of an array. PEND_NO_MEMORY  O(unknowns). */
PEND_MUST_CHECK enum pend_status api_fit_write_direction(const struct api_fit *fit,
                                                         const double direction[],
                                                         struct api_buffer *out);
