#include "api/json/json_scan.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/json/json_digits.h"
#include "api/number/number.h"
#include "api/base/text.h"

/* what the grammar wants next */
enum { WANT_VALUE, WANT_ITEM_OR_END, WANT_KEY, WANT_KEY_OR_END, WANT_MORE, WANT_NOTHING };

/* what one value takes in memory at most, and how much of it a byte of text may ask for */
enum {
    COST_NODE = API_SCAN_NODE,
    COST_STRING = 32,
    COST_ARRAY = 16,
    COST_PER_BYTE = 20,
    COST_FREE = 1 << 16
};

struct api_scan_frame {
    int object;
    int pure; /* an array that has held nothing but numbers so far: nothing of it is in the rest yet
               */
    size_t first; /* of its numbers (while pure) or keys */
};

static int scan_peek(const struct api_scan *s) {
    return s->at < s->bytes ? (unsigned char)s->text[s->at] : -1;
}

static int scan_word(int c) {
    return api_digit(c) || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
}

static void scan_space(struct api_scan *s) {
    while (s->at < s->bytes && s->text[s->at] <= ' ' && strchr(" \t\n\r", s->text[s->at]) &&
           s->text[s->at])
        s->at++;
}

/* messages */

enum { FOUND_BYTES = 64, FOUND_WORD = 24 };

/* names what stands at a place: a word, a character, a byte or the end */
static void scan_found(const struct api_scan *s, size_t at, char found[FOUND_BYTES]) {
    if (at >= s->bytes) {
        snprintf(found, FOUND_BYTES, "the end of the text");
        return;
    }
    const char *p = s->text + at;
    size_t left = s->bytes - at, length = 0;
    while (length < left && length < FOUND_WORD && scan_word((unsigned char)p[length])) length++;
    if (!length) length = (size_t)api_text_utf8(p, left);
    if (!length || (unsigned char)*p < ' ' || *p == 0x7f)
        snprintf(found, FOUND_BYTES, "the byte 0x%02X", (unsigned char)*p);
    else
        snprintf(found, FOUND_BYTES, *p == '"' ? "'%.*s'" : "\"%.*s\"", (int)length, p);
}

/* line and column from 1, the column in characters */
static void scan_place(const struct api_scan *s, size_t at, long *line, long *column) {
    *line = *column = 1;
    for (size_t i = 0; i < at; i++) {
        if (s->text[i] == '\n') ++*line;
        if (s->text[i] == '\n')
            *column = 1;
        else if (((unsigned char)s->text[i] & 0xc0) != 0x80)
            ++*column;
    }
}

__attribute__((format(printf, 4, 5))) static enum pend_status
scan_fail(struct api_scan *s, int status, size_t at, const char *format, ...) {
    char what[200];
    long line, column;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(what, sizeof what, format, arguments);
    va_end(arguments);
    scan_place(s, at, &line, &column);
    api_problem_set(s->problem, status, "%s: %s at line %ld, column %ld (byte %zu)",
                    status == 400 ? "the body is not JSON" : "the body's JSON is refused", what,
                    line, column, at);
    return PEND_INVALID;
}

static enum pend_status scan_expected(struct api_scan *s, const char *what) {
    char found[FOUND_BYTES];
    scan_found(s, s->at, found);
    return scan_fail(s, 400, s->at, "expected %s but found %s", what, found);
}

/* memory */

/* makes room for one more item in a growing array */
static enum pend_status scan_grow(void **items, size_t *cap, size_t count, size_t item_bytes) {
    if (count < *cap) return PEND_OK;
    size_t next = *cap ? 2 * *cap : 64;
    void *grown = realloc(*items, next * item_bytes);
    if (!grown) return PEND_NO_MEMORY;
    *items = grown;
    *cap = next;
    return PEND_OK;
}

static enum pend_status scan_charge(struct api_scan *s, size_t cost) {
    s->cost += cost;
    if (s->cost <= COST_FREE + COST_PER_BYTE * s->bytes) return PEND_OK;
    return scan_fail(s, 422, s->at, "too many tiny values for so short a text");
}

