/* Fuzzes the JSON reader with random bytes and with mutations of documents that follow the grammar.
 * Leaves to others: the meaning of a request's fields (fuzz_call).
 * Invariant: a document is accepted exactly when the plain recursive checker below accepts it, and
 * then every value of it can be reached. */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/json/json_in.h"
#include "tests/fuzz/fuzz.h"
#ifndef FUZZER
#include "tests/harness/test.h"
#endif

enum { DEPTH = 16, ROOM = FUZZ_ROOM - 1 };

/* an independent checker of RFC 8259: recursive, slow and obvious */

struct checker {
    const unsigned char *at, *end;
};

static int check_value(struct checker *c, int depth);

static void check_space(struct checker *c) {
    while (c->at < c->end && strchr(" \t\r\n", *c->at) && *c->at) c->at++;
}

static int check_take(struct checker *c, int byte) {
    if (c->at == c->end || *c->at != byte) return 0;
    c->at++;
    return 1;
}

static int check_digits(struct checker *c) {
    const unsigned char *begin = c->at;
    while (c->at < c->end && *c->at >= '0' && *c->at <= '9') c->at++;
    return c->at > begin;
}

static int check_number(struct checker *c) {
    char text[400];
    const unsigned char *begin = c->at;
    check_take(c, '-');
    if (!check_take(c, '0') && !check_digits(c)) return 0;
    if (check_take(c, '.') && !check_digits(c)) return 0;
    if (check_take(c, 'e') || check_take(c, 'E')) {
        if (!check_take(c, '+')) check_take(c, '-');
        if (!check_digits(c)) return 0;
    }
    size_t bytes = (size_t)(c->at - begin);
    if (bytes >= sizeof text) return -1; /* too long to decide whether it is in range */
    memcpy(text, begin, bytes);
    text[bytes] = 0;
    return isfinite(strtod(text, NULL));
}

static long check_hex(struct checker *c) {
    char text[5] = "";
    if (c->end - c->at < 4) return -1;
    memcpy(text, c->at, 4);
    if (strspn(text, "0123456789abcdefABCDEF") != 4) return -1;
    c->at += 4;
    return strtol(text, NULL, 16);
}

/* one character of a string, or -1 */
static long check_character(struct checker *c) {
    static const long least[] = {0, 0, 0x80, 0x800, 0x10000};
    unsigned lead = *c->at++;
    if (lead < 0x20) return -1;
    if (lead == '\\') {
        if (c->at == c->end) return -1;
        const char *simple = "\"\"\\\\//b\bf\fn\nr\rt\t", *found = simple;
        int escape = *c->at++;
        while (*found && *found != escape) found += 2;
        if (*found) return found[1];
        if (escape != 'u') return -1;
        long high = check_hex(c), low;
        if (high < 0xd800 || high > 0xdfff) return high > 0 ? high : -1;
        if (high > 0xdbff || !check_take(c, '\\') || !check_take(c, 'u')) return -1;
        low = check_hex(c);
        return low >= 0xdc00 && low <= 0xdfff ? 0x10000 + (high - 0xd800) * 0x400 + low - 0xdc00
                                              : -1;
    }
    int length = lead < 0x80   ? 1
                 : lead < 0xc0 ? 0
                 : lead < 0xe0 ? 2
                 : lead < 0xf0 ? 3
                 : lead < 0xf8 ? 4
                               : 0;
    long code = length == 1 ? (long)lead : (long)(lead & (0xffu >> (length + 1)));
    if (!length || c->end - c->at < length - 1) return -1;
    for (int i = 1; i < length; i++) {
        if (*c->at >> 6 != 2) return -1;
        code = code << 6 | (*c->at++ & 0x3f);
    }
    return code >= least[length] && code <= 0x10ffff && (code < 0xd800 || code > 0xdfff) ? code
                                                                                         : -1;
}

/* returns the characters of a string, ended by -1; NULL if there is no string */
static long *check_string(struct checker *c) {
    if (!check_take(c, '"')) return NULL;
    long *text = malloc(((size_t)(c->end - c->at) + 1) * sizeof *text);
    size_t used = 0;
    if (!text) abort();
    while (c->at < c->end && *c->at != '"') {
        long character = check_character(c);
        if (character < 0) {
            free(text);
            return NULL;
        }
        text[used++] = character;
    }
    text[used] = -1;
    if (check_take(c, '"')) return text;
    free(text);
    return NULL;
}

static int same_string(const long *a, const long *b) {
    while (*a == *b && *a >= 0) a++, b++;
    return *a == *b;
}

