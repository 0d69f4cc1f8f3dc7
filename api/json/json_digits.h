/* Numbers that are mostly read: whole ones of few digits, and single digits four at a time.
 * Leaves to others: all other numbers (number_read), the grammar around them (json_scan).
 * Invariant: what is read here is what any reader of JSON makes of it; all else is left alone. */
#ifndef API_JSON_DIGITS_H
#define API_JSON_DIGITS_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

static inline int api_digit(int c) { return c >= '0' && c <= '9'; }

/**
 * Reads a whole number of at most 14 digits.
 *
 * p    up to `end`; there is at least one byte.
 * x    out.
 * Returns the end of the number, or NULL where it is another or none, or where the text ends with
 * it.
 */
static inline const char *api_digits_whole(const char *p, const char *end, double *x) {
    int minus = *p == '-';
    const char *first = p += minus, *last = end - p < 15 ? end : p + 15;
    int64_t whole = 0;
    for (; p < last && api_digit((unsigned char)*p); p++) whole = 10 * whole + (*p - '0');
    /* a digit alone may be 0: that is asked last, since rows of zeros and ones would mislead the
     * processor */
    if (p == first || p == last || *p == '.' || (*p | 0x20) == 'e' ||
        (p > first + 1 && *first == '0'))
        return NULL;
    *x = minus ? -(double)whole : (double)whole;
    return p;
}

/**
 * Reads four digits with a comma behind each, as a matrix of zeros and ones has them.
 *
 * p  eight bytes.
 * x  out.
 * Returns 0 where it is anything else; then x is untouched.
 */
static inline int api_digits_four(const char *p, double x[4]) {
    uint64_t word;
    memcpy(&word, p, sizeof word);
#if __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__
    word = __builtin_bswap64(word);
#endif
    /* now a comma is 0 and a digit its value; what is more than 9 has a high bit, or gets one
     * when 6 is added */
    word ^= 0x2c302c302c302c30;
    if ((word | (word + 0x0006000600060006)) & 0xfff0fff0fff0fff0) return 0;
    for (int i = 0; i < 4; i++) x[i] = (double)(int)(word >> 16 * i & 15);
    return 1;
}

#endif
