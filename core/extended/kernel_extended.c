#include "core/extended/kernel_extended.h"

#include "core/simd/vec_isa.h"

/* a number is a sum of two doubles for each lane */
#define NUMBER_DOUBLE_DOUBLE
#include "core/extended/extended_orders_template.h"

#include "core/bodies/bodies_template.h"
#include "core/taylor/jets_bodies.h"

#define STEP_SIZE(s, place) WIDE_(abs)((s)->rate[place].high)
#include "core/taylor/lanes/step_template.h"

enum {
#define X(name) ARRAY_##name,
    JETS_ARRAYS(X)
#undef X
        ARRAY_COUNT
};

/* ---- memory */

/* numbers from one series to the next */
static size_t extended_series(int n, int order) { return (size_t)n * (size_t)(order + 2); }

/* what ideal pendulums take, in doubles a lane */
static size_t extended_ideal(int n, int order) {
    size_t numbers = 4 * extended_series(n, order) + (size_t)ARRAY_COUNT * (size_t)n;
    return 2 * numbers + 7 * extended_series(n, order);
}

static size_t extended_series_count(const struct pend_terms *terms, int n, int order) {
    size_t real = 0;
    if (terms)
        real = (size_t)terms->count +
               bodies_numbers(terms, (size_t)n, extended_series(n, order), order);
    return (extended_ideal(n, order) + 2 * real) * WIDE;
}

static struct jets_system extended_view(const struct extended_lanes *lanes) {
    size_t n = (size_t)lanes->n, series = extended_series(lanes->n, lanes->order);
    num *at = (num *)(void *)lanes->series, *arrays = at + 4 * series;
    return (struct jets_system){.n = lanes->n,
                                .stride = n,
                                .tile = 8,
                                .parent = lanes->parent,
                                .end = lanes->end,
                                .share = lanes->share,
                                .rate = at,
                                .force = at + series,
                                .turn_re = at + 2 * series,
                                .turn_im = at + 3 * series,
#define X(name) .name = arrays + (size_t)ARRAY_##name * n,
                                JETS_ARRAYS(X)
#undef X
    };
}

static struct extended_sizes extended_sizes_view(const struct extended_lanes *lanes) {
    size_t n = (size_t)lanes->n, series = extended_series(lanes->n, lanes->order);
    num *u = (num *)(void *)lanes->series + 4 * series + (size_t)ARRAY_COUNT * n;
    wide *at = (wide *)(void *)(u + 2 * series);
    return (struct extended_sizes){
        lanes->single && WIDE == 4, at, at + series, at + 2 * series, u, u + series};
}

VEC_INLINE wide lane_get(const double *array, int k) {
    return WIDE_(get)(array + (size_t)k * WIDE);
}

VEC_INLINE void lane_put(double *array, int k, wide x) { WIDE_(put)(array + (size_t)k * WIDE, x); }

VEC_INLINE num lane_pair(const double *high, const double *low, int k) {
    return (num){lane_get(high, k), lane_get(low, k)};
}

/* the same of a real pendulum, with the numbers of its terms, behind what ideal ones take */
static struct bodies_system extended_real(const struct extended_lanes *lanes,
                                          const struct jets_system *s) {
    size_t n = (size_t)lanes->n, count = (size_t)lanes->terms->count;
    num *value = (num *)(void *)(lanes->series + extended_ideal(lanes->n, lanes->order) * WIDE);
    struct bodies_system b = jets_bodies(s, lanes->terms, value);
    for (size_t j = 0; j < count; j++) value[j] = num_from(WIDE_(get)(lanes->value + j * WIDE));
    bodies_lay(&b, n, extended_series(lanes->n, lanes->order), lanes->order, value + count);
    return b;
}

/* sine and cosine of the angle of every arm to its parent, and rates in units */
static void extended_start(const struct extended_lanes *lanes, const struct jets_system *s,
                           wide unit) {
    const struct extended_state *from = &lanes->from;
    for (int k = 0; k < s->n; k++) {
        int p = pend_terms_holder(lanes->terms, s->parent, k);
        num angle = lane_pair(from->phi, from->phi_low, k);
        if (p >= 0) angle = num_sub(angle, lane_pair(from->phi, from->phi_low, p));
        num_sincos(angle, &s->sine[k], &s->cosine[k]);
        s->rate[k] = num_scale(lane_pair(from->rate, from->rate_low, k), unit);
        s->len[k] = num_from(lane_get(lanes->len, k));
        s->mass[k] = num_from(lane_get(lanes->mass, k));
        s->inv_len[k] = num_div(num_of(1), s->len[k]);
        s->turn_re[s->n + k] = num_of(0);
        s->turn_im[s->n + k] = s->rate[k];
    }
}

