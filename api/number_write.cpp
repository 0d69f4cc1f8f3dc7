#include "api/number.h"

#include <assert.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <dragonbox/dragonbox.h>

#include "api/number_digits.h"
#include "api/number_powers.h"

using namespace api;

namespace {

/* significand * 10^exponent */
struct decimal {
    uint64_t significand; /* below 10^17 */
    int exponent;
};

/* d1 . d2 d3 ... d17 times 10^exponent */
struct digits17 {
    unsigned first;
    digits16 others;
    int exponent;

    int significant() const { return 1 + others.significant(); }
};

constexpr int DIGITS = 17;
constexpr int PLAIN_LEAST = -5, PLAIN_BEYOND = 16; /* decimal exponents that are written without an exponent */
constexpr double WHOLE_BEYOND = 1e16;              /* whole numbers below this are exact and written as integers */
constexpr int EXPONENT_LEAST = -324, EXPONENT_MOST = 308;
constexpr uint64_t HIDDEN_BIT = (uint64_t)1 << 52, SMALLEST_NORMAL = HIDDEN_BIT, TIE = (uint64_t)1 << 63,
                   TEN_8 = 100000000, TEN_16 = 10000000000000000;

/* 10^0 .. 10^17 */
struct small_powers {
    constexpr small_powers() : value() {
        uint64_t power = 1;
        for (uint64_t &entry : value) {
            entry = power;
            power *= 10;
        }
    }
    constexpr uint64_t operator[](int p) const { return value[p]; }
    uint64_t value[18];
};
constexpr small_powers power10{};

/* "e-324" to "e308": the characters in the low bytes, their number in the highest */
struct exponent_table {
    constexpr exponent_table() : value() {
        for (int e = EXPONENT_LEAST; e <= EXPONENT_MOST; e++) value[e - EXPONENT_LEAST] = text(e);
    }
    constexpr uint64_t operator[](int e) const { return value[e - EXPONENT_LEAST]; }

