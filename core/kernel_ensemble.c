#include "core/kernel_ensemble.h"

#include "core/lanes.h"

/* a number is one value for each lane */
#if defined(__AVX512F__)
#define NUM_(name) lanes8##name
typedef bits8 mask;
enum { WIDTH = 8 };
#elif defined(__AVX2__)
#define NUM_(name) lanes4##name
typedef bits4 mask;
enum { WIDTH = 4 };
#else
#define NUM_(name) lanes2##name
typedef bits2 mask;
enum { WIDTH = 2 };
#endif
#define JETS_NUM NUM_()
#include "core/jets_system.h"

enum { WIDE = 1 };
typedef num wide;
#define num_of NUM_(_of)
#define num_fma NUM_(_fma)
#define num_max NUM_(_max)
#define num_min NUM_(_min)
#define num_abs NUM_(_abs)
#define wide_of num_of
#define wide_fma num_fma
LANES_INLINE num num_add(num x, num y) { return x + y; }
LANES_INLINE num num_sub(num x, num y) { return x - y; }
LANES_INLINE num num_mul(num x, num y) { return x * y; }
LANES_INLINE num num_div(num x, num y) { return x / y; }
#define NUM_PIN LANES_PIN
LANES_INLINE num num_neg(num x) { return -x; }
#define wide_neg num_neg
LANES_INLINE wide wide_add(wide x, wide y) { return x + y; }
LANES_INLINE wide wide_sub(wide x, wide y) { return x - y; }
LANES_INLINE wide wide_mul(wide x, wide y) { return x * y; }
LANES_INLINE wide wide_get(const num *at) { return *at; }
LANES_INLINE void wide_put(num *at, wide x) { *at = x; }

#include "core/dense_kernel.h"

enum {
#define X(name) ARRAY_##name,
    JETS_ARRAYS(X)
#undef X
        ARRAY_COUNT,
    TRAILING = 4,
    LEADING = 4
};

/* numbers from one series to the next; an odd multiple of the cache's line apart, or they would evict each other */
static size_t ensemble_series(int n, int order) { return (size_t)n * (size_t)(order + 3) + 5; }

static size_t ensemble_series_count(int n, int order) {
    return (4 * ensemble_series(n, order) + (size_t)ARRAY_COUNT * (size_t)n) * WIDTH;
}

