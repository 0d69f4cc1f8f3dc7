#include "api/json/json_digits.h"

#include <stdio.h>
#include <string.h>

#include "api/json/json_in.h"
#include "tests/harness/test.h"

enum { DEPTH = 16, TEXT = 200 };

/* single digits are read four at a time, unless a blank follows their commas */
static void with_blanks(const char *text, size_t bytes, char spaced[2 * TEXT]) {
    for (size_t i = 0; i < bytes; i++) {
        *spaced++ = text[i];
        if (text[i] == ',') *spaced++ = ' ';
    }
    *spaced = 0;
}

/* 1 if a text is accepted, with its numbers if it contains nothing else */
static int read(const char *text, size_t bytes, int *count, double number[TEXT]) {
    OWN(api_json, free) *document = NULL;
    OWN(api_problem, clear) problem;
    api_problem_init(&problem);
    int accepted = api_json_new(&document, text, bytes, DEPTH, &problem) == PEND_OK;
    *count = -1;
    if (accepted) {
        struct api_value root = api_json_root(document);
        const double *found = api_value_numbers(&root, count);
        if (found) memcpy(number, found, (size_t)*count * sizeof *number);
    }
    return accepted;
}

/* 1 if a text and the same text with blanks give the same, or are both refused */
static int agrees(const char *text, size_t bytes, int *accepted) {
    char spaced[2 * TEXT];
    double number[TEXT], other[TEXT];
    int count, others;
    with_blanks(text, bytes, spaced);
    int good = read(text, bytes, &count, number);
    *accepted += good;
    return good == read(spaced, strlen(spaced), &others, other) && count == others &&
           (count < 0 || !memcmp(number, other, (size_t)count * sizeof *number));
}

TEST(json_digits_with_any_byte_changed_are_read_as_those_with_blanks) {
    char text[] = "[0,1,2,3,4,5,6,7,8,9,0,1,10,1,0,-2,3,4,5,6,7.5,8,1,0,1]";
    int accepted = 0, faults = 0;
    for (size_t i = 0; i < sizeof text - 1; i++)
        for (int byte = 0; byte < 256; byte++) {
            char kept = text[i];
            text[i] = (char)byte;
            faults += !agrees(text, sizeof text - 1, &accepted);
            text[i] = kept;
        }
    CHECK_INT(faults, 0);
    CHECK(accepted > 500 && accepted < 5000);
}

TEST(json_digits_of_any_count_and_cut_anywhere_are_read_as_those_with_blanks) {
    char text[TEXT] = "[";
    int accepted = 0, faults = 0;
    for (int count = 1; count < TEXT / 2 - 1; count++) {
        size_t bytes = strlen(text);
        snprintf(text + bytes, TEXT - bytes, "%d]", (7 * count + count / 10) % 10);
        for (size_t cut = 0; cut <= bytes + 2; cut++) faults += !agrees(text, cut, &accepted);
        text[bytes + 1] = ',';
    }
    CHECK_INT(faults, 0);
    CHECK_INT(accepted, TEXT / 2 - 2);
}

TEST(json_digits_four_are_taken_with_their_commas_and_nothing_else) {
    static const char *const others[] = {"1,0,1,0]", "1,0,1,:,", "1,0,1,/,", "10,1,0,1",
                                         " 1,0,1,0", "1.0,1,0,", "-,0,1,0,"};
    double x[4] = {-1, -1, -1, -1};
    for (size_t i = 0; i < sizeof others / sizeof *others; i++)
        CHECK_INT(api_digits_four(others[i], x), 0);
    CHECK(x[0] == -1 && x[3] == -1);
    CHECK_INT(api_digits_four("9,0,4,1,", x), 1);
    CHECK(x[0] == 9 && x[1] == 0 && x[2] == 4 && x[3] == 1);
}
