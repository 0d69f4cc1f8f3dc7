#include "api/json/json_in.h"

#include <float.h>
#include <malloc.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include "tests/harness/test.h"

enum { DEPTH = 16 };

/* parses a text; NULL if it is refused, with the reason in `detail` */
static char detail[API_DETAIL_BYTES];

static struct api_json *parse_bytes(const char *text, size_t bytes, int depth, int *status) {
    struct api_json *document = NULL;
    OWN(api_problem, clear) problem;
    api_problem_init(&problem);
    enum pend_status code = api_json_new(&document, text, bytes, depth, &problem);
    CHECK((code == PEND_OK) == (document != NULL));
    CHECK((code == PEND_INVALID) == (problem.status != 0));
    snprintf(detail, sizeof detail, "%s", problem.detail);
    *status = problem.status;
    return document;
}

static struct api_json *parse(const char *text) {
    int status;
    struct api_json *document = parse_bytes(text, strlen(text), DEPTH, &status);
    CHECK_SAYING(document != NULL, "%s: %s", text, detail);
    return document;
}

static void accepts(const char *text) { OWN(api_json, free) *document = parse(text); }

static void refuses_bytes(const char *text, size_t bytes, int want, const char *says) {
    int status;
    OWN(api_json, free) *document = parse_bytes(text, bytes, DEPTH, &status);
    CHECK_SAYING(!document && status == want, "%.60s: status %d, expected %d", text, status, want);
    CHECK_SAYING(strstr(detail, says) != NULL, "%.60s: \"%s\" does not say \"%s\"", text, detail,
                 says);
}

static void refuses(const char *text, const char *says) {
    refuses_bytes(text, strlen(text), 400, says);
}

/* grammar */

TEST(json_of_every_kind_is_accepted) {
    char texts[] =
        "0~-0~1~-1~10~0.5~-0.5e-7~1E5~1e+5~123456789012345678901234567890~1e-999~null~true~"
        "false~\"\"~\"a\"~[]~{}~ [ ] ~\t{\r\n}\n~[1,2,3]~[[],[],[[]]]~{\"\":\"\"}~{\"a\":{\"a\":{"
        "}},\"b\":[{\"a\":1},{\"a\":1}]}~[1,null,\"x\",{},[],true]~"
        "\"\\\"\\\\\\/\\b\\f\\n\\r\\t\"~\"\\u00e9\\u20AC\\ud83d\\uDE00\"~"
        "\"\xc3\xa9\xe2\x82\xac\xf0\x9f\x98\x80\"~\"\x7f\"~[0,-0,0.0]~"
        "\"\xef\xbf\xbf\xf4\x8f\xbf\xbf\"~[[[[[[[[[[[[[[[[]]]]]]]]]]]]]]]]";
    char *rest = texts;
    for (char *text; (text = strsep(&rest, "~"));) accepts(text);
}