/* a value that becomes a node of the parser's tree: these take time, of the parser and of
 * whoever walks the tree */
static enum pend_status scan_charge_node(struct api_scan *s) {
    if (++s->nodes > API_SCAN_VALUES)
        return scan_fail(s, 422, s->at,
                         "more than %d values, not counting those in arrays of numbers",
                         API_SCAN_VALUES);
    return scan_charge(s, COST_NODE);
}

/* appends a whole number to the rest */
static enum pend_status scan_emit_whole(struct api_scan *s, long long k) {
    PEND_TRY(api_buffer_room(&s->rest, API_NUMBER_BYTES));
    s->rest.bytes = (size_t)(api_number_write_int(s->rest.data + s->rest.bytes, k) - s->rest.data);
    return PEND_OK;
}

static enum pend_status scan_push_number(struct api_scan *s, double x) {
    void *numbers = s->numbers;
    PEND_TRY(scan_grow(&numbers, &s->number_cap, s->number_count, sizeof x));
    s->numbers = numbers;
    s->numbers[s->number_count++] = x;
    return PEND_OK;
}

/* the rest: what goes to the parser */

static enum pend_status scan_emit_number(struct api_scan *s, size_t k) {
    PEND_TRY(scan_charge_node(s));
    return scan_emit_whole(s, (long long)k);
}

/* an array that held only numbers meets something else: its numbers become items of the rest */
static enum pend_status scan_spoil(struct api_scan *s) {
    if (!s->depth || !s->frames[s->depth - 1].pure) return PEND_OK;
    struct api_scan_frame *frame = &s->frames[s->depth - 1];
    frame->pure = 0;
    PEND_TRY(scan_charge_node(s));
    PEND_TRY(api_buffer_text(&s->rest, "["));
    for (size_t k = frame->first; k < s->number_count; k++) {
        PEND_TRY(scan_emit_number(s, k));
        PEND_TRY(api_buffer_text(&s->rest, ","));
    }
    return PEND_OK;
}

static enum pend_status scan_emit_array(struct api_scan *s, size_t first) {
    void *arrays = s->arrays;
    PEND_TRY(scan_grow(&arrays, &s->array_cap, s->array_count, sizeof *s->arrays));
    s->arrays = arrays;
    s->arrays[s->array_count] = (struct api_scan_array){first, (int)(s->number_count - first)};
    PEND_TRY(scan_charge_node(s));
    PEND_TRY(scan_charge(s, COST_ARRAY));
    return scan_emit_whole(s, -(long long)++s->array_count);
}

/* scalars */

static const char *scan_digits(const char *p, const char *end) {
    while (p < end && api_digit((unsigned char)*p)) p++;
    return p;
}

/* the place of a fault becomes the present one */
static enum pend_status scan_expected_digit(struct api_scan *s, const char *p, const char *what) {
    s->at = (size_t)(p - s->text);
    return scan_expected(s, what);
}

/* checks a number's grammar and goes behind it */
static enum pend_status scan_number_grammar(struct api_scan *s) {
    const char *p = s->text + s->at, *end = s->text + s->bytes, *part;
    p += *p == '-';
    part = p;
    if ((p = scan_digits(p, end)) == part)
        return scan_expected_digit(s, p, "a digit behind the minus sign");
    if (*part == '0' && p > part + 1)
        return scan_fail(s, 400, (size_t)(part - s->text),
                         "a number may not begin with the digit 0");
    if (p < end && *p == '.') {
        part = ++p;
        if ((p = scan_digits(p, end)) == part)
            return scan_expected_digit(s, p, "a digit behind the decimal point");
    }
    if (p < end && (*p | 0x20) == 'e') {
        p++;
        p += p < end && (*p == '+' || *p == '-');
        part = p;
        if ((p = scan_digits(p, end)) == part)
            return scan_expected_digit(s, p, "a digit in the exponent");
    }
    s->at = (size_t)(p - s->text);
    return PEND_OK;
}

/* the single digits from here on, each with a comma behind it, as far as there is room in the
 * table */
