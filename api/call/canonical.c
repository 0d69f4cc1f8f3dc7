#include "api/call/canonical.h"

#include <string.h>

#include "api/base/text.h"

static enum pend_status canonical_object(const struct api_value *object, struct api_buffer *out) {
    PEND_TRY(api_buffer_text(out, "{"));
    for (const char *last = NULL;;) {
        struct api_value member = api_value_behind(object, last, 0);
        if (!member.node) return api_buffer_text(out, "}");
        PEND_TRY(api_out_key(out, member.key));
        PEND_TRY(api_canonical_write(&member, out));
        last = member.key;
    }
}

static enum pend_status canonical_array(const struct api_value *array, struct api_buffer *out) {
    int count = 0;
    const double *number = api_value_numbers(array, &count);
    if (number) return api_out_numbers(out, NULL, count, number, 0);
    PEND_TRY(api_buffer_text(out, "["));
    API_VALUE_EACH (item, api_value_first(array)) {
        PEND_TRY(api_out_comma(out));
        PEND_TRY(api_canonical_write(&item, out));
    }
    return api_buffer_text(out, "]");
}

enum pend_status api_canonical_write(const struct api_value *value, struct api_buffer *out) {
    const char *text = api_value_text(value);
    switch (api_value_kind(value)) {
    case API_OBJECT:
        return canonical_object(value, out);
    case API_ARRAY:
        return canonical_array(value, out);
    case API_STRING:
        return api_text_quote(out, text, strlen(text));
    case API_NUMBER:
        PEND_TRY(api_buffer_room(out, API_NUMBER_BYTES));
        out->bytes =
            (size_t)(api_number_write(out->data + out->bytes, api_value_number(value)) - out->data);
        return PEND_OK;
    case API_BOOL:
        return api_buffer_text(out, api_value_number(value) != 0 ? "true" : "false");
    case API_NULL:
    case API_MISSING:
        break;
    }
    return api_buffer_text(out, "null");
}
