#include "core/ensemble/kernel_ensemble.h"

#include <math.h>

#include "core/simd/vec_isa.h"

/* a number is one value for each lane */
#define NUMBER_VEC KERNEL_WIDTH
#include "core/taylor/jets_system.h"

/* exchanges the two lanes of each pair; in a set of lanes, bit i stands for lane i */
#if defined(__AVX512F__)
#define mask_set(x) ((ensemble_set)_mm512_movepi64_mask((__m512i)(x)))
#define num_swap(x) ((lanes8)_mm512_permute_pd((__m512d)(x), 0x55))
#elif defined(__AVX2__)
#define mask_set(x) ((ensemble_set)_mm256_movemask_pd((__m256d)(x)))
#define num_swap(x) ((lanes4)_mm256_permute_pd((__m256d)(x), 5))
#else
#define mask_set(x) ((ensemble_set)(((x)[0] & 1) | ((x)[1] & 2)))
#define num_swap(x) ((lanes2){(x)[1], (x)[0]})
#endif
#define num_abs NUM_(abs)
#define num_max NUM_(max)
#define num_min NUM_(min)

#include "core/taylor/lanes/dense_template.h"

#include "core/taylor/lanes/change_template.h"

#include "core/ensemble/real_template.h"

#define STEP_SIZE(s, place) num_abs((s)->rate[place])
#include "core/taylor/lanes/step_template.h"

enum {
#define X(name) ARRAY_##name,
    JETS_ARRAYS(X)
#undef X
        ARRAY_COUNT
};

/* Distance in numbers from one series to the next. It is an odd number of cache lines, because
 * arrays at an even distance evict each other from the cache. */
static size_t ensemble_series(int n, int order) { return (size_t)n * (size_t)(order + 3) + 5; }

static size_t ensemble_numbers(const struct pend_terms *terms, int n, int order) {
    size_t series = ensemble_series(n, order);
    return 4 * series + (size_t)ARRAY_COUNT * (size_t)n + real_numbers(terms, n, series, order);
}

/* size of the table of a small tree's responses, in numbers */
enum { ENSEMBLE_ANSWERS = sizeof(struct dense_table) / sizeof(num) };

/* the arrays of one series, for ideal and for real pendulums */
struct ensemble_tables {
    struct jets_system jets;
    struct bodies_system real;
};

static size_t ensemble_series_count(const struct pend_terms *terms, int n, int order) {
    return (ensemble_numbers(terms, n, order) + ENSEMBLE_ANSWERS) * WIDE +
           (sizeof(struct ensemble_tables) + 7) / 8;
}

/* the arrays of a series; their table of responses follows them in memory */
VEC_INLINE struct ensemble_tables *ensemble_table(const struct ensemble_lanes *lanes,
                                                  double *series, int order) {
    num *at = (num *)(void *)series;
    size_t numbers = ensemble_numbers(lanes->terms, lanes->n, order);
    return (struct ensemble_tables *)(void *)(at + numbers + ENSEMBLE_ANSWERS);
}

VEC_INLINE struct jets_system *ensemble_view(const struct ensemble_lanes *lanes) {
    return &ensemble_table(lanes, lanes->series, lanes->known)->jets;
}

static void ensemble_lay(const struct ensemble_lanes *lanes, double *memory, int order) {
    size_t n = (size_t)lanes->n, series = ensemble_series(lanes->n, order);
    num *at = (num *)(void *)memory, *arrays = at + 4 * series;
    struct jets_system s = {.n = lanes->n,
                            .stride = n,
                            .tile = 8,
                            .parent = lanes->parent,
                            .end = lanes->end,
                            .share = lanes->share,
                            .rate = at,
                            .force = at + series + n, // row -1 is zero
                            .turn_re = at + 2 * series,
                            .turn_im = at + 3 * series,
#define X(name) .name = arrays + (size_t)ARRAY_##name * n,
                            JETS_ARRAYS(X)
#undef X
    };
    s.len = (num *)(void *)lanes->len;
    s.inv_len = (num *)(void *)lanes->inv_len;
    s.mass = (num *)(void *)lanes->mass;
    struct ensemble_tables *tables = ensemble_table(lanes, memory, order);
    if (lanes->doubt.grade > 0 && !lanes->terms)
        s.answers = at + ensemble_numbers(lanes->terms, lanes->n, order);
    tables->jets = s;
    if (lanes->terms)
        real_lay(&tables->real, lanes, &s, series, order, arrays + (size_t)ARRAY_COUNT * n);
}

