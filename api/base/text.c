#include "api/base/text.h"

#include <assert.h>
#include <string.h>

static int text_tail(unsigned char c) { return (c & 0xc0) == 0x80; }

/* whether c may follow `lead`: after E0, ED, F0 and F4 the range of the second byte is narrower,
 * which excludes overlong forms, surrogates, and code points beyond 10FFFF */
static int text_second(unsigned char lead, unsigned char c) {
    if (lead == 0xe0) return c >= 0xa0 && c <= 0xbf;
    if (lead == 0xed) return c >= 0x80 && c <= 0x9f;
    if (lead == 0xf0) return c >= 0x90 && c <= 0xbf;
    if (lead == 0xf4) return c >= 0x80 && c <= 0x8f;
    return text_tail(c);
}

static int text_length(unsigned char lead) {
    if (lead < 0x80) return 1;
    if (lead < 0xc2 || lead > 0xf4) return 0;
    return lead < 0xe0 ? 2 : lead < 0xf0 ? 3 : 4;
}

int api_text_utf8(const char *text, size_t bytes) {
    assert(bytes);
    const unsigned char *p = (const unsigned char *)text;
    int length = text_length(p[0]);
    if ((size_t)length > bytes) return 0;
    if (length > 1 && !text_second(p[0], p[1])) return 0;
    for (int i = 2; i < length; i++)
        if (!text_tail(p[i])) return 0;
    return length;
}

size_t api_text_cut(const char *text, size_t bytes, size_t cap) {
    if (bytes <= cap) return bytes;
    size_t end = cap;
    while (end && end + 4 > cap && text_tail((unsigned char)text[end])) end--;
    assert(end <= cap && cap < bytes);
    return text_tail((unsigned char)text[end]) ? cap : end;
}

/* number of leading bytes that need no escape */
static size_t text_plain(const char *text, size_t bytes) {
    size_t i = 0;
    while (i < bytes) {
        unsigned char c = (unsigned char)text[i];
        if (c < 0x20 || c == '"' || c == '\\') break;
        int length = api_text_utf8(text + i, bytes - i);
        if (!length) break;
        i += (size_t)length;
    }
    return i;
}

static enum pend_status text_escape_byte(struct api_buffer *out, unsigned char c) {
    static const char from[] = "\"\\\b\f\n\r\t", to[] = "\"\\bfnrt";
    const char *found = c ? strchr(from, c) : NULL;
    if (found) return api_buffer_add(out, (char[]){'\\', to[found - from]}, 2);
    return c >= 0x80 ? api_buffer_text(out, "\xef\xbf\xbd") : api_buffer_format(out, "\\u%04x", c);
}

enum pend_status api_text_escape(struct api_buffer *out, const char *text, size_t bytes) {
    while (bytes) {
        size_t plain = text_plain(text, bytes);
        PEND_TRY(api_buffer_add(out, text, plain));
        text += plain;
        bytes -= plain;
        if (!bytes) break;
        PEND_TRY(text_escape_byte(out, (unsigned char)*text));
        text++;
        bytes--;
    }
    return PEND_OK;
}

enum pend_status api_text_quote(struct api_buffer *out, const char *text, size_t bytes) {
    PEND_TRY(api_buffer_text(out, "\""));
    PEND_TRY(api_text_escape(out, text, bytes));
    return api_buffer_text(out, "\"");
}
