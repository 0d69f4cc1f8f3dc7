/* The part of a sweep that does not depend on other arms' results, for a block of arms of one
 * state: each arm's angle to its parent, and w = l phi'^2.
 * Leaves to others: the sweeps (dynamics_one_template).
 * Invariant: the operations are those of dynamics_vec_template, so the bits are the same. */
#pragma once

#include "core/dynamics/dynamics_template.h"

/* C and Z of the angle to the parent, and w = l phi'^2, for a block of arms. */
struct turns {
    double cosine[DYNAMICS_BLOCK], sine[DYNAMICS_BLOCK], spin[DYNAMICS_BLOCK];
};

#if KERNEL_WIDTH == 4
/* all ones in the first `count` lanes */
VEC_INLINE bits4 wide_first(int count) {
    static const long long ones[8] = {-1, -1, -1, -1, 0, 0, 0, 0};
    bits4 mask;
    memcpy(&mask, ones + 4 - count, sizeof mask);
    return mask;
}
#endif

/* loads the first `count` numbers of a vector; the other lanes are `rest` */
VEC_INLINE wide wide_load_some(const double *from, int count, double rest) {
#if defined(__AVX512F__)
    return (wide)_mm512_mask_loadu_pd(_mm512_set1_pd(rest), (__mmask8)((1u << count) - 1), from);
#elif KERNEL_WIDTH == 4
    bits4 mask = wide_first(count);
    return lanes4_pick(mask, (wide)_mm256_maskload_pd(from, (__m256i)mask), lanes4_of(rest));
#else
    wide x = WIDE_(of)(rest);
    for (int i = 0; i < WIDE; i++)
        if (i < count) x[i] = from[i];
    return x;
#endif
}

VEC_INLINE void wide_store_some(double *to, wide x, int count) {
#if defined(__AVX512F__)
    _mm512_mask_storeu_pd(to, (__mmask8)((1u << count) - 1), (__m512d)x);
#elif KERNEL_WIDTH == 4
    _mm256_maskstore_pd(to, (__m256i)wide_first(count), (__m256d)x);
#else
    for (int i = 0; i < WIDE; i++)
        if (i < count) to[i] = x[i];
#endif
}

VEC_INLINE void turns_put(struct turns *turns, int i, wide cosine, wide sine, wide rate, wide len) {
    WIDE_(put)(turns->cosine + i, cosine);
    WIDE_(put)(turns->sine + i, sine);
    WIDE_(put)(turns->spin + i, len * rate * rate);
}

/* arms i to i + WIDE of a block */
VEC_INLINE void turns_some(struct turns *turns, int i, wide x, wide base, wide rate, wide len) {
    wide sine, cosine;
    WIDE_(between)(x, base, &sine, &cosine);
    turns_put(turns, i, cosine, sine, rate, len);
}

VEC_INLINE void block_turns(struct turns *turns, const struct pend_tree *tree, const double phi[],
                            const double rate[], int begin, int count) {
    double base[DYNAMICS_BLOCK] __attribute__((aligned(64)));
    const int *parent = tree->parent + begin;
    int i = 0;
    if (!begin) base[i++] = 0;
    for (; i < count; i++) base[i] = phi[parent[i]];
    phi += begin, rate += begin;
    const double *len = tree->len + begin;
    for (i = 0; i + WIDE <= count; i += WIDE)
        turns_some(turns, i, wide_load(phi + i), WIDE_(get)(base + i), wide_load(rate + i),
                   wide_load(len + i));
    if (i == count) return;
    count -= i;
    turns_some(turns, i, wide_load_some(phi + i, count, 0), wide_load_some(base + i, count, 0),
               wide_load_some(rate + i, count, 0), wide_load_some(len + i, count, 0));
}
