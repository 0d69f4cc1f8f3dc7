/* Short numbers, eight at a time in AVX-512; only the last step, which shuffles the digits to their
 * positions, takes one number at a time.
 * Leaves to others: detecting AVX-512 (core/base/isa), all other numbers (number_write).
 * Invariant: short_lanes gives the same text as short_batch and can replace it. C++17. */
#ifndef API_NUMBER_LANES_H
#define API_NUMBER_LANES_H

#include "api/number/number_short.h"

#ifdef __x86_64__

#include <immintrin.h>

/* gcc 12 warns about variables that its own header leaves uninitialized on purpose */
#ifndef __clang__
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#pragma GCC diagnostic ignored "-Wuninitialized"
#endif

/* functions that use AVX-512; they are called only if the processor has it */
#define API_LANES __attribute__((target("avx512f,avx512bw,avx512dq,avx512vl,avx512cd")))

namespace api {

/* 10^12, 10^11, ...: those from 10^(digits + 4) on belong to the exponents from SHORT_LEAST on;
 * and 10^SHORT_LEAST up, where a number of that many digits begins, as bits */
struct lane_powers {
    constexpr lane_powers() : falling(), begins() {
        for (int i = 0; i < 24; i++) falling[i] = i <= 12 ? (double)power10[12 - i] : 0;
        for (int i = 0; i < 16; i++) begins[i] = thresholds[SHORT_LEAST + i];
    }
    double falling[24];
    uint64_t begins[16];
};
constexpr lane_powers powers_of_lanes{};

/* the positions of the digits in the text, and the characters at the other positions: for every
 * exponent, without and with a sign */
struct lane_layout {
    unsigned char from[16]; /* the digit at each place; beyond 127 for none */
    char other[16];         /* '0' where a digit is */
};

struct lane_layouts {
    constexpr lane_layouts() : value() {
        for (int e = SHORT_LEAST; e <= SHORT_MOST; e++)
            for (int sign = 0; sign < 2; sign++)
                value[2 * (e - SHORT_LEAST) + sign] = layout(e, sign);
    }
    static constexpr lane_layout layout(int e, int sign) {
        lane_layout made = {};
        int at = 0, digit = 0, point = sign + (e < 0 ? 1 : e + 1);
        for (; at < 16; at++) {
            bool leads = at < sign + (e < 0 ? 1 - e : 0),
                 none = leads || at == point || digit == SHORT_DIGITS;
            made.from[at] = none ? 0x80 : (unsigned char)digit++;
            made.other[at] = at < sign ? '-' : at == point ? '.' : '0';
        }
        return made;
    }
    lane_layout value[2 * (SHORT_MOST - SHORT_LEAST + 1)];
};
constexpr lane_layouts layouts_of_lanes{};

/* floor(log10 2^q) of a small q, as the lanes make it */
constexpr int lane_log10(int q) { return q * 1233 >> 12; }
constexpr bool lane_log10_holds() {
    for (int i = 0; i < SHORT_BINARIES; i++)
        if (lane_log10(SHORT_BINARY + i) != log10_of_power2(SHORT_BINARY + i)) return false;
    return true;
}
static_assert(lane_log10_holds(), "the short way to the exponent is right for all that are short");

class short_lanes {
  public:
    static constexpr int COUNT = 8;

    explicit short_lanes(int wanted) : digits(wanted) {}

    API_LANES bool take(const double x[]) {
        __m512d value = _mm512_loadu_pd(x), magnitude = _mm512_abs_pd(value);
        __mmask8 good;
        __m512i e = exponents(magnitude, good), digit = digits_of(magnitude, e, good);
        if (good != 0xff) return false;
        __m512i sign = _mm512_srli_epi64(_mm512_castpd_si512(value), 63);
        _mm512_store_si512(layout, _mm512_add_epi64(_mm512_add_epi64(e, e), sign));
        _mm512_store_si512(text, digit);
        _mm512_store_si512(bytes, _mm512_add_epi64(lengths(digit, e), sign));
        return true;
    }

    API_LANES char *write(char *out, const double[], int i) const {
        const lane_layout &places = layouts_of_lanes.value[layout[i]];
        __m128i from = _mm_loadu_si128((const __m128i *)places.from);
        __m128i other = _mm_loadu_si128((const __m128i *)places.other);
        __m128i all = _mm_shuffle_epi8(_mm_loadl_epi64((const __m128i *)(text + i)), from);
        _mm_storeu_si128((__m128i *)out, _mm_or_si128(all, other));
        return out + bytes[i];
    }

  private:
    API_LANES static __m512i whole(int64_t i) { return _mm512_set1_epi64(i); }