/* 1 accepted, 0 refused, -1 undecided: too deep, or too many members */
static int check_object(struct checker *c, int depth) {
    enum { MEMBERS = 256 };
    long *keys[MEMBERS];
    int count = 0, verdict = 1;
    check_space(c);
    if (check_take(c, '}')) return 1;
    do {
        check_space(c);
        verdict = count == MEMBERS ? -1 : (keys[count] = check_string(c)) != NULL;
        if (verdict <= 0) break;
        count++;
        for (int i = 0; i < count - 1; i++)
            if (same_string(keys[i], keys[count - 1])) verdict = 0;
        check_space(c);
        if (verdict) verdict = check_take(c, ':');
        check_space(c);
        if (verdict) verdict = check_value(c, depth);
        check_space(c);
    } while (verdict > 0 && check_take(c, ','));
    if (verdict > 0) verdict = check_take(c, '}');
    while (count) free(keys[--count]);
    return verdict;
}

static int check_array(struct checker *c, int depth) {
    check_space(c);
    if (check_take(c, ']')) return 1;
    do {
        check_space(c);
        int verdict = check_value(c, depth);
        if (verdict <= 0) return verdict;
        check_space(c);
    } while (check_take(c, ','));
    return check_take(c, ']');
}

static int check_value(struct checker *c, int depth) {
    static const char *const literals[] = {"true", "false", "null"};
    if (c->at == c->end) return 0;
    if (strchr("{[", *c->at) && *c->at && !depth) return -1;
    if (check_take(c, '{')) return check_object(c, depth - 1);
    if (check_take(c, '[')) return check_array(c, depth - 1);
    if (*c->at == '"') {
        long *text = check_string(c);
        free(text);
        return text != NULL;
    }
    for (int i = 0; i < 3; i++) {
        size_t length = strlen(literals[i]);
        if ((size_t)(c->end - c->at) < length || memcmp(c->at, literals[i], length)) continue;
        c->at += length;
        return 1;
    }
    return check_number(c);
}

static int check_document(const unsigned char *text, size_t bytes) {
    struct checker c = {text, text + bytes};
    check_space(&c);
    int verdict = check_value(&c, DEPTH);
    check_space(&c);
    return verdict > 0 ? c.at == c.end : verdict;
}

/* the reader under test */

/* visits every value; the result depends on all of them */
static double visit(const struct api_value *value) {
    char pointer[API_POINTER_BYTES];
    int count = 0;
    double sum = api_value_number(value);
    const char *text = api_value_text(value);
    const double *numbers = api_value_numbers(value, &count);
    api_value_pointer(value, pointer);
    sum += (double)strlen(pointer) + (text ? (double)strlen(text) : 0);
    for (int i = 0; numbers && i < count; i++) sum += numbers[i];
    struct api_value item = api_value_item(value, 0);
    for (; api_value_kind(&item) != API_MISSING; item = api_value_next(&item)) sum += visit(&item);
    return sum;
}

/* reads a text; returns what is wrong, or NULL */
static const char *complaint(const char *text, size_t bytes) {
    static const char *const none[] = {NULL};
    const char *fault = NULL;
    OWN(api_json, free) *document = NULL;
    OWN(api_problem, clear) problem;
    api_problem_init(&problem);
    enum pend_status status = api_json_new(&document, text, bytes, DEPTH, &problem);
    int verdict = check_document((const unsigned char *)text, bytes),
        open = verdict < 0 || problem.status == 422;
    if (status == PEND_NO_MEMORY) fault = "out of memory";
    if ((status == PEND_OK) != (document != NULL))
        fault = "a document in spite of a failure, or none in spite of success";
    if (!open && verdict && status != PEND_OK) fault = "refused, but JSON";
    if (!open && !verdict && status == PEND_OK) fault = "accepted, but not JSON";
    if (document) {
        struct api_value root = api_json_root(document);
        if (isnan(visit(&root))) fault = "a number that is none";
        (void)api_value_only(&root, none, &problem);
    }
    return fault;
}

static int read_json(char *text, size_t bytes) {
    const char *fault = complaint(text, bytes);
    if (fault) fprintf(stderr, "%s: %.*s\n", fault, (int)bytes, text);
    return !fault;
}