static struct jets_system ensemble_view(const struct ensemble_lanes *lanes) {
    size_t n = (size_t)lanes->n, series = ensemble_series(lanes->n, lanes->order);
    num *at = (num *)(void *)lanes->series, *arrays = at + 4 * series;
    struct jets_system s = {
        .n = lanes->n,
        .stride = n,
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
    return s;
}

LANES_INLINE num lane_get(const double *array, int k) { return NUM_(_get)(array + (size_t)k * WIDTH); }

LANES_INLINE void lane_put(double *array, int k, num x) { NUM_(_put)(array + (size_t)k * WIDTH, x); }

/* sine and cosine of the angle of every arm to its parent, and rates in units */
static void ensemble_start(const struct ensemble_lanes *lanes, const struct jets_system *s, num unit) {
    const struct ensemble_state *from = &lanes->from;
    for (int k = 0; k < s->n; k++) {
        int p = s->parent[k];
        num x = lane_get(from->phi, k), y = p < 0 ? num_of(0) : lane_get(from->phi, p);
        num low = lane_get(from->phi_low, k) - (p < 0 ? num_of(0) : lane_get(from->phi_low, p));
        num d = x - y, back = x - d, error = (x - (d + back)) + (back - y);
        NUM_(_sincos)(d, error + low, &s->sine[k], &s->cosine[k]);
        s->rate[k] = lane_get(from->rate, k) * unit;
    }
}

/* binary logarithm of the largest coefficient of order j, far below all others where all are zero */
LANES_INLINE num ensemble_norm(const struct jets_system *s, int j) {
    num norm = num_of(0);
    for (int k = 0; k < s->n; k++) norm = num_max(norm, num_abs(s->rate[(size_t)j * s->stride + (size_t)k]));
    return NUM_(_log2)(norm) - (num)((mask)(norm == 0) & (mask)num_of(1e4));
}

/* the step in units, by the rule of the taylor method: the first term left out is below rtol times the motion, or atol */
static num ensemble_choose(const struct ensemble_lanes *lanes, const struct jets_system *s) {
    static const double log2_of[LEADING] = {0, 1, 1.5849625007211562, 2};
    num leading[LEADING], reach = num_of(10);
    const double *last = s->share + lanes->order;
    for (int i = 0; i < LEADING; i++) {
        leading[i] = ensemble_norm(s, i) - log2_of[i];
    }
    for (int j = lanes->order - TRAILING + 1; j <= lanes->order; j++) {
        num trailing = ensemble_norm(s, j), here = lanes->log_atol * last[1] - trailing * s->share[j];
        for (int i = 0; i < LEADING; i++) {
            here = num_max(here, lanes->log_rtol * last[-i] + (leading[i] - trailing) * s->share[j - i - 1]);
        }
        reach = num_min(reach, here);
    }
    return NUM_(_exp2)(num_max(reach, num_of(-60)));
}

LANES_INLINE void ensemble_sum(double *high, double *low, int k, num sum, num add) {
    num total = sum + add, part = total - sum;
    lane_put(high, k, total);
    lane_put(low, k, (sum - (total - part)) + (add - part));
}

/* where arm k may get to during the step stays inside its cell: 0, else not 0. Horner's rule on intervals [0, x]. */
static num ensemble_near(const struct ensemble_lanes *lanes, const struct jets_system *s, int k, num x) {
    num high = num_of(0), low = num_of(0), zero = num_of(0);
    for (int j = lanes->order; j >= 0; j--) {
        num c = s->rate[(size_t)j * s->stride + (size_t)k] * s->share[j];
        high = num_fma(x, num_max(high, zero), c);
        low = num_fma(x, num_min(low, zero), c);
    }
    // theta = phi + pi / 2 in units of the cell, from the cell's middle
    num middle = lane_get(lanes->from.phi, k) + 1.57079632679489661923 - lane_get(lanes->cell, k) * (2 * lanes->bound);
    num top = num_fma(x, num_max(high, zero), middle), bottom = num_fma(x, num_min(low, zero), middle);
    double inside = lanes->bound * (1 - 1e-12);
    return (num)(((mask)(top >= inside) | (mask)(bottom <= -inside)) & (mask)num_of(1));
}

/* the state at the end of the step; a sum that is not finite shows in the return value, 0 where all are */
static num ensemble_advance(const struct ensemble_lanes *lanes, const struct jets_system *s, num x, num unit) {
    const struct ensemble_state *from = &lanes->from, *to = &lanes->to;
    num bad = num_of(0), inverse = 1 / unit;
    for (int k = 0; k < s->n; k++) {
        num phi = num_of(0), rate = num_of(0);
        const num *c = s->rate + (size_t)lanes->order * s->stride + k;
        for (int j = lanes->order; j >= 1; j--, c -= s->stride) {
            phi = num_fma(phi, x, *c * s->share[j]);
            rate = num_fma(rate, x, *c);
        }
        phi = x * num_fma(x, phi, *c);
        rate = x * rate * inverse;
        ensemble_sum(to->phi, to->phi_low, k, lane_get(from->phi, k), phi + lane_get(from->phi_low, k));
        ensemble_sum(to->rate, to->rate_low, k, lane_get(from->rate, k), rate + lane_get(from->rate_low, k));
        bad += (phi - phi) + (rate - rate);
    }
    return bad;
}

static int ensemble_step(struct ensemble_lanes *lanes, unsigned char attention[]) {
    struct jets_system s = ensemble_view(lanes);
    num unit = lane_get(lanes->unit, 0), time = lane_get(lanes->from.time, 0), stop = lane_get(lanes->stop, 0);
    ensemble_start(lanes, &s, unit);
    jets_factor(&s);
    num gravity = lane_get(lanes->gravity, 0) * unit * unit;
    if (s.n <= DENSE_MAX) dense_orders(&s, gravity, lanes->order);
    else jets_orders(&s, gravity, lanes->order);
    num x = ensemble_choose(lanes, &s), left = (stop - time) / unit;
    mask lands = (mask)(x >= left);
    num next = NUM_(_pick)(lands, stop, time + x * unit);
    num still = (num)((mask)(next == time) & (mask)num_of(1));
    x = (next - time) / unit;
    num near = num_of(0);
    for (int k = 0; k < s.n && lanes->bound > 0; k++) {
        num here = ensemble_near(lanes, &s, k, x);
        lane_put(lanes->near, k, here);
        near += here;
    }
    num bad = ensemble_advance(lanes, &s, x, unit) + still;
    lane_put(lanes->to.time, 0, next);
    lane_put(lanes->step, 0, x);
    // the next unit is a power of two near this step
    num grown = NUM_(_round)(NUM_(_log2)(num_max(x, num_of(0x1p-60))));
    lane_put(lanes->unit, 0, unit * NUM_(_power)(grown));
    int any = 0;
    for (int i = 0; i < WIDTH; i++) {
        attention[i] = (unsigned char)((lands[i] ? ENSEMBLE_DONE : 0) | (bad[i] == 0 ? 0 : ENSEMBLE_BAD) |
                                       (near[i] == 0 ? 0 : ENSEMBLE_NEAR));
        any |= attention[i];
    }
    return any;
}

#define KERNEL_PASTE2(a, b) a##b
#define KERNEL_PASTE(a, b) KERNEL_PASTE2(a, b)

const struct ensemble_kernel KERNEL_PASTE(pend_kernel_ensemble_, PEND_ISA) = {
    .width = WIDTH,
    .series_count = ensemble_series_count,
    .step = ensemble_step,
};
