#include "api/json/json_escape.h"

#include <stdio.h>
#include <string.h>

#include "tests/harness/test.h"

/* a text and the meaning of the escape at its start, or what is wrong with it */
static const struct {
    const char *text, *want, *fault;
    size_t taken;
} rows[] = {
    {"\\n.", "\n", NULL, 2},
    {"\\/", "/", NULL, 2},
    {"\\\"", "\"", NULL, 2},
    {"\\u0041b", "A", NULL, 6},
    {"\\u007f", "\x7f", NULL, 6},
    {"\\u0080", "\xc2\x80", NULL, 6},
    {"\\u07FF", "\xdf\xbf", NULL, 6},
    {"\\u20aC", "\xe2\x82\xac", NULL, 6},
    {"\\ud83d\\ude00x", "\xf0\x9f\x98\x80", NULL, 12},
    {"\\udbff\\udfff", "\xf4\x8f\xbf\xbf", NULL, 12},
    {"\\", NULL, "a backslash", 0},
    {"\\x41", NULL, "a backslash", 0},
    {"\\u12g4", NULL, "four hexadecimal", 0},
    {"\\u123", NULL, "four hexadecimal", 0},
    {"\\u0000", NULL, "U+0000", 0},
    {"\\ude00", NULL, "a low surrogate", 0},
    {"\\ud83d", NULL, "a high surrogate", 0},
    {"\\ud83d\\u0041", NULL, "a high surrogate", 0},
    {"\\ud83d\\ude0", NULL, "a high surrogate", 0},
    {"\\ud83dude000000", NULL, "a high surrogate", 0},
};

TEST(json_escapes_become_characters_and_faulty_ones_say_why) {
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        char utf8[5] = "";
        size_t taken = 0, length = 0;
        const char *text = rows[i].text,
                   *fault = api_escape_read(text, strlen(text), &taken, utf8, &length);
        CHECK_SAYING(!fault == !rows[i].fault, "%s: %s", text, fault ? fault : "no fault");
        if (fault)
            CHECK_SAYING(rows[i].fault && strstr(fault, rows[i].fault), "%s: %s", text, fault);
        if (!rows[i].want) continue;
        CHECK_SAYING(length == strlen(rows[i].want) && !memcmp(utf8, rows[i].want, length) &&
                         taken == rows[i].taken,
                     "%s: %zu bytes of %zu", text, length, taken);
    }
}
