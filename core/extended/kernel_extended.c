#include "core/extended/kernel_extended.h"

#include "core/simd/vec_isa.h"

/* A number is a sum of two doubles, equal in all lanes; in `values`, each lane is a different
 * instant. */
#define NUMBER_DOUBLE_DOUBLE
#include "core/extended/extended_orders_template.h"

#include "core/bodies/bodies_template.h"
#include "core/taylor/jets_bodies.h"

#define STEP_SIZE(s, place) WIDE_(abs)((s)->rate[place].high)
#include "core/taylor/lanes/step_template.h"
#include "core/tree/turns.h"

enum {
#define X(name) ARRAY_##name,
    JETS_ARRAYS(X)
#undef X
        ARRAY_COUNT
};

/* ---- memory */

/* distance in doubles from one series to the next */
static size_t extended_series(int n, int order) { return (size_t)n * (size_t)(order + 2); }

/* number of doubles for an ideal pendulum, counted in vectors */
static size_t extended_ideal(int n, int order) {
    size_t numbers = 4 * extended_series(n, order) + (size_t)ARRAY_COUNT * (size_t)n;
    return 2 * numbers + 6 * extended_series(n, order);
}

static size_t extended_series_count(const struct pend_terms *terms, int n, int order) {
    size_t real = 0;
    if (terms)
        real = (size_t)terms->count +
               bodies_numbers(terms, (size_t)n, extended_series(n, order), order);
    return (extended_ideal(n, order) + 2 * real) * WIDE;
}

static struct jets_system extended_view(const struct extended_motion *motion) {
    size_t n = (size_t)motion->n, series = extended_series(motion->n, motion->order);
    num *at = (num *)(void *)motion->series, *arrays = at + 4 * series;
    return (struct jets_system){.n = motion->n,
                                .stride = n,
                                .tile = 8,
                                .parent = motion->parent,
                                .end = motion->end,
                                .share = motion->share,
                                .rate = at,
                                .force = at + series,
                                .turn_re = at + 2 * series,
                                .turn_im = at + 3 * series,
#define X(name) .name = arrays + (size_t)ARRAY_##name * n,
                                JETS_ARRAYS(X)
#undef X
    };
}

static struct extended_packs extended_packs_view(const struct extended_motion *motion) {
    size_t n = (size_t)motion->n, series = extended_series(motion->n, motion->order);
    num *u = (num *)(void *)motion->series + 4 * series + (size_t)ARRAY_COUNT * n;
    wide *at = (wide *)(void *)(u + 2 * series);
    return (struct extended_packs){WIDE == 4, u, u + series, at, at + series};
}

VEC_INLINE num extended_angle(const struct extended_motion *motion, int k) {
    return num_of2(motion->from.phi[k], motion->from.phi_low[k]);
}

/* lays out a real pendulum's arrays after those of an ideal one; returns how many doubles it
 * takes */
static struct bodies_system extended_real(const struct extended_motion *motion,
                                          const struct jets_system *s) {
    size_t n = (size_t)motion->n, count = (size_t)motion->terms->count;
    num *value = (num *)(void *)(motion->series + extended_ideal(motion->n, motion->order) * WIDE);
    struct bodies_system b = jets_bodies(s, motion->terms, value);
    for (size_t j = 0; j < count; j++) value[j] = num_of(motion->value[j]);
    bodies_lay(&b, n, extended_series(motion->n, motion->order), motion->order, value + count);
    return b;
}

/* computes sine and cosine of every arm's angle to its parent, and the rates per unit of time */
static void extended_start(const struct extended_motion *motion, const struct jets_system *s,
                           wide unit) {
    const struct extended_state *from = &motion->from;
    for (int k = 0; k < s->n; k++) {
        int p = pend_terms_holder(motion->terms, s->parent, k);
        num angle = extended_angle(motion, k);
        if (p >= 0) angle = num_sub(angle, extended_angle(motion, p));
        num_sincos(angle, &s->sine[k], &s->cosine[k]);
        s->rate[k] = num_scale(num_of2(from->rate[k], from->rate_low[k]), unit);
        s->len[k] = num_of(motion->len[k]);
        s->mass[k] = num_of(motion->mass[k]);
        s->inv_len[k] = num_div(num_of(1), s->len[k]);
        s->turn_re[s->n + k] = num_of(0);
        s->turn_im[s->n + k] = s->rate[k];
    }
}

