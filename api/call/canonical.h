/* Writes a JSON value in canonical form: keys in byte order, no blanks, shortest numbers.
 * Leaves to others: which values need it (request, scene).
 * Invariant: values that differ only in key order and in the notation of numbers and texts give the
 * same bytes; the bytes parse to the same value. */
#pragma once

#include "api/json/json_in.h"
#include "api/json/json_out.h"

/**
 * Appends a value.
 *
 * value  written as null if it is missing.
 *
 * Fails as api_buffer_room does; a part may have been appended then. O(bytes), and O(m^2) in an
 * object of m members.
 */
PEND_MUST_CHECK enum pend_status api_canonical_write(const struct api_value *value,
                                                     struct api_buffer *out);
