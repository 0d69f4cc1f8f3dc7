#include "api/number/number.h"

#include <assert.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <dragonbox/dragonbox.h>

#include "api/number/number_digits.h"
#include "api/number/number_powers.h"
#include "api/number/number_short.h"

using namespace api;

namespace {

struct decimal {
    uint64_t significand; /* below 10^17 */
    int exponent;
};

/* d1.d2d3...d17 times 10^exponent; the first 16 digits as one number, then the last digit */
struct decimal17 {
    uint64_t front;
    unsigned last;
    int exponent;
};

/* a decimal17 whose digits are characters */
struct digits17 {
    digits16 front; /* d1 to d16 */
    unsigned last;  /* d17 */
    int exponent;

    int significant() const { return front.significant(last); }
};

constexpr int DIGITS = 17;
constexpr int PLAIN_LEAST = -5,
              PLAIN_BEYOND = 16; /* decimal exponents from which on an exponent is written */
constexpr double WHOLE_BEYOND =
    1e16; /* whole numbers below this are exact and written as integers */
constexpr int EXPONENT_LEAST = -324, EXPONENT_MOST = 308;
constexpr uint64_t HIDDEN_BIT = (uint64_t)1 << 52, SMALLEST_NORMAL = HIDDEN_BIT,
                   TIE = (uint64_t)1 << 63, TEN_8 = 100000000, TEN_15 = 1000000000000000;

/* "e-324" to "e308": the characters in the low bytes, their number in the highest byte */
struct exponent_table {
    constexpr exponent_table() : value() {
        for (int e = EXPONENT_LEAST; e <= EXPONENT_MOST; e++) value[e - EXPONENT_LEAST] = text(e);
    }
    constexpr uint64_t operator[](int e) const { return value[e - EXPONENT_LEAST]; }