static void extended_bodies(const struct extended_motion *motion, const struct jets_system *s,
                            wide unit, num gravity) {
    const num quarter = num_of2(M_PI_2, PEND_QUARTER_LOW);
    struct bodies_system b = extended_real(motion, s);
    struct bodies_moment now = {num_from(unit), gravity, num_of(motion->start),
                                num_of(motion->from.time)};
    for (int k = 0; k < s->n; k++) {
        int p = pend_terms_holder(b.terms, s->parent, k);
        num from = p >= 0 ? extended_angle(motion, p) : num_neg(quarter);
        b.bend[k] = num_sub(extended_angle(motion, k), from);
        b.sine[k] = s->sine[k], b.cosine[k] = s->cosine[k];
    }
    if (pend_terms_cart(b.terms)) bodies_cart_start(&b, extended_angle(motion, 0));
    bodies_orders(&b, &now, motion->order);
    bodies_forces(&b, motion->order);
}

/* ---- the step */

/* changes of phi and of unit phi' from the start of a step to x units later, by Horner's rule */
struct extended_change {
    num phi, rate;
};

VEC_INLINE struct extended_change extended_horner(const struct extended_motion *motion,
                                                  const struct jets_system *s, int k, num x) {
    wide phi = wide_of(0), rate = wide_of(0);
    int j = motion->order;
    const num *c = s->rate + (size_t)j * s->stride + (size_t)k;
    for (; j > motion->precise; j--, c -= s->stride) {
        phi = wide_fma(phi, x.high, c->high * s->share[j]);
        rate = wide_fma(rate, x.high, c->high);
    }
    struct extended_change v = {num_from(phi), num_from(rate)};
    for (; j >= 1; j--, c -= s->stride) {
        v.phi = num_fma(v.phi, x, num_mul(*c, extended_share(s->share, j)));
        v.rate = num_fma(v.rate, x, *c);
    }
    v.phi = num_mul(x, num_fma(x, v.phi, *c));
    v.rate = num_mul(x, v.rate);
    return v;
}

/* the state of arm k, x units after the start of the step; `inverse` is 1 / unit */
VEC_INLINE struct extended_change extended_later(const struct extended_motion *motion,
                                                 const struct jets_system *s, int k, num x,
                                                 wide inverse) {
    const struct extended_state *from = &motion->from;
    struct extended_change v = extended_horner(motion, s, k, x);
    v.phi = num_add(extended_angle(motion, k), v.phi);
    v.rate = num_add(num_of2(from->rate[k], from->rate_low[k]), num_scale(v.rate, inverse));
    return v;
}

/* computes the state at the end of the step; returns 0 if all sums are finite */
static wide extended_advance(const struct extended_motion *motion, const struct jets_system *s,
                             num x, wide unit) {
    const struct extended_state *to = &motion->to;
    wide bad = wide_of(0), inverse = 1 / unit;
    for (int k = 0; k < s->n; k++) {
        struct extended_change v = extended_later(motion, s, k, x, inverse);
        to->phi[k] = v.phi.high[0], to->phi_low[k] = v.phi.low[0];
        to->rate[k] = v.rate.high[0], to->rate_low[k] = v.rate.low[0];
        bad += (v.phi.high - v.phi.high) + (v.rate.high - v.rate.high);
    }
    return bad;
}

static void extended_expand(const struct extended_motion *motion, const struct jets_system *s,
                            const struct extended_packs *packs, wide unit) {
    num gravity = num_from(wide_of(motion->gravity) * unit * unit);
    extended_start(motion, s, unit);
    if (motion->terms) {
        extended_bodies(motion, s, unit, gravity);
        return;
    }
    jets_factor(s);
    if (s->n <= DENSE_MAX)
        extended_small(s, packs, gravity, motion->order, motion->precise);
    else
        extended_orders(s, packs, gravity, motion->order, motion->precise);
}

