#include "api/json/json_scan.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>

#include "api/base/text.h"
#include "api/json/json_digits.h"
#include "api/json/json_escape.h"
#include "api/json/json_hint.h"
#include "api/json/json_keys.h"
#include "api/number/number.h"

enum { WANT_VALUE, WANT_ITEM_OR_END, WANT_KEY, WANT_KEY_OR_END, WANT_MORE, WANT_NOTHING };

/* upper bounds, in bytes, of the memory of a value, and of the memory per byte of text */
enum { COST_NODE = 80, COST_STRING = 32, COST_ARRAY = 16, COST_PER_BYTE = 20, COST_FREE = 1 << 16 };

static_assert(sizeof(cJSON) <= COST_NODE, "a node takes no more than the scan counts for it");

/* an array or object that is open */
struct scan_frame {
    cJSON *node; /* NULL while `pure` */
    cJSON *last; /* the last child of `node`, or NULL */
    int object;
    int pure;     /* whether an array has contained only numbers so far */
    size_t first; /* index of its first number (while pure) or key */
};

struct scan {
    const char *text;
    size_t bytes, at;
    int depth, depth_cap, want;
    struct scan_frame *frames; /* a frame for each of depth_cap levels */
    struct api_keys keys;
    char *key; /* key of the member that is being read, while it has no node */
    size_t number_count, number_cap;
    long nodes;              /* number of values so far, not counting those in arrays of numbers */
    size_t cost;             /* upper bound of the memory of the values so far, bytes */
    struct api_buffer plain; /* the text of the current string without its escapes, if it has any */
    struct api_json *document;
    struct api_problem *problem;
};

static int scan_peek(const struct scan *s) {
    return s->at < s->bytes ? (unsigned char)s->text[s->at] : -1;
}

static int scan_word(int c) {
    return api_digit(c) || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
}

static void scan_space(struct scan *s) {
    for (; s->at < s->bytes; s->at++) {
        char c = s->text[s->at];
        if (c != ' ' && c != '\n' && c != '\t' && c != '\r') return;
    }
}

/* ---- messages */

enum { FOUND_BYTES = 64, FOUND_WORD = 24, FOUND_KEY = 40 };