static void scan_single_digits(struct api_scan *s) {
    const char *p = s->text + s->at, *end = s->text + s->bytes;
    double *to = s->numbers + s->number_count, *cap = s->numbers + s->number_cap;
    while (cap - to >= 4 && end - p >= 8 && api_digits_four(p, to)) to += 4, p += 8;
    s->number_count = (size_t)(to - s->numbers);
    s->at = (size_t)(p - s->text);
}

static enum pend_status scan_number(struct api_scan *s) {
    double x;
    const char *begin = s->text + s->at, *end = api_digits_whole(begin, s->text + s->bytes, &x);
    if (end) {
        s->at = (size_t)(end - s->text);
        return scan_push_number(s, x);
    }
    PEND_TRY(scan_number_grammar(s));
    end = s->text + s->at;
    x = api_number_read(begin, end);
    if (isfinite(x)) return scan_push_number(s, x);
    return scan_fail(s, 400, (size_t)(begin - s->text),
                     "the number %.*s is beyond the range of a double",
                     end - begin > FOUND_WORD ? FOUND_WORD : (int)(end - begin), begin);
}

/* the numbers from here on in an array of numbers, as far as they go */
static enum pend_status scan_numbers(struct api_scan *s) {
    int c;
    do {
        PEND_TRY(scan_number(s));
        scan_space(s);
        s->want = WANT_MORE;
        if (scan_peek(s) != ',') break;
        s->at++;
        s->want = WANT_VALUE;
        scan_single_digits(s);
        scan_space(s);
        c = scan_peek(s);
    } while (c == '-' || api_digit(c));
    return PEND_OK;
}

static enum pend_status scan_literal(struct api_scan *s) {
    static const char *const literals[] = {"true", "false", "null"};
    for (int i = 0; i < 3; i++) {
        size_t length = strlen(literals[i]);
        if (s->bytes - s->at < length || memcmp(s->text + s->at, literals[i], length)) continue;
        if (s->at + length < s->bytes && scan_word((unsigned char)s->text[s->at + length]))
            continue;
        PEND_TRY(scan_charge_node(s));
        s->at += length;
        return api_buffer_add(&s->rest, literals[i], length);
    }
    return scan_expected(s, "a value");
}

/* strings */

/* four hexadecimal digits behind \u; -1 where there are none */
static long scan_hex(const struct api_scan *s, size_t at) {
    if (at > s->bytes || s->bytes - at < 4) return -1;
    long value = 0;
    for (int i = 0; i < 4; i++) {
        int c = (unsigned char)s->text[at + (size_t)i];
        int lower = c | 0x20;
        if (!api_digit(c) && (lower < 'a' || lower > 'f')) return -1;
        value = 16 * value + (api_digit(c) ? c - '0' : lower - 'a' + 10);
    }
    return value;
}

static int scan_encode(long code, char out[4]) {
    if (code < 0x80) {
        out[0] = (char)code;
        return 1;
    }
    int tail = code < 0x800 ? 1 : code < 0x10000 ? 2 : 3;
    static const int lead[] = {0, 0xc0, 0xe0, 0xf0};
    out[0] = (char)(lead[tail] | (int)(code >> (6 * tail)));
    for (int i = 1; i <= tail; i++) out[i] = (char)(0x80 | (int)(code >> (6 * (tail - i)) & 0x3f));
    return tail + 1;
}

/* \uXXXX, or a pair of them for what lies beyond U+FFFF; s->at is at the backslash */
static enum pend_status scan_unicode(struct api_scan *s) {
    size_t begin = s->at;
    long code = scan_hex(s, begin + 2);
    if (code < 0)
        return scan_fail(s, 400, begin, "\\u must be followed by four hexadecimal digits");
    s->at += 6;
    if (!code) return scan_fail(s, 400, begin, "a string may not hold the character U+0000");
    if (code >= 0xdc00 && code <= 0xdfff)
        return scan_fail(s, 400, begin, "a low surrogate stands alone");
    if (code >= 0xd800 && code <= 0xdbff) {
        int escape = s->bytes - s->at >= 2 && s->text[s->at] == '\\' && s->text[s->at + 1] == 'u';
        long low = escape ? scan_hex(s, s->at + 2) : -1;
        if (low < 0xdc00 || low > 0xdfff)
            return scan_fail(s, 400, begin, "a high surrogate stands alone");
        code = 0x10000 + ((code - 0xd800) << 10) + (low - 0xdc00);
        s->at += 6;
    }
    char utf8[4];
    return api_text_escape(&s->rest, utf8, (size_t)scan_encode(code, utf8));
}