static void ensemble_prepare(struct ensemble_lanes *lanes) {
    ensemble_lay(lanes, lanes->series, lanes->known);
    if (lanes->doubt.grade > 0) ensemble_lay(lanes, lanes->doubt.series, lanes->doubt.order);
}

VEC_INLINE num lane_get(const double *array, int k) { return NUM_(get)(array + (size_t)k * WIDE); }

VEC_INLINE void lane_put(double *array, int k, num x) { NUM_(put)(array + (size_t)k * WIDE, x); }

/* sine and cosine of the angle of every arm to its parent, and rates per unit of time */
static void ensemble_start(const struct ensemble_state *from, const struct jets_system *s,
                           num unit) {
    for (int k = 0; k < s->n; k++) {
        int p = s->parent[k];
        num x = lane_get(from->phi, k), y = p < 0 ? num_of(0) : lane_get(from->phi, p);
        num low = lane_get(from->phi_low, k) - (p < 0 ? num_of(0) : lane_get(from->phi_low, p));
        num d = x - y, back = x - d, error = (x - (d + back)) + (back - y);
        NUM_(sincos)(d, error + low, &s->sine[k], &s->cosine[k]);
        s->rate[k] = lane_get(from->rate, k) * unit;
    }
}

static void ensemble_expand(const struct ensemble_lanes *lanes, const struct jets_system *s,
                            num unit, num gravity, int order) {
    if (lanes->terms) {
        real_expand(lanes, s, &ensemble_table(lanes, lanes->series, order)->real, unit, gravity,
                    order);
        return;
    }
    ensemble_start(&lanes->from, s, unit);
    jets_factor(s);
    if (s->n <= DENSE_MAX)
        dense_orders(s, gravity, order);
    else
        jets_orders(s, gravity, order);
}

VEC_INLINE void ensemble_sum(double *high, double *low, int k, num sum, num add) {
    num total = sum + add, part = total - sum;
    lane_put(high, k, total);
    lane_put(low, k, (sum - (total - part)) + (add - part));
}

/* B_i = sum_j weight[i][j] a_j: the polynomial sum a_j x^j in Bernstein's form on [0, 1], whose
 * values lie between the least and the largest B_i */
enum { RANGE_DEGREE = 8 };
#define F(i)                                                                                       \
    {                                                                                              \
        1, i / 8.0, i *(i - 1) / 56.0, i *(i - 1) * (i - 2) / 336.0,                               \
            i *(i - 1) * (i - 2) * (i - 3) / 1680.0,                                               \
            i *(i - 1) * (i - 2) * (i - 3) * (i - 4) / 6720.0,                                     \
            i *(i - 1) * (i - 2) * (i - 3) * (i - 4) * (i - 5) / 20160.0,                          \
            i *(i - 1) * (i - 2) * (i - 3) * (i - 4) * (i - 5) * (i - 6) / 40320.0,                \
            i *(i - 1) * (i - 2) * (i - 3) * (i - 4) * (i - 5) * (i - 6) * (i - 7) / 40320.0       \
    }
static const double range_weight[RANGE_DEGREE + 1][RANGE_DEGREE + 1] = {
    F(0), F(1), F(2), F(3), F(4), F(5), F(6), F(7), F(8)};
#undef F

/* Bounds of a series on [0, x]: from its first terms in Bernstein's form, the absolute values of
 * the others, and the rounding errors of all. */
VEC_INLINE void ensemble_range(const num a[], num rest, num *low, num *high) {
    num top = a[0], bottom = a[0], size = num_abs(a[0]);
    for (int j = 1; j <= RANGE_DEGREE; j++) size += num_abs(a[j]);
    for (int i = 1; i <= RANGE_DEGREE; i++) {
        num b = a[0];
        for (int j = 1; j <= i; j++) b = num_fma(a[j], num_of(range_weight[i][j]), b);
        top = num_max(b, top);
        bottom = num_min(b, bottom);
    }
    rest = num_fma(size, num_of(1e-14), rest);
    *high = top + rest;
    *low = bottom - rest;
}

