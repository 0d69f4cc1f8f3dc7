#include "api/json/json_out.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "api/base/text.h"

int api_out_number_bytes(int digits) {
    assert(digits >= 0 && digits <= 17);
    int exponent_or_zeros = digits + 8,
        whole = 18; /* longest texts: "-0.000012345" and "-1230000000000000," with a comma */
    if (!digits) return API_OUT_NUMBER_BYTES;
    return exponent_or_zeros > whole ? exponent_or_zeros : whole;
}

enum pend_status api_out_comma(struct api_buffer *out) {
    assert(api_buffer_valid(out));
    if (!out->bytes || strchr("{[:,", out->data[out->bytes - 1])) return PEND_OK;
    return api_buffer_add(out, ",", 1);
}

enum pend_status api_out_key(struct api_buffer *out, const char *name) {
    PEND_TRY(api_out_comma(out));
    PEND_TRY(api_text_quote(out, name, strlen(name)));
    return api_buffer_add(out, ":", 1);
}

enum pend_status api_out_open(struct api_buffer *out, const char *name, char bracket) {
    assert(bracket == '{' || bracket == '[');
    PEND_TRY(api_out_key(out, name));
    return api_buffer_add(out, &bracket, 1);
}

enum pend_status api_out_text(struct api_buffer *out, const char *name, const char *text) {
    PEND_TRY(name ? api_out_key(out, name) : api_out_comma(out));
    return text ? api_text_quote(out, text, strlen(text)) : api_buffer_text(out, "null");
}

enum pend_status api_out_whole(struct api_buffer *out, const char *name, long value) {
    PEND_TRY(api_out_key(out, name));
    return api_buffer_format(out, "%ld", value);
}

enum pend_status api_out_number(struct api_buffer *out, const char *name, double value,
                                int digits) {
    assert(digits >= 0 && digits <= 17);
    if (!isfinite(value)) return PEND_NOT_FINITE;
    PEND_TRY(name ? api_out_key(out, name) : api_out_comma(out));
    PEND_TRY(api_buffer_room(out, API_NUMBER_BYTES));
    out->bytes = (size_t)(api_out_digits(out->data + out->bytes, value, digits) - out->data);
    return PEND_OK;
}

enum pend_status api_out_maybe(struct api_buffer *out, const char *name, double value) {
    return isfinite(value) ? api_out_number(out, name, value, 0) : api_out_text(out, name, NULL);
}

enum pend_status api_out_numbers(struct api_buffer *out, const char *name, int n,
                                 const double value[], int digits) {
    assert(n >= 0 && digits >= 0 && digits <= 17);
    for (int i = 0; i < n; i++)
        if (!isfinite(value[i])) return PEND_NOT_FINITE;
    PEND_TRY(name ? api_out_key(out, name) : api_out_comma(out));
    PEND_TRY(api_buffer_room(out, (size_t)n * API_OUT_NUMBER_BYTES + API_NUMBER_BYTES));
    char *at = out->data + out->bytes;
    *at++ = '[';
    for (int i = 0; i < n; i++) {
        if (i) *at++ = ',';
        at = api_out_digits(at, value[i], digits);
    }
    *at++ = ']';
    out->bytes = (size_t)(at - out->data);
    assert(api_buffer_valid(out));
    return PEND_OK;
}

enum pend_status api_out_matrix(struct api_buffer *out, const char *name, int n,
                                const double value[], int digits) {
    assert(n >= 1);
    PEND_TRY(api_out_open(out, name, '['));
    for (int i = 0; i < n; i++)
        PEND_TRY(api_out_numbers(out, NULL, n, value + (size_t)i * (size_t)n, digits));
    return api_buffer_add(out, "]", 1);
}
