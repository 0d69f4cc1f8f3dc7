#include "core/taylor/jets/kernel_jets.h"

#include <float.h>
#include <math.h>

#include "core/taylor/taylor_order.h"
#include "core/tree/turns.h"

/* sweeps compute with single doubles; loops over arms compute WIDE arms at once */
/* number of terms that determine the step; binary logarithm of the longest step in units */
enum { KERNEL_SIZES = 8, KERNEL_FAR = 1000 };

#include "core/taylor/large/blocks_template.h"
#include "core/taylor/large/chain_template.h"
#include "core/taylor/large/rods_template.h"

#define LANES 2
#include "core/taylor/small/small_template.h"
#define LANES 4
#include "core/taylor/small/small_template.h"
#define LANES 8
#include "core/taylor/jets/values_template.h"
#include "core/taylor/single_template.h"
#include "core/taylor/small/small_template.h"

/* the angle of arm k relative to its parent, as the sum of two doubles */
VEC_INLINE void kernel_angle(const struct jets_system *s, const struct jets_state *state, int k) {
    int p = s->parent[k];
    double x = state->phi[k], y = p < 0 ? 0 : state->phi[p], low = p < 0 ? 0 : state->phi_low[p];
    double d = x - y, back = x - d;
    s->angle[k] = d;
    s->angle_low[k] = ((x - (d + back)) + (back - y)) + (state->phi_low[k] - low);
}

/* kernel_angle for a chain, in which the parent of each arm is the previous arm */
static void kernel_chain_angles(const struct jets_system *s, const struct jets_state *state) {
    wide last = wide_of(0), last_low = wide_of(0);
    for (int a = 0; a < s->n; a += WIDE) {
        wide x = wide_get(state->phi + a), low = wide_get(state->phi_low + a);
        wide y = wide_unshift(last, x), d = x - y, back = x - d;
        wide_put(s->angle + a, d);
        wide_put(s->angle_low + a,
                 ((x - (d + back)) + (back - y)) + (low - wide_unshift(last_low, low)));
        last = x, last_low = low;
    }
}

/* series of a real pendulum of more than eight arms */
static void kernel_loaded_large(const struct jets_system *s, const double *value,
                                const struct bodies_moment *now, int order) {
    struct jets_loads *loads = s->loads;
    loads_number(s, value, now, order);
    if (loads->couples) couples_begin(s, now, order);
    if (s->rods) {
        (loads->couples ? rods_coupled_orders : rods_orders)(s, now->gravity, order);
        if (loads->moves) rods_haul(s, order);
        rods_tips(s, 0, 1);
        loads->orders = order;
        return;
    }
    if (s->chain)
        (loads->couples ? chain_coupled_orders : chain_orders)(s, now->gravity, order);
    else
        (loads->couples ? blocks_coupled_orders : blocks_orders)(s, now->gravity, order);
    if (loads->moves) couples_haul(s, order);
    loads->orders = loads->couples ? order : 0;
}

static void kernel_loaded(const struct jets_system *s, const struct jets_state *state,
                          const struct pend_loads *loads, double unit, int order) {
    struct bodies_moment now = {unit, loads->gravity * (unit * unit), state->time, state->late};
    if (s->n > 8) {
        kernel_loaded_large(s, loads->value, &now, order);
        return;
    }
    for (int k = 0; k < s->n && s->loads->springs; k++) {
        double high = k ? 0 : M_PI_2, low = k ? 0 : PEND_QUARTER_LOW;
        s->loads->bend[k] = (s->angle[k] + high) + (s->angle_low[k] + low);
    }
    if (s->n > 4)
        small8_loaded_orders(s, loads->value, &now, order);
    else if (s->n > 2)
        small4_loaded_orders(s, loads->value, &now, order);
    else
        small2_loaded_orders(s, loads->value, &now, order);
}

static void kernel_along(const struct jets_system *s, int order) {
    if (s->rods) rods_tips(s, 1, order);
    if (s->n > 8)
        couples_along(s, order);
    else if (s->n > 4)
        small8_along(s, order);
    else if (s->n > 2)
        small4_along(s, order);
    else
        small2_along(s, order);
}