TEST(json_that_is_none_is_refused_with_what_was_expected_and_found) {
    refuses("", "expected a value but found the end of the text");
    refuses(" ", "expected a value but found the end of the text");
    refuses("[1,2,]", "expected a value but found \"]\"");
    refuses("[,1]", "expected a value but found \",\"");
    refuses("[1 2]", "expected \",\" or \"]\" but found \"2\"");
    refuses("[1", "expected \",\" or \"]\" but found the end of the text");
    refuses("[", "expected a value but found the end of the text");
    refuses("[1}", "expected \",\" or \"]\" but found \"}\"");
    refuses("{\"a\":1]", "expected \",\" or \"}\" but found \"]\"");
    refuses("{\"a\":1,}", "expected a key in double quotes but found \"}\"");
    refuses("{a:1}", "expected a key in double quotes or \"}\" but found \"a\"");
    refuses("{'a':1}", "expected a key in double quotes or \"}\" but found \"'\"");
    refuses("{1:1}", "expected a key in double quotes or \"}\" but found \"1\"");
    refuses("{\"a\" 1}", "expected \":\" but found \"1\"");
    refuses("{\"a\":}", "expected a value but found \"}\"");
    refuses("{\"a\"", "expected \":\" but found the end of the text");
    refuses("nul", "expected a value but found \"nul\"");
    refuses("nulll", "expected a value but found \"nulll\"");
    refuses("True", "expected a value but found \"True\"");
    refuses("undefined", "expected a value but found \"undefined\"");
    refuses("NaN", "expected a value but found \"NaN\"");
    refuses("[Infinity]", "expected a value but found \"Infinity\"");
    refuses("-Infinity", "expected a digit after the minus sign but found \"Infinity\"");
    refuses("-", "expected a digit after the minus sign but found the end of the text");
    refuses("+1", "expected a value but found \"+\"");
    refuses(".5", "expected a value but found \".\"");
    refuses("1.", "expected a digit after the decimal point but found the end of the text");
    refuses("1.e5", "expected a digit after the decimal point but found \"e5\"");
    refuses("1e", "expected a digit in the exponent but found the end of the text");
    refuses("1e+", "expected a digit in the exponent but found the end of the text");
    refuses("01", "a number may not begin with the digit 0");
    refuses("-00", "a number may not begin with the digit 0");
    refuses("0x10", "expected the end of the text but found \"x10\"");
    refuses("1_000", "expected the end of the text but found \"_000\"");
    refuses("1 1", "expected the end of the text but found \"1\"");
    refuses("{} {}", "expected the end of the text but found \"{\"");
    refuses("[] // so", "expected the end of the text but found \"/\"");
    refuses("/* so */ []", "expected a value but found \"/\"");
    refuses("[1]\v", "expected the end of the text but found the byte 0x0B");
    refuses("\f[1]", "expected a value but found the byte 0x0C");
    refuses("\xc2\xa0[1]", "expected a value but found \"\xc2\xa0\"");
    refuses("\xef\xbb\xbf[1]", "a byte order mark precedes the text");
    refuses("\xff", "expected a value but found the byte 0xFF");
    refuses("\"abc", "the string that begins here does not end");
    refuses("[\"abc\\\"]", "the string that begins here does not end");
    refuses("\"\n\"", "the control character 0x0A in a string must be escaped");
    refuses("\"\\x\"", "a backslash in a string must be followed by one of");
    refuses("\"\\", "a backslash in a string must be followed by one of");
    refuses("\"\\u12g4\"", "four hexadecimal digits");
    refuses("\"\\u12", "four hexadecimal digits");
    refuses("\"\\ud800\"", "a high surrogate is unpaired");
    refuses("\"\\ud800\\n\"", "a high surrogate is unpaired");
    refuses("\"\\ud800\\ud800\"", "a high surrogate is unpaired");
    refuses("\"\\udc00\"", "a low surrogate is unpaired");
    refuses("\"\\u0000\"", "must not contain the character U+0000");
    refuses("{\"\\u0000\":1}", "must not contain the character U+0000");
    refuses("\"\xc0\x80\"", "the byte 0xC0 does not begin a UTF-8 character");
    refuses("\"\xed\xa0\x80\"", "the byte 0xED does not begin a UTF-8 character");
    refuses("\"\xe2\x82\"", "the byte 0xE2 does not begin a UTF-8 character");
    refuses("\"\x80\"", "the byte 0x80 does not begin a UTF-8 character");
    refuses("[1e999]", "the number 1e999 is beyond the range of a double");
    refuses("-1e400", "the number -1e400 is beyond the range of a double");
    refuses("{\"a\":1,\"b\":2,\"a\":3}", "the key \"a\" occurs twice");
    refuses("{\"a\":1,\"\\u0061\":3}", "the key \"a\" occurs twice");
    refuses("{\"\\n\":1,\"\\u000a\":3}", "the key \"\\n\" occurs twice");
    refuses("{\"\xc3\xa9\":1,\"\\u00E9\":3}", "occurs twice");
}

TEST(json_with_a_nul_is_refused) {
    refuses_bytes("[1]\0", 4, 400, "expected the end of the text but found the byte 0x00");
    refuses_bytes("\"a\0b\"", 5, 400, "the control character 0x00 in a string must be escaped");
    refuses_bytes("\0", 1, 400, "expected a value but found the byte 0x00");
    refuses_bytes("[1,\0 2]", 7, 400, "expected a value but found the byte 0x00");
}

TEST(json_messages_say_line_column_and_byte) {
    refuses("[1,\n 2,\n  x]", "found \"x\" at line 3, column 3 (byte 10)");
    refuses("x", "at line 1, column 1 (byte 0)");
    refuses("[\"\xc3\xa9\xf0\x9f\x98\x80\" x]", "found \"x\" at line 1, column 7 (byte 10)");
    refuses("{\"a\":1,\r\n \"a\":2}", "at line 2, column 2 (byte 10)");
}