static enum pend_status scan_escape(struct api_scan *s) {
    static const char from[] = "\"\\/bfnrt", to[] = "\"\\/\b\f\n\r\t";
    int c = s->at + 1 < s->bytes ? (unsigned char)s->text[s->at + 1] : 0;
    if (c == 'u') return scan_unicode(s);
    const char *found = c ? strchr(from, c) : NULL;
    if (!found)
        return scan_fail(s, 400, s->at,
                         "a backslash in a string must be followed by one of \"\\/bfnrtu");
    s->at += 2;
    return api_text_escape(&s->rest, &to[found - from], 1);
}

/* the run of characters that may stand in a string as they are */
static enum pend_status scan_run(struct api_scan *s) {
    const char *begin = s->text + s->at, *end = s->text + s->bytes, *p = begin;
    while (p < end) {
        unsigned char c = (unsigned char)*p;
        if (c == '"' || c == '\\') break;
        if (c < 0x20)
            return scan_fail(s, 400, (size_t)(p - s->text),
                             "the control character 0x%02X in a string must be escaped", c);
        int length = c < 0x80 ? 1 : api_text_utf8(p, (size_t)(end - p));
        if (!length)
            return scan_fail(s, 400, (size_t)(p - s->text),
                             "the byte 0x%02X begins no UTF-8 character", c);
        p += length;
    }
    s->at = (size_t)(p - s->text);
    return api_buffer_add(&s->rest, begin, (size_t)(p - begin));
}

/* a string, in the one spelling that equal strings share */
static enum pend_status scan_string(struct api_scan *s) {
    size_t begin = s->at++, rest = s->rest.bytes;
    PEND_TRY(api_buffer_text(&s->rest, "\""));
    for (;;) {
        PEND_TRY(scan_run(s));
        int c = scan_peek(s);
        if (c < 0) return scan_fail(s, 400, begin, "the string that begins here does not end");
        if (c == '"') break;
        PEND_TRY(scan_escape(s));
    }
    s->at++;
    PEND_TRY(api_buffer_text(&s->rest, "\""));
    return scan_charge(s, COST_STRING + s->rest.bytes - rest);
}

/* arrays and objects */

static enum pend_status scan_open(struct api_scan *s, int object) {
    if (s->depth == s->depth_cap)
        return scan_fail(s, 422, s->at, "more than %d levels of nesting", s->depth_cap);
    s->frames[s->depth++] =
        (struct api_scan_frame){object, !object, object ? s->keys.count : s->number_count};
    s->at++;
    s->want = object ? WANT_KEY_OR_END : WANT_ITEM_OR_END;
    if (!object) return PEND_OK;
    PEND_TRY(scan_charge_node(s));
    return api_buffer_text(&s->rest, "{");
}

static enum pend_status scan_close(struct api_scan *s) {
    struct api_scan_frame *frame = &s->frames[--s->depth];
    s->at++;
    s->want = s->depth ? WANT_MORE : WANT_NOTHING;
    if (frame->object) s->keys.count = frame->first;
    if (frame->pure) return scan_emit_array(s, frame->first);
    return api_buffer_text(&s->rest, frame->object ? "}" : "]");
}

/* what follows a value inside an array or object: a comma or the end */
static enum pend_status scan_more(struct api_scan *s, int c) {
    const struct api_scan_frame *frame = &s->frames[s->depth - 1];
    if (c == (frame->object ? '}' : ']')) return scan_close(s);
    if (c != ',') return scan_expected(s, frame->object ? "\",\" or \"}\"" : "\",\" or \"]\"");
    s->at++;
    s->want = frame->object ? WANT_KEY : WANT_VALUE;
    return frame->pure ? PEND_OK : api_buffer_text(&s->rest, ",");
}