static void kernel_power(const struct jets_system *s, int order, double work[], double heat[]) {
    double sums[2][LOADS_ORDERS] = {{0}};
    if (s->n > 8)
        couples_power(s, order, sums[0], sums[1]);
    else if (s->n > 4)
        small8_power(s, order, sums[0], sums[1]);
    else if (s->n > 2)
        small4_power(s, order, sums[0], sums[1]);
    else
        small2_power(s, order, sums[0], sums[1]);
    memcpy(work, sums[0], (size_t)order * sizeof(double));
    memcpy(heat, sums[1], (size_t)order * sizeof(double));
}

static void kernel_orders(const struct jets_system *s, const struct jets_state *state,
                          const struct pend_loads *loads, double unit, int order) {
    if (s->chain) kernel_chain_angles(s, state);
    for (int k = 0; k < s->n && !s->chain; k++) kernel_angle(s, state, k);
    for (int a = 0; a < s->n; a += WIDE) {
        wide sine, cosine;
        WIDE_(sincos)(wide_get(s->angle + a), wide_get(s->angle_low + a), &sine, &cosine);
        wide_put(s->sine + a, sine);
        wide_put(s->cosine + a, cosine);
        wide_put(s->rate + jets_row(s, a), wide_get(state->rate + a) * unit);
    }
    if (s->loads) {
        kernel_loaded(s, state, loads, unit, order);
        return;
    }
    double gravity = loads->gravity * (unit * unit);
    if (s->chain)
        chain_orders(s, gravity, order);
    else if (s->n > 8)
        blocks_orders(s, gravity, order);
    else if (s->n > 4)
        small8_orders(s, gravity, order);
    else if (s->n > 2)
        small4_orders(s, gravity, order);
    else if (s->n > 1)
        small2_orders(s, gravity, order);
    else
        single_orders(s, gravity, order);
}

/* sum + add, exactly, as a sum of two doubles */
VEC_INLINE void kernel_sum(wide sum, wide add, double *high, double *low) {
    wide total = sum + add, part = total - sum;
    wide_put(high, total);
    wide_put(low, (sum - (total - part)) + (add - part));
}

/* the rates of the next `arms` arms (2, 4 or 8), with zeros in the other lanes: for few arms,
 * memory has the forces next to the rates */
VEC_INLINE wide kernel_rates(const double *at, int arms) {
#if defined(__AVX512F__)
    if (arms == 2) return (wide)_mm512_zextpd128_pd512(_mm_load_pd(at));
    if (arms == 4) return (wide)_mm512_zextpd256_pd512(_mm256_load_pd(at));
#elif KERNEL_WIDTH == 4
    if (arms == 2) return (wide)_mm256_zextpd128_pd256(_mm_load_pd(at));
#endif
    (void)arms;
    return wide_get(at);
}

/* changes of phi and phi'; even and odd orders have separate sums, which halves the latency */
VEC_INLINE struct values_change kernel_halves(const struct jets_system *s, int order, double x_,
                                              double unit, int a, int arms) {
    wide x = wide_of(x_), square = x * x, phi[2] = {wide_of(0), wide_of(0)},
         rate[2] = {wide_of(0), wide_of(0)};
    const double *from = s->rate + jets_row(s, a);
    for (int j = order - order % 2; j >= 0; j -= 2) {
        wide even = kernel_rates(from + (size_t)j * s->stride, arms);
        wide odd = j < order ? kernel_rates(from + (size_t)(j + 1) * s->stride, arms) : wide_of(0);
        phi[0] = wide_fma(phi[0], square, even * s->share[j]);
        phi[1] = wide_fma(phi[1], square, odd * s->share[j + 1]);
        if (j) rate[0] = wide_fma(rate[0], square, even);
        rate[1] = wide_fma(rate[1], square, odd);
    }
    // until here rate[0] lacks the factor x^2, and rate[1] the factor x
    double inverse = 1 / unit;
    wide turn = x * wide_fma(x, rate[0], rate[1]);
    return (struct values_change){.phi = x * wide_fma(x, phi[1], phi[0]), .rate = turn * inverse};
}

VEC_INLINE void kernel_advance_some(const struct jets_system *s, int order, double x, double unit,
                                    const struct jets_state *from, const struct jets_state *to,
                                    int arms) {
    for (int a = 0; a < s->n; a += WIDE) {
        struct values_change v = kernel_halves(s, order, x, unit, a, arms);
        kernel_sum(wide_get(from->phi + a), v.phi + wide_get(from->phi_low + a), to->phi + a,
                   to->phi_low + a);
        kernel_sum(wide_get(from->rate + a), v.rate + wide_get(from->rate_low + a), to->rate + a,
                   to->rate_low + a);
    }
}

