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
#include "core/strand_kernel.h"

#define LANES 2
#include "core/small_kernel.h"
#define LANES 4
#include "core/small_kernel.h"
#define LANES 8
#include "core/small_kernel.h"

/* the angle of an arm to its parent, as the sum of two doubles */
LANES_INLINE void kernel_angle(const struct jets_system *s, const struct jets_state *state, int k) {
    int p = s->parent[k];
    double x = state->phi[k], y = p < 0 ? 0 : state->phi[p], low = p < 0 ? 0 : state->phi_low[p];
    double d = x - y, back = x - d;
    s->angle[k] = d;
    s->angle_low[k] = ((x - (d + back)) + (back - y)) + (state->phi_low[k] - low);
}

/* the same of a strand, whose arms' parents are the arms before them */
static void kernel_strand_angles(const struct jets_system *s, const struct jets_state *state) {
    wide last = wide_of(0), last_low = wide_of(0);
    for (int a = 0; a < s->n; a += WIDE) {
        wide x = wide_get(state->phi + a), low = wide_get(state->phi_low + a);
        wide y = strand_unshift(last, x), d = x - y, back = x - d;
        wide_put(s->angle + a, d);
        wide_put(s->angle_low + a, ((x - (d + back)) + (back - y)) + (low - strand_unshift(last_low, low)));
        last = x, last_low = low;
    }
}

static void kernel_orders(const struct jets_system *s, const struct jets_state *state, double gravity, double unit,
                          int order) {
    if (s->strand) kernel_strand_angles(s, state);
    for (int k = 0; k < s->n && !s->strand; k++) kernel_angle(s, state, k);
    for (int a = 0; a < s->n; a += WIDE) {
        wide sine, cosine;
        WIDE_(sincos)(wide_get(s->angle + a), wide_get(s->angle_low + a), &sine, &cosine);
        wide_put(s->sine + a, sine);
        wide_put(s->cosine + a, cosine);
        wide_put(s->rate + jets_row(s, a), wide_get(state->rate + a) * unit);
    }
    gravity *= unit * unit;
    if (s->strand)
        strand_orders(s, gravity, order);
    else if (s->n > 8)
        blocks_orders(s, gravity, order);
    else if (s->n > 4)
        small8_orders(s, gravity, order);
    else if (s->n > 2)
        small4_orders(s, gravity, order);
    else
        small2_orders(s, gravity, order);
}

/* changes of phi and phi' and, where wanted, the new phi'' and lambda of the arms from a on, by Horner's rule */
struct kernel_change {
    wide phi, rate, acc, force;
};

/* what an instant is asked for, beside phi and phi' */
struct kernel_wish {
    int acc, force;
};