TEST(json_that_is_too_deep_is_a_422) {
    char text[2000] = "";
    int status;
    memset(text, '[', 1000);
    refuses_bytes(text, 1000, 422, "more than 16 levels of nesting at line 1, column 17 (byte 16)");
    for (int i = 0; i < 100; i++) memcpy(text + 5 * i, "{\"a\":", 5);
    refuses_bytes(text, 500, 422, "more than 16 levels of nesting");
    OWN(api_json, free) *document = parse_bytes("[[1]]", 5, 1, &status);
    CHECK(!document && status == 422);
    document = parse_bytes("[1]", 3, 1, &status);
    CHECK(document && !status);
}

/* keys of an object with a hundred thousand members would have to be compared with each other */
TEST(json_objects_of_very_many_members_are_a_422) {
    OWN_MEMORY char *text = malloc(2000000);
    size_t used = 1;
    REQUIRE(text);
    text[0] = '{';
    for (int i = 0; i < 100000; i++) used += (size_t)sprintf(text + used, "\"%d\":%d,", i, i);
    text[used - 1] = '}';
    refuses_bytes(text, used, 422, "an object has more than 256 members");
    text[used = strcspn(text, "}")] = 0;
    used = (size_t)(strstr(text, ",\"257\"") - text);
    text[used++] = '}';
    refuses_bytes(text, used, 422, "an object has more than 256 members");
    used = 1;
    for (int i = 0; i < 256; i++) used += (size_t)sprintf(text + used, "\"%d\":[%d],", i, i);
    text[used - 1] = '}';
    text[used] = 0;
    OWN(api_json, free) *document = parse(text);
    struct api_value root = api_json_root(document), last = api_value_member(&root, "255");
    CHECK_INT(api_value_count(&root), 256);
    CHECK_INT(api_value_count(&last), 1);
}

TEST(json_of_very_many_tiny_values_is_a_422) {
    enum { ITEMS = 200000 };
    static const char *const items[] = {"[],", "{},", "\"\","};
    OWN_MEMORY char *text = malloc(4 * ITEMS);
    REQUIRE(text);
    for (int kind = 0; kind < 3; kind++) {
        size_t used = 1;
        text[0] = '[';
        for (int i = 0; i < ITEMS; i++) used += (size_t)sprintf(text + used, "%s", items[kind]);
        text[used - 1] = ']';
        refuses_bytes(text, used, 422, "too many values for");
    }
    size_t used = 1;
    for (int i = 0; i < ITEMS; i++) used += (size_t)sprintf(text + used, "0,");
    memcpy(text + used, "null]", 6);
    refuses_bytes(text, used + 5, 422, "too many values for");
}

/* values */

TEST(json_values_are_found) {
    struct api_json *document =
        parse("{\"n\":null,\"t\":true,\"f\":false,\"x\":-1.5e3,\"s\":\"a\\u00e9\",\"o\":{\"k\":7},"
              "\"e\":[],\"a\":[1,2.5,-3],\"m\":[1,\"b\",[4],null],\"A\":0}");
    struct api_value root = api_json_root(document), value;
    static const struct {
        const char *key;
        enum api_kind kind;
        double number;
        int count;
    } table[] = {{"n", API_NULL, 0, 0},       {"t", API_BOOL, 1, 0},   {"f", API_BOOL, 0, 0},
                 {"x", API_NUMBER, -1500, 0}, {"s", API_STRING, 0, 0}, {"o", API_OBJECT, 0, 1},
                 {"e", API_ARRAY, 0, 0},      {"a", API_ARRAY, 0, 3},  {"m", API_ARRAY, 0, 4},
                 {"A", API_NUMBER, 0, 0},     {"N", API_MISSING, 0, 0}};
    for (size_t i = 0; i < sizeof table / sizeof *table; i++) {
        value = api_value_member(&root, table[i].key);
        CHECK_SAYING(api_value_kind(&value) == table[i].kind, "%s is %d", table[i].key,
                     api_value_kind(&value));
        CHECK_SAYING(api_value_number(&value) == table[i].number, "%s is %g", table[i].key,
                     api_value_number(&value));
        CHECK_INT(api_value_count(&value), table[i].count);
        CHECK((api_value_text(&value) != NULL) == (table[i].kind == API_STRING));
    }
    value = api_value_member(&root, "s");
    CHECK_TEXT(api_value_text(&value), "a\xc3\xa9");
    CHECK_INT(api_value_count(&root), 10);
    api_json_free(&document);
    CHECK(!document);
}