static void kernel_advance(const struct jets_system *s, int order, double x, double unit,
                           const struct jets_state *from, const struct jets_state *to) {
    if (s->n > 4)
        kernel_advance_some(s, order, x, unit, from, to, 8);
    else if (s->n > 2)
        kernel_advance_some(s, order, x, unit, from, to, 4);
    else
        kernel_advance_some(s, order, x, unit, from, to, 2);
}

/* four numbers, as one vector or as two */
#if KERNEL_WIDTH == 2
typedef lanes2 term;
#define TERM_(name) lanes2_##name
#else
typedef lanes4 term;
#define TERM_(name) lanes4_##name
#endif
enum {
    TERM_WIDTH = KERNEL_WIDTH == 2 ? 2 : 4,
    TERMS = KERNEL_SIZES / 2,
    TERM_PARTS = TERMS / TERM_WIDTH
};

struct kernel_terms {
    term part[KERNEL_SIZES / TERM_WIDTH]; /* leading terms first, then trailing ones */
};

VEC_INLINE term term_get(const double *at) {
    term x;
    memcpy(&x, at, sizeof x);
    return x;
}

/* row i of the rates that determine the step: rate_0 .. rate_3 and rate_{order - 3} ..
 * rate_order */
VEC_INLINE const double *kernel_term(const struct jets_system *s, int order, int i) {
    return s->rate + (size_t)(i < TERMS ? i : order + 1 - KERNEL_SIZES + i) * s->stride;
}

/* Returns, for each row of kernel_term, the largest magnitude among the arms; not a number, or
 * infinite, if a coefficient is.
 * arms  2, 4 or 8: the number of lanes that may be nonzero. */
VEC_INLINE struct kernel_terms kernel_sizes(const struct jets_system *s, int order, int arms) {
    struct kernel_terms terms;
    for (int i = 0; i < KERNEL_SIZES; i++) {
        wide most = wide_of(0), poison = wide_of(0);
        for (int a = 0; a < s->n; a += WIDE) {
            wide x = kernel_rates(kernel_term(s, order, i) + jets_row(s, a), arms);
            most = WIDE_(peak)(x, most);
            poison += x * 0;
        }
        double size = most[0], spoilt = poison[0];
        for (int lane = 1; lane < WIDE && lane < arms; lane++) {
            size = most[lane] > size ? most[lane] : size;
            spoilt += poison[lane];
        }
        terms.part[i / TERM_WIDTH][i % TERM_WIDTH] = size + spoilt;
    }
    return terms;
}

VEC_INLINE double term_least(const term x[]) {
#if KERNEL_WIDTH == 2
    lanes2 two = lanes2_min(x[0], x[1]);
#else
    lanes2 two = lanes2_min(__builtin_shufflevector(x[0], x[0], 0, 1),
                            __builtin_shufflevector(x[0], x[0], 2, 3));
#endif
    return lanes2_min(two, __builtin_shufflevector(two, two, 1, 0))[0];
}

