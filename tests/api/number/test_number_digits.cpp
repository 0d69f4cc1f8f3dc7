extern "C" {
#include "tests/harness/test.h"
}

#include "api/number/number_digits.h"

#include <stdio.h>
#include <string.h>

/* the digits by printf, with the point inserted */
static void expected(unsigned long high, unsigned long low, int before, char text[18],
                     int *significant) {
    char digits[17];
    snprintf(digits, sizeof digits, "%08lu%08lu", high, low);
    snprintf(text, 18, "%.*s.%s", before, digits, digits + before);
    for (*significant = 16; *significant && digits[*significant - 1] == '0';) --*significant;
}

/* numbers of all lengths, with and without trailing zeros */
static unsigned long number(unsigned long long *seed) {
    static const unsigned long power[] = {1,      10,      100,      1000,     10000,
                                          100000, 1000000, 10000000, 100000000};
    int zeros = test_random_int(seed, 9);
    return (unsigned long)test_random_int(seed, (int)power[8 - zeros]) * power[zeros];
}

template <class digits16> static void agrees() {
    unsigned long long seed = 1;
    int faults = 0;
    for (int i = 0; i < 200000; i++) {
        unsigned long high = number(&seed), low = i % 3 ? number(&seed) : 0;
        int before = i % 17, significant;
        char want[18], got[20] = {}, plain[20] = {};
        digits16 digits(high, low);
        expected(high, low, before, want, &significant);
        digits.store_with_point(got, before);
        digits.store(plain);
        faults += strcmp(got, want) != 0 || digits.significant(0) != significant ||
                  digits.significant(3) != 17;
        memmove(got + before, got + before + 1, (size_t)(17 - before));
        faults += strcmp(got, plain) != 0;
    }
    CHECK_INT(faults, 0);
}

TEST(number_digits_are_those_of_printf_in_plain_arithmetic) { agrees<api::digits16_plain>(); }

#ifdef __SSE2__
TEST(number_digits_are_those_of_printf_with_sse2) { agrees<api::digits16_sse2>(); }
#endif
