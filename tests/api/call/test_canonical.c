#include "api/call/canonical.h"

#include <string.h>

#include "tests/harness/test.h"

enum { DEPTH = 16 };

/* the canonical form of a text; "" with a failed check if it is not JSON */
static void canonical(const char *text, struct api_buffer *out) {
    OWN(api_json, free) *document = NULL;
    OWN(api_problem, clear) problem;
    api_problem_init(&problem);
    api_buffer_init(out, 1 << 20);
    if (CHECK_SAYING(api_json_new(&document, text, strlen(text), DEPTH, &problem) == PEND_OK,
                     "%s: %s", text, problem.detail)) {
        struct api_value root = api_json_root(document);
        CHECK(api_canonical_write(&root, out) == PEND_OK);
    }
    CHECK(api_buffer_add(out, "", 1) == PEND_OK);
}

static void check(const char *text, const char *wanted) {
    OWN(api_buffer, clear) once, twice;
    canonical(text, &once);
    CHECK_TEXT(once.data, wanted);
    canonical(once.data, &twice);
    CHECK_TEXT(twice.data, wanted);
}

TEST(canonical_form_heeds_neither_order_nor_spelling) {
    check("{ \"b\" : 1.0, \"a\" : [ 1e0, 2.50, -0.0, 1E+2 ], \"\\u0061a\" : null }",
          "{\"a\":[1,2.5,-0.0,100],\"aa\":null,\"b\":1}");
    check("{\"b\":{\"d\":true,\"c\":[]},\"a\":{}}", "{\"a\":{},\"b\":{\"c\":[],\"d\":true}}");
    check("[[1,2],[\"x\",false],[{\"k\":0.1}]]", "[[1,2],[\"x\",false],[{\"k\":0.1}]]");
    check("\"\\u00e9\\/\\n\\\"\"", "\"\xc3\xa9/\\n\\\"\"");
    check("9007199254740993", "9007199254740992");
}

TEST(canonical_form_tells_the_order_of_items_and_the_sign_of_zero) {
    check("[2,1]", "[2,1]");
    check("[0,-0.0]", "[0,-0.0]");
    check("{\"B\":1,\"a\":2}", "{\"B\":1,\"a\":2}");
}

TEST(canonical_form_that_finds_no_room_says_so) {
    OWN(api_json, free) *document = NULL;
    OWN(api_problem, clear) problem;
    struct api_buffer out;
    const char *text = "{\"a\":[1,2,{\"b\":\"text\"}]}";
    api_problem_init(&problem);
    REQUIRE(api_json_new(&document, text, strlen(text), DEPTH, &problem) == PEND_OK);
    struct api_value root = api_json_root(document);
    int failed = 0;
    for (size_t limit = 0;; limit++) {
        api_buffer_init(&out, limit);
        enum pend_status status = api_canonical_write(&root, &out);
        CHECK(out.bytes <= limit);
        int good = status == PEND_OK;
        if (good) CHECK(out.bytes == strlen(text) && !memcmp(out.data, text, out.bytes));
        api_buffer_clear(&out);
        if (good) break;
        CHECK(status == PEND_LIMIT);
        failed++;
    }
    CHECK(failed >= (int)strlen(text));
}
