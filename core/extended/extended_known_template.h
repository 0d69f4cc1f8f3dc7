/* The known terms T and c of an order of the series in numbers of 32 digits: the convolutions of
 * the known coefficients of u, phi' and lambda, with as few operations as the coefficients' sizes
 * allow.
 * Leaves to others: the solution for the next coefficients (extended_orders_template), memory
 * (kernel_extended).
 * Invariant: a sum has all digits of its largest term, unless one double suffices for the order. */
#pragma once

#include "core/taylor/jets_system.h"

#define num_from NUM_(from)
#define num_gather NUM_(gather)
#define num_settle NUM_(settle)
#define num_total NUM_(total)

enum {
#ifdef __FMA__
    FIXED = 8 /* first order with terms small enough for sums with a fixed last digit of the high
               * part */
#else
    FIXED = 1 << 30 /* never: such sums need fused multiply-add */
#endif
};

/* The input of the sums T and c for vectors of four lanes, in the order of the series. The four
 * sums of an arm are computed side by side from u = (Re u, Im u, Re u, Im u) of order j and met =
 * (phi', phi', lambda, lambda), phi' of order j and lambda of order j - 1. Sizes are |Re u| + |Im
 * u| and |met|. */
struct extended_packs {
    int packed; /* 0 if this form is not used */
    num *u, *met;
    wide *turn, *size;
};

/* x in the lanes of a set, y in the others */
VEC_INLINE num extended_blend(const wide_mask *set, num x, num y) { return NUM_(pick)(*set, x, y); }

/* appends phi' and u of order k, and lambda of order k - 1 */
static void extended_pack(const struct jets_system *s, const struct extended_packs *packs, int k) {
    wide_mask odd = {0}, late = {0};
    for (int i = 0; i < WIDE; i++) odd[i] = -(i % 2), late[i] = -(i / 2);
    for (int i = 0; i < s->n && packs->packed; i++) {
        size_t at = (size_t)k * s->stride + (size_t)i, next = at + s->stride;
        num force = k ? s->force[at - s->stride] : num_of(0);
        packs->u[next] = extended_blend(&odd, s->turn_im[next], s->turn_re[next]);
        packs->met[at] = extended_blend(&late, force, s->rate[at]);
        packs->turn[next] = WIDE_(abs)(s->turn_re[next].high) + WIDE_(abs)(s->turn_im[next].high);
        packs->size[at] = WIDE_(abs)(packs->met[at].high);
    }
}

struct extended_known {
    num wind_re, wind_im, drag_re, drag_im;
};

VEC_INLINE struct extended_known extended_convolve(const struct jets_system *s, size_t n, int k,
                                                   int a) {
    const num *re = s->turn_re + a + n, *im = s->turn_im + a + n;
    const num *rate = s->rate + a + (size_t)k * n,
              *force = s->force + a + (size_t)(k ? k - 1 : 0) * n;
    struct extended_known x = {num_of(0), num_of(0), num_of(0), num_of(0)};
    for (int j = 1; j <= k; j++, re += n, im += n, rate -= n, force -= n) {
        num w = *rate, f = *force;
        x.wind_re = num_gather(*re, w, x.wind_re);
        x.wind_im = num_gather(*im, w, x.wind_im);
        x.drag_re = num_gather(*re, f, x.drag_re);
        x.drag_im = num_gather(*im, f, x.drag_im);
    }
    x.wind_re = num_fma(*re, *rate, x.wind_re);
    x.wind_im = num_fma(*im, *rate, x.wind_im);
    x.drag_re = num_settle(x.drag_re);
    x.drag_im = num_settle(x.drag_im);
    return x;
}

/* sums whose high part has a fixed last digit, with enough space above it for every product */
struct extended_fixed {
    wide start, high, low;
};

typedef unsigned long long extended_bits __attribute__((vector_size(sizeof(wide))));

/* an initial value for sums of products whose absolute values add up to at most `size`: 6 times the
 * next power of two, so that the place of the last digit never changes */
VEC_INLINE wide extended_bias(wide size) {
    extended_bits exponent = (extended_bits)size & 0x7ff0000000000000ULL;
    return (wide)((exponent + (2ULL << 52)) | 0x8000000000000ULL);
}

