/* Values of a series at many instants: phi, phi' and, on request, phi'' and lambda.
 * Leaves to others: the series (blocks_template, small_template), the types of vectors, states and
 * values (the including file).
 * Invariant: a row's bits depend neither on the other rows nor on the width of vectors. */
#pragma once

#include <string.h>

#include "core/taylor/jets_system.h"

/* the quantities requested besides phi and phi' */
struct values_wish {
    int acc, force;
};

/* changes of phi and phi' and, on request, the new phi'' and lambda */
struct values_change {
    wide phi, rate, acc, force;
};

/* ---- trees of more than eight arms: one instant after another, arms in lanes */

/* values of a vector of arms from arm a on, by Horner's rule */
VEC_INLINE struct values_change values_horner(const struct jets_system *s, int order, double x_,
                                              double unit, int a, struct values_wish wish) {
    wide x = wide_of(x_);
    struct values_change v = {wide_of(0), wide_of(0), wide_of(0), wide_of(0)};
    const double *rate = s->rate + jets_row(s, a) + (size_t)order * s->stride;
    const double *tension = s->force + jets_row(s, a) + (size_t)(order - 1) * s->stride;
    for (int j = order; j >= 1; j--) {
        wide w = wide_get(rate);
        v.phi = wide_fma(v.phi, x, w * s->share[j]);
        v.rate = wide_fma(v.rate, x, w);
        if (wish.acc) v.acc = wide_fma(v.acc, x, w * (double)j);
        if (wish.force) v.force = wide_fma(v.force, x, wide_get(tension));
        rate -= s->stride;
        tension -= s->stride;
    }
    v.phi = x * wide_fma(x, v.phi, wide_get(rate));
    // exact: the unit is a power of two
    double inverse = 1 / unit;
    v.rate = x * v.rate * inverse;
    v.acc = v.acc * (inverse * inverse);
    v.force = v.force * (inverse * inverse);
    return v;
}

VEC_INLINE void values_give(double to[], int a, int n, wide x) {
    if (a + WIDE <= n) {
        memcpy(to + a, &x, sizeof x);
        return;
    }
    for (int i = 0; a + i < n; i++) to[a + i] = x[i];
}

VEC_INLINE void values_large(const struct jets_system *s, int order, const double x[], int count,
                             double unit, const struct jets_state *from,
                             const struct jets_values *to, struct values_wish wish) {
    for (int i = 0; i < count; i++) {
        size_t row = (size_t)i * (size_t)s->n;
        for (int a = 0; a < s->n; a += WIDE) {
            struct values_change v = values_horner(s, order, x[i], unit, a, wish);
            v.phi = wide_get(from->phi + a) + (v.phi + wide_get(from->phi_low + a));
            v.rate = wide_get(from->rate + a) + (v.rate + wide_get(from->rate_low + a));
            values_give(to->phi + row, a, s->n, v.phi);
            values_give(to->rate + row, a, s->n, v.rate);
            if (wish.acc) values_give(to->acc + row, a, s->n, v.acc);
            if (wish.force) values_give(to->force + row, a, s->n, v.force);
        }
    }
}

/* ---- up to eight arms: `arms` lanes (2, 4 or 8) per instant, and as many instants as fit into a
 * vector */

/* number of vectors computed together, to hide the latency of sums */
enum { VALUES_TOGETHER = 2 };

/* number of arms, and of instants, in one vector */
VEC_INLINE int values_side(int arms) { return arms < WIDE ? arms : WIDE; }
VEC_INLINE int values_instants(int arms) { return WIDE / values_side(arms); }

/* one number per arm, repeated for every instant of a vector */
VEC_INLINE wide values_get(const double *at, int arms) {
#if defined(__AVX512F__)
    if (arms == 2) return (wide)_mm512_broadcast_f64x2(_mm_load_pd(at));
    if (arms == 4) return (wide)_mm512_broadcast_f64x4(_mm256_load_pd(at));
#elif KERNEL_WIDTH == 4
    if (arms == 2) return (wide)_mm256_broadcast_pd((const __m128d *)(const void *)at);
#endif
    (void)arms;
    return wide_get(at);
}

