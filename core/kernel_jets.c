#include "core/kernel_jets.h"

#include <string.h>

#include "core/lanes.h"

/* numbers of the sweeps are doubles; loops over arms take as many at once as the instruction set holds */
#if defined(__AVX512F__)
enum { WIDE = 8 };
typedef lanes8 wide;
#define WIDE_(name) lanes8_##name
#elif defined(__AVX2__)
enum { WIDE = 4 };
typedef lanes4 wide;
#define WIDE_(name) lanes4_##name
#else
enum { WIDE = 2 };
typedef lanes2 wide;
#define WIDE_(name) lanes2_##name
#endif
#define wide_fma WIDE_(fma)
#define wide_of WIDE_(of)
#define wide_get WIDE_(get)
#define wide_put WIDE_(put)
#define num_fma lanes1_fma

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
#include "core/jets_factor.h"

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
    jets_factor(s);
    if (s->n > 8)
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

LANES_INLINE struct kernel_change kernel_horner(const struct jets_system *s, int order, double x_, double unit, int a,
                                                int acc, int force) {
    wide x = wide_of(x_);
    struct kernel_change v = {wide_of(0), wide_of(0), wide_of(0), wide_of(0)};
    const double *rate = s->rate + jets_row(s, a) + (size_t)order * s->stride;
    const double *tension = s->force + jets_row(s, a) + (size_t)(order - 1) * s->stride;
    for (int j = order; j >= 1; j--) {
        wide w = wide_get(rate);
        v.phi = wide_fma(v.phi, x, w * s->share[j]);
        v.rate = wide_fma(v.rate, x, w);
        if (acc) v.acc = wide_fma(v.acc, x, w * (double)j);
        if (force) v.force = wide_fma(v.force, x, wide_get(tension));
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

static void kernel_advance(const struct jets_system *s, int order, double x, double unit, const struct jets_state *from,
                           const struct jets_state *to) {
    for (int a = 0; a < s->n; a += WIDE) {
        struct kernel_change v = kernel_horner(s, order, x, unit, a, 0, 0);
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

LANES_INLINE void kernel_values_some(const struct jets_system *s, int order, double x, double unit,
                                     const struct jets_state *from, const struct jets_values *to, int acc, int force) {
    for (int a = 0; a < s->n; a += WIDE) {
        struct kernel_change v = kernel_horner(s, order, x, unit, a, acc, force);
        kernel_give(to->phi, a, s->n, wide_get(from->phi + a) + (v.phi + wide_get(from->phi_low + a)));
        kernel_give(to->rate, a, s->n, wide_get(from->rate + a) + (v.rate + wide_get(from->rate_low + a)));
        if (acc) kernel_give(to->acc, a, s->n, v.acc);
        if (force) kernel_give(to->force, a, s->n, v.force);
    }
}

static void kernel_values(const struct jets_system *s, int order, double x, double unit, const struct jets_state *from,
                          const struct jets_values *to) {
    if (to->acc && to->force)
        kernel_values_some(s, order, x, unit, from, to, 1, 1);
    else if (to->force)
        kernel_values_some(s, order, x, unit, from, to, 0, 1);
    else if (to->acc)
        kernel_values_some(s, order, x, unit, from, to, 1, 0);
    else
        kernel_values_some(s, order, x, unit, from, to, 0, 0);
}

#define KERNEL_PASTE2(a, b) a##b
#define KERNEL_PASTE(a, b) KERNEL_PASTE2(a, b)

const struct jets_kernel KERNEL_PASTE(pend_kernel_jets_, PEND_ISA) = {
    .orders = kernel_orders,
    .advance = kernel_advance,
    .values = kernel_values,
};
