#include "api/base/buffer.h"

#include <assert.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { BUFFER_FIRST = 1024 };

int api_buffer_valid(const struct api_buffer *buffer) {
    return buffer->bytes <= buffer->cap && buffer->cap <= buffer->limit &&
           (!buffer->cap || buffer->data);
}

void api_buffer_init(struct api_buffer *buffer, size_t limit) {
    *buffer = (struct api_buffer){.limit = limit};
}

void api_buffer_clear(struct api_buffer *buffer) {
    assert(api_buffer_valid(buffer));
    free(buffer->data);
    api_buffer_init(buffer, buffer->limit);
}

void api_buffer_trim(struct api_buffer *buffer) {
    assert(api_buffer_valid(buffer));
    char *data =
        buffer->bytes && buffer->bytes < buffer->cap ? realloc(buffer->data, buffer->bytes) : NULL;
    if (!data) return;
    buffer->data = data;
    buffer->cap = buffer->bytes;
}

/* twice the capacity, at least `need`, at most the limit */
static size_t buffer_next_cap(const struct api_buffer *buffer, size_t need) {
    size_t cap = buffer->cap < BUFFER_FIRST / 2 ? BUFFER_FIRST / 2 : buffer->cap;
    cap = cap > buffer->limit / 2 ? buffer->limit : 2 * cap;
    if (cap < need) cap = need;
    return cap < buffer->limit ? cap : buffer->limit;
}

enum pend_status api_buffer_room(struct api_buffer *buffer, size_t more) {
    assert(api_buffer_valid(buffer));
    if (more <= buffer->cap - buffer->bytes) return PEND_OK;
    if (more > buffer->limit - buffer->bytes) return PEND_LIMIT;
    size_t need = buffer->bytes + more, cap = buffer_next_cap(buffer, need);
    char *data = realloc(buffer->data, cap);
    /* if memory is short, exactly the needed bytes may still be available */
    if (!data && cap > need) data = realloc(buffer->data, cap = need);
    if (!data) return PEND_NO_MEMORY;
    buffer->data = data;
    buffer->cap = cap;
    assert(api_buffer_valid(buffer));
    return PEND_OK;
}

enum pend_status api_buffer_add(struct api_buffer *buffer, const void *data, size_t bytes) {
    PEND_TRY(api_buffer_room(buffer, bytes));
    if (bytes) memcpy(buffer->data + buffer->bytes, data, bytes);
    buffer->bytes += bytes;
    return PEND_OK;
}

enum pend_status api_buffer_text(struct api_buffer *buffer, const char *text) {
    return api_buffer_add(buffer, text, strlen(text));
}

/* prints into the free bytes; returns the length of the whole text, < 0 on an encoding error */
__attribute__((format(printf, 2, 0))) static int
buffer_print(struct api_buffer *buffer, const char *format, va_list arguments) {
    size_t room = buffer->cap - buffer->bytes;
    return vsnprintf(room ? buffer->data + buffer->bytes : NULL, room, format, arguments);
}

enum pend_status api_buffer_format(struct api_buffer *buffer, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    int bytes = buffer_print(buffer, format, arguments);
    va_end(arguments);
    if (bytes < 0) return PEND_BUG;
    /* The text did not fit together with printf's NUL, for which the limit may leave no space:
     * print into a copy. */
    if ((size_t)bytes >= buffer->cap - buffer->bytes) {
        PEND_TRY(api_buffer_room(buffer, (size_t)bytes));
        char *copy = malloc((size_t)bytes + 1);
        if (!copy) return PEND_NO_MEMORY;
        va_start(arguments, format);
        vsnprintf(copy, (size_t)bytes + 1, format, arguments);
        va_end(arguments);
        if (bytes) memcpy(buffer->data + buffer->bytes, copy, (size_t)bytes);
        free(copy);
    }
    buffer->bytes += (size_t)bytes;
    return PEND_OK;
}