/* keeps a key as it is written in the rest, quotes included */
static enum pend_status scan_keep_key(struct api_scan *s, struct api_key key, size_t at) {
    const char *rest = s->rest.data;
    enum pend_status status =
        api_keys_add(&s->keys, s->frames[s->depth - 1].first, API_SCAN_MEMBERS, rest, key);
    if (status == PEND_LIMIT)
        return scan_fail(s, 422, at, "an object has more than %d members", API_SCAN_MEMBERS);
    if (status != PEND_INVALID) return status;
    int length = (int)api_text_cut(rest + key.at, key.bytes, 40);
    return scan_fail(s, 400, at, "the key %.*s is there twice", length, rest + key.at);
}

static enum pend_status scan_key(struct api_scan *s, int c) {
    size_t at = s->at, begin = s->rest.bytes;
    if (c != '"')
        return scan_expected(s, s->want == WANT_KEY ? "a key in double quotes"
                                                    : "a key in double quotes or \"}\"");
    PEND_TRY(scan_string(s));
    PEND_TRY(scan_keep_key(s, (struct api_key){begin, s->rest.bytes - begin}, at));
    scan_space(s);
    if (scan_peek(s) != ':') return scan_expected(s, "\":\"");
    s->at++;
    s->want = WANT_VALUE;
    return api_buffer_text(&s->rest, ":");
}

/* a number that is not in an array of numbers: its place in the table stands for it */
static enum pend_status scan_lone_number(struct api_scan *s) {
    PEND_TRY(scan_number(s));
    return scan_emit_number(s, s->number_count - 1);
}

static enum pend_status scan_value(struct api_scan *s, int c) {
    int number = c == '-' || api_digit(c);
    if (number && s->depth && s->frames[s->depth - 1].pure) return scan_numbers(s);
    PEND_TRY(scan_spoil(s));
    if (c == '{' || c == '[') return scan_open(s, c == '{');
    s->want = s->depth ? WANT_MORE : WANT_NOTHING;
    if (number) return scan_lone_number(s);
    if (c != '"') return scan_literal(s);
    PEND_TRY(scan_charge_node(s));
    return scan_string(s);
}

static enum pend_status scan_step(struct api_scan *s) {
    scan_space(s);
    int c = scan_peek(s);
    if (s->want == WANT_MORE) return scan_more(s, c);
    if (s->want == WANT_KEY_OR_END && c == '}') return scan_close(s);
    if (s->want == WANT_KEY_OR_END || s->want == WANT_KEY) return scan_key(s, c);
    if (s->want == WANT_ITEM_OR_END && c == ']') return scan_close(s);
    return scan_value(s, c);
}

static enum pend_status scan_document(struct api_scan *s) {
    if (s->bytes >= 3 && !memcmp(s->text, "\xef\xbb\xbf", 3))
        return scan_fail(s, 400, 0, "a byte order mark precedes the text");
    while (s->want != WANT_NOTHING) PEND_TRY(scan_step(s));
    scan_space(s);
    return s->at == s->bytes ? PEND_OK : scan_expected(s, "the end of the text");
}

enum pend_status api_scan_run(struct api_scan *scan, const char *text, size_t bytes, int depth_cap,
                              struct api_problem *problem) {
    *scan =
        (struct api_scan){.text = text, .bytes = bytes, .depth_cap = depth_cap, .problem = problem};
    api_buffer_init(&scan->rest, SIZE_MAX);
    scan->frames = calloc((size_t)depth_cap, sizeof *scan->frames);
    return scan->frames ? scan_document(scan) : PEND_NO_MEMORY;
}

void api_scan_clear(struct api_scan *scan) {
    free(scan->frames);
    api_keys_clear(&scan->keys);
    free(scan->numbers);
    free(scan->arrays);
    api_buffer_clear(&scan->rest);
    *scan = (struct api_scan){0};
}