  private:
    static constexpr uint64_t text(int e) {
        unsigned rest = (unsigned)(e < 0 ? -e : e), count = 1 + (rest > 9) + (rest > 99),
                 bytes = count + 1 + (e < 0);
        uint64_t word = 'e' | (e < 0 ? (uint64_t)'-' << 8 : 0) | (uint64_t)bytes << 56;
        for (unsigned at = bytes; count--; rest /= 10)
            word |= (uint64_t)('0' + rest % 10) << 8 * --at;
        return word;
    }
    uint64_t value[EXPONENT_MOST - EXPONENT_LEAST + 1];
};
constexpr exponent_table exponents{};

/* ---- layout */

inline digits17 spread(const decimal17 &d) {
    uint64_t high = d.front / TEN_8;
    return {digits16(high, d.front - TEN_8 * high), d.last, d.exponent};
}

/* number of decimal digits, 1 to 17 */
inline int digit_count(uint64_t x) {
    int estimate = (64 - __builtin_clzll(x | 1)) * 1233 >> 12;
    return estimate + (x >= power10[estimate]);
}

inline digits17 spread_any(decimal d) {
    int count = digit_count(d.significand);
    uint64_t all = d.significand * power10[DIGITS - count];
    return spread({all / 10, (unsigned)(all % 10), d.exponent + count - 1});
}

/* 0.000123 */
inline char *write_small(char *out, const digits17 &d) {
    memcpy(out, "0.000000", 8);
    out += 1 - d.exponent;
    d.front.store(out);
    out[16] = (char)('0' + d.last);
    return out + d.significant();
}

/* 1.23, 123.4, 1230 */
inline char *write_plain(char *out, const digits17 &d) {
    int count = d.significant(), before = d.exponent + 1;
    d.front.store_with_point(out, before);
    out[17] = (char)('0' + d.last);
    return out + (count > before ? count + 1 : before);
}

/* 1.23e-45 */
inline char *write_scientific(char *out, const digits17 &d) {
    int count = d.significant();
    uint64_t exponent = exponents[d.exponent];
    d.front.store_with_point(out, 1);
    out[17] = (char)('0' + d.last);
    out += count + (count > 1);
    store(out, exponent);
    return out + (exponent >> 56);
}

inline char *write_digits(char *out, const digits17 &d) {
    if (d.exponent >= 0 && d.exponent < PLAIN_BEYOND) return write_plain(out, d);
    if (d.exponent < 0 && d.exponent >= PLAIN_LEAST) return write_small(out, d);
    return write_scientific(out, d);
}

/* ---- conversion */

/* a normal number is mantissa * 2^exponent */
inline uint64_t mantissa_of(uint64_t bits) { return (bits & (HIDDEN_BIT - 1)) | HIDDEN_BIT; }
inline int exponent_of(uint64_t bits) { return (int)(bits >> 52) - 1075; }

/* significand * power to 128 bits, rounded down; the error is below 2 in the last bit */
inline uint128 times(uint64_t significand, uint128 power) {
    unsigned __int128 high = (unsigned __int128)significand * power.high;
    unsigned __int128 sum = high + (uint64_t)((unsigned __int128)significand * power.low >> 64);
    return {(uint64_t)(sum >> 64), (uint64_t)sum};
}

/* true if the sign of a difference is uncertain */
inline bool unclear(int64_t difference) { return (uint64_t)difference + 3 <= 6; }

/* The shortest decimal in the interval of reals that round to the double. The interval is scaled to
 * a width of 1 to 10 units; the result is the multiple of 10 units in it (there is at most one),
 * else the nearest integer. One multiplication with a truncated power of ten decides. Returns false
 * if a comparison is within its error, and for zero, subnormal numbers and powers of two. */
inline bool shortest_fast(uint64_t bits, decimal17 &d) {
    int exponent = exponent_of(bits), k = log10_of_power2(exponent);
    uint128 power = powers_of_ten[-k];
    int shift = exponent + power_exponent(-k) + 128; /* 1 .. 4 */
    uint128 scaled = times(mantissa_of(bits) << shift, power);
    uint64_t tens = scaled.high / 10, units = scaled.high - 10 * tens, fraction = scaled.low;
    /* in units of 2^-59: the distances to the multiples of 10 below and above */
    int64_t below = (int64_t)(units << 59 | fraction >> 5), above = ((int64_t)10 << 59) - below;
    int64_t half = (int64_t)(power.high >> (6 - shift));
    if (mantissa_of(bits) == HIDDEN_BIT || bits < SMALLEST_NORMAL) return false;
    if (unclear(below - half) || unclear(above - half) || unclear((int64_t)(fraction - TIE)))
        return false;
    /* all ones if a multiple of 10 is inside the interval; without a branch, which could not be
     * predicted */
    uint64_t inside = (uint64_t)(((below < above ? below : above) - half) >> 63),
             up = (uint64_t)(above < half);
    uint64_t last = (units + (fraction >> 63)) & ~inside, front = tens + up;
    /* whether there are 16 digits or 17 */
    uint64_t sixteen = front < TEN_15;
    front += (9 * front + last) & -sixteen;
    d = {front, (unsigned)(last & (sixteen - 1)), k + 16 - (int)sixteen};
    return true;
}

decimal shortest_library(double x) {
    using namespace jkj::dragonbox;
    auto d = to_decimal(x, policy::sign::ignore, policy::trailing_zero::ignore);
    return {d.significand, d.exponent};
}

/* rounded exactly by the C library, for ties that the product cannot decide */
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

/* A normal number rounded to `digits` digits; a carry may give 10^digits. Returns false if the
 * direction of rounding cannot be proved. */
inline bool rounded_fast(double x, int digits, decimal &d) {
    uint64_t bits = bits_of(x), significand = mantissa_of(bits) << 11;
    if (bits < SMALLEST_NORMAL) return false;
    d.exponent = decimal_exponent(bits) - (digits - 1);
    int p = -d.exponent;
    uint128 power = powers_of_ten[p], scaled = times(significand, power);
    /* bit of scaled.high at which the point is, 1 .. 63 */
    int shift = -(exponent_of(bits) - 11 + power_exponent(p)) - 128;
    uint64_t units = scaled.high >> shift,
             fraction = scaled.high << (64 - shift) | scaled.low >> shift;
    d.significand = units + (fraction > TIE);
    if (!unclear((int64_t)(fraction - TIE))) return true;
    bool exact = p >= 0 && p <= POWER_EXACT_MOST && !(scaled.low << (64 - shift)) &&
                 significand * power.low == 0;
    d.significand = units + (units & 1);
    return exact && fraction == TIE;
}

/* for slow paths */

#define SELDOM __attribute__((noinline, cold))

inline bool whole(double x) { return x < WHOLE_BEYOND && (double)(int64_t)x == x; }

/* The numbers that shortest_fast refuses. The caller has written the sign, except that of zero:
 * -0.0 keeps its fraction, because some parsers read -0 as an integer and drop the sign. */
SELDOM char *write_shortest_library(char *out, double x) {
    double magnitude = fabs(x);
    memcpy(out, "0.0", 3);
    if (x == 0) return out + (signbit(x) ? 3 : 1);
    if (whole(magnitude)) return write_plain(out, spread_any({(uint64_t)(int64_t)magnitude, 0}));
    return write_digits(out, spread_any(shortest_library(magnitude)));
}

int shortest_digits(double x) {
    return x == 0 ? 1 : spread_any(shortest_library(fabs(x))).significant();
}

SELDOM char *write_rounded_library(char *out, double x, int digits) {
    if (shortest_digits(x) <= digits) return write_shortest_library(out, x);
    return write_digits(out, spread_any(rounded_library(fabs(x), digits)));
}

/* writes the sign; the next byte overwrites it if x is positive */
inline char *write_sign(char *out, double x) {
    *out = '-';
    return out + signbit(x);
}

} // namespace

