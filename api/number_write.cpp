#include "api/number.h"

#include <cassert>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include <dragonbox/dragonbox.h>

namespace {

/* x = significand * 10^exponent */
struct decimal {
    uint64_t significand;
    int exponent;
};

/* d1 . d2 d3 ... d17 times 10^exponent: 17 digits, one a byte, the earlier digits in the lower bytes */
struct digits17 {
    unsigned first;
    uint64_t high, low; /* d2 .. d9 and d10 .. d17, values 0 .. 9 */
    int exponent;
};

constexpr int DIGITS = 17;
constexpr int PLAIN_LEAST = -5, PLAIN_BEYOND = 16; /* decimal exponents that are written without an exponent */
constexpr uint64_t ASCII_ZEROS = 0x3030303030303030;

constexpr uint64_t power10[] = {1,
                                10,
                                100,
                                1000,
                                10000,
                                100000,
                                1000000,
                                10000000,
                                100000000,
                                1000000000,
                                10000000000,
                                100000000000,
                                1000000000000,
                                10000000000000,
                                100000000000000,
                                1000000000000000,
                                10000000000000000,
                                100000000000000000};

void store(char *out, uint64_t bytes) {
#if __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__
    bytes = __builtin_bswap64(bytes);
#endif
    memcpy(out, &bytes, sizeof bytes);
}

/* number of decimal digits, 1 to 17 */
int digit_count(uint64_t x) {
    int estimate = (64 - __builtin_clzll(x | 1)) * 1233 >> 12;
    return estimate + (x >= power10[estimate]);
}

/* the 8 digits of x < 10^8, first digit in the lowest byte: halves, then quarters, then digits, all at once */
uint64_t eight_digits(uint64_t x) {
    uint64_t four = x / 10000, halves = four | (x - 10000 * four) << 32;
    uint64_t hundreds = (halves * 10486 >> 20) & 0x0000007f0000007f;
    uint64_t quarters = hundreds | (halves - 100 * hundreds) << 16;
    uint64_t tens = (quarters * 103 >> 10) & 0x000f000f000f000f;
    return tens | (quarters - 10 * tens) << 8;
}

digits17 spread(decimal d) {
    int count = digit_count(d.significand);
    uint64_t all = d.significand * power10[DIGITS - count];
    uint64_t top = all / 100000000, first = top / 100000000;
    return {(unsigned)first, eight_digits(top - 100000000 * first), eight_digits(all - 100000000 * top),
            d.exponent + count - 1};
}

/* digits up to the last that is not 0 */
int significant(const digits17 &d) {
    if (d.low) return 17 - __builtin_clzll(d.low) / 8;
    return d.high ? 9 - __builtin_clzll(d.high) / 8 : 1;
}

/* 0.000123 */
char *write_small(char *out, const digits17 &d) {
    store(out, 0x3030303030302e30); /* "0.000000" */
    out += 1 - d.exponent;
    *out = (char)('0' + d.first);
    store(out + 1, d.high | ASCII_ZEROS);
    store(out + 9, d.low | ASCII_ZEROS);
    return out + significant(d);
}

/* 1.23, 123.4, 1230: the digits behind the point are the same ones one byte further on */
char *write_plain(char *out, const digits17 &d) {
    uint64_t high = d.high | ASCII_ZEROS, low = d.low | ASCII_ZEROS;
    uint64_t high_on = high << 8, low_on = low << 8 | high >> 56;
    int count = significant(d), point = d.exponent; /* digits before the point, besides the first */
    out[0] = (char)('0' + d.first);
    out[17] = (char)(low >> 56);
    if (point < 8) {
        uint64_t before = ((uint64_t)1 << 8 * point) - 1, dot = (uint64_t)'.' << 8 * point;
        store(out + 1, (high & before) | dot | (high_on & ~before & ~((uint64_t)0xff << 8 * point)));
        store(out + 9, low_on);
    } else {
        int p = point - 8;
        uint64_t before = p < 8 ? ((uint64_t)1 << 8 * p) - 1 : ~(uint64_t)0, dot = p < 8 ? (uint64_t)'.' << 8 * p : 0;
        uint64_t at = p < 8 ? (uint64_t)0xff << 8 * p : 0;
        store(out + 1, high);
        store(out + 9, (low & before) | dot | (low_on & ~before & ~at));
    }
    return out + (count > point + 1 ? count + 1 : point + 1);
}

/* 1.23e-45 */
char *write_exponent(char *out, const digits17 &d) {
    int count = significant(d), exponent = d.exponent;
    out[0] = (char)('0' + d.first);
    out[1] = '.';
    store(out + 2, d.high | ASCII_ZEROS);
    store(out + 10, d.low | ASCII_ZEROS);
    out += count > 1 ? count + 1 : 1;
    *out++ = 'e';
    if (exponent < 0) *out++ = '-';
    return api_number_write_int(out, exponent < 0 ? -exponent : exponent);
}

char *write_decimal(char *out, decimal d) {
    digits17 digits = spread(d);
    if (digits.exponent >= 0 && digits.exponent < PLAIN_BEYOND) return write_plain(out, digits);
    if (digits.exponent < 0 && digits.exponent >= PLAIN_LEAST) return write_small(out, digits);
    return write_exponent(out, digits);
}

decimal shortest(double x) {
    using namespace jkj::dragonbox;
    auto d = to_decimal(x, policy::sign::ignore, policy::trailing_zero::ignore);
    return {d.significand, d.exponent};
}

/* rounded by the C library, exactly: the slow way */
decimal rounded(double x, int digits) {
    char text[40];
    uint64_t significand = 0;
    snprintf(text, sizeof text, "%.*e", digits - 1, x);
    const char *p = text;
    for (; *p && *p != 'e'; p++)
        if (*p >= '0' && *p <= '9') significand = 10 * significand + (uint64_t)(*p - '0');
    return {significand, (int)strtol(p + 1, nullptr, 10) - (digits - 1)};
}

char *write_zero(char *out, double x) {
    memcpy(out, "-0.0", 4);
    if (std::signbit(x)) return out + 4;
    *out = '0';
    return out + 1;
}

} // namespace

extern "C" char *api_number_write(char *out, double x) {
    assert(std::isfinite(x));
    if (x == 0) return write_zero(out, x);
    *out = '-';
    out += std::signbit(x);
    return write_decimal(out, shortest(x));
}

extern "C" char *api_number_write_digits(char *out, double x, int digits) {
    assert(std::isfinite(x) && digits >= 1 && digits <= DIGITS);
    if (x == 0) return write_zero(out, x);
    *out = '-';
    out += std::signbit(x);
    return write_decimal(out, rounded(std::fabs(x), digits));
}

extern "C" char *api_number_write_int(char *out, long long i) {
    char text[20];
    int at = sizeof text;
    unsigned long long rest = i < 0 ? 0 - (unsigned long long)i : (unsigned long long)i;
    do text[--at] = (char)('0' + rest % 10);
    while (rest /= 10);
    if (i < 0) *out++ = '-';
    memcpy(out, text + at, sizeof text - at);
    return out + sizeof text - at;
}
