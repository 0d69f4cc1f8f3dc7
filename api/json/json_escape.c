#include "api/json/json_escape.h"

#include <assert.h>
#include <string.h>

#include "api/json/json_digits.h"

/* the value of \uXXXX; -1 if it is malformed */
static long escape_hex(const char *text, size_t bytes) {
    if (bytes < 6 || text[0] != '\\' || text[1] != 'u') return -1;
    long value = 0;
    for (int i = 2; i < 6; i++) {
        int c = (unsigned char)text[i], lower = c | 0x20;
        if (!api_digit(c) && (lower < 'a' || lower > 'f')) return -1;
        value = 16 * value + (api_digit(c) ? c - '0' : lower - 'a' + 10);
    }
    return value;
}

static size_t escape_encode(long code, char utf8[4]) {
    static const int lead[] = {0, 0xc0, 0xe0, 0xf0};
    int tail = code < 0x80 ? 0 : code < 0x800 ? 1 : code < 0x10000 ? 2 : 3;
    utf8[0] = (char)(lead[tail] | (int)(code >> (6 * tail)));
    for (int i = 1; i <= tail; i++) utf8[i] = (char)(0x80 | (int)(code >> (6 * (tail - i)) & 0x3f));
    return (size_t)tail + 1;
}

/* reads \uXXXX, or a surrogate pair */
static const char *escape_unicode(const char *text, size_t bytes, size_t *taken, char utf8[4],
                                  size_t *length) {
    long code = escape_hex(text, bytes);
    if (code < 0) return "\\u must be followed by four hexadecimal digits";
    if (!code) return "a string must not contain the character U+0000";
    if (code >= 0xdc00 && code <= 0xdfff) return "a low surrogate is unpaired";
    int high = code >= 0xd800 && code <= 0xdbff;
    if (high) {
        long low = escape_hex(text + 6, bytes - 6);
        if (low < 0xdc00 || low > 0xdfff) return "a high surrogate is unpaired";
        code = 0x10000 + ((code - 0xd800) << 10) + (low - 0xdc00);
    }
    *taken = high ? 12 : 6;
    *length = escape_encode(code, utf8);
    return NULL;
}

const char *api_escape_read(const char *text, size_t bytes, size_t *taken, char utf8[4],
                            size_t *length) {
    static const char from[] = "\"\\/bfnrt", to[] = "\"\\/\b\f\n\r\t";
    assert(bytes && text[0] == '\\');
    int c = bytes > 1 ? (unsigned char)text[1] : 0;
    if (c == 'u') return escape_unicode(text, bytes, taken, utf8, length);
    const char *found = c ? strchr(from, c) : NULL;
    if (!found) return "a backslash in a string must be followed by one of \"\\/bfnrtu";
    utf8[0] = to[found - from];
    *taken = 2;
    *length = 1;
    return NULL;
}
