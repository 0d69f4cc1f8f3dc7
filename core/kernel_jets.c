#include "core/kernel_jets.h"

#include <math.h>
#include <string.h>

#include "core/kernel_width.h"

/* numbers of the sweeps are doubles; loops over arms take as many at once as the instruction set holds */
enum { WIDE = KERNEL_WIDTH };
typedef KERNEL_OF(lanes, ) wide;
#define WIDE_(name) KERNEL_OF(lanes, _##name)
#define wide_fma WIDE_(fma)
#define wide_of WIDE_(of)
#define wide_get WIDE_(get)
#define wide_put WIDE_(put)
#define num_fma lanes1_fma

/* terms that a step is judged by; the longest step in units, as a binary logarithm */
enum { KERNEL_SIZES = 8, KERNEL_FAR = 1000, KERNEL_ORDERS = 40 };

LANES_INLINE double num_of(double x) { return x; }
LANES_INLINE double num_add(double x, double y) { return x + y; }
LANES_INLINE double num_sub(double x, double y) { return x - y; }
LANES_INLINE double num_mul(double x, double y) { return x * y; }
LANES_INLINE double num_div(double x, double y) { return x / y; }
LANES_INLINE wide wide_neg(wide x) { return -x; }
LANES_INLINE wide wide_add(wide x, wide y) { return x + y; }
LANES_INLINE wide wide_sub(wide x, wide y) { return x - y; }
LANES_INLINE wide wide_mul(wide x, wide y) { return x * y; }
#include "core/blocks_kernel.h"

#define LANES 2
#include "core/small_kernel.h"
#define LANES 4
#include "core/small_kernel.h"
#define LANES 8
#include "core/small_kernel.h"
#include "core/values_kernel.h"

/* the angle of an arm to its parent, as the sum of two doubles */
LANES_INLINE void kernel_angle(const struct jets_system *s, const struct jets_state *state, int k) {
    int p = s->parent[k];
    double x = state->phi[k], y = p < 0 ? 0 : state->phi[p], low = p < 0 ? 0 : state->phi_low[p];
    double d = x - y, back = x - d;
    s->angle[k] = d;
    s->angle_low[k] = ((x - (d + back)) + (back - y)) + (state->phi_low[k] - low);
}

static void kernel_orders(const struct jets_system *s, const struct jets_state *state, double gravity, double unit,
                          int order) {
    for (int k = 0; k < s->n; k++) kernel_angle(s, state, k);
    for (int a = 0; a < s->n; a += WIDE) {
        wide sine, cosine;
        WIDE_(sincos)(wide_get(s->angle + a), wide_get(s->angle_low + a), &sine, &cosine);
        wide_put(s->sine + a, sine);
        wide_put(s->cosine + a, cosine);
        wide_put(s->rate + jets_row(s, a), wide_get(state->rate + a) * unit);
    }
    gravity *= unit * unit;
    if (s->n > 8)
        blocks_orders(s, gravity, order);
    else if (s->n > 4)
        small8_orders(s, gravity, order);
    else if (s->n > 2)
        small4_orders(s, gravity, order);
    else
        small2_orders(s, gravity, order);
}

/* sum + add, exactly, as a sum of two */
LANES_INLINE void kernel_sum(wide sum, wide add, double *high, double *low) {
    wide total = sum + add, part = total - sum;
    wide_put(high, total);
    wide_put(low, (sum - (total - part)) + (add - part));
}

/* changes of phi and phi', even and odd orders apart: half the waiting */
LANES_INLINE struct values_change kernel_halves(const struct jets_system *s, int order, double x_, double unit, int a) {
    wide x = wide_of(x_), square = x * x, phi[2] = {wide_of(0), wide_of(0)}, rate[2] = {wide_of(0), wide_of(0)};
    const double *from = s->rate + jets_row(s, a);
    for (int j = order - order % 2; j >= 0; j -= 2) {
        wide even = wide_get(from + (size_t)j * s->stride);
        // the row after the last is zero
        wide odd = j < order ? wide_get(from + (size_t)(j + 1) * s->stride) : wide_of(0);
        phi[0] = wide_fma(phi[0], square, even * s->share[j]);
        phi[1] = wide_fma(phi[1], square, odd * s->share[j + 1]);
        if (j) rate[0] = wide_fma(rate[0], square, even);
        rate[1] = wide_fma(rate[1], square, odd);
    }
    // what is left of the even orders of phi' has x^2 outstanding, of the odd ones x
    double inverse = 1 / unit;
    wide turn = x * wide_fma(x, rate[0], rate[1]);
    return (struct values_change){.phi = x * wide_fma(x, phi[1], phi[0]), .rate = turn * inverse};
}