/* the lanes in which arm k cannot leave its cell during the step */
static wide_mask ensemble_near(const struct ensemble_lanes *lanes, const struct jets_system *s,
                               int k, num x) {
    const num *c = s->rate + k;
    num a[RANGE_DEGREE + 1], power = x, rest = num_of(0), low, high;
    a[0] = num_of(0);
    for (int j = 1; j <= RANGE_DEGREE; j++, power *= x)
        a[j] = c[(size_t)(j - 1) * s->stride] * s->share[j - 1] * power;
    for (int j = lanes->order; j >= RANGE_DEGREE; j--)
        rest = num_fma(rest, x, num_abs(c[(size_t)j * s->stride]) * s->share[j]);
    ensemble_range(a, rest * power, &low, &high);
    // theta = phi + pi / 2, measured from the middle of the cell
    num middle =
        lane_get(lanes->from.phi, k) + M_PI_2 - lane_get(lanes->cell, k) * (2 * lanes->bound);
    double inside = lanes->bound * (1 - 1e-12);
    return ~((wide_mask)(middle + high < inside) & (wide_mask)(middle + low > -inside));
}

/* sets the lanes in which the force of arm k may exceed its extremes so far, and those in which it
 * may be zero */
static void ensemble_force(struct ensemble_lanes *lanes, const struct jets_system *s, int k, num x,
                           num scale) {
    const num *c = s->force + k;
    num a[RANGE_DEGREE + 1], power = x, rest = num_of(0), low, high;
    a[0] = c[0];
    for (int j = 1; j <= RANGE_DEGREE; j++, power *= x) a[j] = c[(size_t)j * s->stride] * power;
    for (int j = lanes->order - 1; j > RANGE_DEGREE; j--)
        rest = num_fma(rest, x, num_abs(c[(size_t)j * s->stride]));
    ensemble_range(a, rest * power, &low, &high);
    wide_mask above = (wide_mask)(high * scale > lane_get(lanes->force_max, k)),
              below = (wide_mask)(low * scale < lane_get(lanes->force_min, k));
    lanes->peak[k] = lanes->extremes ? mask_set(above | below) : 0;
    lanes->turn[k] = lanes->signs ? mask_set((wide_mask)(high >= 0) & (wide_mask)(low <= 0)) : 0;
}

/* computes the state at the end of the step; returns 0 if all sums are finite */
static num ensemble_advance(const struct ensemble_lanes *lanes, const struct jets_system *s, num x,
                            num inverse) {
    const struct ensemble_state *from = &lanes->from, *to = &lanes->to;
    num bad = num_of(0);
    for (int k = 0; k < s->n; k++) {
        num phi = num_of(0), rate = num_of(0);
        const num *c = s->rate + (size_t)lanes->order * s->stride + k;
        for (int j = lanes->order; j >= 1; j--, c -= s->stride) {
            phi = num_fma(phi, x, *c * s->share[j]);
            rate = num_fma(rate, x, *c);
        }
        phi = x * num_fma(x, phi, *c);
        rate = x * rate * inverse;
        ensemble_sum(to->phi, to->phi_low, k, lane_get(from->phi, k),
                     phi + lane_get(from->phi_low, k));
        ensemble_sum(to->rate, to->rate_low, k, lane_get(from->rate, k),
                     rate + lane_get(from->rate_low, k));
        bad += (phi - phi) + (rate - rate);
    }
    return bad;
}

/* marks the requested events that the step may contain */
static void ensemble_watch(struct ensemble_lanes *lanes, const struct jets_system *s, num x,
                           num inverse, struct ensemble_attention *attention) {
    for (int k = 0; k < s->n && lanes->bound > 0; k++) {
        lanes->near[k] = mask_set(ensemble_near(lanes, s, k, x));
        attention->near |= lanes->near[k];
    }
    for (int k = 0; k < s->n && (lanes->extremes || lanes->signs); k++) {
        ensemble_force(lanes, s, k, x, inverse * inverse);
        attention->force |= lanes->peak[k] | lanes->turn[k];
    }
}

