#include "core/extended/kernel_extended.h"

#include "core/simd/vec_isa.h"
#include "core/taylor/taylor_order.h"

/* a number is a sum of two doubles for each lane */
#define NUMBER_DOUBLE_DOUBLE
#include "core/taylor/jets_template.h"
#define num_from NUM_(from)
#define num_gather NUM_(gather)
#define num_settle NUM_(settle)
#define num_total NUM_(total)

enum {
#define X(name) ARRAY_##name,
    JETS_ARRAYS(X)
#undef X
        ARRAY_COUNT,
    DENSE_MAX = 4, /* arms of trees whose orders are solved by an inverse */
    TRAILING = 4,
    LEADING = 4,
#ifdef __FMA__
    FIXED = 8 /* the order from which terms are so small that sums with a fixed last place do */
#else
    FIXED = 1 << 30 /* these need fused multiply-add */
#endif
};

/* ---- memory */

/* numbers from one series to the next */
static size_t extended_series(int n, int order) { return (size_t)n * (size_t)(order + 2); }

static size_t extended_series_count(int n, int order) {
    size_t numbers = 4 * extended_series(n, order) + (size_t)ARRAY_COUNT * (size_t)n;
    return (2 * numbers + 7 * extended_series(n, order)) * WIDE;
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

/*
 * What the sums of T and c need besides the series, in the same order. Sizes are |Re u| + |Im u|,
 * |phi'| and |lambda|. With a single trajectory the four sums of an arm go side by side in lanes: u
 * = (Re u, Im u, Re u, Im u) of order j and met = (phi', phi', lambda, lambda), phi' of order j and
 * lambda of order j - 1.
 */
struct extended_sizes {
    int single;
    wide *turn, *rate, *force; /* force is met's sizes with a single trajectory */
    num *u, *met;
};

static struct extended_sizes extended_sizes_view(const struct extended_lanes *lanes) {
    size_t n = (size_t)lanes->n, series = extended_series(lanes->n, lanes->order);
    num *u = (num *)(void *)lanes->series + 4 * series + (size_t)ARRAY_COUNT * n;
    wide *at = (wide *)(void *)(u + 2 * series);
    return (struct extended_sizes){
        lanes->single && WIDE == 4, at, at + series, at + 2 * series, u, u + series};
}

/* x in the lanes of a set, y in the others */
VEC_INLINE num extended_blend(const wide_mask *set, num x, num y) { return NUM_(pick)(*set, x, y); }

/* lays out phi' and u of order k, and lambda of the order before, for a single trajectory */
static void extended_pack(const struct jets_system *s, const struct extended_sizes *sizes, int k) {
    wide_mask odd = {0}, late = {0};
    for (int i = 0; i < WIDE; i++) odd[i] = -(i % 2), late[i] = -(i / 2);
    for (int i = 0; i < s->n; i++) {
        size_t at = (size_t)k * s->stride + (size_t)i, next = at + s->stride;
        num force = k ? s->force[at - s->stride] : num_of(0);
        sizes->u[next] = extended_blend(&odd, s->turn_im[next], s->turn_re[next]);
        sizes->met[at] = extended_blend(&late, force, s->rate[at]);
        sizes->turn[next] = WIDE_(abs)(s->turn_re[next].high) + WIDE_(abs)(s->turn_im[next].high);
        sizes->force[at] = WIDE_(abs)(sizes->met[at].high);
    }
}

/* sizes of phi' and u of order k, and of lambda of the order before */
static void extended_measure(const struct jets_system *s, const struct extended_sizes *sizes,
                             int k) {
    if (sizes->single) {
        extended_pack(s, sizes, k);
        return;
    }
    for (int i = 0; i < s->n; i++) {
        size_t at = (size_t)k * s->stride + (size_t)i, before = at - s->stride,
               next = at + s->stride;
        sizes->rate[at] = WIDE_(abs)(s->rate[at].high);
        sizes->turn[next] = WIDE_(abs)(s->turn_re[next].high) + WIDE_(abs)(s->turn_im[next].high);
        if (k) sizes->force[before] = WIDE_(abs)(s->force[before].high);
    }
}

VEC_INLINE wide lane_get(const double *array, int k) {
    return WIDE_(get)(array + (size_t)k * WIDE);
}

VEC_INLINE void lane_put(double *array, int k, wide x) { WIDE_(put)(array + (size_t)k * WIDE, x); }

VEC_INLINE num lane_pair(const double *high, const double *low, int k) {
    return (num){lane_get(high, k), lane_get(low, k)};
}

/* 1 / (j + 1) to all digits, from its first ones */
VEC_INLINE num extended_share(const double share[], int j) {
    wide high = wide_of(share[j]);
    num rest = NUM_(product)(high, wide_of(j + 1));
    return (num){high, ((1 - rest.high) - rest.low) * high};
}

/* sine and cosine of the angle of every arm to its parent, rates in units, and the tree system
 * of order 0 */
static void extended_start(const struct extended_lanes *lanes, const struct jets_system *s,
                           wide unit) {
    const struct extended_state *from = &lanes->from;
    for (int k = 0; k < s->n; k++) {
        int p = s->parent[k];
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
    jets_factor(s);
}

/* ---- the known parts of an order: T and c */

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

/* sums whose first part has a fixed last place, far enough up that every product fits */
struct extended_fixed {
    wide start, high, low;
};

typedef unsigned long long extended_bits __attribute__((vector_size(sizeof(wide))));

/* a start for products whose sizes add up to `size` at most: 6 times a power of two above it, so
 * that the last place is the same all along */
VEC_INLINE wide extended_bias(wide size) {
    extended_bits exponent = (extended_bits)size & 0x7ff0000000000000ULL;
    return (wide)((exponent + (2ULL << 52)) | 0x8000000000000ULL);
}

/* adds x y: what of the product the first part has no place for goes to the second */
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

/* sums of the sizes of the terms of both */
VEC_INLINE void extended_sizes(const struct extended_sizes *sizes, int n, int k, int a, wide *wind,
                               wide *drag) {
    const wide *turn = sizes->turn + n + a, *rate = sizes->rate + k * n + a,
               *force = sizes->force + (k - 1) * n + a;
    *wind = *drag = wide_of(0);
    for (int j = 1; j <= k; j++, turn += n, rate -= n, force -= n) {
        *wind = wide_fma(*turn, *rate, *wind);
        *drag = wide_fma(*turn, *force, *drag);
    }
    *wind = wide_fma(*turn, *rate, *wind);
}

/* order k > 0, a few digits short, where the terms are small */
VEC_INLINE struct extended_known extended_convolve_fixed(const struct jets_system *s,
                                                         const struct extended_sizes *sizes,
                                                         size_t n, int k, int a) {
    const num *re = s->turn_re + a + n, *im = s->turn_im + a + n;
    const num *rate = s->rate + a + (size_t)k * n, *force = s->force + a + (size_t)(k - 1) * n;
    wide wind, drag;
    extended_sizes(sizes, (int)n, k, a, &wind, &drag);
    struct extended_fixed wind_re = extended_empty(wind), wind_im = wind_re;
    struct extended_fixed drag_re = extended_empty(drag), drag_im = drag_re;
    for (int j = 1; j <= k; j++, re += n, im += n, rate -= n, force -= n) {
        num w = *rate, f = *force, x = *re, y = *im;
        extended_collect(&wind_re, x, w);
        extended_collect(&wind_im, y, w);
        extended_collect(&drag_re, x, f);
        extended_collect(&drag_im, y, f);
    }
    extended_collect(&wind_re, *re, *rate);
    extended_collect(&wind_im, *im, *rate);
    return (struct extended_known){extended_collected(&wind_re), extended_collected(&wind_im),
                                   extended_collected(&drag_re), extended_collected(&drag_im)};
}

struct extended_rough {
    wide wind_re, wind_im, drag_re, drag_im;
};

/* the same of an order that needs but one double */
VEC_INLINE struct extended_rough extended_convolve_rough(const struct jets_system *s,
                                                         const struct extended_sizes *sizes,
                                                         size_t n, int k, int a) {
    if (sizes->single) {
        const num *u = sizes->u + a + n, *met = sizes->met + a + (size_t)k * n;
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

/* ---- orders of small trees, by the inverse of the tree system */

/* what a unit of T_j (pull) and of c_j (side) does to phi'' and to the force of arm i: [j][i] */
struct extended_table {
    num rate_pull[DENSE_MAX][DENSE_MAX], rate_side[DENSE_MAX][DENSE_MAX];
    num force_pull[DENSE_MAX][DENSE_MAX], force_side[DENSE_MAX][DENSE_MAX];
};

/* the answer of all arms to the right-hand side in heave and drag_im */
static void extended_answer(const struct jets_system *s, num rate[], num force[]) {
    for (int k = 0; k < s->n; k++)
        s->sum_side[k] = s->sum_cos[k] = s->sum_sin[k] = s->early[k] = num_of(0);
    jets_up(s);
    jets_down(s, num_of(0));
    for (int i = 0; i < s->n; i++) {
        num ar = s->from_radial[i], at = s->from_tangential[i];
        num gap =
            num_add(num_sub(num_mul(s->sine[i], ar), num_mul(s->cosine[i], at)), s->tangential[i]);
        rate[i] = num_mul(gap, s->inv_len[i]);
        force[i] = num_fma(num_mul(s->eff[i], s->kappa[i]), ar, s->tension[i]);
    }
}

static void extended_invert(const struct jets_system *s, struct extended_table *table) {
    for (int k = 0; k < s->n; k++) s->heave[k] = s->drag_im[k] = num_of(0);
    for (int j = 0; j < s->n; j++) {
        s->heave[j] = num_mul(s->eff[j], s->len[j]);
        extended_answer(s, table->rate_pull[j], table->force_pull[j]);
        s->heave[j] = num_of(0);
        s->drag_im[j] = num_of(1);
        extended_answer(s, table->rate_side[j], table->force_side[j]);
        s->drag_im[j] = num_of(0);
    }
}

/* the four sums of a single trajectory, from one each in a lane */
VEC_INLINE struct extended_known extended_spread(num x) {
    return (struct extended_known){num_of2(x.high[0], x.low[0]), num_of2(x.high[1], x.low[1]),
                                   num_of2(x.high[2 % WIDE], x.low[2 % WIDE]),
                                   num_of2(x.high[3 % WIDE], x.low[3 % WIDE])};
}

/* the sums of order k of a single trajectory, by the same operations */
VEC_INLINE struct extended_known extended_convolve_single(const struct extended_sizes *sizes,
                                                          size_t n, int k, int a) {
    const num *u = sizes->u + a + n, *met = sizes->met + a + (size_t)k * n;
    if (k < FIXED) {
        num sum = num_of(0);
        for (int j = 1; j <= k + 1; j++, u += n, met -= n) sum = num_gather(*u, *met, sum);
        return extended_spread(num_settle(sum));
    }
    wide size = wide_of(0);
    const wide *turn = sizes->turn + a + n, *other = sizes->force + a + (size_t)k * n;
    for (int j = 1; j <= k + 1; j++, turn += n, other -= n) size = wide_fma(*turn, *other, size);
    struct extended_fixed sum = extended_empty(size);
    for (int j = 1; j <= k + 1; j++, u += n, met -= n) extended_collect(&sum, *u, *met);
    return extended_spread(extended_collected(&sum));
}

VEC_INLINE struct extended_known extended_find(const struct jets_system *s,
                                               const struct extended_sizes *sizes, size_t n, int k,
                                               int a) {
    if (sizes->single) return extended_convolve_single(sizes, n, k, a);
    return k < FIXED ? extended_convolve(s, n, k, a) : extended_convolve_fixed(s, sizes, n, k, a);
}

/* order k from its known parts; lift and drop are gravity's, of the root */
VEC_INLINE void extended_solve(const struct jets_system *s, const struct extended_table *table,
                               int n, int k, num gravity, const struct extended_known known[]) {
    num share = extended_share(s->share, k), turn_share = extended_share(s->share, k + 1),
        pull[DENSE_MAX], side[DENSE_MAX], drop = num_of(0);
    for (int j = 0; j < n; j++) {
        pull[j] = known[j].wind_im;
        side[j] = num_mul(known[j].drag_im, share);
    }
    if (k == 0) {
        // gravity is a pull on the root
        num per_len = num_mul(gravity, s->inv_len[0]);
        pull[0] = num_sub(pull[0], num_mul(s->sine[0], per_len));
        drop = num_mul(s->cosine[0], per_len);
    }
    for (int i = 0; i < n; i++) {
        num rate = num_of(0), force = num_of(0);
        for (int j = 0; j < n; j++) {
            rate = num_gather(side[j], table->rate_side[j][i], rate);
            force = num_gather(side[j], table->force_side[j][i], force);
            rate = num_gather(pull[j], table->rate_pull[j][i], rate);
            force = num_gather(pull[j], table->force_pull[j][i], force);
        }
        rate = num_settle(rate);
        if (i == 0) rate = num_sub(rate, drop);
        s->rate[(k + 1) * n + i] = num_sub(rate, known[i].wind_re);
        s->force[k * n + i] = num_sub(num_mul(num_of(k + 1), num_settle(force)), known[i].drag_re);
        s->turn_re[(k + 2) * n + i] = num_neg(num_mul(turn_share, known[i].wind_im));
        s->turn_im[(k + 2) * n + i] = num_mul(turn_share, rate);
    }
}

VEC_INLINE void extended_solve_rough(const struct jets_system *s,
                                     const struct extended_table *table, int n, int k,
                                     const struct extended_rough known[]) {
    for (int i = 0; i < n; i++) {
        wide rate = wide_of(0), force = wide_of(0);
        for (int j = 0; j < n; j++) {
            wide side = known[j].drag_im * s->share[k], pull = known[j].wind_im;
            rate = wide_fma(pull, table->rate_pull[j][i].high,
                            wide_fma(side, table->rate_side[j][i].high, rate));
            force = wide_fma(pull, table->force_pull[j][i].high,
                             wide_fma(side, table->force_side[j][i].high, force));
        }
        s->rate[(k + 1) * n + i] = num_from(rate - known[i].wind_re);
        s->force[k * n + i] = num_from((double)(k + 1) * force - known[i].drag_re);
        s->turn_re[(k + 2) * n + i] = num_from(-s->share[k + 1] * known[i].wind_im);
        s->turn_im[(k + 2) * n + i] = num_from(s->share[k + 1] * rate);
    }
}

VEC_INLINE void extended_small_of(const struct jets_system *s, const struct extended_sizes *sizes,
                                  num gravity, int order, int precise, int n) {
    struct extended_table table;
    extended_invert(s, &table);
    extended_measure(s, sizes, 0);
    for (int k = 0; k < order; k++) {
        struct extended_known known[DENSE_MAX];
        struct extended_rough rough[DENSE_MAX];
        if (k < precise) {
            for (int i = 0; i < n; i++) known[i] = extended_find(s, sizes, (size_t)n, k, i);
            extended_solve(s, &table, n, k, gravity, known);
            extended_measure(s, sizes, k + 1);
        } else {
            for (int i = 0; i < n; i++)
                rough[i] = extended_convolve_rough(s, sizes, (size_t)n, k, i);
            extended_solve_rough(s, &table, n, k, rough);
            if (sizes->single) extended_measure(s, sizes, k + 1);
        }
    }
}

static void extended_small(const struct jets_system *s, const struct extended_sizes *sizes,
                           num gravity, int order, int precise) {
    if (s->n == 1)
        extended_small_of(s, sizes, gravity, order, precise, 1);
    else if (s->n == 2)
        extended_small_of(s, sizes, gravity, order, precise, 2);
    else if (s->n == 3)
        extended_small_of(s, sizes, gravity, order, precise, 3);
    else
        extended_small_of(s, sizes, gravity, order, precise, 4);
}

/* ---- orders of other trees, by the sweeps */

static void extended_learn(const struct jets_system *s, int k) {
    num share = extended_share(s->share, k), turn_share = extended_share(s->share, k + 1);
    for (int i = 0; i < s->n; i++) {
        size_t now = (size_t)k * s->stride + (size_t)i, next = now + s->stride,
               after = next + s->stride;
        num ar = s->from_radial[i], at = s->from_tangential[i];
        num gap =
            num_add(num_sub(num_mul(s->sine[i], ar), num_mul(s->cosine[i], at)), s->tangential[i]);
        num turned = num_mul(num_mul(gap, s->inv_len[i]), share);
        s->force[now] = num_sub(num_fma(s->stiff[i], ar, s->tension[i]), s->drag_re[i]);
        s->rate[next] = num_sub(turned, s->wind_re[i]);
        s->turn_re[after] = num_neg(num_mul(s->wind_im[i], turn_share));
        s->turn_im[after] = num_mul(turned, turn_share);
    }
}

static void extended_orders(const struct jets_system *s, const struct extended_sizes *sizes,
                            num gravity, int order, int precise) {
    for (int i = 0; i < s->n; i++) {
        s->stiff[i] = num_mul(s->eff[i], s->kappa[i]);
        s->weight[i] = num_mul(s->eff[i], s->len[i]);
    }
    extended_measure(s, sizes, 0);
    for (int k = 0; k < order; k++) {
        for (int i = 0; i < s->n; i++) {
            struct extended_known x;
            if (k < precise) {
                x = extended_find(s, sizes, s->stride, k, i);
            } else {
                struct extended_rough y = extended_convolve_rough(s, sizes, s->stride, k, i);
                x = (struct extended_known){num_from(y.wind_re), num_from(y.wind_im),
                                            num_from(y.drag_re), num_from(y.drag_im)};
            }
            jets_prepare(s, k, i, x.wind_re, x.wind_im, x.drag_re, x.drag_im);
        }
        jets_up(s);
        jets_down(s, k ? num_of(0) : gravity);
        extended_learn(s, k);
        if (k < precise || sizes->single) extended_measure(s, sizes, k + 1);
    }
}

/* ---- the step */

/* binary logarithm of the largest coefficient of order j, far below all others where all are
 * zero */
VEC_INLINE wide extended_norm(const struct jets_system *s, int j) {
    wide norm = wide_of(0);
    for (int k = 0; k < s->n; k++)
        norm = WIDE_(max)(norm, WIDE_(abs)(s->rate[(size_t)j * s->stride + (size_t)k].high));
    return WIDE_(log2)(norm) - (wide)((wide_mask)(norm == 0) & (wide_mask)wide_of(1e4));
}

/* the step in units, by the rule of the taylor method: the first term left out is below rtol times
 * the motion, or atol
 */
static wide extended_choose(const struct extended_lanes *lanes, const struct jets_system *s) {
    static const double log2_of[LEADING] = {0, 1, 1.5849625007211562, 2};
    wide leading[LEADING], reach = wide_of(10);
    const double *last = s->share + lanes->order;
    double spread = (PEND_TAYLOR_LOG_CAP - lanes->log_rtol) * last[0];
    for (int i = 0; i < LEADING; i++) leading[i] = extended_norm(s, i) - log2_of[i];
    for (int j = lanes->order - TRAILING + 1; j <= lanes->order; j++) {
        wide trailing = extended_norm(s, j),
             far = lanes->log_atol * last[1] - trailing * s->share[j];
        wide here = lanes->log_rtol * last[0] + (leading[0] - trailing) * s->share[j - 1];
        for (int i = 1; i < LEADING; i++)
            here = WIDE_(max)(here, lanes->log_rtol * last[-i] +
                                        (leading[i] - trailing) * s->share[j - i - 1]);
        // what atol lets pass is bounded as rtol is
        here = WIDE_(max)(here, WIDE_(min)(far, here + spread));
        reach = WIDE_(min)(reach, here);
    }
    return WIDE_(exp2)(WIDE_(max)(reach, wide_of(-60)));
}

/* phi (less its start) and unit times phi' (less its start) x units after the start, by Horner's
 * rule */
struct extended_change {
    num phi, rate;
};

/* how the coefficients of an arm are read: all lanes, or one lane's in every lane */
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

/* the state at the end of the step; a sum that is not finite shows in the return value, 0 where
 * all are */
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

static int extended_step(struct extended_lanes *lanes) {
    struct jets_system s = extended_view(lanes);
    wide unit = lane_get(lanes->unit, 0), time = lane_get(lanes->from.time, 0),
         stop = lane_get(lanes->stop, 0);
    struct extended_sizes sizes = extended_sizes_view(lanes);
    extended_start(lanes, &s, unit);
    num gravity = num_from(lane_get(lanes->gravity, 0) * unit * unit);
    if (s.n <= DENSE_MAX)
        extended_small(&s, &sizes, gravity, lanes->order, lanes->precise);
    else
        extended_orders(&s, &sizes, gravity, lanes->order, lanes->precise);
    wide x = extended_choose(lanes, &s), left = (stop - time) / unit;
    wide_mask lands = (wide_mask)(x >= left);
    wide next = WIDE_(pick)(lands, stop, time + x * unit);
    wide still = (wide)((wide_mask)(next == time) & (wide_mask)wide_of(1));
    // times are doubles, what lies between them is not
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

const struct extended_kernel KERNEL_NAME(pend_kernel_extended_) = {
    .width = WIDE,
    .series_count = extended_series_count,
    .step = extended_step,
    .values = extended_values,
};