/* all orders of a real pendulum */
static void extended_bodies(const struct extended_lanes *lanes, const struct jets_system *s,
                            wide unit, num gravity) {
    const num quarter = num_of2(0x1.921fb54442d18p+0, 0x1.1a62633145c07p-54);
    struct bodies_system b = extended_real(lanes, s);
    struct bodies_moment now = {num_from(unit), gravity, num_from(lane_get(lanes->start, 0)),
                                num_from(lane_get(lanes->from.time, 0))};
    for (int k = 0; k < s->n; k++) {
        int p = pend_terms_holder(b.terms, s->parent, k);
        num angle = lane_pair(lanes->from.phi, lanes->from.phi_low, k), from = num_neg(quarter);
        if (p >= 0) from = lane_pair(lanes->from.phi, lanes->from.phi_low, p);
        b.bend[k] = num_sub(angle, from);
        b.sine[k] = s->sine[k], b.cosine[k] = s->cosine[k];
    }
    if (pend_terms_cart(b.terms))
        bodies_cart_start(&b, lane_pair(lanes->from.phi, lanes->from.phi_low, 0));
    bodies_orders(&b, &now, lanes->order);
    bodies_forces(&b, lanes->order);
}

/* ---- the step */

/* phi (less its start) and unit times phi' (less its start) x units after the start, by Horner's
 * rule */
struct extended_change {
    num phi, rate;
};

/* reads the coefficients of an arm: all lanes, or one lane's value in every lane */
VEC_INLINE num extended_pick(const num *at, int lane) {
    return lane < 0 ? *at : num_of2(at->high[lane], at->low[lane]);
}

VEC_INLINE struct extended_change extended_horner(const struct extended_lanes *lanes,
                                                  const struct jets_system *s, int k, int lane,
                                                  num x) {
    wide phi = wide_of(0), rate = wide_of(0);
    int j = lanes->order;
    const num *c = s->rate + (size_t)j * s->stride + (size_t)k;
    for (; j > lanes->precise; j--, c -= s->stride) {
        wide w = extended_pick(c, lane).high;
        phi = wide_fma(phi, x.high, w * s->share[j]);
        rate = wide_fma(rate, x.high, w);
    }
    struct extended_change v = {num_from(phi), num_from(rate)};
    for (; j >= 1; j--, c -= s->stride) {
        num w = extended_pick(c, lane);
        v.phi = num_fma(v.phi, x, num_mul(w, extended_share(s->share, j)));
        v.rate = num_fma(v.rate, x, w);
    }
    v.phi = num_mul(x, num_fma(x, v.phi, extended_pick(c, lane)));
    v.rate = num_mul(x, v.rate);
    return v;
}

/* the state at the end of the step; the return value is 0 where all sums are finite */
static wide extended_advance(const struct extended_lanes *lanes, const struct jets_system *s, num x,
                             wide unit) {
    const struct extended_state *from = &lanes->from, *to = &lanes->to;
    wide bad = wide_of(0), inverse = 1 / unit;
    for (int k = 0; k < s->n; k++) {
        struct extended_change v = extended_horner(lanes, s, k, -1, x);
        num phi = num_add(lane_pair(from->phi, from->phi_low, k), v.phi);
        num rate = num_add(lane_pair(from->rate, from->rate_low, k), num_scale(v.rate, inverse));
        lane_put(to->phi, k, phi.high);
        lane_put(to->phi_low, k, phi.low);
        lane_put(to->rate, k, rate.high);
        lane_put(to->rate_low, k, rate.low);
        bad += (phi.high - phi.high) + (rate.high - rate.high);
    }
    return bad;
}

static void extended_expand(const struct extended_lanes *lanes, const struct jets_system *s,
                            const struct extended_sizes *sizes, wide unit) {
    num gravity = num_from(lane_get(lanes->gravity, 0) * unit * unit);
    extended_start(lanes, s, unit);
    if (lanes->terms) {
        extended_bodies(lanes, s, unit, gravity);
        return;
    }
    jets_factor(s);
    if (s->n <= DENSE_MAX)
        extended_small(s, sizes, gravity, lanes->order, lanes->precise);
    else
        extended_orders(s, sizes, gravity, lanes->order, lanes->precise);
}

