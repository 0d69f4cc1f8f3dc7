#include "api/base/text.h"

#include <stdlib.h>
#include <string.h>

#include "tests/harness/test.h"

/* by the definition: decodes, and checks that the shortest form of an allowed character was used */
static int utf8_by_definition(const unsigned char *p, int bytes) {
    int length = p[0] < 0x80             ? 1
                 : (p[0] & 0xe0) == 0xc0 ? 2
                 : (p[0] & 0xf0) == 0xe0 ? 3
                 : (p[0] & 0xf8) == 0xf0 ? 4
                                         : 0;
    static const long least[] = {0, 0, 0x80, 0x800, 0x10000}, mask[] = {0, 0x7f, 0x1f, 0x0f, 0x07};
    if (!length || length > bytes) return 0;
    long code = p[0] & mask[length];
    for (int i = 1; i < length; i++) {
        if (p[i] >> 6 != 2) return 0;
        code = code << 6 | (p[i] & 0x3f);
    }
    return code >= least[length] && code <= 0x10ffff && (code < 0xd800 || code > 0xdfff) ? length
                                                                                         : 0;
}

/* every pair of bytes, followed by bytes that are a continuation or not, and cut short */
TEST(text_knows_utf8) {
    static const unsigned char tails[] = {0x00, 0x7f, 0x80, 0xbf, 0xc0, 0xff};
    int faults = 0, good = 0;
    for (int lead = 0; lead < 256; lead++)
        for (int second = 0; second < 256; second++)
            for (int t = 0; t < 36; t++)
                for (int bytes = 1; bytes <= 4; bytes++) {
                    unsigned char text[] = {(unsigned char)lead, (unsigned char)second,
                                            tails[t / 6], tails[t % 6]};
                    int length = api_text_utf8((const char *)text, (size_t)bytes);
                    faults += length != utf8_by_definition(text, bytes);
                    good += length > 1;
                }
    CHECK_INT(faults, 0);
    CHECK(good > 10000);
}

TEST(text_is_cut_between_characters) {
    static const char text[] = "a\xc3\xa9\xe2\x82\xac\xf0\x9f\x98\x80z";
    static const size_t cut[] = {0, 1, 1, 3, 3, 3, 6, 6, 6, 6, 10, 11};
    for (size_t cap = 0; cap < sizeof cut / sizeof *cut; cap++)
        CHECK_INT((long long)api_text_cut(text, strlen(text), cap), (long long)cut[cap]);
    CHECK_INT((long long)api_text_cut("\x80\x80\x80\x80\x80\x80\x80", 7, 5), 5);
}

static void quoted(const char *text, size_t bytes, const char *want) {
    OWN(api_buffer, clear) out;
    api_buffer_init(&out, 1000);
    CHECK_INT(api_text_quote(&out, text, bytes), PEND_OK);
    CHECK_INT(api_buffer_add(&out, "", 1), PEND_OK);
    CHECK_TEXT(out.data, want);
}

TEST(text_is_quoted_as_json) {
    quoted("", 0, "\"\"");
    quoted("plain \x7f", 7, "\"plain \x7f\"");
    quoted("a\"b\\c/d", 7, "\"a\\\"b\\\\c/d\"");
    quoted("\b\f\n\r\t\x01\x1f\0x", 9, "\"\\b\\f\\n\\r\\t\\u0001\\u001f\\u0000x\"");
    quoted("\xc3\xa9\xf0\x9f\x98\x80", 6, "\"\xc3\xa9\xf0\x9f\x98\x80\"");
}

TEST(text_that_is_no_utf8_is_replaced) {
    quoted("\xff", 1, "\"\xef\xbf\xbd\"");
    quoted("a\xc3", 2, "\"a\xef\xbf\xbd\"");
    quoted("\xc3(", 2, "\"\xef\xbf\xbd(\"");
    quoted("\xed\xa0\x80", 3, "\"\xef\xbf\xbd\xef\xbf\xbd\xef\xbf\xbd\"");
    quoted("\xc0\x80", 2, "\"\xef\xbf\xbd\xef\xbf\xbd\"");
}

TEST(text_stops_at_the_limit_of_the_buffer) {
    for (size_t limit = 0; limit < 8; limit++) {
        OWN(api_buffer, clear) out;
        api_buffer_init(&out, limit);
        CHECK_INT(api_text_quote(&out, "a\nb\"", 4), limit < 8 ? PEND_LIMIT : PEND_OK);
    }
}
