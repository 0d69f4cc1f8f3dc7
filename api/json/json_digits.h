/* Fast paths for the most frequent numbers: short integers, and four single digits at once.
 * Leaves to others: all other numbers (number_read), the grammar around them (json_scan).
 * Invariant: the value equals that of number_read; other text is not consumed. */
#pragma once

#include <stddef.h>
#include <stdint.h>
#include <string.h>

static inline int api_digit(int c) { return c >= '0' && c <= '9'; }

/**
 * Reads a whole number of at most 14 digits.
 *
 * p    the text, up to `end`; at least one byte.
 * x    out.
 * Returns the end of the number. Returns NULL if the text begins with anything else, or ends with
 * the number.
 */
static inline const char *api_digits_whole(const char *p, const char *end, double *x) {
    int minus = *p == '-';
    const char *first = p += minus, *last = end - p < 15 ? end : p + 15;
    int64_t whole = 0;
    for (; p < last && api_digit((unsigned char)*p); p++) whole = 10 * whole + (*p - '0');
    /* A single 0 is valid. This is tested last, because rows of zeros and ones would defeat branch
     * prediction. */
    if (p == first || p == last || *p == '.' || (*p | 0x20) == 'e' ||
        (p > first + 1 && *first == '0'))
        return NULL;
    *x = minus ? -(double)whole : (double)whole;
    return p;
}

/**
 * Reads four digits, each followed by a comma, as in a matrix of zeros and ones.
 *
 * p  eight bytes.
 * x  out.
 * Returns 0 if the bytes are anything else; then x is unchanged.
 */
static inline int api_digits_four(const char *p, double x[4]) {
    uint64_t word;
    memcpy(&word, p, sizeof word);
#if __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__
    word = __builtin_bswap64(word);
#endif
    /* Now commas are 0 and digits are their value. A byte above 9 has a high bit, or gets one when
     * 6 is added. */
    word ^= 0x2c302c302c302c30;
    if ((word | (word + 0x0006000600060006)) & 0xfff0fff0fff0fff0) return 0;
    for (int i = 0; i < 4; i++) x[i] = (double)(int)(word >> 16 * i & 15);
    return 1;
}