/* the instants of a vector, each repeated for all its arms; 0 from instant `count` on */
VEC_INLINE wide values_places(const double x[], int arms, int count) {
#if defined(__AVX512F__)
    __m512d some = _mm512_maskz_loadu_pd((__mmask8)(count < WIDE ? (1u << count) - 1 : 0xff), x);
    if (arms == 2)
        return (wide)_mm512_permutexvar_pd(_mm512_setr_epi64(0, 0, 1, 1, 2, 2, 3, 3), some);
    if (arms == 4)
        return (wide)_mm512_permutexvar_pd(_mm512_setr_epi64(0, 0, 0, 0, 1, 1, 1, 1), some);
    return (wide)_mm512_broadcastsd_pd(_mm512_castpd512_pd128(some));
#else
    wide places = wide_of(0);
    for (int i = 0; i < WIDE; i++)
        if (i / values_side(arms) < count) places[i] = x[i / values_side(arms)];
    return places;
#endif
}

/* writes one vector, the arms from a on of up to `count` instants, to rows of n */
VEC_INLINE void values_put(double *to, int n, int arms, int a, int count, wide x) {
    int side = values_side(arms), own = n - a < side ? n - a : side;
    if (count > values_instants(arms)) count = values_instants(arms);
#if defined(__AVX512F__)
    unsigned each = (1u << own) - 1;
    unsigned kept = arms == 2 ? each * 0x55u : arms == 4 ? each * 0x11u : each;
    __m512d packed =
        own == side ? (__m512d)x : _mm512_maskz_compress_pd((__mmask8)kept, (__m512d)x);
    _mm512_mask_storeu_pd(to, (__mmask8)((1u << (count * own)) - 1), packed);
#else
    if (own == WIDE) {
        memcpy(to + a, &x, sizeof x);
        return;
    }
    double part[WIDE] __attribute__((aligned(32)));
    wide_put(part, x);
    for (int i = 0; i < count; i++)
        for (int k = 0; k < own; k++) to[i * n + a + k] = part[i * side + k];
#endif
}

/* the sums of even and odd orders, kept apart, which halves the latency */
struct values_parts {
    wide even[VALUES_TOGETHER], odd[VALUES_TOGETHER];
};

VEC_INLINE void values_two(struct values_parts *sum, const wide square[], wide even, wide odd) {
    for (int v = 0; v < VALUES_TOGETHER; v++) {
        sum->even[v] = wide_fma(sum->even[v], square[v], even);
        sum->odd[v] = wide_fma(sum->odd[v], square[v], odd);
    }
}

VEC_INLINE void values_start(struct values_parts *sum) {
    for (int v = 0; v < VALUES_TOGETHER; v++) sum->even[v] = sum->odd[v] = wide_of(0);
}

VEC_INLINE wide values_whole(const struct values_parts *sum, int v, wide x) {
    return wide_fma(x, sum->odd[v], sum->even[v]);
}

/* changes of phi and of phi' */
VEC_INLINE void values_motion(const struct jets_system *s, int order, int arms, int a,
                              const wide x[], double inverse, struct values_change change[]) {
    wide square[VALUES_TOGETHER];
    // phi divided by x; phi' minus its initial value, divided by x
    struct values_parts phi, rate;
    values_start(&phi), values_start(&rate);
    for (int v = 0; v < VALUES_TOGETHER; v++) square[v] = x[v] * x[v];
    for (int j = order - order % 2; j >= 0; j -= 2) {
        const double *at = s->rate + a + (size_t)j * 8;
        wide even = values_get(at, arms), odd = j < order ? values_get(at + 8, arms) : wide_of(0);
        values_two(&phi, square, even * s->share[j], odd * s->share[j + 1]);
        for (int v = 0; v < VALUES_TOGETHER; v++) {
            if (j) rate.odd[v] = wide_fma(rate.odd[v], square[v], even);
            rate.even[v] = wide_fma(rate.even[v], square[v], odd);
        }
    }
    for (int v = 0; v < VALUES_TOGETHER; v++) {
        change[v].phi = x[v] * values_whole(&phi, v, x[v]);
        change[v].rate = x[v] * values_whole(&rate, v, x[v]) * inverse;
    }
}