TEST(json_arrays_of_numbers_are_doubles) {
    OWN(api_json, free) *document =
        parse("{\"a\":[1,2.5,-3],\"b\":[[1,0],[],[7]],\"e\":[],\"m\":[1,2,null],\"x\":4}");
    struct api_value root = api_json_root(document), a = api_value_member(&root, "a"),
                     b = api_value_member(&root, "b");
    struct api_value e = api_value_member(&root, "e"), m = api_value_member(&root, "m"),
                     x = api_value_member(&root, "x");
    int count = -1;
    const double *numbers = api_value_numbers(&a, &count);
    REQUIRE(numbers);
    CHECK_INT(count, 3);
    CHECK(numbers[0] == 1 && numbers[1] == 2.5 && numbers[2] == -3);
    CHECK(api_value_numbers(&e, &count) != NULL);
    CHECK_INT(count, 0);
    CHECK(!api_value_numbers(&b, &count) && !api_value_numbers(&m, &count) &&
          !api_value_numbers(&x, &count));
    CHECK(!api_value_numbers(&root, &count));
    struct api_value row = api_value_item(&b, 2);
    numbers = api_value_numbers(&row, &count);
    CHECK(numbers && count == 1 && numbers[0] == 7);
    struct api_value item = api_value_item(&a, 1), beyond = api_value_item(&a, 3);
    CHECK_INT(api_value_kind(&item), API_NUMBER);
    CHECK(api_value_number(&item) == 2.5);
    CHECK(!api_value_numbers(&item, &count));
    CHECK_INT(api_value_kind(&beyond), API_MISSING);
}

/* "0:1 1:null ..." of an array's items by iteration and by index */
TEST(json_items_are_walked) {
    static const char *const texts[] = {"[]", "[5]", "[1,2,3,4]", "[null,2,[3],\"x\",5]",
                                        "[[],[[]],{}]"};
    static const int counts[] = {0, 1, 4, 5, 3};
    for (int i = 0; i < 5; i++) {
        OWN(api_json, free) *document = parse(texts[i]);
        struct api_value root = api_json_root(document), item = api_value_item(&root, 0);
        int seen = 0;
        for (; api_value_kind(&item) != API_MISSING; item = api_value_next(&item), seen++) {
            struct api_value same = api_value_item(&root, seen);
            CHECK(same.node == item.node && item.index == seen);
            CHECK_INT(api_value_kind(&same), api_value_kind(&item));
        }
        CHECK_INT(seen, counts[i]);
        CHECK_INT(api_value_count(&root), counts[i]);
        item = api_value_next(&item);
        CHECK_INT(api_value_kind(&item), API_MISSING);
    }
}

TEST(json_root_may_be_any_value) {
    OWN(api_json, free) *document = parse(" [1,2] ");
    struct api_value root = api_json_root(document);
    int count;
    CHECK(api_value_numbers(&root, &count) && count == 2);
    api_json_free(&document);
    document = parse("-7");
    root = api_json_root(document);
    CHECK(api_value_number(&root) == -7);
}

TEST(json_text_is_not_needed_afterwards) {
    char *text = strdup("{\"key\":\"value\",\"list\":[1,2]}");
    OWN(api_json, free) *document = parse(text);
    memset(text, 'x', strlen(text));
    free(text);
    struct api_value root = api_json_root(document), key = api_value_member(&root, "key");
    CHECK_TEXT(api_value_text(&key), "value");
}

/* a random document, whose text is generated together with the expected values */

struct maker {
    unsigned long long seed;
    char text[1 << 16];
    size_t used;
};

static void put(struct maker *maker, const char *text) {
    static const char *const space[] = {"", "", "", " ", "\n", "\t \r\n"};
    maker->used += (size_t)sprintf(maker->text + maker->used, "%s%s", text,
                                   space[test_random_int(&maker->seed, 6)]);
}

