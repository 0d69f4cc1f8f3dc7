/* The widest vectors of the instruction set that the including kernel is compiled for, and the
 * names that depend on it.
 * Leaves to others: the vectors (vec, double_double), which set runs (isa), compiling once for
 * each set (Makefile).
 * Invariant: the width is a literal that the preprocessor can compare and paste. */
#pragma once

#include <string.h>

#include "core/simd/vec.h"

/** Number of doubles in the widest vector. */
#if defined(__AVX512F__)
#define KERNEL_WIDTH 8
#elif defined(__AVX2__)
#define KERNEL_WIDTH 4
#else
#define KERNEL_WIDTH 2
#endif

#define KERNEL_PASTE3(a, b, c) a##b##c
#define KERNEL_PASTE(a, b, c) KERNEL_PASTE3(a, b, c)

/** KERNEL_OF(vec, _fma) is lanes8_fma, lanes4_fma or lanes2_fma; KERNEL_OF(bits, ) is bits8,
 * bits4 or bits2. */
#define KERNEL_OF(kind, name) KERNEL_PASTE(kind, KERNEL_WIDTH, name)

/** A vector of the widest type, and its functions: WIDE_(fma) is lanes8_fma, lanes4_fma or
 * lanes2_fma. */
enum { WIDE = KERNEL_WIDTH };
typedef KERNEL_OF(lanes, ) wide;
#define WIDE_(name) KERNEL_OF(lanes, _##name)
#define wide_of WIDE_(of)
#define wide_fma WIDE_(fma)
#define wide_get WIDE_(get)
#define wide_put WIDE_(put)
#define wide_gather WIDE_(gather)

/** Loads WIDE doubles from any address; wide_get requires an aligned address. */
VEC_INLINE wide wide_load(const double *from) {
    wide x;
    memcpy(&x, from, sizeof x);
    return x;
}

/** All ones in a lane where a comparison of vectors holds, else 0. */
typedef KERNEL_OF(bits, ) wide_mask;

/** KERNEL_NAME(pend_x_) is pend_x_base, pend_x_avx2 or pend_x_avx512. */
#define KERNEL_NAME(stem) KERNEL_PASTE(stem, PEND_ISA, )
