#include "api/number/number.h"

#include <float.h>
#include <limits.h>
#include <locale.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/harness/test.h"

enum { CANARY = 0x5a };

/* the written number, as a string; "" if a byte after API_NUMBER_BYTES was changed or the text is
 * too long */
static const char *written(double x, int digits, char text[API_NUMBER_BYTES + 9]) {
    memset(text, CANARY, API_NUMBER_BYTES + 8);
    char *end = digits ? api_number_write_digits(text, x, digits) : api_number_write(text, x);
    int sound = end > text && end - text <= 24;
    for (int i = 0; i < 8; i++) sound &= text[API_NUMBER_BYTES + i] == CANARY;
    *(sound ? end : text) = 0;
    return text;
}

static double from_bits(uint64_t bits) {
    double x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

static uint64_t random_bits(unsigned long long *seed) {
    uint64_t high = (uint64_t)test_random_int(seed, 1 << 30),
             low = (uint64_t)test_random_int(seed, 1 << 30);
    return high << 34 ^ low << 4 ^ (uint64_t)test_random_int(seed, 16);
}

static int same(double x, double y) { return !memcmp(&x, &y, sizeof x); }

/* -?digits[.digits][e[-]digits] as in RFC 8259 */
static int is_json(const char *p) {
    p += *p == '-';
    if (*p == '0' && p[1] >= '0' && p[1] <= '9') return 0;
    size_t whole = strspn(p, "0123456789");
    p += whole;
    if (!whole) return 0;
    if (*p == '.') {
        size_t fraction = strspn(++p, "0123456789");
        p += fraction;
        if (!fraction) return 0;
    }
    if (*p == 'e') {
        p += 1 + (p[1] == '-');
        size_t exponent = strspn(p, "0123456789");
        p += exponent;
        if (!exponent) return 0;
    }
    return !*p;
}

/* the significant digits of a decimal without zeros at either end, and the power of ten of the
 * first */
static void significant(const char *text, char digits[64], int *exponent) {
    int count = 0, point = -1, power = 0;
    for (; *text; text++) {
        if (*text == '.') point = count;
        if (*text == 'e') power = (int)strtol(text + 1, NULL, 10);
        if (*text == 'e') break;
        if (*text >= '0' && *text <= '9') digits[count++] = *text;
    }
    digits[count] = 0;
    if (point < 0) point = count;
    size_t zeros = strspn(digits, "0");
    memmove(digits, digits + zeros, (size_t)count - zeros + 1);
    *exponent = point - (int)zeros + power;
    for (size_t end = strlen(digits); end && digits[end - 1] == '0';) digits[--end] = 0;
}

static int same_decimal(const char *a, const char *b) {
    char x[64], y[64];
    int e, f;
    significant(a, x, &e);
    significant(b, y, &f);
    return !strcmp(x, y) && e == f;
}

static int digit_count(const char *text) {
    char digits[64];
    int exponent;
    significant(text, digits, &exponent);
    return (int)strlen(digits);
}

/* prints errors in the written form of x, at most a few times; returns the number of errors */
static int faults_of(double x) {
    static int told;
    char text[API_NUMBER_BYTES + 9], rounded[64];
    const char *fault = NULL;
    written(x, 0, text);
    if (!is_json(text)) fault = "is no JSON";
    if (!same(strtod(text, NULL), x)) fault = "does not read back";
    if (!same(api_number_read(text, text + strlen(text)), x)) fault = "is not read back";
    int count = digit_count(text);
    if (count > 1) {
        snprintf(rounded, sizeof rounded, "%.*e", count - 2, x);
        if (same(strtod(rounded, NULL), x)) fault = "is not the shortest";
    }
    if (fault && told++ < 10) printf("  %a: \"%s\" %s\n", x, text, fault);
    return fault != NULL;
}

TEST(number_is_written_as_people_expect) {
    static const struct {
        double x;
        const char *text;
    } table[] = {
        {0, "0"},
        {-0.0, "-0.0"},
        {1, "1"},
        {-1, "-1"},
        {100, "100"},
        {0.57, "0.57"},
        {1234.5, "1234.5"},
        {0.1, "0.1"},
        {0.3, "0.3"},
        {1.0 / 3, "0.3333333333333333"},
        {-9.81, "-9.81"},
        {5e-324, "5e-324"},
        {DBL_MIN, "2.2250738585072014e-308"},
        {DBL_MAX, "1.7976931348623157e308"},
        {-DBL_MAX, "-1.7976931348623157e308"},
        {1e15, "1000000000000000"},
        {9999999999999998, "9999999999999998"},
        {1e16, "1e16"},
        {1e22, "1e22"},
        {1e23, "1e23"},
        {9007199254740993.0, "9007199254740992"},
        {0.00001, "0.00001"},
        {0.000012345, "0.000012345"},
        {0.0000099, "9.9e-6"},
        {1.5e-7, "1.5e-7"},
        {123456789012345.67, "123456789012345.67"},
        {1234567890123456.7, "1234567890123456.8"},
        {0.1 + 0.2, "0.30000000000000004"},
        {1e100, "1e100"},
        {2e-100, "2e-100"},
    };
    for (size_t i = 0; i < sizeof table / sizeof *table; i++) {
        char text[API_NUMBER_BYTES + 9];
        CHECK_TEXT(written(table[i].x, 0, text), table[i].text);
    }
}

TEST(number_of_any_bits_reads_back_and_is_the_shortest) {
    unsigned long long seed = 1;
    int faults = 0, tried = 0;
    for (int i = 0; i < 300000; i++) {
        double x = from_bits(random_bits(&seed));
        if (!isfinite(x)) continue;
        tried++;
        faults += faults_of(x);
    }
    CHECK_INT(faults, 0);
    CHECK(tried > 200000);
}

/* PEND_NUMBERS=100000000 makes it a long test */
TEST(number_of_a_million_bits_reads_back) {
    const char *wish = getenv("PEND_NUMBERS");
    long count = wish ? atol(wish) : 1000000, faults = 0;
    unsigned long long seed = 2;
    for (long i = 0; i < count; i++) {
        char text[API_NUMBER_BYTES];
        double x = from_bits(random_bits(&seed));
        if (isfinite(x)) faults += !same(api_number_read(text, api_number_write(text, x)), x);
    }
    CHECK_INT(faults, 0);
}

TEST(number_of_everyday_size_reads_back_and_is_the_shortest) {
    unsigned long long seed = 3;
    int faults = 0;
    for (int i = 0; i < 100000; i++) {
        faults += faults_of(20 * test_random(&seed) - 10);
        faults += faults_of(i * 0.01);
        faults +=
            faults_of(test_random_int(&seed, 100000000) / pow(10, test_random_int(&seed, 12)));
        faults += faults_of(
            ldexp((double)test_random_int(&seed, 1 << 30), test_random_int(&seed, 60) - 50));
    }
    CHECK_INT(faults, 0);
}

/* the neighbours too: the interval that reads back to a power of two is asymmetric, and short
 * decimals are near powers of ten */
TEST(number_next_to_every_power_of_two_and_ten_reads_back_and_is_the_shortest) {
    int faults = 0, tried = 0;
    for (int e = -1074; e < 1024; e++)
        for (int to = -1; to <= 1; to++, tried++) {
            double x = ldexp(1, e);
            faults += faults_of(to ? nextafter(x, to * INFINITY) : x);
        }
    for (int e = -323; e <= 308; e++)
        for (int to = -1; to <= 1; to++, tried++) {
            char text[16];
            snprintf(text, sizeof text, "1e%d", e);
            double x = strtod(text, NULL);
            faults += faults_of(to ? nextafter(x, to * INFINITY) : x);
        }
    CHECK_INT(faults, 0);
    CHECK_INT(tried, 3 * (2098 + 632));
}

TEST(number_of_a_whole_value_is_exact) {
    unsigned long long seed = 4;
    int faults = 0;
    for (int i = 0; i < 200000; i++) {
        char text[API_NUMBER_BYTES + 9], want[32];
        long long whole = (long long)(random_bits(&seed) >> (11 + test_random_int(&seed, 53)));
        snprintf(want, sizeof want, "%lld", whole);
        if (whole < 10000000000000000) faults += strcmp(written((double)whole, 0, text), want) != 0;
    }
    CHECK_INT(faults, 0);
}

/* it is the nearest of the decimals of that length that read back, which is x rounded to that
 * length */
TEST(number_is_the_nearest_of_the_shortest) {
    unsigned long long seed = 5;
    int faults = 0;
    for (int i = 0; i < 100000; i++) {
        char text[API_NUMBER_BYTES + 9], rounded[64];
        double x = i % 2 ? from_bits(random_bits(&seed)) : 20 * test_random(&seed) - 10;
        if (!isnormal(x)) continue;
        written(x, 0, text);
        snprintf(rounded, sizeof rounded, "%.*e", digit_count(text) - 1, x);
        faults += !same_decimal(text, rounded);
    }
    CHECK_INT(faults, 0);
}

static int rounding_faults(double x, int digits) {
    static int told;
    char text[API_NUMBER_BYTES + 9], shortest[API_NUMBER_BYTES + 9], want[64];
    written(x, digits, text);
    written(x, 0, shortest);
    snprintf(want, sizeof want, "%.*e", digits - 1, x);
    if (isinf(strtod(want, NULL))) return !is_json(text) || isinf(strtod(text, NULL));
    int fault =
        !is_json(text) || !same_decimal(text, digit_count(shortest) <= digits ? shortest : want);
    if (fault && told++ < 10)
        printf("  %a to %d digits: \"%s\", expected \"%s\"\n", x, digits, text, want);
    return fault;
}

TEST(number_rounded_to_digits_is_that_of_printf) {
    unsigned long long seed = 6;
    const char *wish = getenv("PEND_NUMBERS");
    long count = wish ? atol(wish) / 50 : 100000, faults = 0;
    for (long i = 0; i < count; i++) {
        double bits = from_bits(random_bits(&seed));
        if (isfinite(bits)) faults += rounding_faults(bits, (int)(1 + i % 17));
        faults += rounding_faults(20 * test_random(&seed) - 10, (int)(1 + i % 17));
    }
    CHECK_INT(faults, 0);
}

TEST(number_rounded_is_never_beyond_the_largest_double) {
    static const char *const want[] = {"1e308",     "1.7e308",    "1.79e308",
                                       "1.797e308", "1.7976e308", "1.79769e308"};
    char text[API_NUMBER_BYTES + 9];
    for (int digits = 1; digits <= 17; digits++)
        for (int sign = -1; sign <= 1; sign += 2) {
            written(sign * DBL_MAX, digits, text);
            CHECK(isfinite(strtod(text, NULL)) && digit_count(text) <= digits);
            if (digits <= 6) CHECK_TEXT(text + (sign < 0), want[digits - 1]);
            /* truncated, not rounded: of 17 digits 17976931348623157 */
            CHECK(fabs(strtod(text, NULL)) > DBL_MAX * (1 - pow(10, 1 - digits)));
        }
    written(1.49e308, 1, text);
    CHECK_TEXT(text, "1e308");
    written(1.5e308, 2, text);
    CHECK_TEXT(text, "1.5e308");
}

/* x.5, x.25, 12500000: halfway between two decimals, exactly */
TEST(number_rounded_at_a_tie_goes_to_the_even_digit) {
    static const struct {
        double x;
        int digits;
        const char *text;
    } table[] = {
        {0.5, 1, "0.5"},
        {2.5, 1, "2"},
        {3.5, 1, "4"},
        {0.125, 2, "0.12"},
        {0.375, 2, "0.38"},
        {-1.5, 1, "-2"},
        {12500000, 2, "12000000"},
        {1.35e22, 2, "1.4e22"},
        {9.5, 1, "10"},
        {99.95, 3, "100"},
        {999999.5, 6, "1000000"},
        {0.99, 1, "1"},
        {1e-7, 3, "1e-7"},
        {2.0 / 3, 6, "0.666667"},
        {123456789, 6, "123457000"},
        {0.1, 17, "0.1"},
        {0.1, 16, "0.1"},
        {0, 6, "0"},
        {-0.0, 6, "-0.0"},
        {5e-324, 6, "5e-324"},
        {DBL_MAX, 3, "1.79e308"},
        {9.9999999e15, 3, "1e16"},
        {0.1 + 0.2, 16, "0.3"},
    };
    for (size_t i = 0; i < sizeof table / sizeof *table; i++) {
        char text[API_NUMBER_BYTES + 9];
        CHECK_TEXT(written(table[i].x, table[i].digits, text), table[i].text);
    }
    unsigned long long seed = 7;
    int faults = 0;
    for (int i = 0; i < 100000; i++) {
        double x = ldexp(2.0 * test_random_int(&seed, 1 << 20) + 1, -test_random_int(&seed, 30));
        for (int digits = 1; digits <= 15; digits += 7) faults += rounding_faults(x, digits);
    }
    CHECK_INT(faults, 0);
}

/* numbers as they occur in rows: similar, of all sizes, with zeros, ties, carries and whole numbers
 * among them */
static double row_number(int kind, unsigned long long *seed) {
    int way = kind ? test_random_int(seed, 8 * kind) : 7;
    if (way == 0) return 0;
    if (way == 1) return test_random_int(seed, 2000) / 2.0 - 500;
    if (way == 2) return (test_random_int(seed, 1 << 20) - (1 << 19)) / 1024.0;
    if (way == 3) return 10 - pow(10, -test_random_int(seed, 16));
    if (way == 4) return pow(10, test_random_int(seed, 40) - 20);
    if (way == 5) return test_random(seed) * pow(10, test_random_int(seed, 16) - 7);
    double bits = from_bits(random_bits(seed));
    return way == 6 && isfinite(bits) ? bits : 20 * test_random(seed) - 10;
}

/* PEND_NUMBERS as above */
TEST(number_rows_are_their_numbers_one_by_one) {
    enum { MOST = 120, ROUNDS = 9000 };
    static char text[MOST * 32 + API_NUMBER_ROWS_BYTES], want[MOST * 32 + API_NUMBER_BYTES];
    const char *wish = getenv("PEND_NUMBERS");
    long rounds = wish ? atol(wish) / 50 : ROUNDS, faults = 0;
    unsigned long long seed = 8;
    for (long round = 0; round < rounds; round++) {
        double value[MOST];
        int digits = (int)(round % 18), width = 1 + test_random_int(&seed, 20);
        struct api_number_rows rows = {
            test_random_int(&seed, MOST / width + 1), width, value, digits, 0, "\n", 1};
        if (round & 1) rows.open = '[', memcpy(rows.close, "],", 3), rows.close_bytes = 2;
        char *at = want;
        for (long i = 0; i < rows.rows; i++) {
            if (rows.open) *at++ = rows.open;
            for (int k = 0; k < width; k++) {
                double x = value[i * width + k] = row_number((int)(round / 18 % 4), &seed);
                at = digits ? api_number_write_digits(at, x, digits) : api_number_write(at, x);
                *at++ = ',';
            }
            memcpy(at - 1, rows.close, 2);
            at += rows.close_bytes - 1;
        }
        char *end = api_number_write_rows(text, &rows);
        faults += end - text != at - want || memcmp(text, want, (size_t)(at - want)) != 0;
    }
    CHECK_INT(faults, 0);
}

TEST(number_written_as_an_integer_is_that_of_printf) {
    static const long long table[] = {0,   1,     -1,      9,       10,        99,
                                      100, 12345, INT_MAX, INT_MIN, LLONG_MAX, LLONG_MIN};
    for (size_t i = 0; i < sizeof table / sizeof *table; i++) {
        char text[API_NUMBER_BYTES + 1], want[32];
        *api_number_write_int(text, table[i]) = 0;
        snprintf(want, sizeof want, "%lld", table[i]);
        CHECK_TEXT(text, want);
    }
}

static double read(const char *text) { return api_number_read(text, text + strlen(text)); }

TEST(number_is_read_exactly_rounded) {
    static const struct {
        const char *text;
        double x;
    } table[] = {
        {"0", 0},
        {"-0", -0.0},
        {"-0.0", -0.0},
        {"0e999", 0},
        {"9007199254740993", 9007199254740992},
        {"9007199254740993.0000000000000000000000000000000000000000000000000000000001",
         9007199254740994},
        {"1e23", 1e23},
        {"8.5e22", 8.5e22},
        {"2.2250738585072011e-308", 0x0.fffffffffffffp-1022},
        {"2.4703282292062327208e-324", 0},
        {"2.4703282292062328e-324", 5e-324},
        {"1e-400", 0},
        {"1.7976931348623158e308", DBL_MAX},
        {"1.7976931348623159e308", INFINITY},
        {"-1e400", -INFINITY},
        {"1e99999999999999999999", INFINITY},
        {"1e-99999999999999999999", 0},
        {"0.00000000000000000000000000000000000000000000000000000000000000000001e68", 1},
        {"100000000000000000000000000000000000000000000000000000000000000000000e-68", 1},
    };
    for (size_t i = 0; i < sizeof table / sizeof *table; i++)
        CHECK_SAYING(same(read(table[i].text), table[i].x), "%s is read as %a", table[i].text,
                     read(table[i].text));
}

TEST(number_of_random_digits_is_read_as_strtod_does) {
    unsigned long long seed = 8;
    int faults = 0;
    for (int i = 0; i < 100000; i++) {
        char text[64];
        int used = snprintf(text, sizeof text, "%d.", test_random_int(&seed, 1000));
        for (int more = 1 + test_random_int(&seed, 30); more; more--)
            text[used++] = (char)('0' + test_random_int(&seed, 10));
        snprintf(text + used, sizeof text - (size_t)used, "e%d", test_random_int(&seed, 660) - 335);
        faults += !same(read(text), strtod(text, NULL));
    }
    CHECK_INT(faults, 0);
}

/* a locale of the test's own, because few machines have one with a decimal comma */
static int locale_with_comma(const char *directory) {
    char command[160], text[8];
    snprintf(command, sizeof command,
             "localedef -c -i de_DE -f UTF-8 '%s/de_DE.UTF-8' >/dev/null 2>&1", directory);
    if (system(command) || setenv("LOCPATH", directory, 1) || !setlocale(LC_NUMERIC, "de_DE.UTF-8"))
        return 0;
    snprintf(text, sizeof text, "%.1f", 0.5);
    return !strcmp(text, "0,5");
}

TEST(number_does_not_obey_the_locale) {
    char text[API_NUMBER_BYTES + 9], directory[] = "/tmp/pendulumd-test-XXXXXX", command[64];
    REQUIRE(mkdtemp(directory));
    if (locale_with_comma(directory)) {
        CHECK_TEXT(written(0.125, 0, text), "0.125");
        CHECK_TEXT(written(0.125, 2, text), "0.12");
        CHECK_TEXT(written(25, 1, text), "20");
        CHECK(read("0.5") == 0.5);
    } else
        test_skip(
            "no locale with a decimal comma can be made: the package locales is not installed");
    setlocale(LC_NUMERIC, "C");
    unsetenv("LOCPATH");
    snprintf(command, sizeof command, "rm -rf '%s'", directory);
    CHECK(!system(command));
}