static int extended_step(struct extended_motion *motion) {
    struct jets_system s = extended_view(motion);
    wide unit = wide_of(motion->unit), time = wide_of(motion->from.time),
         stop = wide_of(motion->stop);
    struct extended_packs packs = extended_packs_view(motion);
    extended_expand(motion, &s, &packs, unit);
    wide x = step_reach(&s, motion->order, motion->log_rtol, motion->log_atol),
         left = (stop - time) / unit;
    if (motion->terms) {
        struct bodies_system b = extended_real(motion, &s);
        if (b.need & BODIES_FRICTION) x = bodies_reach(&b, num_from(x)).high;
    }
    wide_mask lands = (wide_mask)(x >= left);
    wide next = WIDE_(pick)(lands, stop, time + x * unit);
    // times are doubles, but their difference need not be one
    num step = num_scale(num_total(next, -time), 1 / unit);
    wide bad = extended_advance(motion, &s, step, unit);
    // the next unit is a power of two near this step
    wide power = WIDE_(power)(WIDE_(round)(WIDE_(log2)(WIDE_(max)(step.high, wide_of(0x1p-60)))));
    motion->to.time = next[0];
    motion->unit *= power[0];
    return (lands[0] ? EXTENDED_DONE : 0) | (bad[0] == 0 && next[0] != time[0] ? 0 : EXTENDED_BAD);
}

/* ---- values inside the step: an instant in each lane */

VEC_INLINE void extended_give(double to[], int n, int k, int count, wide x) {
    for (int i = 0; to && i < count; i++) to[(size_t)i * (size_t)n + (size_t)k] = x[i];
}

/* the value of the tension (shift = 0) or of phi'' (shift = 1), by Horner's rule */
VEC_INLINE num extended_sum(const struct extended_motion *motion, const num *series, size_t stride,
                            int k, num x, int shift) {
    num sum = num_of(0);
    for (int j = motion->order - 1; j >= 0; j--) {
        num c = series[(size_t)(j + shift) * stride + (size_t)k];
        sum = num_fma(sum, x, shift ? num_mul(c, num_of(j + 1)) : c);
    }
    return sum;
}

static void extended_values(const struct extended_motion *motion, double unit, int count,
                            const double t[], const struct extended_values *to) {
    struct jets_system s = extended_view(motion);
    wide at = wide_of(t[0]), inverse = wide_of(1 / unit), squared = inverse * inverse;
    for (int i = 1; i < count; i++) at[i] = t[i];
    num x = num_scale(num_total(at, wide_of(-motion->from.time)), inverse);
    for (int k = 0; k < s.n; k++) {
        struct extended_change v = extended_later(motion, &s, k, x, inverse);
        extended_give(to->phi, s.n, k, count, v.phi.high);
        extended_give(to->phi_low, s.n, k, count, v.phi.low);
        extended_give(to->rate, s.n, k, count, v.rate.high);
        extended_give(to->rate_low, s.n, k, count, v.rate.low);
        if (to->acc)
            extended_give(to->acc, s.n, k, count,
                          extended_sum(motion, s.rate, s.stride, k, x, 1).high * squared);
        if (to->force)
            extended_give(to->force, s.n, k, count,
                          extended_sum(motion, s.force, s.stride, k, x, 0).high * squared);
    }
}

static void extended_power(const struct extended_motion *motion, double unit, double work[],
                           double heat[]) {
    struct jets_system s = extended_view(motion);
    struct bodies_system b = extended_real(motion, &s);
    num given[BODIES_ORDERS], lost[BODIES_ORDERS];
    bodies_power(&b, num_of(unit), motion->order, motion->order, given, lost);
    for (int j = 0; j < motion->order; j++) work[j] = given[j].high[0], heat[j] = lost[j].high[0];
}

const struct extended_kernel KERNEL_NAME(pend_kernel_extended_) = {
    .width = WIDE,
    .series_count = extended_series_count,
    .step = extended_step,
    .values = extended_values,
    .power = extended_power,
};