LANES_INLINE struct kernel_change kernel_horner(const struct jets_system *s, int order, double x_, double unit, int a,
                                                struct kernel_wish wish) {
    wide x = wide_of(x_);
    struct kernel_change v = {wide_of(0), wide_of(0), wide_of(0), wide_of(0)};
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

/* sum + add, exactly, as a sum of two */
LANES_INLINE void kernel_sum(wide sum, wide add, double *high, double *low) {
    wide total = sum + add, part = total - sum;
    wide_put(high, total);
    wide_put(low, (sum - (total - part)) + (add - part));
}

/* changes of phi and phi', even and odd orders apart: half the waiting */
LANES_INLINE struct kernel_change kernel_halves(const struct jets_system *s, int order, double x_, double unit, int a) {
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
    return (struct kernel_change){.phi = x * wide_fma(x, phi[1], phi[0]), .rate = turn * inverse};
}

static void kernel_advance(const struct jets_system *s, int order, double x, double unit, const struct jets_state *from,
                           const struct jets_state *to) {
    for (int a = 0; a < s->n; a += WIDE) {
        struct kernel_change v = kernel_halves(s, order, x, unit, a);
        kernel_sum(wide_get(from->phi + a), v.phi + wide_get(from->phi_low + a), to->phi + a, to->phi_low + a);
        kernel_sum(wide_get(from->rate + a), v.rate + wide_get(from->rate_low + a), to->rate + a, to->rate_low + a);
    }
}

LANES_INLINE void kernel_give(double to[], int a, int n, wide x) {
    if (!to) return;
    if (a + WIDE <= n) {
        memcpy(to + a, &x, sizeof x);
        return;
    }
    for (int i = 0; a + i < n; i++) to[a + i] = x[i];
}

/* one instant, arms in lanes */
LANES_INLINE void kernel_row(const struct jets_system *s, int order, double x, double unit,
                             const struct jets_state *from, const struct jets_values *to, struct kernel_wish wish) {
    for (int a = 0; a < s->n; a += WIDE) {
        struct kernel_change v = kernel_horner(s, order, x, unit, a, wish);
        kernel_give(to->phi, a, s->n, wide_get(from->phi + a) + (v.phi + wide_get(from->phi_low + a)));
        kernel_give(to->rate, a, s->n, wide_get(from->rate + a) + (v.rate + wide_get(from->rate_low + a)));
        if (wish.acc) kernel_give(to->acc, a, s->n, v.acc);
        if (wish.force) kernel_give(to->force, a, s->n, v.force);
    }
}

/* series of phi and phi'' of up to 8 arms, order by order, from those of phi' */
struct kernel_table {
    double phi[(KERNEL_ORDERS + 1) * 8], acc[(KERNEL_ORDERS + 1) * 8];
};

LANES_INLINE void kernel_table(const struct jets_system *s, int order, int acc, struct kernel_table *table) {
    for (int j = 0; j <= order; j++) {
        lanes8 rate = lanes8_get(s->rate + (size_t)j * s->stride), phi = rate * s->share[j], bend = rate * (double)j;
        memcpy(table->phi + 8 * j, &phi, sizeof phi);
        if (acc && j) memcpy(table->acc + 8 * (j - 1), &bend, sizeof bend);
    }
}

/* a sum over the orders up to `last` of one arm, instants in lanes: even and odd ones apart, as in kernel_advance */
struct kernel_parts {
    wide even, odd;
};

LANES_INLINE struct kernel_parts kernel_top(const double *at, int last) {
    int odd = last % 2;
    return (struct kernel_parts){wide_of(at[8 * (last - odd)]), odd ? wide_of(at[8 * last]) : wide_of(0)};
}

LANES_INLINE void kernel_two(struct kernel_parts *sum, const double *at, int j, wide square) {
    sum->even = wide_fma(sum->even, square, wide_of(at[8 * j]));
    sum->odd = wide_fma(sum->odd, square, wide_of(at[8 * j + 8]));
}

/* two arms, up to WIDE instants in lanes */
LANES_INLINE void kernel_column(const struct jets_system *s, const struct kernel_table *table, int order, wide x,
                                double unit, const int pair[2], struct kernel_wish wish, struct kernel_change v[2]) {
    double inverse = 1 / unit; // exact: a power of two
    wide square = x * x;
    struct kernel_parts phi[2], rate[2], acc[2], force[2];
    int last = order - 1;
    for (int i = 0; i < 2; i++) {
        int k = pair[i];
        phi[i] = kernel_top(table->phi + k, order);
        // phi' without its start, over x
        rate[i] = kernel_top(s->rate + 8 + k, last);
        if (wish.acc) acc[i] = kernel_top(table->acc + k, last);
        if (wish.force) force[i] = kernel_top(s->force + k, last);
    }
    for (int j = order - order % 2 - 2; j >= 0; j -= 2)
        for (int i = 0; i < 2; i++) kernel_two(&phi[i], table->phi + pair[i], j, square);
    for (int j = last - last % 2 - 2; j >= 0; j -= 2)
        for (int i = 0; i < 2; i++) kernel_two(&rate[i], s->rate + 8 + pair[i], j, square);
    for (int j = last - last % 2 - 2; j >= 0 && wish.acc; j -= 2)
        for (int i = 0; i < 2; i++) kernel_two(&acc[i], table->acc + pair[i], j, square);
    for (int j = last - last % 2 - 2; j >= 0 && wish.force; j -= 2)
        for (int i = 0; i < 2; i++) kernel_two(&force[i], s->force + pair[i], j, square);
    for (int i = 0; i < 2; i++) {
        v[i].phi = x * wide_fma(x, phi[i].odd, phi[i].even);
        v[i].rate = x * wide_fma(x, rate[i].odd, rate[i].even) * inverse;
        if (wish.acc) v[i].acc = wide_fma(x, acc[i].odd, acc[i].even) * (inverse * inverse);
        if (wish.force) v[i].force = wide_fma(x, force[i].odd, force[i].even) * (inverse * inverse);
    }
}

/* values of two arms, instants in lanes, to two neighbours in each of WIDE rows */
LANES_INLINE void kernel_spread(double rows[], int n, wide first, wide second) {
    for (int i = 0; i < WIDE; i++) {
        lanes2 pair = {first[i], second[i]};
        memcpy(rows + (size_t)i * (size_t)n, &pair, sizeof pair);
    }
}

/* up to WIDE instants: rows are written whole here and copied, for loops that end at count would be foretold badly */
LANES_INLINE void kernel_columns(const struct jets_system *s, const struct kernel_table *table, int order,
                                 const double x[], int count, double unit, const struct jets_state *from,
                                 const struct jets_values *to, struct kernel_wish wish) {
    double phi[WIDE * 8 + 1], rate[WIDE * 8 + 1], acc[WIDE * 8 + 1], force[WIDE * 8 + 1];
    wide at = wide_of(0);
    int n = s->n;
    size_t bytes = (size_t)count * (size_t)n * sizeof(double);
    memcpy(&at, x, (size_t)count * sizeof *x);
    // the last arm of an odd number writes into the row after, before that row's first arm does
    for (int k = (n - 1) / 2 * 2; k >= 0; k -= 2) {
        // two arms side by side: a lone series would wait for itself
        int pair[2] = {k, k + 1 < n ? k + 1 : k};
        struct kernel_change v[2];
        kernel_column(s, table, order, at, unit, pair, wish, v);
        for (int i = 0; i < 2; i++) {
            int arm = pair[i];
            v[i].phi = from->phi[arm] + (v[i].phi + from->phi_low[arm]);
            v[i].rate = from->rate[arm] + (v[i].rate + from->rate_low[arm]);
        }
        kernel_spread(phi + k, n, v[0].phi, v[1].phi);
        kernel_spread(rate + k, n, v[0].rate, v[1].rate);
        if (wish.acc) kernel_spread(acc + k, n, v[0].acc, v[1].acc);
        if (wish.force) kernel_spread(force + k, n, v[0].force, v[1].force);
    }
    memcpy(to->phi, phi, bytes);
    memcpy(to->rate, rate, bytes);
    if (wish.acc) memcpy(to->acc, acc, bytes);
    if (wish.force) memcpy(to->force, force, bytes);
}

/* small trees have their instants in lanes, large ones their arms */
LANES_INLINE void kernel_values_some(const struct jets_system *s, int order, const double x[], int count, double unit,
                                     const struct jets_state *from, const struct jets_values *values,
                                     struct kernel_wish wish) {
    int many = s->n > 8 ? 1 : WIDE;
    struct kernel_table table;
    if (s->n <= 8) kernel_table(s, order, wish.acc, &table);
    for (int i = 0; i < count; i += many) {
        size_t row = (size_t)i * (size_t)s->n;
        struct jets_values to = {values->phi + row, values->rate + row, wish.acc ? values->acc + row : NULL,
                                 wish.force ? values->force + row : NULL};
        if (many == 1)
            kernel_row(s, order, x[i], unit, from, &to, wish);
        else
            kernel_columns(s, &table, order, x + i, count - i < many ? count - i : many, unit, from, &to, wish);
    }
}

static void kernel_values(const struct jets_system *s, int order, const double x[], int count, double unit,
                          const struct jets_state *from, const struct jets_values *to) {
    if (to->acc && to->force)
        kernel_values_some(s, order, x, count, unit, from, to, (struct kernel_wish){1, 1});
    else if (to->force)
        kernel_values_some(s, order, x, count, unit, from, to, (struct kernel_wish){0, 1});
    else if (to->acc)
        kernel_values_some(s, order, x, count, unit, from, to, (struct kernel_wish){1, 0});
    else
        kernel_values_some(s, order, x, count, unit, from, to, (struct kernel_wish){0, 0});
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
