#include "server/classes/nickname.h"

#include <assert.h>
#include <string.h>
#include <unicode/uchar.h>
#include <unicode/unorm2.h>
#include <unicode/uspoof.h>
#include <unicode/ustring.h>

enum {
    NICKNAME_UNITS = 2048,          /* of UTF-16; a character becomes 18 at most, a name has 32 */
    NICKNAME_BRAILLE_BLANK = 0x2800 /* looks like a blank, and is a symbol */
};

/* Leaves out blanks, control and format characters, and what has no picture. Returns how many units
 * are left. */
static int32_t nickname_seen(UChar text[], int32_t units) {
    int32_t kept = 0;
    for (int32_t at = 0; at < units;) {
        UChar32 c;
        U16_NEXT(text, at, units, c);
        if (U_GET_GC_MASK(c) & (U_GC_Z_MASK | U_GC_CC_MASK | U_GC_CF_MASK)) continue;
        if (u_hasBinaryProperty(c, UCHAR_DEFAULT_IGNORABLE_CODE_POINT)) continue;
        if (c != NICKNAME_BRAILLE_BLANK) U16_APPEND_UNSAFE(text, kept, c);
    }
    assert(kept <= units);
    return kept;
}

/* The skeleton makes l of I and 1, and O of 0; i and o join them, whatever their case was. */
static void nickname_digits(UChar text[], int32_t units) {
    for (int32_t i = 0; i < units; i++) {
        if (text[i] == 'i' || text[i] == 'l') text[i] = '1';
        if (text[i] == 'o') text[i] = '0';
    }
}

int srv_nickname_fold(const char *name, char fold[], size_t cap) {
    UChar one[NICKNAME_UNITS], two[NICKNAME_UNITS];
    UErrorCode error = U_ZERO_ERROR;
    int32_t units = 0, bytes = 0;
    assert(cap > 3);
    fold[0] = 0;
    u_strFromUTF8WithSub(one, NICKNAME_UNITS, &units, name, -1, 0xfffd, NULL, &error);
    units =
        unorm2_normalize(unorm2_getNFKCInstance(&error), one, units, two, NICKNAME_UNITS, &error);
    if (U_SUCCESS(error)) units = nickname_seen(two, units);
    USpoofChecker *checker = uspoof_open(&error);
    units = uspoof_getSkeleton(checker, 0, two, units, one, NICKNAME_UNITS, &error);
    uspoof_close(checker);
    units = u_strFoldCase(two, NICKNAME_UNITS, one, units, U_FOLD_CASE_DEFAULT, &error);
    if (U_FAILURE(error)) return -1;
    nickname_digits(two, units);
    /* a unit has three bytes of UTF-8 at most */
    int32_t most = (int32_t)(cap - 1) / 3;
    u_strToUTF8WithSub(fold, (int32_t)cap, &bytes, two, units < most ? units : most, 0xfffd, NULL,
                       &error);
    return U_FAILURE(error) ? -1 : bytes;
}