static double make_number(struct maker *maker) {
    char text[40];
    double x = (test_random(&maker->seed) - 0.5) * pow(10, test_random_int(&maker->seed, 40) - 20);
    if (test_random_int(&maker->seed, 2)) x = test_random_int(&maker->seed, 100);
    snprintf(text, sizeof text, "%.17g", x);
    put(maker, text);
    return x;
}

/* generates a value (read == NULL) or checks one that was generated from the same seed; returns the
 * number of errors */
static int make(struct maker *maker, const struct api_value *read, int depth) {
    int kind = test_random_int(&maker->seed, depth ? 7 : 4), faults = 0,
        count = test_random_int(&maker->seed, 6);
    char key[40];
    if (kind < 2) {
        double x = make_number(maker);
        return read && (api_value_kind(read) != API_NUMBER || api_value_number(read) != x);
    }
    if (kind == 2) {
        snprintf(key, sizeof key, "\"t\\u00e9xt \\n%d\"", count);
        put(maker, key);
        snprintf(key, sizeof key, "t\xc3\xa9xt \n%d", count);
        return read && (!api_value_text(read) || strcmp(api_value_text(read), key));
    }
    if (kind == 3) {
        put(maker, count > 3 ? "true" : "null");
        return read && api_value_kind(read) != (count > 3 ? API_BOOL : API_NULL);
    }
    int object = kind == 4, numbers = kind == 5;
    put(maker, object ? "{" : "[");
    if (read)
        faults += api_value_count(read) != count ||
                  api_value_kind(read) != (object ? API_OBJECT : API_ARRAY);
    for (int i = 0; i < count; i++) {
        snprintf(key, sizeof key, "%s\"k%d\":", i ? "," : "", i);
        put(maker, object ? key : i ? "," : "");
        snprintf(key, sizeof key, "k%d", i);
        struct api_value child = {0};
        if (read) child = object ? api_value_member(read, key) : api_value_item(read, i);
        if (numbers) {
            double x = make_number(maker);
            faults += read && api_value_number(&child) != x;
        } else
            faults += make(maker, read ? &child : NULL, depth - 1);
    }
    put(maker, object ? "}" : "]");
    return faults;
}

TEST(json_of_random_documents_is_read_as_it_was_written) {
    static struct maker maker, again;
    int faults = 0;
    size_t longest = 0;
    for (unsigned long long seed = 1; seed <= 3000; seed++) {
        maker.seed = again.seed = seed * 1000;
        maker.used = again.used = 0;
        make(&maker, NULL, 5);
        if (maker.used > longest) longest = maker.used;
        OWN(api_json, free) *document = parse(maker.text);
        REQUIRE(document);
        struct api_value root = api_json_root(document);
        faults += make(&again, &root, 5);
    }
    CHECK_INT(faults, 0);
    CHECK(longest > 1000);
}

/* damage */

static const char sample[] =
    "{\"pendulum\":{\"arms\":[{\"name\":\"tr\\u00fcnk\",\"length\":1.5,\"mass\":1e-1},{\"name\":"
    "\"\xe2\x82\xac\\\"\",\"parent\":null,\"length\":-0.5E+2}],\"gravity\":9.81},\n \"times\" : [ "
    "0, 0.5,1 ],\"S\":[[1,0],[1,1],[]],\"states\":[{\"phi\":[0]},{}],\"x\":[true,false,1,"
    "\"\\ud83d\\ude00\",[]]}";

/* the text at the end of a page after which nothing can be read */
struct guarded {
    char *page;
    size_t bytes;
};

