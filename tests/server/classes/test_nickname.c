/* Tests of server/classes/nickname: look-alikes have the same fold, and others different ones. */
#include "server/classes/nickname.h"

#include <string.h>

#include "tests/harness/test.h"

enum { FOLD = 320 };

static void check_same(const char *one, const char *other, int same) {
    char a[FOLD], b[FOLD];
    CHECK(srv_nickname_fold(one, a, FOLD) > 0 && srv_nickname_fold(other, b, FOLD) > 0);
    CHECK_SAYING((strcmp(a, b) == 0) == same, "%s -> %s, %s -> %s", one, a, other, b);
}

TEST(nicknames_that_look_alike_have_one_fold) {
    static const char *const anna[] = {
        "anna",
        "ANNA",
        " An na ",
        "A\xe2\x80\x8bnna",           /* U+200B, zero width space */
        "A\xd8\x9cnna",               /* U+061C, Arabic letter mark */
        "A\xe2\x80\x8fnna",           /* U+200F, right-to-left mark */
        "Anna\xe2\xa0\x80",           /* U+2800, a blank of Braille */
        "A\xe3\x85\xa4nna",           /* U+3164, Hangul filler */
        "An\xcd\x8fna",               /* U+034F, combining grapheme joiner */
        "A\xef\xb8\x8fnna",           /* U+FE0F, variation selector */
        "\xd0\x90nna",                /* Cyrillic A */
        "\xce\x91nn\xd0\xb0",         /* Greek Alpha, Cyrillic a */
        "\xef\xbc\xa1\xef\xbd\x8ena", /* full-width A and n */
        "\xf0\x9d\x90\x80nna",        /* mathematical bold A */
        "\xe2\x92\xb6nna",            /* A in a circle */
    };
    for (size_t i = 0; i < sizeof anna / sizeof *anna; i++) check_same("Anna", anna[i], 1);
    /* composed and decomposed letters; capitals of one script that look like those of another */
    check_same("Jos\xc3\xa9", "Jose\xcc\x81", 1);
    check_same("Hanna",
               "\xd0\x9d"
               "anna",
               1);
    check_same("Ian", "lan", 1);
    /* marks in another order; a syllable of Hangul and its letters */
    check_same("s\xcc\xa3\xcc\x87", "\xe1\xb9\xa9", 1);
    check_same("s\xcc\x87\xcc\xa3", "\xe1\xb9\xa9", 1);
    check_same("\xed\x95\x9c", "\xe1\x84\x92\xe1\x85\xa1\xe1\x86\xab", 1);
    check_same("Max (10)", "Max (lO)", 1);
    /* and these do not look alike */
    check_same("Anna", "Anne", 0);
    check_same("Anna", "Anna (2)", 0);
    check_same("Jose", "Jos\xc3\xa9", 0);
    check_same("\xe5\xbc\xa0\xe4\xbc\x9f", "\xe5\xbc\xa0\xe6\x95\x8f", 0);
    check_same("\xd9\x85\xd8\xad\xd9\x85\xd8\xaf", "\xd8\xa3\xd8\xad\xd9\x85\xd8\xaf", 0);
    check_same("\xf0\x9f\x98\x80", "\xf0\x9f\x98\x81", 0); /* two faces */
}

TEST(a_fold_fits_and_what_cannot_be_seen_has_none) {
    char fold[FOLD], wide[200] = "", little[8];
    CHECK_INT(srv_nickname_fold("\xe2\x80\x8b \xe2\x81\xa0", fold, FOLD), 0);
    CHECK_TEXT(fold, "");
    /* U+FDFA stands for 18 characters; the fold of 32 of them is truncated at a character */
    for (int i = 0; i < 32; i++) strcat(wide, "\xef\xb7\xba");
    CHECK(srv_nickname_fold(wide, fold, FOLD) > 0 && strlen(fold) < FOLD);
    /* bytes that are not UTF-8 end nothing */
    CHECK(srv_nickname_fold("\xff\xfe"
                            "a",
                            fold, FOLD) > 0);
    CHECK(srv_nickname_fold("abcdef", little, sizeof little) > 0);
    CHECK_TEXT(little, "abcd");
}