/* documents to start from: small, but with all kinds of values */
static const char *const seeds[] = {
    ("{\"pendulum\":{\"arms\":[{\"name\":\"a\",\"length\":2.0,\"mass\":1.0},{\"name\":\"b\","
     "\"parent\":\"a\",\"length\":1.5,\"mass\":1e-1}],\"gravity\":9.81},"
     "\"times\":{\"start\":0,\"stop\":5,\"step\":0.01}}"),
    "{\"L\":[2,1.5],\"m\":[1,1],\"S\":[[1,0],[1,1]]}",
    (" [ 1 , null,\ttrue,\nfalse,\"\\u20ac \\ud83d\\ude00 "
     "\xe2\x82\xac\\n\",{},[],[[-0.5E+10]],1e308] "),
    "\"\xf0\x9f\x98\x80\xc3\xa9\\\\\\\"\\/\"",
    "[[[[[[[[[[[[[[[1]]]]]]]]]]]]]]]",
    "{\"a\":1,\"b\":{\"a\":1},\"\":[{\"a\":1},{\"a\":2}]}",
};

enum { SEEDS = sizeof seeds / sizeof *seeds };

static struct fuzz_reader json = {.name = "json", .read = read_json, .bare = 1};

__attribute__((constructor)) static void register_json(void) {
    for (int i = 0; i < SEEDS; i++) json.seed[i] = seeds[i];
    fuzz_register(&json, 1);
}

#ifndef FUZZER

/* texts that mutations insert */
static const char *const pieces[] = {
    "[", "]", "{", "}", ",",    ":",      "\"", "\\", "\\u",  "\\ud800",  "\\u0000",     "1e999",
    "-", "0", ".", "e", "null", "\"a\":", " ",  "\n", "\xff", "\xc0\x80", "\xed\xa0\x80"};

enum { PIECES = sizeof pieces / sizeof *pieces };

static size_t replace(char *text, size_t bytes, size_t at, size_t old, const char *piece,
                      size_t length) {
    if (bytes - old + length > ROOM) return bytes;
    memmove(text + at + length, text + at + old, bytes - at - old);
    memcpy(text + at, piece, length);
    return bytes - old + length;
}

static size_t mutate(char *text, size_t bytes, unsigned long long *state) {
    size_t at = bytes ? (size_t)test_random_int(state, (int)bytes) : 0, old = bytes - at;
    const char *other = seeds[test_random_int(state, SEEDS)],
               *piece = pieces[test_random_int(state, PIECES)];
    size_t length = 1 + (size_t)test_random_int(state, (int)strlen(other)),
           random = (size_t)test_random_int(state, 8);
    char byte = (char)test_random_int(state, 256);
    if (old > random) old = random;
    switch (test_random_int(state, 6)) {
    case 0:
        return replace(text, bytes, at, old ? 1 : 0, &byte, 1);
    case 1:
        return replace(text, bytes, at, old, "", 0);
    case 2:
        return replace(text, bytes, at, 0, piece, strlen(piece));
    case 3:
        return replace(text, bytes, at, old, piece, strlen(piece));
    case 4:
        return replace(text, bytes, at, 0, other, length);
    default:
        return bytes - (bytes > 40 ? random : 0);
    }
}

/* checks one text with the harness */
static int sound(const char *text, size_t bytes) {
    return CHECK_SAYING(fuzz_show(&json, text, bytes), "%.*s", (int)bytes, text);
}

/* FUZZ_RUNS (50000) mutations from FUZZ_SEED (1) */
TEST(fuzz_json_reader_and_checker_agree_on_mutations) {
    static char text[ROOM];
    const char *runs_text = getenv("FUZZ_RUNS"), *seed_text = getenv("FUZZ_SEED");
    long runs = runs_text ? atol(runs_text) : 50000, accepted = 0;
    unsigned long long state = seed_text ? strtoull(seed_text, NULL, 10) : 1;
    for (long i = 0; i < runs; i++) {
        const char *seed = seeds[test_random_int(&state, SEEDS)];
        size_t bytes = strlen(seed);
        memcpy(text, seed, bytes);
        for (int times = test_random_int(&state, 6); times >= 0; times--)
            bytes = mutate(text, bytes, &state);
        if (!sound(text, bytes)) return;
        accepted += check_document((const unsigned char *)text, bytes) == 1;
    }
    CHECK_SAYING(accepted > runs / 50 && accepted < runs / 2, "%ld of %ld accepted", accepted,
                 runs);
}

TEST(fuzz_json_reader_accepts_the_seeds) {
    for (int i = 0; i < SEEDS; i++) {
        CHECK_INT(check_document((const unsigned char *)seeds[i], strlen(seeds[i])), 1);
        sound(seeds[i], strlen(seeds[i]));
    }
}

#endif
