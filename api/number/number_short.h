/* Short numbers: at most eight digits, 1e-5 <= |x| < 1e7. Each step runs for sixteen numbers before
 * the next step, because the steps of one number depend on each other and would not overlap.
 * Leaves to others: all other numbers, the characters between them (number_write).
 * Invariant: the text equals that of api_number_write_digits, byte for byte. C++17. */
#pragma once

#include <math.h>
#include <stdint.h>
#include <string.h>

#include "api/number/number_digits.h"
#include "api/number/number_powers.h"

namespace api {

/* The range of exponents in plain form, and the distance to a tie below which rounding in doubles
 * is not conclusive. */
constexpr int SHORT_DIGITS = 8, SHORT_LEAST = -5, SHORT_MOST = 6; /* decimal exponents of short
                                                                   * numbers */
constexpr int SHORT_BINARY = -17, SHORT_BINARIES = 41;            /* 2^-17 < 1e-5, 2^24 > 1e7 */
constexpr double SHORT_NEAR_TIE = 1e-7;

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

inline void store(char *out, uint64_t bytes) {
#if __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__
    bytes = __builtin_bswap64(bytes);
#endif
    memcpy(out, &bytes, sizeof bytes);
}

inline uint64_t bits_of(double x) {
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

/* for every binary exponent of a short number: the least number with one decimal digit more than
 * 2^exponent, as bits, and the decimal exponent of numbers below it */
struct short_exponents {
    constexpr short_exponents() : threshold(), exponent() {
        for (int i = 0; i < SHORT_BINARIES; i++) {
            exponent[i] = log10_of_power2(SHORT_BINARY + i);
            threshold[i] = thresholds[exponent[i] + 1];
        }
    }
    uint64_t threshold[SHORT_BINARIES];
    int exponent[SHORT_BINARIES];
};
constexpr short_exponents short_binaries{};

/* 10^p for p = digits - 1 - exponent >= -7; exact for p >= 0; smaller p are not used */
constexpr int SHORT_TENS_LEAST = -7;
constexpr double short_tens[] = {1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 1,    1e1,  1e2, 1e3,
                                 1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11, 1e12, 1e13};

/* the layout of a number with a given decimal exponent */
struct short_layout {
    uint64_t stay, move; /* masks of the bytes before and after the point */
    uint64_t point;
    int start;  /* mask of the digits after "0.000" */
    int before; /* digits before the point; 8 = the point is not among the digits */
    int least;  /* least number of characters, filled with zeros */
};

struct short_layouts {
    constexpr short_layouts() : value() {
        for (int e = SHORT_LEAST; e <= SHORT_MOST; e++) {
            short_layout &layout = value[e - SHORT_LEAST];
            if (e < 0)
                layout = {~(uint64_t)0, 0, 0, 1 - e, 8, 0};
            else
                layout = {
                    before(e + 1), ~before(e + 1) << 8, (uint64_t)'.' << 8 * (e + 1), 0, e + 1,
                    e + 1};
        }
    }
    static constexpr uint64_t before(int bytes) { return ((uint64_t)1 << 8 * bytes) - 1; }
    short_layout value[SHORT_MOST - SHORT_LEAST + 1];
};
constexpr short_layouts short_layouts_at{};

/*
 * Converts several short numbers at once.
 *
 * COUNT            how many numbers are converted at a time;
 * short_batch(digits)  constructs a converter to 1 to SHORT_DIGITS digits;
 * take(x)          converts x[0] .. x[COUNT - 1]; returns false if one of them has another size
 *                  (zero included), or rounding it needs more precision than a double has;
 * write(out, x, i) writes the text of x[i] after take(x) and returns its end; API_NUMBER_BYTES
 *                  bytes of out are writable.
 */
class short_batch {
  public:
    static constexpr int COUNT = 16;
    explicit short_batch(int wanted) : digits(wanted) {}

    bool take(const double x[]) { return scale(x) && round(); }

    /* without a branch on a number's size or digits, which could not be predicted */
    char *write(char *out, const double x[], int i) const {
        const short_layout &layout = short_layouts_at.value[exponent[i]];
        int count = 8 - (__builtin_clzll(text[i]) >> 3);
        uint64_t spelt = text[i] | 0x3030303030303030;
        *out = '-';
        out += signbit(x[i]);
        memcpy(out, "0.000000", 8);
        out += layout.start;
        store(out, (spelt & layout.stay) | layout.point | (spelt << 8 & layout.move));
        out[8] = (char)(spelt >> 56);
        count += count > layout.before;
        return out + (count > layout.least ? count : layout.least);
    }

  private:
    int digits;
    double scaled[COUNT]; /* the number scaled to `digits` digits before the point; below 10^8, with
                           * an error of less than 10^-8 */
    int exponent[COUNT];  /* decimal exponents, minus SHORT_LEAST */
    uint64_t text[COUNT]; /* eight digits, one per byte, the first in the lowest byte */

    bool scale(const double x[]) {
        const double *power = short_tens + (digits - 1 - SHORT_LEAST - SHORT_TENS_LEAST);
        unsigned most =
                     (unsigned)((digits - 1 < SHORT_MOST ? digits - 1 : SHORT_MOST) - SHORT_LEAST),
                 wrong = 0;
        for (int i = 0; i < COUNT; i++) {
            uint64_t bits = bits_of(fabs(x[i])), binary = (bits >> 52) - (1023 + SHORT_BINARY);
            wrong |= binary >= SHORT_BINARIES;
            binary = binary >= SHORT_BINARIES ? 0 : binary;
            exponent[i] = short_binaries.exponent[binary] - SHORT_LEAST +
                          (bits >= short_binaries.threshold[binary]);
            wrong |= (unsigned)exponent[i] > most;
            scaled[i] = fabs(x[i]) * power[-exponent[i]];
        }
        return !wrong;
    }

    /* returns false if a number is too close to a tie, or is rounded up to one more digit */
    bool round() {
        int32_t tail = (int32_t)power10[SHORT_DIGITS - digits], units[COUNT], greatest = 0;
        double nearest = 1;
        for (int i = 0; i < COUNT; i++) {
            int32_t below = (int32_t)scaled[i];
            double above_tie = scaled[i] - below - 0.5, distance = fabs(above_tie);
            nearest = distance < nearest ? distance : nearest;
            units[i] = below + (above_tie > 0);
            greatest = units[i] > greatest ? units[i] : greatest;
            units[i] *= tail;
        }
        for (int i = 0; i < COUNT; i += 2)
            digits16((uint64_t)units[i], (uint64_t)units[i + 1]).values(text + i);
        return nearest >= SHORT_NEAR_TIE && (uint64_t)greatest < power10[digits];
    }
};

} // namespace api
