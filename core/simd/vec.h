/* Vectors of 2, 4 and 8 doubles with fused multiply-add where the instruction set of the
 * including kernel has it.
 * Leaves to others: choosing the instruction set (the Makefile compiles kernels once for each).
 * Invariant: lanes never mix; with avx2 and avx512 a lane's result is the same to the last bit. */
#pragma once

#ifdef __x86_64__
#include <immintrin.h>
#endif

typedef double lanes1;
typedef double lanes2 __attribute__((vector_size(16)));
typedef double lanes4 __attribute__((vector_size(32)));
typedef double lanes8 __attribute__((vector_size(64)));

#define VEC_INLINE static inline __attribute__((always_inline, unused))

/** x y + z, rounded once with avx2 and avx512, twice in the base set. */
VEC_INLINE lanes2 lanes2_fma(lanes2 x, lanes2 y, lanes2 z) {
#ifdef __FMA__
    return (lanes2)_mm_fmadd_pd((__m128d)x, (__m128d)y, (__m128d)z);
#else
    return x * y + z;
#endif
}

VEC_INLINE lanes4 lanes4_fma(lanes4 x, lanes4 y, lanes4 z) {
#ifdef __FMA__
    return (lanes4)_mm256_fmadd_pd((__m256d)x, (__m256d)y, (__m256d)z);
#else
    return x * y + z;
#endif
}

VEC_INLINE lanes8 lanes8_fma(lanes8 x, lanes8 y, lanes8 z) {
#if defined(__AVX512F__)
    return (lanes8)_mm512_fmadd_pd((__m512d)x, (__m512d)y, (__m512d)z);
#elif defined(__FMA__)
    lanes4 low = lanes4_fma(__builtin_shufflevector(x, x, 0, 1, 2, 3),
                            __builtin_shufflevector(y, y, 0, 1, 2, 3),
                            __builtin_shufflevector(z, z, 0, 1, 2, 3));
    lanes4 high = lanes4_fma(__builtin_shufflevector(x, x, 4, 5, 6, 7),
                             __builtin_shufflevector(y, y, 4, 5, 6, 7),
                             __builtin_shufflevector(z, z, 4, 5, 6, 7));
    return __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7);
#else
    return x * y + z;
#endif
}

/** Loads array elements one by one: the gather instruction is slow on processors with mitigations
 * against data sampling. */
VEC_INLINE lanes2 lanes2_gather(const double *from, const int index[2]) {
    return (lanes2){from[index[0]], from[index[1]]};
}

VEC_INLINE lanes4 lanes4_gather(const double *from, const int index[4]) {
    return (lanes4){from[index[0]], from[index[1]], from[index[2]], from[index[3]]};
}

VEC_INLINE lanes8 lanes8_gather(const double *from, const int index[8]) {
    return (lanes8){from[index[0]], from[index[1]], from[index[2]], from[index[3]],
                    from[index[4]], from[index[5]], from[index[6]], from[index[7]]};
}

/** A number in every lane. */
VEC_INLINE lanes1 lanes1_of(double x) { return x; }
VEC_INLINE lanes2 lanes2_of(double x) { return (lanes2){x, x}; }
VEC_INLINE lanes4 lanes4_of(double x) { return (lanes4){x, x, x, x}; }
VEC_INLINE lanes8 lanes8_of(double x) { return (lanes8){x, x, x, x, x, x, x, x}; }

/* Keeps a vector of the instruction set's own width in a register: gcc 12 would otherwise load
 * it again for every use. */
#if defined(__AVX512F__)
#define VEC_PIN(x) __asm__("" : "+v"(x))
#elif defined(__x86_64__)
#define VEC_PIN(x) __asm__("" : "+x"(x))
#else
#define VEC_PIN(x) ((void)(x))
#endif

/** The fused multiply-add of one double. */
VEC_INLINE lanes1 lanes1_fma(lanes1 x, lanes1 y, lanes1 z) {
#ifdef __FMA__
    return __builtin_fma(x, y, z);
#else
    return x * y + z;
#endif
}

/* sines of multiples of a sixteenth of the circle; the cosines begin a quarter circle later */
static const double lanes_sixteenths[20] __attribute__((aligned(64), unused)) = {
    0,  0x1.87de2a6aea963p-2,  0x1.6a09e667f3bcdp-1,  0x1.d906bcf328d46p-1,
    1,  0x1.d906bcf328d46p-1,  0x1.6a09e667f3bcdp-1,  0x1.87de2a6aea963p-2,  /**/
    0,  -0x1.87de2a6aea963p-2, -0x1.6a09e667f3bcdp-1, -0x1.d906bcf328d46p-1, /**/
    -1, -0x1.d906bcf328d46p-1, -0x1.6a09e667f3bcdp-1, -0x1.87de2a6aea963p-2, /**/
    0,  0x1.87de2a6aea963p-2,  0x1.6a09e667f3bcdp-1,  0x1.d906bcf328d46p-1};

#define LANES 2
#include "core/simd/vec_math.h"
#define LANES 4
#include "core/simd/vec_math.h"
#define LANES 8
#include "core/simd/vec_math.h"