static void kernel_advance(const struct jets_system *s, int order, double x, double unit, const struct jets_state *from,
                           const struct jets_state *to) {
    for (int a = 0; a < s->n; a += WIDE) {
        struct values_change v = kernel_halves(s, order, x, unit, a);
        kernel_sum(wide_get(from->phi + a), v.phi + wide_get(from->phi_low + a), to->phi + a, to->phi_low + a);
        kernel_sum(wide_get(from->rate + a), v.rate + wide_get(from->rate_low + a), to->rate + a, to->rate_low + a);
    }
}

LANES_INLINE bits8 kernel_larger(bits8 x, bits8 y) {
#ifdef __AVX512F__
    return (bits8)_mm512_max_epi64((__m512i)x, (__m512i)y);
#else
    bits8 more = x > y;
    return (x & more) | (y & ~more);
#endif
}

/*
 * The largest magnitudes among the arms of rate_0 .. rate_3 and of rate_{order - 3} .. rate_order, one a lane. They are
 * compared as integers: the order is the same, and what is not finite is largest.
 */
LANES_INLINE bits8 kernel_sizes(const struct jets_system *s, int order) {
    bits8 x[KERNEL_SIZES], pair[4], four[2];
    for (int i = 0; i < KERNEL_SIZES; i++) x[i] = (bits8){0};
    for (size_t a = 0; a < (size_t)s->n; a += 8) {
        const double *first = s->rate + a / 8 * s->tile, *last = first + (size_t)(order + 1 - KERNEL_SIZES) * s->stride;
        for (int i = 0; i < KERNEL_SIZES; i++) {
            const double *row = i < KERNEL_SIZES / 2 ? first : last;
            x[i] = kernel_larger(x[i], (bits8)lanes8_abs(lanes8_get(row + (size_t)i * s->stride)));
        }
    }
    for (int i = 0; i < 4; i++) {
        bits8 even = x[2 * i], odd = x[2 * i + 1];
        pair[i] = kernel_larger(__builtin_shufflevector(even, odd, 0, 8, 2, 10, 4, 12, 6, 14),
                                __builtin_shufflevector(even, odd, 1, 9, 3, 11, 5, 13, 7, 15));
    }
    for (int i = 0; i < 2; i++) {
        bits8 even = pair[2 * i], odd = pair[2 * i + 1];
        four[i] = kernel_larger(__builtin_shufflevector(even, odd, 0, 1, 8, 9, 4, 5, 12, 13),
                                __builtin_shufflevector(even, odd, 2, 3, 10, 11, 6, 7, 14, 15));
    }
    return kernel_larger(__builtin_shufflevector(four[0], four[1], 0, 1, 2, 3, 8, 9, 10, 11),
                         __builtin_shufflevector(four[0], four[1], 4, 5, 6, 7, 12, 13, 14, 15));
}

/* the trailing terms in lanes, the leading ones in turn */
static double kernel_reach(const struct jets_system *s, int order, double log_rtol, double log_atol) {
    // phi has the coefficients of the rates over 1 .. 4
    static const double log2_of[4] = {0, 1, 1.5849625007211562, 2};
    const long long least = 1LL << 52, infinite = 0x7ffLL << 52; // bits of normal numbers lie between
    const double *share = s->share + order - 3;
    bits8 sizes = kernel_sizes(s, order), bad = sizes >= infinite;
    lanes8 logs = lanes8_log2((lanes8)sizes);
    lanes4 trailing = __builtin_shufflevector(logs, logs, 4, 5, 6, 7), part, here;
    long long any = 0;
    for (int i = 0; i < KERNEL_SIZES; i++) any |= bad[i];
    if (any) return NAN;
    memcpy(&part, share, sizeof part);
    here = log_atol * s->share[order + 1] - trailing * part;
    for (int i = 0; i < 4; i++) {
        if (sizes[i] < least) continue;
        // a radius of convergence from a trailing term and a leading one, times what is left of it at the tolerance
        memcpy(&part, share - i - 1, sizeof part);
        lanes4 gap = lanes4_of(logs[i] - log2_of[i]) - trailing;
        here = lanes4_max(lanes4_of(log_rtol * s->share[order - i]) + gap * part, here);
    }
    double reach = KERNEL_FAR;
    for (int i = 0; i < 4; i++) {
        if (sizes[4 + i] >= least && here[i] < reach) reach = here[i];
    }
    return lanes2_exp2(lanes2_of(reach > -KERNEL_FAR ? reach : -KERNEL_FAR))[0];
}

const struct jets_kernel KERNEL_NAME(pend_kernel_jets_) = {
    .orders = kernel_orders,
    .advance = kernel_advance,
    .reach = kernel_reach,
    .values = kernel_values,
};