    /* decimal exponents, from SHORT_LEAST on; `good`: those that are short */
    API_LANES __m512i exponents(__m512d magnitude, __mmask8 &good) const {
        __m512i bits = _mm512_castpd_si512(magnitude);
        __m512i binary = _mm512_sub_epi64(_mm512_srli_epi64(bits, 52), whole(1023));
        __m512i log10 = _mm512_srai_epi64(_mm512_mul_epi32(binary, whole(1233)), 12);
        __m512i e = _mm512_sub_epi64(log10, whole(SHORT_LEAST));
        const uint64_t *begins = powers_of_lanes.begins;
        __m512i next =
            _mm512_permutex2var_epi64(_mm512_loadu_si512(begins), _mm512_add_epi64(e, whole(1)),
                                      _mm512_loadu_si512(begins + 8));
        e = _mm512_mask_add_epi64(e, _mm512_cmpge_epu64_mask(bits, next), e, whole(1));
        int most = (digits - 1 < SHORT_MOST ? digits - 1 : SHORT_MOST) - SHORT_LEAST;
        __m512i place = _mm512_sub_epi64(binary, whole(SHORT_BINARY));
        good = _mm512_cmplt_epu64_mask(place, whole(SHORT_BINARIES)) &
               _mm512_cmple_epu64_mask(e, whole(most));
        return e;
    }

    /* eight digits of each, one a byte, the first in the lowest */
    API_LANES __m512i digits_of(__m512d magnitude, __m512i e, __mmask8 &good) const {
        const double *falling = powers_of_lanes.falling + (SHORT_DIGITS - digits);
        __m512d power =
            _mm512_permutex2var_pd(_mm512_loadu_pd(falling), e, _mm512_loadu_pd(falling + 8));
        __m512d scaled = _mm512_mul_pd(magnitude, power);
        __m256i below = _mm512_cvttpd_epi32(scaled);
        __m512d above_tie =
            _mm512_sub_pd(_mm512_sub_pd(scaled, _mm512_cvtepi32_pd(below)), _mm512_set1_pd(0.5));
        __mmask8 up = _mm512_cmp_pd_mask(above_tie, _mm512_setzero_pd(), _CMP_GT_OQ);
        __m256i units = _mm256_mask_add_epi32(below, up, below, _mm256_set1_epi32(1));
        good &= _mm512_cmp_pd_mask(_mm512_abs_pd(above_tie), _mm512_set1_pd(SHORT_NEAR_TIE),
                                   _CMP_GE_OQ);
        good &= _mm256_cmplt_epu32_mask(units, _mm256_set1_epi32((int)power10[digits]));
        units = _mm256_mullo_epi32(units, _mm256_set1_epi32((int)power10[SHORT_DIGITS - digits]));
        return spread(_mm512_cvtepu32_epi64(units));
    }

    /* halves, quarters, digits */
    API_LANES static __m512i spread(__m512i x) {
        __m512i front = _mm512_srli_epi64(_mm512_mul_epu32(x, whole(109951163)), 40);
        __m512i back = _mm512_sub_epi64(x, _mm512_mul_epu32(front, whole(10000)));
        x = _mm512_or_si512(front, _mm512_slli_epi64(back, 32));
        front = _mm512_srli_epi16(_mm512_mulhi_epu16(x, _mm512_set1_epi16(5243)), 3);
        back = _mm512_sub_epi32(x, _mm512_madd_epi16(front, _mm512_set1_epi32(100)));
        x = _mm512_or_si512(front, _mm512_slli_epi32(back, 16));
        front = _mm512_mulhi_epu16(x, _mm512_set1_epi16(6554));
        back = _mm512_sub_epi16(x, _mm512_mullo_epi16(front, _mm512_set1_epi16(10)));
        return _mm512_or_si512(front, _mm512_slli_epi16(back, 8));
    }

    /* characters without the sign */
    API_LANES static __m512i lengths(__m512i digit, __m512i e) {
        __m512i count = _mm512_sub_epi64(whole(8), _mm512_srli_epi64(_mm512_lzcnt_epi64(digit), 3));
        __m512i before = _mm512_add_epi64(e, whole(SHORT_LEAST + 1)); /* the point */
        __mmask8 small = _mm512_cmple_epi64_mask(before, _mm512_setzero_si512());
        __m512i with_point = _mm512_add_epi64(count, whole(1));
        __m512i plain =
            _mm512_mask_mov_epi64(before, _mm512_cmpgt_epi64_mask(count, before), with_point);
        return _mm512_mask_sub_epi64(plain, small, _mm512_add_epi64(count, whole(2)), before);
    }

    alignas(64) int64_t layout[COUNT];
    alignas(64) int64_t bytes[COUNT];
    alignas(64) uint64_t text[COUNT];
    int digits;
};

} // namespace api

#ifndef __clang__
#pragma GCC diagnostic pop
#endif

#endif

#endif