  private:
    static constexpr uint64_t text(int e) {
        unsigned rest = (unsigned)(e < 0 ? -e : e), count = 1 + (rest > 9) + (rest > 99), bytes = count + 1 + (e < 0);
        uint64_t word = 'e' | (e < 0 ? (uint64_t)'-' << 8 : 0) | (uint64_t)bytes << 56;
        for (unsigned at = bytes; count--; rest /= 10) word |= (uint64_t)('0' + rest % 10) << 8 * --at;
        return word;
    }
    uint64_t value[EXPONENT_MOST - EXPONENT_LEAST + 1];
};
constexpr exponent_table exponents{};

inline void store(char *out, uint64_t bytes) {
#if __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__
    bytes = __builtin_bswap64(bytes);
#endif
    memcpy(out, &bytes, sizeof bytes);
}

/* layout */

/* all has exactly 17 digits */
inline digits17 spread(uint64_t all, int exponent) {
    uint64_t top = all / TEN_8, first = top / TEN_8;
    return {(unsigned)first, digits16(top - TEN_8 * first, all - TEN_8 * top), exponent};
}

/* number of decimal digits, 1 to 17 */
inline int digit_count(uint64_t x) {
    int estimate = (64 - __builtin_clzll(x | 1)) * 1233 >> 12;
    return estimate + (x >= power10[estimate]);
}

inline digits17 spread_any(decimal d) {
    int count = digit_count(d.significand);
    return spread(d.significand * power10[DIGITS - count], d.exponent + count - 1);
}

/* 0.000123 */
inline char *write_small(char *out, const digits17 &d) {
    memcpy(out, "0.000000", 8);
    out += 1 - d.exponent;
    *out = (char)('0' + d.first);
    d.others.store(out + 1);
    return out + d.significant();
}

/* 1.23, 123.4, 1230 */
inline char *write_plain(char *out, const digits17 &d) {
    int count = d.significant(), before = d.exponent + 1;
    out[0] = (char)('0' + d.first);
    d.others.store_with_point(out + 1, d.exponent);
    return out + (count > before ? count + 1 : before);
}

/* 1.23e-45 */
inline char *write_scientific(char *out, const digits17 &d) {
    int count = d.significant();
    uint64_t exponent = exponents[d.exponent];
    out[0] = (char)('0' + d.first);
    out[1] = '.';
    d.others.store(out + 2);
    out += count + (count > 1);
    store(out, exponent);
    return out + (exponent >> 56);
}

inline char *write_digits(char *out, const digits17 &d) {
    if (d.exponent >= 0 && d.exponent < PLAIN_BEYOND) return write_plain(out, d);
    if (d.exponent < 0 && d.exponent >= PLAIN_LEAST) return write_small(out, d);
    return write_scientific(out, d);
}

/* conversion */

/* a positive double as significand * 2^exponent, and its kind */
struct binary {
    uint64_t significand;
    int exponent;
    bool regular; /* normal, and no power of two: its neighbours are equally far away */
};

inline uint64_t bits_of(double x) {
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

inline binary take_apart(uint64_t bits) {
    uint64_t fraction = bits & (HIDDEN_BIT - 1);
    int biased = (int)(bits >> 52);
    if (!biased) return {fraction, -1074, false};
    return {fraction | HIDDEN_BIT, biased - 1075, fraction != 0};
}

/* significand * power to 128 bits, rounded down; the error is below 2 in the last bit */
inline uint128 times(uint64_t significand, uint128 power) {
    unsigned __int128 high = (unsigned __int128)significand * power.high;
    unsigned __int128 sum = high + (uint64_t)((unsigned __int128)significand * power.low >> 64);
    return {(uint64_t)(sum >> 64), (uint64_t)sum};
}

/* true where a and b are too close to say which is greater */
inline bool unclear(uint64_t a, uint64_t b) { return a - b + 3 <= 6; }

/*
 * The shortest decimal in the interval of the numbers that read back to the double, scaled so that the interval is 1 to
 * 10 units wide: a multiple of 10 units if one is in it (then it is the only one), else the nearest whole number. One
 * multiplication with a truncated power decides, unless a comparison is within its error; those cases, powers of two
 * and subnormal numbers go to the library.
 */
inline bool shortest_fast(double x, decimal &d) {
    binary b = take_apart(bits_of(x));
    int k = log10_of_power2(b.exponent);
    uint128 power = powers_of_ten[-k];
    int shift = b.exponent + power_exponent(-k) + 128; /* 1 .. 4 */
    uint128 scaled = times(b.significand << shift, power);
    uint64_t units = scaled.high % 10, fraction = scaled.low;
    /* in 2^-60: distance to the multiples of 10 below and above, half the interval */
    uint64_t below = units << 60 | fraction >> 4, above = ((uint64_t)10 << 60) - below,
             half = power.high >> (5 - shift);
    if (!b.regular || unclear(below, half) || unclear(above, half) || unclear(fraction, TIE)) return false;
    uint64_t nearest = scaled.high + (fraction >> 63);
    if (below < half) nearest = scaled.high - units;
    if (above < half) nearest = scaled.high - units + 10;
    d = {nearest, k};
    return true;
}

decimal shortest_library(double x) {
    using namespace jkj::dragonbox;
    auto d = to_decimal(x, policy::sign::ignore, policy::trailing_zero::ignore);
    return {d.significand, d.exponent};
}

/* the digits of what shortest_fast found: 16 or 17 */
inline digits17 spread_found(decimal d) {
    uint64_t sixteen = d.significand < TEN_16;
    return spread(d.significand + (9 * d.significand & -sixteen), d.exponent + 16 - (int)sixteen);
}

/* rounded by the C library, exactly: for ties that the product cannot prove */
decimal rounded_library(double x, int digits) {
    char text[40];
    uint64_t significand = 0;
    snprintf(text, sizeof text, "%.*e", digits - 1, x);
    const char *p = text;
    for (; *p != 'e'; p++)
        if (*p >= '0' && *p <= '9') significand = 10 * significand + (uint64_t)(*p - '0');
    return {significand, (int)strtol(p + 1, nullptr, 10) - (digits - 1)};
}

/* floor(log10 x) of a normal number */
inline int decimal_exponent(uint64_t bits) {
    int estimate = log10_of_power2((int)(bits >> 52) - 1023);
    return estimate + (estimate < EXPONENT_MOST && bits >= thresholds[estimate + 1]);
}

/*
 * A normal number rounded to `digits` digits; a carry may make them 10^digits. False where it cannot be proved which
 * way to round.
 */
inline bool rounded_fast(double x, int digits, decimal &d) {
    uint64_t bits = bits_of(x), significand = take_apart(bits).significand << 11;
    if (bits < SMALLEST_NORMAL) return false;
    d.exponent = decimal_exponent(bits) - (digits - 1);
    int p = -d.exponent;
    uint128 power = powers_of_ten[p], scaled = times(significand, power);
    /* the point is this far up in scaled.high, 1 .. 63 */
    int shift = -(take_apart(bits).exponent - 11 + power_exponent(p)) - 128;
    uint64_t units = scaled.high >> shift, fraction = scaled.high << (64 - shift) | scaled.low >> shift;
    d.significand = units + (fraction > TIE);
    if (!unclear(fraction, TIE)) return true;
    bool exact = p >= 0 && p <= POWER_EXACT_MOST && !(scaled.low << (64 - shift)) && significand * power.low == 0;
    d.significand = units + (units & 1);
    return exact && fraction == TIE;
}

/* ways that are seldom taken */

#define SELDOM __attribute__((noinline, cold))

SELDOM char *write_zero(char *out, double x) {
    memcpy(out, "-0.0", 4);
    if (signbit(x)) return out + 4;
    *out = '0';
    return out + 1;
}

SELDOM char *write_shortest_library(char *out, double x) { return write_digits(out, spread_any(shortest_library(x))); }

/* number of digits of the shortest decimal, x > 0 */
int shortest_digits(double x) { return spread_any(shortest_library(x)).significant(); }

SELDOM char *write_rounded_library(char *out, double x, int digits) {
    if (shortest_digits(x) <= digits) return write_shortest_library(out, x);
    return write_digits(out, spread_any(rounded_library(x, digits)));
}

inline bool whole(double x) { return x < WHOLE_BEYOND && (double)(int64_t)x == x; }

/* x > 0 */
inline char *write_shortest(char *out, double x) {
    decimal d;
    if (whole(x)) return write_plain(out, spread_any({(uint64_t)(int64_t)x, 0}));
    if (!shortest_fast(x, d)) return write_shortest_library(out, x);
    return write_digits(out, spread_found(d));
}

} // namespace

extern "C" char *api_number_write(char *out, double x) {
    assert(isfinite(x));
    if (x == 0) return write_zero(out, x);
    *out = '-';
    return write_shortest(out + signbit(x), fabs(x));
}

extern "C" char *api_number_write_digits(char *out, double x, int digits) {
    assert(isfinite(x) && digits >= 1 && digits <= DIGITS);
    double magnitude = fabs(x);
    decimal d;
    if (x == 0) return write_zero(out, x);
    *out = '-';
    out += signbit(x);
    if (digits == DIGITS) return write_shortest(out, magnitude);
    /* with 15 digits or less the shortest decimal, where it is no longer, comes out by rounding */
    if (digits > 15 || !rounded_fast(magnitude, digits, d) || d.significand == power10[digits])
        return write_rounded_library(out, magnitude, digits);
    return write_digits(out, spread(d.significand * power10[DIGITS - digits], d.exponent + digits - 1));
}

extern "C" char *api_number_write_int(char *out, long long i) {
    char text[20];
    size_t at = sizeof text;
    unsigned long long rest = i < 0 ? 0 - (unsigned long long)i : (unsigned long long)i;
    do text[--at] = (char)('0' + rest % 10);
    while (rest /= 10);
    if (i < 0) *out++ = '-';
    memcpy(out, text + at, sizeof text - at);
    return out + sizeof text - at;
}
