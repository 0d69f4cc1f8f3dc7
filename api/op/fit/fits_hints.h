/* Finds likely mistakes in a request whose model is rejected: data in another unit, about another
 * zero, with arms exchanged, mirrored, or a fixed number that should be an unknown. A separate fit
 * tries each of these, within a bounded number of motions.
 * Leaves to others: the requested fit (op_fits).
 * Invariant: the request and its fit are not changed. */
#pragma once

#include "api/base/buffer.h"
#include "api/op/fit/fits_camera.h"

/* no tries for a fit with more measured numbers */
enum { API_HINT_NUMBERS = 20000 };

struct api_hints;

/** Prepares the tries; there are none if the model is not rejected, or if only frequencies were
 * measured. Ends with api_hints_free. The fit and its result must outlive the hints. At most
 * `motions` motions are computed, or as many as the fit needed. PEND_NO_MEMORY  O(measurements +
 * unknowns). */
PEND_MUST_CHECK enum pend_status api_hints_new(struct api_hints **hints, const struct api_fit *fit,
                                               const struct pend_fit_result *result, long motions);
void api_hints_free(struct api_hints **hints);

/** Computes one iteration of a try. done  out: non-zero after the last. PEND_NO_MEMORY. */
PEND_MUST_CHECK enum pend_status api_hints_step(struct api_hints *hints, int *done);

/** Writes `hints`, an array of sentences. */
PEND_MUST_CHECK enum pend_status api_hints_write(const struct api_hints *hints,
                                                 struct api_buffer *out);