/* describes the text at a position: a word, a character, a byte or the end */
static void scan_found(const struct scan *s, size_t at, char found[FOUND_BYTES]) {
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
static void scan_place(const struct scan *s, size_t at, long *line, long *column) {
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
scan_fail(struct scan *s, int status, size_t at, const char *format, ...) {
    char what[200];
    long line, column;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(what, sizeof what, format, arguments);
    va_end(arguments);
    scan_place(s, at, &line, &column);
    if (status == 400)
        api_problem_set(s->problem, status,
                        API_TYPE_NOT_JSON
                        "the body is not JSON: %s at line %ld, column %ld (byte %zu)",
                        what, line, column, at);
    else
        api_problem_set(s->problem, status,
                        API_TYPE_LIMIT
                        "the body's JSON is refused: %s at line %ld, column %ld (byte %zu)",
                        what, line, column, at);
    return PEND_INVALID;
}

static enum pend_status scan_expected(struct scan *s, const char *what) {
    char found[FOUND_BYTES];
    scan_found(s, s->at, found);
    return scan_fail(s, 400, s->at, "expected %s but found %s%s", what, found,
                     api_json_hint(s->text, s->bytes, s->at));
}

/* ---- memory */

static enum pend_status scan_charge(struct scan *s, size_t cost) {
    s->cost += cost;
    if (s->cost <= COST_FREE + COST_PER_BYTE * s->bytes) return PEND_OK;
    return scan_fail(s, 422, s->at, "too many values for a text of this length");
}

static enum pend_status scan_push_number(struct scan *s, double x) {
    if (s->number_count == s->number_cap) {
        size_t cap = s->number_cap ? 2 * s->number_cap : 64;
        double *grown = realloc(s->document->numbers, cap * sizeof x);
        if (!grown) return PEND_NO_MEMORY;
        s->document->numbers = grown;
        s->number_cap = cap;
    }
    s->document->numbers[s->number_count++] = x;
    return PEND_OK;
}

/* ---- nodes */

/* adds a node of a cJSON type to the frame at a depth, or makes it the root at depth 0 */
static enum pend_status scan_add(struct scan *s, int depth, int type, cJSON **added) {
    if (++s->nodes > API_SCAN_VALUES)
        return scan_fail(s, 422, s->at,
                         "more than %d values, not counting those in arrays of numbers",
                         API_SCAN_VALUES);
    PEND_TRY(scan_charge(s, COST_NODE));
    cJSON *node = *added = api_arena_take(&s->document->nodes, sizeof *node);
    if (!node) return PEND_NO_MEMORY;
    *node = (cJSON){.type = type};
    if (!depth) {
        s->document->root = node;
        return PEND_OK;
    }
    struct scan_frame *frame = &s->frames[depth - 1];
    assert(frame->node && !frame->pure);
    if (frame->object) node->string = s->key;
    *(frame->last ? &frame->last->next : &frame->node->child) = node;
    frame->last = node;
    return PEND_OK;
}

static enum pend_status scan_add_number(struct scan *s, double x) {
    cJSON *node;
    PEND_TRY(scan_add(s, s->depth, cJSON_Number, &node));
    node->valuedouble = x;
    return PEND_OK;
}

/* creates nodes for the numbers of an array that contains something else as well */
static enum pend_status scan_spoil(struct scan *s) {
    if (!s->depth || !s->frames[s->depth - 1].pure) return PEND_OK;
    struct scan_frame *frame = &s->frames[s->depth - 1];
    PEND_TRY(scan_add(s, s->depth - 1, cJSON_Array, &frame->node));
    frame->pure = 0;
    for (size_t k = frame->first; k < s->number_count; k++)
        PEND_TRY(scan_add_number(s, s->document->numbers[k]));
    s->number_count = frame->first;
    return PEND_OK;
}

/* adds the array of numbers that has just closed */
static enum pend_status scan_add_array(struct scan *s, size_t first) {
    cJSON *node;
    PEND_TRY(scan_add(s, s->depth, cJSON_Array | API_SCAN_NUMBERS, &node));
    node->valueint = (int)(s->number_count - first);
    node->valuedouble = (double)first;
    return scan_charge(s, COST_ARRAY);
}

/* ---- scalars */

static const char *scan_digits(const char *p, const char *end) {
    while (p < end && api_digit((unsigned char)*p)) p++;
    return p;
}

static enum pend_status scan_expected_digit(struct scan *s, const char *p, const char *what) {
    s->at = (size_t)(p - s->text);
    return scan_expected(s, what);
}

static enum pend_status scan_number_grammar(struct scan *s) {
    const char *p = s->text + s->at, *end = s->text + s->bytes, *part;
    p += *p == '-';
    part = p;
    if ((p = scan_digits(p, end)) == part)
        return scan_expected_digit(s, p, "a digit after the minus sign");
    if (*part == '0' && p > part + 1)
        return scan_fail(s, 400, (size_t)(part - s->text),
                         "a number may not begin with the digit 0");
    if (p < end && *p == '.') {
        part = ++p;
        if ((p = scan_digits(p, end)) == part)
            return scan_expected_digit(s, p, "a digit after the decimal point");
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

/* reads single digits, each followed by a comma, as many as fit into the table */
static void scan_single_digits(struct scan *s) {
    const char *p = s->text + s->at, *end = s->text + s->bytes;
    double *numbers = s->document->numbers;
    double *to = numbers + s->number_count, *cap = numbers + s->number_cap;
    while (cap - to >= 4 && end - p >= 8 && api_digits_four(p, to)) to += 4, p += 8;
    s->number_count = (size_t)(to - numbers);
    s->at = (size_t)(p - s->text);
}

static enum pend_status scan_number(struct scan *s, double *x) {
    const char *begin = s->text + s->at, *end = api_digits_whole(begin, s->text + s->bytes, x);
    if (end) {
        s->at = (size_t)(end - s->text);
        return PEND_OK;
    }
    PEND_TRY(scan_number_grammar(s));
    end = s->text + s->at;
    *x = api_number_read(begin, end);
    if (isfinite(*x)) return PEND_OK;
    return scan_fail(s, 400, (size_t)(begin - s->text),
                     "the number %.*s is beyond the range of a double",
                     end - begin > FOUND_WORD ? FOUND_WORD : (int)(end - begin), begin);
}

/* reads the following numbers of an array of numbers */
static enum pend_status scan_numbers(struct scan *s) {
    int c;
    double x;
    do {
        PEND_TRY(scan_number(s, &x));
        PEND_TRY(scan_push_number(s, x));
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

static enum pend_status scan_literal(struct scan *s) {
    static const struct {
        const char *text;
        int type;
    } literals[] = {{"true", cJSON_True}, {"false", cJSON_False}, {"null", cJSON_NULL}};
    cJSON *node;
    for (int i = 0; i < 3; i++) {
        size_t length = strlen(literals[i].text);
        if (s->bytes - s->at < length || memcmp(s->text + s->at, literals[i].text, length))
            continue;
        if (s->at + length < s->bytes && scan_word((unsigned char)s->text[s->at + length]))
            continue;
        PEND_TRY(scan_add(s, s->depth, literals[i].type, &node));
        s->at += length;
        return PEND_OK;
    }
    return scan_expected(s, "a value");
}

/* ---- strings */

static enum pend_status scan_escape(struct scan *s) {
    char utf8[4];
    size_t taken, length;
    const char *fault = api_escape_read(s->text + s->at, s->bytes - s->at, &taken, utf8, &length);
    if (fault) return scan_fail(s, 400, s->at, "%s", fault);
    s->at += taken;
    return api_buffer_add(&s->plain, utf8, length);
}

/* checks and skips the characters of a string up to its end or next escape */
static enum pend_status scan_run(struct scan *s) {
    const char *p = s->text + s->at, *end = s->text + s->bytes;
    while (p < end) {
        unsigned char c = (unsigned char)*p;
        if (c == '"' || c == '\\') break;
        if (c < 0x20)
            return scan_fail(s, 400, (size_t)(p - s->text),
                             "the control character 0x%02X in a string must be escaped", c);
        int length = c < 0x80 ? 1 : api_text_utf8(p, (size_t)(end - p));
        if (!length)
            return scan_fail(s, 400, (size_t)(p - s->text),
                             "the byte 0x%02X does not begin a UTF-8 character", c);
        p += length;
    }
    s->at = (size_t)(p - s->text);
    return PEND_OK;
}

/* reads a string into the document's memory and terminates it with NUL */
static enum pend_status scan_string(struct scan *s, char **text, size_t *bytes) {
    size_t begin = s->at++, from = s->at;
    s->plain.bytes = 0;
    for (;;) {
        PEND_TRY(scan_run(s));
        int c = scan_peek(s);
        if (c < 0) return scan_fail(s, 400, begin, "the string that begins here does not end");
        if (c == '"') break;
        PEND_TRY(api_buffer_add(&s->plain, s->text + from, s->at - from));
        PEND_TRY(scan_escape(s));
        from = s->at;
    }
    size_t plain = s->plain.bytes, tail = s->at++ - from;
    *bytes = plain + tail;
    PEND_TRY(scan_charge(s, COST_STRING + *bytes));
    if (!(*text = api_arena_take(&s->document->nodes, *bytes + 1))) return PEND_NO_MEMORY;
    if (plain) memcpy(*text, s->plain.data, plain);
    memcpy(*text + plain, s->text + from, tail);
    (*text)[*bytes] = 0;
    return PEND_OK;
}

static enum pend_status scan_add_string(struct scan *s) {
    cJSON *node;
    size_t bytes;
    PEND_TRY(scan_add(s, s->depth, cJSON_String, &node));
    return scan_string(s, &node->valuestring, &bytes);
}

/* ---- arrays and objects */

static enum pend_status scan_open(struct scan *s, int object) {
    if (s->depth == s->depth_cap)
        return scan_fail(s, 422, s->at, "more than %d levels of nesting", s->depth_cap);
    struct scan_frame *frame = &s->frames[s->depth++];
    *frame = (struct scan_frame){
        .object = object, .pure = !object, .first = object ? s->keys.count : s->number_count};
    s->at++;
    s->want = object ? WANT_KEY_OR_END : WANT_ITEM_OR_END;
    return object ? scan_add(s, s->depth - 1, cJSON_Object, &frame->node) : PEND_OK;
}

static enum pend_status scan_close(struct scan *s) {
    struct scan_frame *frame = &s->frames[--s->depth];
    s->at++;
    s->want = s->depth ? WANT_MORE : WANT_NOTHING;
    if (frame->object) s->keys.count = frame->first;
    return frame->pure ? scan_add_array(s, frame->first) : PEND_OK;
}

/* reads the comma or the end after a value inside an array or object */
static enum pend_status scan_more(struct scan *s, int c) {
    const struct scan_frame *frame = &s->frames[s->depth - 1];
    if (c == (frame->object ? '}' : ']')) return scan_close(s);
    if (c != ',') return scan_expected(s, frame->object ? "\",\" or \"}\"" : "\",\" or \"]\"");
    s->at++;
    s->want = frame->object ? WANT_KEY : WANT_VALUE;
    return PEND_OK;
}

static enum pend_status scan_fail_twice(struct scan *s, struct api_key key, size_t at) {
    s->plain.bytes = 0;
    PEND_TRY(api_text_quote(&s->plain, key.text, key.bytes));
    int length = (int)api_text_cut(s->plain.data, s->plain.bytes, FOUND_KEY);
    return scan_fail(s, 400, at, "the key %.*s occurs twice", length, s->plain.data);
}

static enum pend_status scan_key(struct scan *s, int c) {
    size_t at = s->at;
    struct api_key key;
    if (c != '"')
        return scan_expected(s, s->want == WANT_KEY ? "a key in double quotes"
                                                    : "a key in double quotes or \"}\"");
    PEND_TRY(scan_string(s, &s->key, &key.bytes));
    key.text = s->key;
    enum pend_status status =
        api_keys_add(&s->keys, s->frames[s->depth - 1].first, API_SCAN_MEMBERS, key);
    if (status == PEND_LIMIT)
        return scan_fail(s, 422, at, "an object has more than %d members", API_SCAN_MEMBERS);
    if (status == PEND_INVALID) return scan_fail_twice(s, key, at);
    PEND_TRY(status);
    scan_space(s);
    if (scan_peek(s) != ':') return scan_expected(s, "\":\"");
    s->at++;
    s->want = WANT_VALUE;
    return PEND_OK;
}

static enum pend_status scan_value(struct scan *s, int c) {
    int number = c == '-' || api_digit(c);
    if (number && s->depth && s->frames[s->depth - 1].pure) return scan_numbers(s);
    PEND_TRY(scan_spoil(s));
    if (c == '{' || c == '[') return scan_open(s, c == '{');
    s->want = s->depth ? WANT_MORE : WANT_NOTHING;
    if (number) {
        double x;
        PEND_TRY(scan_number(s, &x));
        return scan_add_number(s, x);
    }
    return c == '"' ? scan_add_string(s) : scan_literal(s);
}

static enum pend_status scan_step(struct scan *s) {
    scan_space(s);
    int c = scan_peek(s);
    if (s->want == WANT_MORE) return scan_more(s, c);
    if (s->want == WANT_KEY_OR_END && c == '}') return scan_close(s);
    if (s->want == WANT_KEY_OR_END || s->want == WANT_KEY) return scan_key(s, c);
    if (s->want == WANT_ITEM_OR_END && c == ']') return scan_close(s);
    return scan_value(s, c);
}

static enum pend_status scan_document(struct scan *s) {
    if (s->bytes >= 3 && !memcmp(s->text, "\xef\xbb\xbf", 3))
        return scan_fail(s, 400, 0, "a byte order mark precedes the text: leave it out");
    while (s->want != WANT_NOTHING) {
        PEND_TRY(scan_step(s));
        assert(s->at <= s->bytes && s->depth <= s->depth_cap);
        assert((s->want == WANT_NOTHING) == (s->document->root && !s->depth));
    }
    scan_space(s);
    return s->at == s->bytes ? PEND_OK : scan_expected(s, "the end of the text");
}

enum pend_status api_scan_run(struct api_json *document, const char *text, size_t bytes,
                              int depth_cap, struct api_problem *problem) {
    assert(depth_cap > 0);
    *document = (struct api_json){0};
    struct scan scan = {.text = text,
                        .bytes = bytes,
                        .depth_cap = depth_cap,
                        .document = document,
                        .problem = problem};
    api_buffer_init(&scan.plain, SIZE_MAX);
    scan.frames = calloc((size_t)depth_cap, sizeof *scan.frames);
    enum pend_status status = scan.frames ? scan_document(&scan) : PEND_NO_MEMORY;
    /* release the unused memory of the table; if that fails, it keeps its size */
    double *numbers =
        scan.number_count ? realloc(document->numbers, scan.number_count * sizeof *numbers) : NULL;
    if (numbers) document->numbers = numbers;
    free(scan.frames);
    api_keys_clear(&scan.keys);
    api_buffer_clear(&scan.plain);
    return status;
}

void api_scan_clear(struct api_json *document) {
    api_arena_clear(&document->nodes);
    free(document->numbers);
    *document = (struct api_json){0};
}
