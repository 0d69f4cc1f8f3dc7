/* Converts two 8-digit numbers to 16 characters at once, with SSE2 or in 64-bit arithmetic.
 * Leaves to others: computing the digits, and the characters around them (number_write).
 * Invariant: both versions give the same bytes; only bytes [out, out + 17) are written. C++17. */
#pragma once

#include <stdint.h>
#include <string.h>

#ifdef __SSE2__
#include <immintrin.h>
#endif

namespace api {

/* the eight decimal digits of a number below 10^8, one per byte, the first in the lowest byte;
 * splits into halves, quarters and digits in parallel */
inline uint64_t digits8(uint64_t x) {
    uint64_t four = x * 109951163 >> 40, halves = four | (x - 10000 * four) << 32;
    uint64_t hundreds = (halves * 10486 >> 20) & 0x0000007f0000007f;
    uint64_t quarters = hundreds | (halves - 100 * hundreds) << 16;
    uint64_t tens = (quarters * 103 >> 10) & 0x000f000f000f000f;
    return tens | (quarters - 10 * tens) << 8;
}

/*
 * Both classes hold the digits of two numbers below 10^8, those of the first before those of the
 * second, and have these functions:
 *
 * significant(last)              returns the number of digits without trailing zeros; `last` is the
 *                                17th digit;
 * values(out)                    writes the digits, one per byte, the first of each number in the
 *                                lowest byte;
 * store(out)                     writes 16 characters;
 * store_with_point(out, before)  writes 17 characters with the point after `before` digits, 0
 * to 16.
 */
class digits16_plain {
  public:
    digits16_plain() = default;
    digits16_plain(uint64_t x, uint64_t y) : high(digits8(x)), low(digits8(y)) {}

    int significant(unsigned last) const {
        if (last) return 17;
        if (low) return 16 - __builtin_clzll(low) / 8;
        return high ? 8 - __builtin_clzll(high) / 8 : 0;
    }

    void values(uint64_t out[2]) const {
        out[0] = high;
        out[1] = low;
    }

    void store(char *out) const {
        store(out, high | ZEROS);
        store(out + 8, low | ZEROS);
    }

    void store_with_point(char *out, int before) const {
        uint64_t front = high | ZEROS, back = low | ZEROS, moved = back << 8 | front >> 56;
        store(out, before < 8 ? with_point(front, front << 8, before) : front);
        store(out + 8, before < 8    ? moved
                       : before < 16 ? with_point(back, moved, before - 8)
                                     : back);
        out[16] = before < 16 ? (char)(back >> 56) : '.';
    }

  private:
    static constexpr uint64_t ZEROS = 0x3030303030303030;

    /* inserts a point at byte `at`, 0 to 7: bytes before it come from `bytes`, bytes after it from
     * `moved` */
    static uint64_t with_point(uint64_t bytes, uint64_t moved, int at) {
        uint64_t before = ((uint64_t)1 << 8 * at) - 1, point = (uint64_t)0xff << 8 * at;
        return (bytes & before) | ((uint64_t)'.' << 8 * at) | (moved & ~before & ~point);
    }

    static void store(char *out, uint64_t bytes) {
#if __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__
        bytes = __builtin_bswap64(bytes);
#endif
        memcpy(out, &bytes, sizeof bytes);
    }

    uint64_t high, low;
};

#ifdef __SSE2__

/* sets of leading bytes: at masks + 16 - n, n bytes of ones are followed by zeros */
struct lead_masks {
    constexpr lead_masks() : bytes() {
        for (int i = 0; i < 16; i++) bytes[i] = 0xff;
    }
    unsigned char bytes[32];
};
constexpr lead_masks masks{};

class digits16_sse2 {
  public:
    digits16_sse2() = default;
    /* splits both numbers at a time into halves, quarters and digits */
    digits16_sse2(uint64_t high, uint64_t low) {
        __m128i x =
            _mm_unpacklo_epi64(_mm_cvtsi64_si128((int64_t)high), _mm_cvtsi64_si128((int64_t)low));
        __m128i front = _mm_srli_epi64(_mm_mul_epu32(x, _mm_set1_epi64x(109951163)), 40);
        __m128i back = _mm_sub_epi64(x, _mm_mul_epu32(front, _mm_set1_epi64x(10000)));
        x = _mm_or_si128(front, _mm_slli_epi64(back, 32));
        front = _mm_srli_epi16(_mm_mulhi_epu16(x, _mm_set1_epi16(5243)), 3);
        back = _mm_sub_epi32(x, _mm_madd_epi16(front, _mm_set1_epi32(100)));
        x = _mm_or_si128(front, _mm_slli_epi32(back, 16));
        front = _mm_mulhi_epu16(x, _mm_set1_epi16(6554));
        back = _mm_sub_epi16(x, _mm_mullo_epi16(front, _mm_set1_epi16(10)));
        digits = _mm_or_si128(front, _mm_slli_epi16(back, 8));
    }

    int significant(unsigned last) const {
        unsigned zeros = (unsigned)_mm_movemask_epi8(_mm_cmpeq_epi8(digits, _mm_setzero_si128()));
        return __builtin_clz((zeros ^ 0xffff) << 1 | (unsigned)(last != 0) << 17 | 1) ^ 31;
    }

    void values(uint64_t out[2]) const { _mm_storeu_si128((__m128i *)out, digits); }

    void store(char *out) const { _mm_storeu_si128((__m128i *)out, text()); }

    void store_with_point(char *out, int before) const {
        __m128i lead = _mm_loadu_si128((const __m128i *)(masks.bytes + 16 - before)), all = text();
        out[16] = (char)(_mm_extract_epi16(all, 7) >> 8);
        __m128i moved = _mm_slli_si128(all, 1);
        _mm_storeu_si128((__m128i *)out,
                         _mm_or_si128(_mm_and_si128(lead, all), _mm_andnot_si128(lead, moved)));
        out[before] = '.';
    }

  private:
    __m128i text() const { return _mm_or_si128(digits, _mm_set1_epi8('0')); }
    __m128i digits;
};

using digits16 = digits16_sse2;

#else

using digits16 = digits16_plain;

#endif

} // namespace api
