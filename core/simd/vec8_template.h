/* Eight numbers in one, two or four vectors of the processor's own width. gcc would keep vectors of
 * eight in memory.
 * Leaves to others: the meaning of the numbers (blocks_template).
 * Invariant: the same operations in the same order for every width, so that avx2 and avx512
 * agree to the last bit. */
#pragma once

#include <string.h>

#include "core/simd/vec_isa.h"

enum { VEC8 = 8, VEC8_PARTS = VEC8 / KERNEL_WIDTH };

struct vec8 {
    wide part[VEC8_PARTS];
};

VEC_INLINE struct vec8 vec8_get(const double *at) {
    struct vec8 x;
    for (int p = 0; p < VEC8_PARTS; p++) x.part[p] = wide_get(at + p * WIDE);
    return x;
}

VEC_INLINE void vec8_put(double *at, const struct vec8 *x) {
    for (int p = 0; p < VEC8_PARTS; p++) wide_put(at + p * WIDE, x->part[p]);
}

/** wide_shift: the lanes of x moved down by one, the first lane of `after` last. wide_unshift:
 * moved up by one, the last lane of `before` first. */
VEC_INLINE wide wide_shift(wide x, wide after) {
#if KERNEL_WIDTH == 8
    return __builtin_shufflevector(x, after, 1, 2, 3, 4, 5, 6, 7, 8);
#elif KERNEL_WIDTH == 4
    return __builtin_shufflevector(x, after, 1, 2, 3, 4);
#else
    return __builtin_shufflevector(x, after, 1, 2);
#endif
}

VEC_INLINE wide wide_unshift(wide before, wide x) {
#if KERNEL_WIDTH == 8
    return __builtin_shufflevector(before, x, 7, 8, 9, 10, 11, 12, 13, 14);
#elif KERNEL_WIDTH == 4
    return __builtin_shufflevector(before, x, 3, 4, 5, 6);
#else
    return __builtin_shufflevector(before, x, 1, 2);
#endif
}

/** The last lane of x, in every lane. */
VEC_INLINE wide wide_end(wide x) {
#if KERNEL_WIDTH == 8
    return __builtin_shufflevector(x, x, 7, 7, 7, 7, 7, 7, 7, 7);
#elif KERNEL_WIDTH == 4
    return __builtin_shufflevector(x, x, 3, 3, 3, 3);
#else
    return __builtin_shufflevector(x, x, 1, 1);
#endif
}

/** WIDE of the eight lanes, those from `first` on: x in lane `lane` of the eight, zero in the
 * others. */
VEC_INLINE wide wide_only(double x, int lane, int first) {
    static const long long all[2 * VEC8 - 1] = {[VEC8 - 1] = -1};
    KERNEL_OF(bits, ) mask;
    memcpy(&mask, all + VEC8 - 1 - lane + first, sizeof mask);
    return (wide)(mask & (KERNEL_OF(bits, ))wide_of(x));
}

/** The sum of eight rows, row i times number i of x. */
VEC_INLINE struct vec8 vec8_product(const double *rows, const struct vec8 *x) {
    struct vec8 product;
#if KERNEL_WIDTH == 8
#define VEC8_BEAM(i) __builtin_shufflevector(x->part[0], x->part[0], i, i, i, i, i, i, i, i)
#else
    double beam[VEC8] __attribute__((aligned(64)));
    vec8_put(beam, x);
#define VEC8_BEAM(i) wide_of(beam[i])
#endif
#define VEC8_TERM(i) wide_get(rows + (i)*VEC8 + p * WIDE), VEC8_BEAM(i)
    for (int p = 0; p < VEC8_PARTS; p++) {
        wide part = wide_fma(VEC8_TERM(0), wide_of(0)), sum = wide_fma(VEC8_TERM(1), wide_of(0));
        part = wide_fma(VEC8_TERM(2), part);
        sum = wide_fma(VEC8_TERM(3), sum);
        part = wide_fma(VEC8_TERM(4), part);
        sum = wide_fma(VEC8_TERM(5), sum);
        part = wide_fma(VEC8_TERM(6), part);
        sum = wide_fma(VEC8_TERM(7), sum);
        product.part[p] = part + sum;
    }
#undef VEC8_TERM
#undef VEC8_BEAM
    return product;
}
