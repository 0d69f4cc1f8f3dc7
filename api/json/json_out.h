/* Writing JSON into a buffer: keys, strings, numbers, arrays of numbers.
 * Leaves to others: which members there are (op_*, encode_json), limits (buffer).
 * Invariant: the last byte of the buffer decides whether a comma is written, so callers do not
 * count members; NaN and infinity are never written. */
#pragma once

#include "api/base/buffer.h"
#include "api/number/number.h"

/* Most bytes of a number with its comma: -2.2250738585072014e-308, */
enum { API_OUT_NUMBER_BYTES = 25 };

/** Returns the most bytes of a number with its comma, rounded to `digits` significant digits; 0 =
 * not rounded. */
int api_out_number_bytes(int digits);

/** Writes a finite number; `at` has API_NUMBER_BYTES of space, digits as above. Returns the end. */
static inline char *api_out_digits(char *at, double x, int digits) {
    return digits ? api_number_write_digits(at, x, digits) : api_number_write(at, x);
}

/** Appends a comma, unless the buffer is empty or ends with an opening bracket, a colon or a
 * comma. */
PEND_MUST_CHECK enum pend_status api_out_comma(struct api_buffer *out);

/** Appends the name of a member and a colon; api_out_comma decides about a comma before it. */
PEND_MUST_CHECK enum pend_status api_out_key(struct api_buffer *out, const char *name);

/** Appends the name and opens its object or array: bracket is '{' or '['. */
PEND_MUST_CHECK enum pend_status api_out_open(struct api_buffer *out, const char *name,
                                              char bracket);

/** Appends a member (an item of an array if name is NULL) that is a string; text is UTF-8, NULL
 * gives null. */
PEND_MUST_CHECK enum pend_status api_out_text(struct api_buffer *out, const char *name,
                                              const char *text);

/** Appends a member whose value is an integer. */
PEND_MUST_CHECK enum pend_status api_out_whole(struct api_buffer *out, const char *name,
                                               long value);

/**
 * Appends a member (an item of an array if name is NULL) that is a number.
 *
 * PEND_NOT_FINITE  value is NaN or infinite; nothing was appended.
 */
PEND_MUST_CHECK enum pend_status api_out_number(struct api_buffer *out, const char *name,
                                                double value, int digits);

/** Appends a member that is a number with all digits; a value that is not finite gives null. */
PEND_MUST_CHECK enum pend_status api_out_maybe(struct api_buffer *out, const char *name,
                                               double value);

/**
 * Appends an array of numbers; api_out_comma decides about a comma before it.
 *
 * name    name of the member, or NULL for an item of an array.
 * value   n numbers.
 *
 * PEND_NOT_FINITE  one of them is NaN or infinite; nothing was appended.
 */
PEND_MUST_CHECK enum pend_status api_out_numbers(struct api_buffer *out, const char *name, int n,
                                                 const double value[], int digits);

/** Appends a member whose value is an n x n matrix, row-major, as an array of rows; fails as
 * api_out_numbers does. */
PEND_MUST_CHECK enum pend_status api_out_matrix(struct api_buffer *out, const char *name, int n,
                                                const double value[], int digits);