/* the step in units: trailing terms are computed side by side in lanes, leading terms in a loop */
VEC_INLINE double kernel_reach_some(const struct jets_system *s, int order, double log_rtol,
                                    double log_atol, int arms) {
    // log2 of 1 .. 4: the coefficients of phi are those of the rates divided by
    // 1 .. 4
    static const double log2_of[TERMS] = {0, 1, 1.5849625007211562, 2};
    const double *share = s->share + order - 3;
    double spread = (PEND_TAYLOR_LOG_CAP - log_rtol) * s->share[order];
    struct kernel_terms size = kernel_sizes(s, order, arms);
    term here[TERM_PARTS], leading[TERM_PARTS], poison = TERM_(of)(0);
    for (int i = 0; i < KERNEL_SIZES / TERM_WIDTH; i++) poison += size.part[i] * 0;
    for (int i = 0; i < TERM_PARTS; i++)
        leading[i] = TERM_(log2)(size.part[i]) - term_get(log2_of + i * TERM_WIDTH);
    for (int i = 0; i < TERM_PARTS; i++) {
        const double *own = share + i * TERM_WIDTH;
        term trailing = TERM_(log2)(size.part[TERM_PARTS + i]), far = TERM_(of)(KERNEL_FAR);
        term atol = log_atol * s->share[order + 1] - trailing * term_get(own),
             most = TERM_(of)(-KERNEL_FAR);
        for (int j = 0; j < TERMS; j++) {
            if (size.part[j / TERM_WIDTH][j % TERM_WIDTH] < DBL_MIN) continue;
            // log2 of the step that a trailing and a leading term allow: their estimate of the
            // radius of convergence, times a margin for the tolerance
            term gap = TERM_(of)(leading[j / TERM_WIDTH][j % TERM_WIDTH]) - trailing;
            most = TERM_(max)(
                TERM_(of)(log_rtol * s->share[order - j]) + gap * term_get(own - j - 1), most);
        }
        // the tolerance atol may lengthen the step, at most to that of the largest rtol
        most = TERM_(max)(TERM_(min)(most + spread, atol), most);
        here[i] = TERM_(min)(TERM_(pick)(size.part[TERM_PARTS + i] < DBL_MIN, far, most), far);
    }
    double reach = term_least(here), spoilt = 0;
    for (int i = 0; i < TERM_WIDTH; i++) spoilt += poison[i];
    if (!(spoilt == 0)) return NAN;
    return lanes2_exp2(lanes2_of(reach > -KERNEL_FAR ? reach : -KERNEL_FAR))[0];
}

static double kernel_reach(const struct jets_system *s, int order, double log_rtol,
                           double log_atol) {
    if (s->n > 4) return kernel_reach_some(s, order, log_rtol, log_atol, 8);
    if (s->n > 2) return kernel_reach_some(s, order, log_rtol, log_atol, 4);
    return kernel_reach_some(s, order, log_rtol, log_atol, 2);
}

#include "core/taylor/jets/left_template.h"

/* A pendulum with one arm. The change d of its angle solves d'' = (g / l) sin(phi) d, and from
 * order 1 on the coefficients of sin phi are those of the force over 3 m g (single_orders). */
static double kernel_single_spread(const struct jets_system *s, const struct pend_loads *loads,
                                   const struct jets_spread *how, double *phi, double *speed) {
    double pull[JETS_SPREAD_MAX + 1], turn[JETS_SPREAD_MAX + 2], before = INFINITY;
    double x = how->x, unit = how->unit, rate = *speed * unit, power = x;
    double per_force = s->inv_len[0] / (3 * s->mass[0]), swing = s->rate[0] / unit;
    double least = how->least * fmax(fabs(*phi), fabs(rate * x)), turned = *phi, faster = 0;
    double force =
        s->mass[0] * (loads->gravity * s->cosine[0] * *phi - 2 * s->len[0] * swing * *speed);
    pull[0] = loads->gravity * (unit * unit) * s->inv_len[0] * s->sine[0];
    turn[0] = *phi, turn[1] = rate;
    for (int k = 0;; k++, power *= x) {
        double gap = rate * power, even = 0, odd = 0;
        faster += gap;
        turned += gap * s->share[k];
        if (k == how->order || (k >= JETS_SPREAD && fabs(gap) + before < least)) break;
        before = fabs(gap);
        if (k) pull[k] = s->force[(size_t)k * s->stride] * per_force;
        for (int j = 0; j < k; j += 2) {
            even = num_fma(pull[j], turn[k - j], even);
            odd = num_fma(pull[j + 1], turn[k - j - 1], odd);
        }
        if (k % 2 == 0) even = num_fma(pull[k], turn[0], even);
        rate = s->share[k] * (even + odd);
        turn[k + 2] = s->share[k + 1] * rate;
    }
    *phi = turned;
    *speed = faster / (x * unit);
    return fabs(force);
}

static double kernel_spread(const struct jets_system *s, const struct pend_loads *loads,
                            const struct jets_spread *how, double phi[], double rate[]) {
    if (s->n > 4) return small8_spread(s, how, phi, rate);
    if (s->n > 2) return small4_spread(s, how, phi, rate);
    if (s->n > 1) return small2_spread(s, how, phi, rate);
    return kernel_single_spread(s, loads, how, phi, rate);
}

const struct jets_kernel KERNEL_NAME(pend_kernel_jets_) = {
    .orders = kernel_orders,
    .advance = kernel_advance,
    .reach = kernel_reach,
    .values = kernel_values,
    .spread = kernel_spread,
    .left = kernel_left,
    .power = kernel_power,
    .along = kernel_along,
};
