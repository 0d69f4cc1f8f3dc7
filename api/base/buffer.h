/* A growing byte buffer with a hard limit, into which responses are written.
 * Leaves to others: the meaning of the bytes.
 * Invariant: bytes <= cap <= limit; after a failure the buffer keeps its contents and stays
 * usable. */
#pragma once

#include <stddef.h>

#include "core/base/status.h"

struct api_buffer {
    char *data;
    size_t bytes, cap, limit;
};

/** Initializes an empty buffer that may grow to `limit` bytes; allocates nothing. */
void api_buffer_init(struct api_buffer *buffer, size_t limit);

/** Frees the memory and leaves an empty buffer of the same limit. */
void api_buffer_clear(struct api_buffer *buffer);
int api_buffer_valid(const struct api_buffer *buffer);

/** Frees unused capacity; the contents stay, but may move. */
void api_buffer_trim(struct api_buffer *buffer);

/**
 * Ensures that `more` bytes can be written directly at data + bytes; the caller then adds them to
 * `bytes`.
 *
 * PEND_LIMIT      the buffer would exceed its limit.
 * PEND_NO_MEMORY
 * Amortised O(1) a byte.
 */
PEND_MUST_CHECK enum pend_status api_buffer_room(struct api_buffer *buffer, size_t more);

/** Appends bytes; fails as api_buffer_room does. */
PEND_MUST_CHECK enum pend_status api_buffer_add(struct api_buffer *buffer, const void *data,
                                                size_t bytes);

/** Appends a string without its NUL; fails as api_buffer_room does. */
PEND_MUST_CHECK enum pend_status api_buffer_text(struct api_buffer *buffer, const char *text);

/** Appends printf output; fails as api_buffer_room does. For headers and messages, not for
 * doubles. */
PEND_MUST_CHECK enum pend_status api_buffer_format(struct api_buffer *buffer, const char *format,
                                                   ...) __attribute__((format(printf, 2, 3)));