namespace {

inline char *write_shortest(char *out, double x) {
    assert(isfinite(x));
    decimal17 d;
    out = write_sign(out, x);
    return shortest_fast(bits_of(fabs(x)), d) ? write_digits(out, spread(d))
                                              : write_shortest_library(out, x);
}

/* truncates, where rounding up would exceed the largest double, which could not be read back */
__attribute__((noinline, cold)) double cut_greatest(double x, int digits) {
    uint64_t unit = power10[DIGITS - digits], greatest = UINT64_C(17976931348623157) / unit * unit;
    double cut = static_cast<double>(greatest) * 1e292;
    return fabs(x) > cut ? copysign(cut, x) : x;
}

} // namespace

extern "C" char *api_number_write(char *out, double x) { return write_shortest(out, x); }

extern "C" char *api_number_write_digits(char *out, double x, int digits) {
    assert(isfinite(x) && digits >= 1 && digits <= DIGITS);
    decimal d;
    if (digits == DIGITS) return api_number_write(out, x);
    if (fabs(x) >= 1.5e308) x = cut_greatest(x, digits);
    out = write_sign(out, x);
    /* with at most 15 digits, rounding gives the shortest decimal if that has so few digits */
    if (digits > 15 || !rounded_fast(fabs(x), digits, d) || d.significand == power10[digits])
        return write_rounded_library(out, x, digits);
    return write_digits(out,
                        spread({d.significand * power10[16 - digits], 0, d.exponent + digits - 1}));
}

namespace {

/* the separators of rows, and the position in the current row; copied, because the output might
 * alias them */
class row_writer {
  public:
    explicit row_writer(const struct api_number_rows &rows)
        : k(0), width(rows.width), open(rows.open) {
        memcpy(close, rows.close, sizeof close);
        close_bytes = rows.close_bytes;
    }
    char *begin(char *out) const {
        *out = open;
        return out + (open && !k);
    }
    char *end(char *out) {
        *out++ = ',';
        if (++k < width) return out;
        k = 0;
        memcpy(out - 1, close, sizeof close);
        return out - 1 + close_bytes;
    }

  private:
    long k, width;
    char open, close[3];
    int close_bytes;
};

/* two functions, each small enough for the registers */

__attribute__((noinline)) char *rows_shortest(char *out, const struct api_number_rows &rows) {
    const double *x = rows.value;
    for (long i = 0; i < rows.rows; i++) {
        *out = rows.open;
        out += rows.open != 0;
        for (const double *end = x + rows.width; x < end; x++) {
            out = write_shortest(out, *x);
            *out++ = ',';
        }
        memcpy(out - 1, rows.close, sizeof rows.close);
        out += rows.close_bytes - 1;
    }
    return out;
}

__attribute__((noinline)) char *rows_rounded(char *out, const struct api_number_rows &rows) {
    const double *x = rows.value, *end = x + rows.rows * rows.width;
    row_writer writer(rows);
    short_batch numbers(rows.digits < SHORT_DIGITS ? rows.digits : SHORT_DIGITS);
    for (long count; x < end; x += count) {
        count = end - x < numbers.COUNT ? end - x : numbers.COUNT;
        bool brief = rows.digits <= SHORT_DIGITS && count == numbers.COUNT && numbers.take(x);
        for (int i = 0; brief && i < numbers.COUNT; i++)
            out = writer.end(numbers.write(writer.begin(out), x, i));
        for (int i = 0; !brief && i < count; i++)
            out = writer.end(api_number_write_digits(writer.begin(out), x[i], rows.digits));
    }
    return out;
}

} // namespace

extern "C" char *api_number_write_rows(char *out, const struct api_number_rows *rows) {
    return rows->digits ? rows_rounded(out, *rows) : rows_shortest(out, *rows);
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
