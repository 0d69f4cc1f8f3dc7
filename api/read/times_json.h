/* Reads the requested instants from JSON: a grid by its step or its count, or a list.
 * Leaves to others: computing samples at them (core/integrate/run/run).
 * Invariant: instants that were read are finite, strictly monotonic within the resolution of
 * doubles, and within the limits. */
#pragma once

#include "api/read/field.h"
#include "api/base/limits.h"
#include "core/integrate/methods/method.h"

struct api_times {
    struct pend_times times;
    double *list; /* owned; times.list is the same pointer, or NULL for a grid */
};

/**
 * Reads the instants.
 *
 * times  out; released by api_times_clear, also after a failure.
 * value  an object {start, stop, step} or {start, stop, count}, in s, where start is 0 by default;
 *        or an array of instants. A grid by its step ends at the last instant before stop, and
 *        exactly at stop if the step divides the span to 1e-9. Backwards in time a step may have
 *        either sign.
 *
 * PEND_INVALID   every error was added to the problem.
 * PEND_NO_MEMORY
 * O(1) for a grid, O(count) for a list.
 */
PEND_MUST_CHECK enum pend_status api_times_read(struct api_times *times,
                                                const struct api_value *value,
                                                const struct api_limits *limits,
                                                struct api_problem *problem);
void api_times_clear(struct api_times *times);
