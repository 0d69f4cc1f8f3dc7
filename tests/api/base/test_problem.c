#include "api/base/problem.h"

#include <stdio.h>
#include <string.h>

#include "api/json/json_in.h"
#include "tests/harness/test.h"

/* the problem as text, NUL-terminated, in static memory; checked to be JSON */
static const char *text_of(const struct api_problem *problem) {
    static char text[100000];
    OWN(api_buffer, clear) out;
    OWN(api_json, free) *document = NULL;
    OWN(api_problem, clear) reading;
    api_problem_init(&reading);
    api_buffer_init(&out, sizeof text - 1);
    text[0] = 0;
    if (!CHECK_INT(api_problem_write(problem, &out), PEND_OK)) return text;
    CHECK_SAYING(!api_json_new(&document, out.data, out.bytes, 8, &reading), "no JSON: %s",
                 reading.detail);
    memcpy(text, out.data, out.bytes);
    text[out.bytes] = 0;
    return text;
}

TEST(problem_that_was_set_is_written) {
    struct api_problem problem;
    api_problem_init(&problem);
    CHECK_INT(problem.status, 0);
    api_problem_set(&problem, 404, "there is nothing at %s", "/nowhere");
    CHECK_TEXT(text_of(&problem),
               "{\"type\":\"about:blank\",\"title\":\"Not Found\",\"status\":404,"
               "\"detail\":\"there is nothing at /nowhere\"}");
    api_problem_clear(&problem);
    CHECK_INT(problem.status, 0);
}

TEST(problem_has_the_type_in_front_of_its_format_and_no_other) {
    OWN(api_problem, clear) problem;
    api_problem_init(&problem);
    api_problem_set(&problem, 413, API_TYPE_LIMIT "%s", "\1Q is text of the client");
    CHECK_TEXT(problem.type, "over-limit");
    CHECK(strstr(text_of(&problem), "{\"type\":\"urn:pendulumd:problem-over-limit\",") != NULL);
    api_problem_clear(&problem);
    api_problem_set(&problem, 404, "%s", API_TYPE_LIMIT);
    CHECK(!problem.type);
}

TEST(problem_keeps_what_was_stated_first) {
    OWN(api_problem, clear) problem;
    api_problem_init(&problem);
    api_problem_set(&problem, 413, "first");
    api_problem_set(&problem, 400, "second");
    CHECK_INT(problem.status, 413);
    CHECK_TEXT(problem.detail, "first");
    CHECK_TEXT(problem.title, "Content Too Large");
}

TEST(problem_of_faults_is_a_422_with_pointers) {
    OWN(api_problem, clear) problem;
    api_problem_init(&problem);
    api_problem_fault(&problem, "/pendulum/arms/3/mass",
                      API_CODE_OUT_OF_RANGE "must be greater than %d, got %g", 0, -1.0);
    api_problem_fault(&problem, "", "has \"no\" arms");
    CHECK_TEXT(text_of(&problem),
               "{\"type\":\"urn:pendulumd:problem-invalid-request\",\"title\":\"Unprocessable "
               "Content\",\"status\":422,\"detail\":\"2 errors in the request: see errors\","
               "\"errors\":[{\"pointer\":\"/pendulum/arms/3/mass\",\"detail\":\"must be greater "
               "than 0, got -1\",\"code\":\"out_of_range\"},{\"pointer\":\"\",\"detail\":\"has "
               "\\\"no\\\" arms\",\"code\":\"invalid\"}]}");
}

TEST(problem_has_a_status_for_every_result) {
    static const short http[PEND_STATUS_COUNT + 1] = {200, 422, 422, 503, 503, 503,
                                                      422, 422, 422, 500, 500, 500};
    for (int i = 0; i <= PEND_STATUS_COUNT; i++)
        CHECK_INT(api_problem_http((enum pend_status)i), http[i]);
}

TEST(problem_has_a_title_for_every_status_that_is_used) {
    static const int statuses[] = {400, 404, 405, 406, 408, 413, 414, 415,
                                   417, 422, 429, 431, 500, 501, 503, 505};
    for (size_t i = 0; i < sizeof statuses / sizeof *statuses; i++) {
        OWN(api_problem, clear) problem;
        api_problem_init(&problem);
        api_problem_set(&problem, statuses[i], "x");
        CHECK_SAYING(!strstr(problem.title, "Error") || statuses[i] == 500, "%d: %s", statuses[i],
                     problem.title);
    }
}

TEST(problem_keeps_a_hundred_faults_and_counts_the_rest) {
    OWN(api_problem, clear) problem;
    api_problem_init(&problem);
    for (int i = 0; i < 250; i++) {
        char pointer[20];
        snprintf(pointer, sizeof pointer, "/%d", i);
        api_problem_fault(&problem, pointer, "fault %d", i);
    }
    CHECK_INT(problem.count, 100);
    CHECK_INT(problem.beyond, 150);
    const char *text = text_of(&problem);
    CHECK(strstr(text, "\"250 errors in the request: see errors\"") != NULL);
    CHECK(strstr(text, "\"errors_omitted\":150}") != NULL);
    CHECK(strstr(text, "/99\"") && !strstr(text, "/100\""));
}

TEST(problem_cuts_long_texts_where_a_character_ends) {
    struct api_problem problem;
    char text[1000] = "", pointer[400];
    for (int i = 0; i < 300; i++) strcat(text, "\xe2\x82\xac");
    memset(pointer, 'p', sizeof pointer - 1);
    pointer[sizeof pointer - 1] = 0;
    for (int shift = 0; shift < 3; shift++) {
        api_problem_init(&problem);
        api_problem_set(&problem, 400, "%.*s%s", shift, "xx", text);
        api_problem_fault(&problem, pointer, "%s", text);
        const char *written = text_of(&problem);
        CHECK(!strstr(written, "\xef\xbf\xbd"));
        CHECK(strstr(written, "\xe2\x82\xac...\"") != NULL);
        api_problem_clear(&problem);
    }
}

TEST(problem_with_hostile_text_is_valid_json) {
    OWN(api_problem, clear) problem;
    char hostile[256];
    for (int i = 0; i < 255; i++) hostile[i] = (char)(i + 1);
    hostile[255] = 0;
    api_problem_init(&problem);
    api_problem_set(&problem, 400, "%s", hostile);
    api_problem_fault(&problem, hostile + 128, "%s", hostile + 128);
    CHECK(strlen(text_of(&problem)) > 300);
}

TEST(problem_counts_faults_for_which_there_is_no_memory) {
    OWN(api_problem, clear) problem;
    OWN(api_buffer, clear) out;
    api_problem_init(&problem);
    test_alloc_fail(1, 1);
    api_problem_fault(&problem, "/a", "lost");
    test_alloc_faults_off();
    CHECK_INT(problem.status, 422);
    CHECK_INT(problem.count, 0);
    CHECK_INT(problem.beyond, 1);
    CHECK(strstr(text_of(&problem), "\"errors_omitted\":1}") != NULL);
    api_problem_clear(&problem);

    api_problem_init(&problem);
    api_problem_fault(&problem, "/a", "kept");
    api_buffer_init(&out, 6);
    CHECK_INT(api_buffer_text(&out, "before"), PEND_OK);
    for (out.limit = 6; out.limit < 220; out.limit++)
        if (api_problem_write(&problem, &out) == PEND_OK) break;
    CHECK(out.limit > 100 && out.bytes == out.limit && !memcmp(out.data, "before{", 7));
}