#include "core/ensemble/doubt_template.h"

static void ensemble_step(struct ensemble_lanes *lanes, struct ensemble_attention *attention) {
    const struct jets_system *s = ensemble_view(lanes);
    num unit = lane_get(lanes->unit, 0), time = lane_get(lanes->from.time, 0),
        stop = lane_get(lanes->stop, 0);
    // the unit is a power of two, so its inverse is exact
    num gravity = lane_get(lanes->gravity, 0) * unit * unit, inverse = 1 / unit;
    ensemble_expand(lanes, s, unit, gravity, lanes->known);
    num x = step_reach(s, lanes->order, lanes->log_rtol, lanes->log_atol);
    if (lanes->terms) x = real_reach(&ensemble_table(lanes, lanes->series, lanes->known)->real, x);
    if (lanes->paired) x = num_min(x, num_swap(x));
    wide_mask lands = (wide_mask)(x >= (stop - time) * inverse);
    num next = NUM_(pick)(lands, stop, time + x * unit);
    // the step is so short that the time would not advance
    wide_mask still =
        (wide_mask)(next == time) | (wide_mask)(num_abs(x * unit) < num_abs(stop) * 0x1p-52);
    x = (next - time) * inverse;
    *attention = (struct ensemble_attention){.done = mask_set(lands)};
    ensemble_watch(lanes, s, x, inverse, attention);
    num bad = ensemble_advance(lanes, s, x, inverse);
    if (lanes->power)
        real_balance(lanes, &ensemble_table(lanes, lanes->series, lanes->known)->real, unit, x);
    if (lanes->doubt.grade > 0) ensemble_doubt(lanes, s, x, next, gravity);
    attention->bad = mask_set((still & ~lands) | ~(wide_mask)(bad == 0));
    lane_put(lanes->to.time, 0, next);
    lane_put(lanes->step, 0, x);
    // the next unit is a power of two near this step
    num grown = NUM_(round)(NUM_(log2)(num_max(x, num_of(0x1p-60))));
    lane_put(lanes->unit, 0, unit * NUM_(power)(grown));
}

static const double *ensemble_forces(const struct ensemble_lanes *lanes) {
    return (const double *)ensemble_view(lanes)->force;
}

/* computes one vector of instants at a time, with the same sums as ensemble_advance */
static void ensemble_values(const struct ensemble_lanes *lanes, int lane, double unit,
                            const double x[], const struct ensemble_values *to) {
    const struct jets_system *s = ensemble_view(lanes);
    double inverse = 1 / unit;
    for (int k = 0; k < s->n; k++) {
        size_t at = (size_t)k * WIDE + (size_t)lane;
        double base = lanes->from.phi[at], base_rate = lanes->from.rate[at];
        for (int i = 0; i < ENSEMBLE_INSTANTS / WIDE; i++) {
            num phi = num_of(0), rate = num_of(0), force = num_of(0), place = lane_get(x, i);
            const double *c = (const double *)(s->rate + k) + lane,
                         *f = (const double *)(s->force + k) + lane;
            for (int j = lanes->order; j >= 1; j--) {
                double w = c[(size_t)j * s->stride * WIDE];
                phi = num_fma(phi, place, num_of(w * s->share[j]));
                rate = num_fma(rate, place, num_of(w));
                if (to->force)
                    force = num_fma(force, place, num_of(f[(size_t)(j - 1) * s->stride * WIDE]));
            }
            phi = place * num_fma(place, phi, num_of(c[0]));
            rate = place * rate * inverse;
            int row = k * (ENSEMBLE_INSTANTS / WIDE) + i;
            lane_put(to->phi, row, base + (phi + lanes->from.phi_low[at]));
            lane_put(to->rate, row, base_rate + (rate + lanes->from.rate_low[at]));
            if (to->force) lane_put(to->force, row, force * (inverse * inverse));
        }
    }
}

const struct ensemble_kernel KERNEL_NAME(pend_kernel_ensemble_) = {
    .width = WIDE,
    .series_count = ensemble_series_count,
    .prepare = ensemble_prepare,
    .force = ensemble_forces,
    .step = ensemble_step,
    .values = ensemble_values,
};
