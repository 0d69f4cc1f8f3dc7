/* The numbers that are read most often: whole ones of few digits, and single digits four at a time.
 * Leaves to others: all other numbers (number_read), the grammar around them (json_scan).
 * Invariant: a number that is read here has the value that number_read gives it; any other text is
 * left unread. */
#ifndef API_JSON_DIGITS_H
#define API_JSON_DIGITS_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

static inline int api_digit(int c) { return c >= '0' && c <= '9'; }

/**
 * Reads a whole number of at most 14 digits.
 *
 * p    up to `end`; at least one byte.
 * x    out.
 * Returns the end of the number; NULL if the text begins with another number or none, or ends with
 * the number.
 */
static inline const char *api_digits_whole(const char *p, const char *end, double *x) {
    int minus = *p == '-';
    const char *first = p += minus, *last = end - p < 15 ? end : p + 15;
    int64_t whole = 0;
    for (; p < last && api_digit((unsigned char)*p); p++) whole = 10 * whole + (*p - '0');
    /* a 0 may stand alone; that is tested last, since rows of zeros and ones would defeat the
     * processor's prediction of this branch */
    if (p == first || p == last || *p == '.' || (*p | 0x20) == 'e' ||
        (p > first + 1 && *first == '0'))
        return NULL;
    *x = minus ? -(double)whole : (double)whole;
    return p;
}

/**
 * Reads four digits with a comma behind each, the text of a matrix of zeros and ones.
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
    /* now a comma is 0 and a digit is its value; a value above 9 has a high bit, or gets one when 6
     * is added */
    word ^= 0x2c302c302c302c30;
    if ((word | (word + 0x0006000600060006)) & 0xfff0fff0fff0fff0) return 0;
    for (int i = 0; i < 4; i++) x[i] = (double)(int)(word >> 16 * i & 15);
    return 1;
}

#endif