/* adds x y: digits below the last one of the sum's high part go to its low part */
VEC_INLINE void extended_collect(struct extended_fixed *sum, num x, num y) {
    wide high = wide_fma(x.high, y.high, sum->high), part = high - sum->high;
    wide rest = wide_fma(x.high, y.low, wide_fma(x.high, y.high, -part));
    sum->low += wide_fma(x.low, y.high, rest);
    sum->high = high;
}

VEC_INLINE num extended_collected(const struct extended_fixed *sum) {
    return num_total(sum->high - sum->start, sum->low);
}

VEC_INLINE struct extended_fixed extended_empty(wide size) {
    wide start = extended_bias(size);
    return (struct extended_fixed){start, start, wide_of(0)};
}

struct extended_rough {
    wide wind_re, wind_im, drag_re, drag_im;
};

/* extended_convolve for orders for which one double suffices */
VEC_INLINE struct extended_rough extended_convolve_rough(const struct jets_system *s,
                                                         const struct extended_packs *packs,
                                                         size_t n, int k, int a) {
    if (packs->packed) {
        const num *u = packs->u + a + n, *met = packs->met + a + (size_t)k * n;
        wide sum = wide_of(0);
        for (int j = 1; j <= k + 1; j++, u += n, met -= n) sum = wide_fma(u->high, met->high, sum);
        return (struct extended_rough){wide_of(sum[0]), wide_of(sum[1]), wide_of(sum[2 % WIDE]),
                                       wide_of(sum[3 % WIDE])};
    }
    const num *re = s->turn_re + a + n, *im = s->turn_im + a + n;
    const num *rate = s->rate + a + (size_t)k * n, *force = s->force + a + (size_t)(k - 1) * n;
    struct extended_rough x = {wide_of(0), wide_of(0), wide_of(0), wide_of(0)};
    for (int j = 1; j <= k; j++, re += n, im += n, rate -= n, force -= n) {
        x.wind_re = wide_fma(re->high, rate->high, x.wind_re);
        x.wind_im = wide_fma(im->high, rate->high, x.wind_im);
        x.drag_re = wide_fma(re->high, force->high, x.drag_re);
        x.drag_im = wide_fma(im->high, force->high, x.drag_im);
    }
    x.wind_re = wide_fma(re->high, rate->high, x.wind_re);
    x.wind_im = wide_fma(im->high, rate->high, x.wind_im);
    return x;
}

/* expands the four sums, one in each lane, to four numbers */
VEC_INLINE struct extended_known extended_spread(num x) {
    return (struct extended_known){num_of2(x.high[0], x.low[0]), num_of2(x.high[1], x.low[1]),
                                   num_of2(x.high[2 % WIDE], x.low[2 % WIDE]),
                                   num_of2(x.high[3 % WIDE], x.low[3 % WIDE])};
}

/* the sums of order k, in lanes, by the same operations as in extended_convolve */
VEC_INLINE struct extended_known extended_convolve_packed(const struct extended_packs *packs,
                                                          size_t n, int k, int a) {
    const num *u = packs->u + a + n, *met = packs->met + a + (size_t)k * n;
    if (k < FIXED) {
        num sum = num_of(0);
        for (int j = 1; j <= k + 1; j++, u += n, met -= n) sum = num_gather(*u, *met, sum);
        return extended_spread(num_settle(sum));
    }
    wide size = wide_of(0);
    const wide *turn = packs->turn + a + n, *other = packs->size + a + (size_t)k * n;
    for (int j = 1; j <= k + 1; j++, turn += n, other -= n) size = wide_fma(*turn, *other, size);
    struct extended_fixed sum = extended_empty(size);
    for (int j = 1; j <= k + 1; j++, u += n, met -= n) extended_collect(&sum, *u, *met);
    return extended_spread(extended_collected(&sum));
}

VEC_INLINE struct extended_known extended_find(const struct jets_system *s,
                                               const struct extended_packs *packs, size_t n, int k,
                                               int a) {
    return packs->packed ? extended_convolve_packed(packs, n, k, a) : extended_convolve(s, n, k, a);
}
