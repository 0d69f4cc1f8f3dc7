/* Text for JSON: checking UTF-8, quoting and escaping strings.
 * Leaves to others: reading JSON (json_in), numbers (number).
 * Invariant: the output is a valid JSON string in valid UTF-8 whatever the input was. */
#pragma once

#include "api/base/buffer.h"

/**
 * Returns the length of the UTF-8 sequence at the start of text, 1 to 4 bytes, or 0 if there is
 * none (Unicode table 3-7: no overlong form, no surrogate, nothing beyond U+10FFFF).
 *
 * bytes  length of text, >= 1; nothing beyond is read.
 */
int api_text_utf8(const char *text, size_t bytes);

/** Returns the length of the longest prefix of at most `cap` bytes that does not cut a UTF-8
 * sequence in two. */
size_t api_text_cut(const char *text, size_t bytes, size_t cap);

/**
 * Appends text as the inside of a JSON string. Equal texts give equal bytes.
 *
 * Fails as api_buffer_room does; then a part may have been appended.
 */
PEND_MUST_CHECK enum pend_status api_text_escape(struct api_buffer *out, const char *text,
                                                 size_t bytes);

/**
 * Appends text as a JSON string with its quotes; bytes that are not UTF-8 become U+FFFD.
 *
 * Fails as api_buffer_room does; then a part may have been appended.
 */
PEND_MUST_CHECK enum pend_status api_text_quote(struct api_buffer *out, const char *text,
                                                size_t bytes);
