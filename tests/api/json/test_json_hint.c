#include "api/json/json_hint.h"

#include <string.h>

#include "tests/harness/test.h"

TEST(a_hint_names_the_habit_behind_a_text_that_is_not_json) {
    static const struct {
        const char *before, *rest, *piece;
    } row[] = {
        {"[", "NaN]", "no NaN"},
        {"[-", "Infinity]", "no infinity"},
        {"[", "True]", "true"},
        {"[", "None]", "null"},
        {"{", "'a':1}", "double quotes"},
        {"[1, ", "]", "a comma is missing before"},
        {"{", "// x\n}", "no comments"},
        {"[", ".5]", "0.5"},
        {"[1,", "5x", "decimal mark"},
        {"", "\x1f\x8b", "uncompressed"},
        {"", "", "empty"},
        {"[1", "", "cut off"},
    };
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        char text[40];
        size_t at = strlen(row[i].before);
        strcpy(text, row[i].before);
        strcpy(text + at, row[i].rest);
        const char *hint = api_json_hint(text, strlen(text), at);
        CHECK_SAYING(strstr(hint, row[i].piece) != NULL, "%s: %s", text, hint);
    }
}

TEST(there_is_no_hint_where_nothing_is_known) {
    CHECK_TEXT(api_json_hint("[1;2]", 5, 2), "");
    CHECK_TEXT(api_json_hint("[1]]", 4, 3), "");
}