static struct guarded guarded_new(void) {
    size_t bytes = (size_t)sysconf(_SC_PAGESIZE);
    char *page = mmap(NULL, 2 * bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (page == MAP_FAILED || mprotect(page + bytes, bytes, PROT_NONE)) return (struct guarded){0};
    return (struct guarded){page, bytes};
}

static char *guarded_text(const struct guarded *guarded, const char *text, size_t bytes) {
    return memcpy(guarded->page + guarded->bytes - bytes, text, bytes);
}

TEST(json_cut_anywhere_is_refused_without_reading_on) {
    struct guarded guarded = guarded_new();
    int status, accepted = 0;
    REQUIRE(guarded.page && sizeof sample < guarded.bytes);
    for (size_t bytes = 0; bytes < sizeof sample - 1; bytes++) {
        OWN(api_json, free) *document =
            parse_bytes(guarded_text(&guarded, sample, bytes), bytes, DEPTH, &status);
        accepted += document != NULL || status != 400;
    }
    CHECK_INT(accepted, 0);
    struct api_json *document = parse_bytes(guarded_text(&guarded, sample, sizeof sample - 1),
                                            sizeof sample - 1, DEPTH, &status);
    CHECK(document != NULL);
    api_json_free(&document);
    munmap(guarded.page, 2 * guarded.bytes);
}

TEST(json_with_any_byte_changed_gets_a_verdict) {
    struct guarded guarded = guarded_new();
    int status, accepted = 0, refused = 0;
    REQUIRE(guarded.page && sizeof sample < guarded.bytes);
    char *text = guarded_text(&guarded, sample, sizeof sample - 1);
    for (size_t i = 0; i < sizeof sample - 1; i++)
        for (int byte = 0; byte < 256; byte++) {
            char kept = text[i];
            text[i] = (char)byte;
            struct api_json *document = parse_bytes(text, sizeof sample - 1, DEPTH, &status);
            accepted += document != NULL;
            refused += status == 400 || status == 422;
            api_json_free(&document);
            text[i] = kept;
        }
    CHECK_INT(accepted + refused, 256 * ((int)sizeof sample - 1));
    CHECK(accepted > 5000 && refused > 50000);
    munmap(guarded.page, 2 * guarded.bytes);
}

/* memory */

TEST(json_without_memory_fails_cleanly_whichever_allocation_fails) {
    for (int for_good = 0; for_good < 2; for_good++) {
        long count = 0, made;
        int faults = 0, failures = 0;
        do {
            OWN(api_json, free) *document = NULL;
            OWN(api_problem, clear) problem;
            api_problem_init(&problem);
            long before = test_alloc_count();
            test_alloc_fail(++count, for_good);
            enum pend_status code =
                api_json_new(&document, sample, sizeof sample - 1, DEPTH, &problem);
            test_alloc_faults_off();
            made = test_alloc_count() - before;
            faults += problem.status || (code == PEND_OK) != (document != NULL);
            failures += code == PEND_NO_MEMORY;
        } while (made >= count);
        CHECK_INT(faults, 0);
        CHECK_SAYING(failures > 5 && failures < count, "%d failures of %ld", failures, count);
    }
}

#ifndef __SANITIZE_ADDRESS__
static size_t heap_bytes(void) {
    struct mallinfo2 info = mallinfo2();
    return info.uordblks + info.hblkhd;
}

TEST(json_of_a_mebibyte_of_numbers_takes_little_more_than_the_doubles) {
    enum { BYTES = 1 << 20, COUNT = (BYTES - 1) / 2 };
    OWN_MEMORY char *text = malloc(BYTES);
    int status, count = 0;
    REQUIRE(text);
    for (int i = 0; i < COUNT; i++) memcpy(text + 2 * i + 1, "0,", 2);
    text[0] = '[';
    text[2 * COUNT] = ']';
    size_t before = heap_bytes();
    OWN(api_json, free) *document = parse_bytes(text, 2 * COUNT + 1, DEPTH, &status);
    size_t taken = heap_bytes() - before;
    REQUIRE(document);
    struct api_value root = api_json_root(document);
    CHECK(api_value_numbers(&root, &count) != NULL);
    CHECK_INT(count, COUNT);
    CHECK_SAYING(taken < COUNT * sizeof(double) * 1.01, "%zu bytes for %d doubles", taken, COUNT);
}
#endif

/* pointers and faults */

static void points(const struct api_value *value, const char *want) {
    char pointer[API_POINTER_BYTES];
    api_value_pointer(value, pointer);
    CHECK_TEXT(pointer, want);
}

TEST(json_pointers_lead_to_the_value) {
    OWN(api_json, free) *document = parse("{\"a\":{\"b\":[1,[2,3],{\"c/d~e\":4}]}}");
    struct api_value root = api_json_root(document), a = api_value_member(&root, "a"),
                     b = api_value_member(&a, "b");
    struct api_value row = api_value_item(&b, 1), number = api_value_item(&row, 1),
                     object = api_value_next(&row);
    struct api_value odd = api_value_member(&object, "c/d~e"),
                     none = api_value_member(&odd, "none");
    struct api_value deeper = api_value_item(&none, 3);
    points(&root, "");
    points(&b, "/a/b");
    points(&number, "/a/b/1/1");
    points(&odd, "/a/b/2/c~1d~0e");
    points(&none, "/a/b/2/c~1d~0e/none");
    points(&deeper, "/a/b/2/c~1d~0e/none/3");
    CHECK(api_value_number(&odd) == 4);
    CHECK_INT(api_value_kind(&deeper), API_MISSING);
}

TEST(json_pointers_that_are_too_long_are_cut) {
    char key[300] = "";
    struct api_value root = {0}, value = {.parent = &root, .key = key};
    for (int shift = 0; shift < 3; shift++) {
        char pointer[API_POINTER_BYTES];
        key[0] = 0;
        for (int i = 0; i < shift; i++) strcat(key, "x");
        for (int i = 0; i < 80; i++) strcat(key, "\xe2\x82\xac");
        api_value_pointer(&value, pointer);
        size_t bytes = strlen(pointer);
        CHECK(bytes < API_POINTER_BYTES && bytes > API_POINTER_BYTES - 8);
        CHECK(!strcmp(pointer + bytes - 6, "\xe2\x82\xac..."));
    }
    /* and a chain of parents that is longer than in any document */
    struct api_value chain[400] = {{0}};
    char pointer[API_POINTER_BYTES];
    for (int i = 1; i < 400; i++)
        chain[i] = (struct api_value){.parent = &chain[i - 1], .index = 7};
    api_value_pointer(&chain[399], pointer);
    CHECK(strstr(pointer, "/7/7/7") == pointer && strstr(pointer, "..."));
}

TEST(json_fields_that_are_not_known_are_faulted_with_what_was_meant) {
    static const char *const allowed[] = {"length", "mass", "parent", "L", "rtol", NULL};
    static const struct {
        const char *key, *says;
    } table[] = {
        {"lenght", "is not a known field; did you mean \"length\"?"},
        {"masss", "is not a known field; did you mean \"mass\"?"},
        {"MASS", "is not a known field; did you mean \"mass\"?"},
        {"perent", "is not a known field; did you mean \"parent\"?"},
        {"rtoll", "is not a known field; did you mean \"rtol\"?"},
        {"l", "is not a known field; did you mean \"L\"?"},
        {"x", "is not a known field; allowed here: length, mass, parent, L, rtol"},
        {"", "is not a known field; allowed here: length, mass, parent, L, rtol"},
        {"completely different",
         "is not a known field; allowed here: length, mass, parent, L, rtol"},
    };
    for (size_t i = 0; i < sizeof table / sizeof *table; i++) {
        char text[100];
        OWN(api_problem, clear) problem;
        api_problem_init(&problem);
        snprintf(text, sizeof text, "{\"mass\":1,\"%s\":2,\"L\":[]}", table[i].key);
        OWN(api_json, free) *document = parse(text);
        struct api_value root = api_json_root(document);
        CHECK_INT(api_value_only(&root, allowed, &problem), 1);
        REQUIRE(problem.count == 1);
        CHECK_TEXT(problem.faults[0].detail, table[i].says);
        CHECK_TEXT(problem.faults[0].pointer + 1, table[i].key);
    }
}

TEST(json_all_unknown_fields_are_counted) {
    static const char *const allowed[] = {"b", NULL};
    OWN(api_problem, clear) problem;
    api_problem_init(&problem);
    OWN(api_json, free) *document = parse("{\"a\":1,\"b\":2,\"c\":[3],\"d\":{}}");
    struct api_value root = api_json_root(document), member = api_value_member(&root, "b");
    CHECK_INT(api_value_only(&root, allowed, &problem), 3);
    CHECK_INT(api_value_only(&member, allowed, &problem), 0);
    CHECK_INT(problem.count, 3);
    CHECK_TEXT(problem.faults[2].pointer, "/d");
}

TEST(json_numbers_are_read_with_their_range) {
    static const struct {
        const char *text;
        double least, greatest;
        const char *unit;
        int result;
        const char *says;
    } table[] = {
        {"0.5", 0, 1, "s", 1, ""},
        {"0", 0, 1, "s", 1, ""},
        {"1", 0, 1, "s", 1, ""},
        {"1.5", 0, 1, "s", -1, "must be a number from 0 to 1 s, got 1.5"},
        {"-0.1", 0, INFINITY, "kg", -1, "must be a number, at least 0 kg, got -0.1"},
        {"0", DBL_TRUE_MIN, INFINITY, "m", -1, "must be a number greater than 0 m, got 0"},
        {"1e-300", DBL_TRUE_MIN, INFINITY, "m", 1, ""},
        {"0", DBL_TRUE_MIN, 1, "", -1, "must be a number greater than 0 and at most 1, got 0"},
        {"7", -INFINITY, 5, "", -1, "must be a number, at most 5, got 7"},
        {"null", -INFINITY, INFINITY, "", -1, "must be a number, got null"},
        {"true", 0, 1, "", -1, "must be a number from 0 to 1, got true"},
        {"\"0.5\"", 0, 1, "", -1, "must be a number from 0 to 1, got the text \"0.5\""},
        {"[0.5]", 0, 1, "", -1, "must be a number from 0 to 1, got an array"},
        {"{}", 0, 1, "", -1, "must be a number from 0 to 1, got an object"},
    };
    for (size_t i = 0; i < sizeof table / sizeof *table; i++) {
        char text[60];
        double x = -77;
        OWN(api_problem, clear) problem;
        api_problem_init(&problem);
        snprintf(text, sizeof text, "{\"x\":%s}", table[i].text);
        OWN(api_json, free) *document = parse(text);
        struct api_value root = api_json_root(document), value = api_value_member(&root, "x");
        CHECK_INT(api_value_read_number(&value, table[i].least, table[i].greatest, table[i].unit,
                                        &x, &problem),
                  table[i].result);
        CHECK_TEXT(problem.count ? problem.faults[0].detail : "", table[i].says);
        CHECK((x != -77) == (table[i].result == 1));
        value = api_value_member(&root, "y");
        CHECK_INT(api_value_read_number(&value, 0, 1, "", &x, &problem), 0);
    }
}

/* an array of this many arrays */
static struct api_buffer small_arrays(int count) {
    struct api_buffer text;
    api_buffer_init(&text, 10000000);
    CHECK(!api_buffer_add(&text, "[", 1));
    for (int i = 0; i < count; i++)
        CHECK(!api_buffer_text(&text, i ? ",[ 1, 2, 3, 4]" : "[ 1, 2, 3, 4]"));
    CHECK(!api_buffer_add(&text, "]", 1));
    return text;
}

TEST(a_document_may_have_so_many_values_besides_numbers_in_arrays) {
    for (int beyond = 0; beyond < 2; beyond++) {
        OWN(api_buffer, clear) text = small_arrays(299999 + beyond); /* and the array of them */
        OWN(api_problem, clear) problem;
        OWN(api_json, free) *document;
        api_problem_init(&problem);
        CHECK_INT(api_json_new(&document, text.data, text.bytes, 4, &problem),
                  beyond ? PEND_INVALID : PEND_OK);
        CHECK_INT(problem.status, beyond ? 422 : 0);
        CHECK(!beyond || strstr(problem.detail, "more than 300000 values"));
    }
}

TEST(members_and_items_are_walked_alike) {
    static const char text[] = "{\"a\":[1,2],\"b\":[[],3],\"c\":{}}";
    OWN(api_json, free) *document;
    struct api_problem problem;
    api_problem_init(&problem);
    REQUIRE(!api_json_new(&document, text, sizeof text - 1, 9, &problem));
    struct api_value root = api_json_root(document), a = api_value_first(&root),
                     b = api_value_next(&a);
    struct api_value c = api_value_next(&b), end = api_value_next(&c), none = api_value_first(&c);
    CHECK_TEXT(a.key, "a");
    CHECK_TEXT(b.key, "b");
    CHECK_TEXT(c.key, "c");
    CHECK(api_value_kind(&end) == API_MISSING && api_value_kind(&none) == API_MISSING);
    struct api_value one = api_value_first(&a), two = api_value_next(&one),
                     three = api_value_next(&two);
    CHECK(api_value_number(&one) == 1 && api_value_number(&two) == 2 &&
          api_value_kind(&three) == API_MISSING);
    struct api_value list = api_value_first(&b), number = api_value_next(&list),
                     behind = api_value_next(&number);
    CHECK(api_value_kind(&list) == API_ARRAY && api_value_number(&number) == 3);
    CHECK(api_value_kind(&behind) == API_MISSING && !number.key && number.index == 1);
}