/* phi'' and lambda */
VEC_INLINE void values_pull(const struct jets_system *s, int order, int arms, int a, const wide x[],
                            double inverse, struct values_wish wish,
                            struct values_change change[]) {
    wide square[VALUES_TOGETHER];
    struct values_parts acc, force;
    int last = order - 1;
    values_start(&acc), values_start(&force);
    for (int v = 0; v < VALUES_TOGETHER; v++) square[v] = x[v] * x[v];
    for (int j = last - last % 2; j >= 0; j -= 2) {
        const double *rate = s->rate + a + (size_t)(j + 1) * 8,
                     *tension = s->force + a + (size_t)j * 8;
        wide zero = wide_of(0);
        if (wish.acc)
            values_two(&acc, square, values_get(rate, arms) * (double)(j + 1),
                       j < last ? values_get(rate + 8, arms) * (double)(j + 2) : zero);
        if (wish.force)
            values_two(&force, square, values_get(tension, arms),
                       j < last ? values_get(tension + 8, arms) : zero);
    }
    for (int v = 0; v < VALUES_TOGETHER; v++) {
        change[v].acc = values_whole(&acc, v, x[v]) * (inverse * inverse);
        change[v].force = values_whole(&force, v, x[v]) * (inverse * inverse);
    }
}

/* computes the arms from a on for up to VALUES_TOGETHER vectors of instants, from row `to` on */
VEC_INLINE void values_block(const struct jets_system *s, int order, int arms, int a,
                             const double x[], int count, double unit,
                             const struct jets_state *from, const struct jets_values *to,
                             struct values_wish wish) {
    int n = s->n, step = values_instants(arms);
    double inverse = 1 / unit; // exact, because the unit is a power of two
    wide place[VALUES_TOGETHER];
    struct values_change change[VALUES_TOGETHER];
    for (int v = 0; v < VALUES_TOGETHER; v++)
        place[v] =
            v * step < count ? values_places(x + v * step, arms, count - v * step) : wide_of(0);
    values_motion(s, order, arms, a, place, inverse, change);
    if (wish.acc || wish.force) values_pull(s, order, arms, a, place, inverse, wish, change);
    wide phi = values_get(from->phi + a, arms), phi_low = values_get(from->phi_low + a, arms);
    wide rate = values_get(from->rate + a, arms), rate_low = values_get(from->rate_low + a, arms);
    for (int v = 0; v < VALUES_TOGETHER && v * step < count; v++) {
        size_t row = (size_t)(v * step) * (size_t)n;
        int left = count - v * step;
        values_put(to->phi + row, n, arms, a, left, phi + (change[v].phi + phi_low));
        values_put(to->rate + row, n, arms, a, left, rate + (change[v].rate + rate_low));
        if (wish.acc) values_put(to->acc + row, n, arms, a, left, change[v].acc);
        if (wish.force) values_put(to->force + row, n, arms, a, left, change[v].force);
    }
}

VEC_INLINE void values_small(const struct jets_system *s, int order, int arms, const double x[],
                             int count, double unit, const struct jets_state *from,
                             const struct jets_values *to, struct values_wish wish) {
    int most = VALUES_TOGETHER * values_instants(arms);
    for (int i = 0; i < count; i += most) {
        size_t row = (size_t)i * (size_t)s->n;
        struct jets_values here = {to->phi + row, to->rate + row, wish.acc ? to->acc + row : NULL,
                                   wish.force ? to->force + row : NULL};
        for (int a = 0; a < s->n; a += values_side(arms))
            values_block(s, order, arms, a, x + i, count - i < most ? count - i : most, unit, from,
                         &here, wish);
    }
}

/* ---- trees of any size */

VEC_INLINE void values_some(const struct jets_system *s, int order, const double x[], int count,
                            double unit, const struct jets_state *from,
                            const struct jets_values *to, struct values_wish wish) {
    if (s->n > 8)
        values_large(s, order, x, count, unit, from, to, wish);
    else if (s->n > 4)
        values_small(s, order, 8, x, count, unit, from, to, wish);
    else if (s->n > 2)
        values_small(s, order, 4, x, count, unit, from, to, wish);
    else
        values_small(s, order, 2, x, count, unit, from, to, wish);
}

static void kernel_values(const struct jets_system *s, int order, const double x[], int count,
                          double unit, const struct jets_state *from,
                          const struct jets_values *to) {
    if (to->acc && to->force)
        values_some(s, order, x, count, unit, from, to, (struct values_wish){1, 1});
    else if (to->force)
        values_some(s, order, x, count, unit, from, to, (struct values_wish){0, 1});
    else if (to->acc)
        values_some(s, order, x, count, unit, from, to, (struct values_wish){1, 0});
    else
        values_some(s, order, x, count, unit, from, to, (struct values_wish){0, 0});
}
