/* Numbers as little-endian bytes, whatever the processor's own order is.
 * Leaves to others: the meaning of the numbers (encode_octets, encode_npz, encode_mat).
 * Invariant: on a little-endian processor every function is a memcpy. */
#pragma once

#include <stddef.h>
#include <stdint.h>
#include <string.h>

/** Writes the low `bytes` bytes of x, the lowest first. Returns the end. */
static inline char *api_octets_whole(char *at, uint64_t x, int bytes) {
    for (int i = 0; i < bytes; i++, x >>= 8) *at++ = (char)(x & 0xff);
    return at;
}

/** Writes a double, IEEE 754 binary64. Returns the end. */
static inline char *api_octets_double(char *at, double x) {
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
#if __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__
    bits = __builtin_bswap64(bits);
#endif
    memcpy(at, &bits, sizeof bits);
    return at + sizeof bits;
}

/** Writes a double rounded to a float, IEEE 754 binary32. Returns the end. */
static inline char *api_octets_float(char *at, double x) {
    float narrow = (float)x;
    uint32_t bits;
    memcpy(&bits, &narrow, sizeof bits);
    return api_octets_whole(at, bits, 4);
}

/** Writes `count` doubles. Returns the end. */
static inline char *api_octets_doubles(char *at, size_t count, const double x[]) {
#if __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__
    memcpy(at, x, count * sizeof *x);
    return at + count * sizeof *x;
#else
    for (size_t i = 0; i < count; i++) at = api_octets_double(at, x[i]);
    return at;
#endif
}

/** Writes `count` doubles: x[0], x[step], x[2 step], ... Returns the end. */
static inline char *api_octets_spread(char *at, size_t count, const double x[], size_t step) {
    for (size_t i = 0; i < count; i++) at = api_octets_double(at, x[i * step]);
    return at;
}
