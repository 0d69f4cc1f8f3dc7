#include "api/json/json_hint.h"

#include <assert.h>
#include <string.h>
#include <strings.h>

#include "api/json/json_digits.h"

static const char no_such_number[] = ": JSON has no NaN and no infinity, leave the value out";

/* literals of other languages, found by their first letters */
static const struct {
    const char *word, *hint;
} hint_words[] = {
    {"nan", no_such_number},
    {"inf", no_such_number},
    {"true", ": JSON writes true"},
    {"false", ": JSON writes false"},
    {"none", ": JSON writes null"},
    {"nil", ": JSON writes null"},
    {"undefined", ": JSON has no undefined, leave the field out"},
    {"object object]",
     ": this is the text of a JavaScript object, send the output of JSON.stringify"},
};

/* characters that begin no value */
static const struct {
    char first;
    const char *hint;
} hint_characters[] = {
    {'\'', ": JSON uses double quotes only"},
    {'/', ": JSON has no comments"},
    {'#', ": JSON has no comments"},
    {'%', ": JSON has no comments"},
    {'.', ": a number begins with a digit, like 0.5"},
    {'+', ": a number has no plus sign"},
    {'@', ": the name of a file was sent instead of its contents"},
    {'\x1f', ": it looks compressed, send it uncompressed"},
    {'\xff', ": it looks like UTF-16, send UTF-8"},
    {'\xfe', ": it looks like UTF-16, send UTF-8"},
};

/* the last non-blank character before the position; 0 if there is none */
static char hint_before(const char *text, size_t at) {
    while (at && strchr(" \t\r\n", text[at - 1])) at--;
    return at ? text[at - 1] : 0;
}

const char *api_json_hint(const char *text, size_t bytes, size_t at) {
    assert(at <= bytes);
    const char *p = text + at;
    size_t left = bytes - at;
    if (!bytes) return ": the body is empty";
    if (!left) return ": the text is cut off";
    if ((*p == '}' || *p == ']') && hint_before(text, at) == ',')
        return ": a comma is missing before it";
    if (at >= 2 && api_digit((unsigned char)*p) && p[-1] == ',' && api_digit((unsigned char)p[-2]))
        return ": the decimal mark is a point";
    for (size_t i = 0; i < sizeof hint_words / sizeof *hint_words; i++) {
        size_t length = strlen(hint_words[i].word);
        if (left >= length && !strncasecmp(p, hint_words[i].word, length))
            return hint_words[i].hint;
    }
    for (size_t i = 0; i < sizeof hint_characters / sizeof *hint_characters; i++)
        if (*p == hint_characters[i].first) return hint_characters[i].hint;
    return "";
}