static int extended_step(struct extended_lanes *lanes) {
    struct jets_system s = extended_view(lanes);
    wide unit = lane_get(lanes->unit, 0), time = lane_get(lanes->from.time, 0),
         stop = lane_get(lanes->stop, 0);
    struct extended_sizes sizes = extended_sizes_view(lanes);
    extended_expand(lanes, &s, &sizes, unit);
    wide x = step_reach(&s, lanes->order, lanes->log_rtol, lanes->log_atol),
         left = (stop - time) / unit;
    if (lanes->terms) {
        struct bodies_system b = extended_real(lanes, &s);
        if (b.need & BODIES_GRIP) x = bodies_reach(&b, num_from(x)).high;
    }
    wide_mask lands = (wide_mask)(x >= left);
    wide next = WIDE_(pick)(lands, stop, time + x * unit);
    wide still = (wide)((wide_mask)(next == time) & (wide_mask)wide_of(1));
    // times are doubles, but their difference is not
    num step = num_scale(num_total(next, -time), 1 / unit);
    wide bad = extended_advance(lanes, &s, step, unit) + still;
    lane_put(lanes->to.time, 0, next);
    // the next unit is a power of two near this step
    lane_put(lanes->unit, 0,
             unit *
                 WIDE_(power)(WIDE_(round)(WIDE_(log2)(WIDE_(max)(step.high, wide_of(0x1p-60))))));
    int any = 0;
    for (int i = 0; i < WIDE; i++) {
        lanes->attention[i] =
            (unsigned char)((lands[i] ? EXTENDED_DONE : 0) | (bad[i] == 0 ? 0 : EXTENDED_BAD));
        any |= lanes->attention[i];
    }
    return any;
}

/* ---- values inside the step: an instant in each lane */

VEC_INLINE void extended_give(double to[], int n, int k, int count, wide x) {
    for (int i = 0; to && i < count; i++) to[(size_t)i * (size_t)n + (size_t)k] = x[i];
}

/* the tension (shift = 0) or phi'' (shift = 1) by Horner's rule */
VEC_INLINE num extended_sum(const struct extended_lanes *lanes, const num *series, size_t stride,
                            int k, int lane, num x, int shift) {
    num sum = num_of(0);
    for (int j = lanes->order - 1; j >= 0; j--) {
        num c = extended_pick(series + (size_t)(j + shift) * stride + (size_t)k, lane);
        sum = num_fma(sum, x, shift ? num_mul(c, num_of(j + 1)) : c);
    }
    return sum;
}

static void extended_values(const struct extended_lanes *lanes, int lane, double unit, int count,
                            const double t[], const struct extended_values *to) {
    struct jets_system s = extended_view(lanes);
    const struct extended_state *from = &lanes->from;
    wide at = wide_of(t[0]), inverse = wide_of(1 / unit);
    for (int i = 1; i < count; i++) at[i] = t[i];
    num x = num_scale(num_total(at, wide_of(-from->time[lane])), inverse);
    for (int k = 0; k < s.n; k++) {
        size_t here = (size_t)k * WIDE + (size_t)lane;
        struct extended_change v = extended_horner(lanes, &s, k, lane, x);
        num phi = num_add(num_of2(from->phi[here], from->phi_low[here]), v.phi);
        num rate =
            num_add(num_of2(from->rate[here], from->rate_low[here]), num_scale(v.rate, inverse));
        extended_give(to->phi, s.n, k, count, phi.high);
        extended_give(to->phi_low, s.n, k, count, phi.low);
        extended_give(to->rate, s.n, k, count, rate.high);
        extended_give(to->rate_low, s.n, k, count, rate.low);
        wide squared = inverse * inverse;
        if (to->acc)
            extended_give(to->acc, s.n, k, count,
                          extended_sum(lanes, s.rate, s.stride, k, lane, x, 1).high * squared);
        if (to->force)
            extended_give(to->force, s.n, k, count,
                          extended_sum(lanes, s.force, s.stride, k, lane, x, 0).high * squared);
    }
}

static void extended_power(const struct extended_lanes *lanes, int lane, double unit, double work[],
                           double heat[]) {
    struct jets_system s = extended_view(lanes);
    struct bodies_system b = extended_real(lanes, &s);
    num given[BODIES_ORDERS], lost[BODIES_ORDERS];
    bodies_power(&b, num_of(unit), lanes->order, lanes->order, given, lost);
    for (int j = 0; j < lanes->order; j++)
        work[j] = given[j].high[lane], heat[j] = lost[j].high[lane];
}

const struct extended_kernel KERNEL_NAME(pend_kernel_extended_) = {
    .width = WIDE,
    .series_count = extended_series_count,
    .step = extended_step,
    .values = extended_values,
    .power = extended_power,
};
