#include "core/derivatives/kernel_ideal.h"

#include <math.h>

#define NUMBER_VEC 1

#include "core/derivatives/ideal_known_template.h"
#include "core/taylor/taylor_order.h"

/* With u = e^{i (phi - phi_0)}, the acceleration of a tip relative to its joint is l u'', and the
 * force along an arm is F = lambda u, in the frame of the arm at the start. Let x be the derivative
 * of phi, and E the derivative of -i u, or of -i l u divided by l if a length varies. Then
 *
 *   E = x u - i (dl / l) u          Im F - x lambda = Im F - Im (F u*)        (F* is the known
 *   force)
 *
 * Order k + 2 of E, apart from the term with x_{k+2}, and order k of Im F are five sums of products
 * of known numbers. The tree system of order 0, the same as for the motion, gives x'' and Re F: Im
 * E is a pull along an arm, Im F a force across it. A varying mass adds a force dm (z'' + i g); it
 * is subtracted as B from F of every arm between that mass and the pivot. Numbers with derivatives
 * need ten sums instead of five, divisions, and a pass for every eight parameters.
 *
 * tests/bench/parts/bench_derivatives.c compares this with other programs; core/theory.md has the
 * figures. */

enum { LANES = IDEAL_LANES, TRAILING = 4, LEADING = 4 };

/* log2 of the size, relative to the motion, below which a derivative does not limit the step */
static const double ideal_floor = -40;

/* ---- the orders */

/* The sums of orders k and k + 1 of an arm, without the products that contain order k of the
 * solution. The factors in order k + 2 of E are of one order less than those in order k + 1 of F,
 * so that one loop computes both. */
VEC_INLINE void ideal_known_sums(const struct ideal_known *s, const struct ideal_group *g, int a,
                                 int k, int p, struct ideal_sums *now, struct ideal_sums *next) {
    size_t row = (size_t)a * g->rows * LANES + (size_t)p, at = ideal_place(s, a, k);
    const double *x = g->angle + row, *along = g->along + row, *across = g->across + row;
    const double *re = s->turn_re + at, *im = s->turn_im + at, *force = s->force + at;
    wide zero = wide_of(0), first = wide_get(x), second = wide_get(x + LANES);
    wide len = g->lengths ? wide_get(g->length + a * LANES + p) : zero;
    wide now_x[3], next_x[3], now_f[2] = {zero, zero}, next_f[2] = {zero, zero};
    now_x[0] = wide_fma(second, wide_of(re[LANES]), first * re[2 * LANES]);
    now_x[1] = wide_fma(second, wide_of(im[LANES]), first * im[2 * LANES]);
    now_x[2] = wide_fma(second, wide_of(force[-LANES]), first * force[0]);
    next_x[0] = wide_fma(second, wide_of(re[2 * LANES]), first * re[3 * LANES]);
    next_x[1] = wide_fma(second, wide_of(im[2 * LANES]), first * im[3 * LANES]);
    next_x[2] = wide_fma(second, wide_of(force[0]), first * force[LANES]);
    if (g->lengths) {
        now_x[0] = wide_fma(len, wide_of(im[2 * LANES]), now_x[0]);
        now_x[1] = wide_fma(len, wide_of(-re[2 * LANES]), now_x[1]);
        next_x[0] = wide_fma(len, wide_of(im[3 * LANES]), next_x[0]);
        next_x[1] = wide_fma(len, wide_of(-re[3 * LANES]), next_x[1]);
    }
    for (int i = 0; i < k; i++, re -= LANES, im -= LANES, force -= LANES) {
        x += LANES;
        wide y = wide_get(x + LANES), f = wide_get(along), c = wide_get(across);
        // reload the numbers of the next order: sixteen registers do not suffice to keep them
        wide later_re = wide_of(re[LANES]), later_im = wide_of(im[LANES]);
        next_x[0] = wide_fma(y, later_re, next_x[0]);
        next_f[1] = wide_fma(c, later_re, next_f[1]);
        next_x[1] = wide_fma(y, later_im, next_x[1]);
        next_f[0] = wide_fma(f, later_im, next_f[0]);
        next_x[2] = wide_fma(y, wide_of(force[-LANES]), next_x[2]);
        wide ur = wide_of(re[0]), ui = wide_of(im[0]);
        now_x[0] = wide_fma(y, ur, now_x[0]);
        now_f[1] = wide_fma(c, ur, now_f[1]);
        now_x[1] = wide_fma(y, ui, now_x[1]);
        now_f[0] = wide_fma(f, ui, now_f[0]);
        now_x[2] = wide_fma(y, wide_of(force[-2 * LANES]), now_x[2]);
        along += LANES, across += LANES;
    }
    *now = (struct ideal_sums){now_x[0], now_x[1], now_x[2] + (now_f[0] - now_f[1])};
    *next = (struct ideal_sums){next_x[0], next_x[1], next_x[2] + (next_f[0] - next_f[1])};
}

/* computes order k of B, the effect of varying masses */
VEC_INLINE void ideal_masses(const struct ideal_known *s, const struct ideal_group *g, int k,
                             int p) {
    for (int a = 0; a < s->n; a++) {
        wide mass = wide_get(g->mass + a * LANES + p);
        PUT(WORK_MASS_RE, a, mass * s->acc_re[ideal_place(s, a, k)]);
        PUT(WORK_MASS_IM, a, mass * s->acc_im[ideal_place(s, a, k)]);
    }
    for (int a = s->n - 1; a > 0; a--) {
        int up = s->system.parent[a];
        double C = s->system.cosine[a], Z = s->system.sine[a];
        wide re = GET(WORK_MASS_RE, a), im = GET(WORK_MASS_IM, a);
        PUT(WORK_MASS_RE, up, GET(WORK_MASS_RE, up) + (C * re - Z * im));
        PUT(WORK_MASS_IM, up, GET(WORK_MASS_IM, up) + (Z * re + C * im));
    }
}

/* solves the tree system with the table of responses */
VEC_INLINE void ideal_dense(const struct ideal_known *s, int n, const struct ideal_sums sum[],
                            double factor, double inverse, struct ideal_answer answer[]) {
    wide side[IDEAL_DENSE];
    assert(n <= IDEAL_DENSE);
    for (int j = 0; j < n; j++) side[j] = sum[j].across * inverse;
    for (int i = 0; i < n; i++) {
        const double *row = s->table + 2 * i * IDEAL_PITCH, *force = row + IDEAL_PITCH;
        wide x = side[0] * row[n], f = side[0] * force[n];
        for (int j = 1; j < n; j++) {
            x = wide_fma(side[j], wide_of(row[n + j]), x);
            f = wide_fma(side[j], wide_of(force[n + j]), f);
        }
        for (int j = 0; j < n; j++) {
            x = wide_fma(sum[j].im, wide_of(row[j]), x);
            f = wide_fma(sum[j].im, wide_of(force[j]), f);
        }
        answer[i] = (struct ideal_answer){x, f * factor};
    }
}

/* adds order k of the torques and of the bodies' inertia to the forces across the arms */
VEC_INLINE void ideal_load(const struct ideal_known *s, const struct ideal_group *g, int n, int k,
                           int p, struct ideal_sums sum[]) {
    for (int a = 0; a < n; a++) {
        int up = s->system.parent[a];
        if (s->bodies || g->lengths) sum[a].across += ideal_resist(s, g, a, k, p, sum[a].re);
        if (!s->joints) continue;
        wide torque = ideal_torque(s, g, a, k, p);
        sum[a].across = wide_fma(torque, wide_of(s->system.inv_len[a]), sum[a].across);
        if (up >= 0)
            sum[up].across = wide_fma(torque, wide_of(-s->system.inv_len[up]), sum[up].across);
    }
}

/* computes from the sums, which it overwrites, the coefficients of order k of the angles and of the
 * forces along the arms */
VEC_INLINE void ideal_solve(const struct ideal_known *s, const struct ideal_group *g, int n,
                            int real, int k, int p, struct ideal_sums sum[],
                            struct ideal_answer answer[]) {
    assert(n == s->n && k >= 0 && k < s->order);
    double factor = (double)(k + 1) * (k + 2);
    double inverse = s->system.share[k] * s->system.share[k + 1];
    if (g->masses) {
        ideal_masses(s, g, k, p);
        for (int a = 0; a < n; a++) sum[a].across -= GET(WORK_MASS_IM, a);
    }
    if (!k) {
        // gravity acts as an acceleration of the pivot
        wide lift = wide_get(g->gravity + p) * (0.5 * s->square * s->system.inv_len[0]);
        sum[0].re = wide_fma(wide_of(s->system.cosine[0]), lift, sum[0].re);
        sum[0].im -= s->system.sine[0] * lift;
    }
    if (real) ideal_load(s, g, n, k, p, sum);
    if (n <= IDEAL_DENSE)
        ideal_dense(s, n, sum, factor, inverse, answer);
    else
        ideal_swept(s, g, p, sum, factor, inverse, answer);
    for (int a = 0; a < n; a++) {
        size_t row = ((size_t)a * g->rows + (size_t)k) * LANES + (size_t)p;
        if (real) sum[a].across -= answer[a].x * (s->inertia[a] * s->system.inv_len[a] * factor);
        answer[a].x -= sum[a].re;
        if (g->masses) {
            answer[a].along += GET(WORK_MASS_RE, a);
            sum[a].across += GET(WORK_MASS_IM, a);
        }
        wide_put(g->angle + row + 2 * LANES, answer[a].x);
        wide_put(g->along + row, answer[a].along);
        wide_put(g->across + row, sum[a].across);
    }
}

/* computes the orders; for up to IDEAL_DENSE arms, the known terms of an order stay in registers */
VEC_INLINE void ideal_orders_in(const struct ideal_known *s, const struct ideal_group *g, int n,
                                int real, int p, struct ideal_sums now[], struct ideal_sums next[],
                                struct ideal_answer answer[]) {
    for (int k = 0; k < s->order; k += 2) {
        for (int a = 0; a < n; a++) ideal_known_sums(s, g, a, k, p, &now[a], &next[a]);
        ideal_solve(s, g, n, real, k, p, now, answer);
        if (k + 1 == s->order) break;
        for (int a = 0; a < n; a++) {
            // adds the terms that contain order k of the solution; u_1 is i phi'_0
            wide rate = wide_of(s->rate[ideal_place(s, a, 0)]);
            next[a].im = wide_fma(rate, answer[a].x, next[a].im);
            next[a].across = wide_fma(rate, answer[a].along, next[a].across);
        }
        ideal_solve(s, g, n, real, k + 1, p, next, answer);
    }
}

static void ideal_orders_swept(const struct ideal_known *s, const struct ideal_group *g, int p) {
    void *now = ideal_row(g, s->n, WORK_NOW, 0), *next = ideal_row(g, s->n, WORK_NEXT, 0);
    void *answer = ideal_row(g, s->n, WORK_ANSWER, 0);
    ideal_orders_in(s, g, s->n, s->loaded, p, now, next, answer);
}

/* the orders of up to `room` arms, once for each n, which is then a compile-time constant */
#define IDEAL_ORDERS(name, room, arms, real)                                                       \
    static void ideal_orders_##name(const struct ideal_known *s, const struct ideal_group *g,      \
                                    int p) {                                                       \
        struct ideal_sums now[room], next[room];                                                   \
        struct ideal_answer answer[room];                                                          \
        struct ideal_known known = *s;                                                             \
        known.n = arms;                                                                            \
        ideal_orders_in(&known, g, known.n, real, p, now, next, answer);                           \
    }
IDEAL_ORDERS(2, 2, 2, 0)
IDEAL_ORDERS(3, 3, 3, 0)
IDEAL_ORDERS(4, 4, 4, 0)
IDEAL_ORDERS(few, IDEAL_DENSE, s->n, 0)
IDEAL_ORDERS(real_1, 1, 1, 1)
IDEAL_ORDERS(real_2, 2, 2, 1)
IDEAL_ORDERS(real_3, 3, 3, 1)
IDEAL_ORDERS(real_4, 4, 4, 1)
IDEAL_ORDERS(real_few, IDEAL_DENSE, s->n, 1)
#undef IDEAL_ORDERS

/* a pendulum with one arm: phi'' = -(g / l) cos phi, with the derivative (g / l) sin phi x - d(g /
 * l) cos phi */
static void ideal_orders_single(const struct ideal_known *s, const struct ideal_group *g, int p) {
    assert(s->n == 1);
    double pull = s->gravity * s->system.inv_len[0];
    wide change = wide_get(g->gravity + p) * (s->square * s->system.inv_len[0]) -
                  pull * wide_get(g->length + p);
    for (int k = 0; k < s->order; k++) {
        wide sum = wide_of(0), other = sum;
        for (int j = 0; j < k; j += 2) {
            const double *x = g->angle + j * LANES + p, *lift = s->acc_re + (k - j) * LANES;
            sum = wide_fma(wide_get(x), wide_of(lift[0]), sum);
            other = wide_fma(wide_get(x + LANES), wide_of(lift[-LANES]), other);
        }
        if (k % 2 == 0)
            sum = wide_fma(wide_get(g->angle + k * LANES + p), wide_of(s->acc_re[0]), sum);
        double share = s->system.share[k] * s->system.share[k + 1];
        wide acc = pull * (sum + other) - s->acc_im[k * LANES] * change;
        wide_put(g->angle + (k + 2) * LANES + p, share * acc);
    }
}

typedef void ideal_orders_fn(const struct ideal_known *s, const struct ideal_group *g, int p);

/* selects the function that computes the orders, by the number of arms */
static ideal_orders_fn *ideal_orders_of(const struct ideal_known *s) {
    static ideal_orders_fn *const form[2][4] = {
        {ideal_orders_single, ideal_orders_2, ideal_orders_3, ideal_orders_4},
        {ideal_orders_real_1, ideal_orders_real_2, ideal_orders_real_3, ideal_orders_real_4}};
    if (s->n > IDEAL_DENSE) return ideal_orders_swept;
    if (s->n > 4) return s->loaded ? ideal_orders_real_few : ideal_orders_few;
    return form[s->loaded][s->n - 1];
}

/* ---- the length of a step */

/* log2 of the largest coefficient of order j in the angles' series, plus log2 of a factor */
VEC_INLINE wide ideal_norm(const struct ideal_known *s, const struct ideal_group *g, int j, int p,
                           double factor) {
    wide most = wide_of(0);
    for (int a = 0; a < s->n; a++)
        most =
            WIDE_(peak)(wide_get(g->angle + ((size_t)a * g->rows + (size_t)j) * LANES + p), most);
    return WIDE_(log2)(most * factor) - (wide)((wide_mask)(most == 0) & (wide_mask)wide_of(1e4));
}

/* log2 of the largest coefficient of order j >= 1 of the motion's angles, times 2^ideal_floor */
static double ideal_motion_norm(const struct ideal_known *s, int j) {
    wide most = wide_of(0);
    for (int a = 0; a < s->n; a++)
        most =
            WIDE_(peak)(wide_of(s->rate[ideal_place(s, a, j - 1)] * s->system.share[j - 1]), most);
    return most[0] > 0 ? WIDE_(log2)(most)[0] + ideal_floor : -1e4;
}

/* the rule of step_template in each lane; derivatives count as at least 2^ideal_floor of the
 * motion */
static double ideal_reach(const struct ideal_known *s, const struct ideal_group *g, double log_rtol,
                          double log_atol) {
    const double *last = s->system.share + s->order, *share = s->system.share;
    assert(s->order >= LEADING);
    double least = 10, spread = (PEND_TAYLOR_LOG_CAP - log_rtol) * last[0], floor[LEADING];
    for (int i = 0; i < LEADING; i++) floor[i] = ideal_motion_norm(s, i + 1);
    for (int p = 0; p < g->lanes; p += WIDE) {
        wide leading[LEADING], reach = wide_of(10);
        for (int i = 0; i < LEADING; i++)
            leading[i] = WIDE_(max)(ideal_norm(s, g, i + 1, p, 1), wide_of(floor[i]));
        for (int j = s->order - TRAILING + 1; j <= s->order; j++) {
            wide trailing = ideal_norm(s, g, j + 1, p, j + 1);
            wide far = log_atol * last[1] - trailing * share[j], here = wide_of(-1e4);
            for (int i = 0; i < LEADING; i++)
                here = WIDE_(max)(here,
                                  log_rtol * last[-i] + (leading[i] - trailing) * share[j - i - 1]);
            here = WIDE_(max)(here, WIDE_(min)(far, here + spread));
            reach = WIDE_(min)(reach, here);
        }
        for (int i = 0; i < WIDE; i++) least = fmin(least, reach[i]);
    }
    return exp2(fmax(least, -60));
}

static int ideal_finite(const struct ideal_known *s, const struct ideal_group *g) {
    wide bad = wide_of(0);
    double sum = 0;
    for (int a = 0; a < s->n; a++)
        for (int i = 0; i < (s->order + 2) * LANES; i += WIDE)
            bad += wide_get(g->angle + (size_t)a * g->rows * LANES + i) * 0;
    for (int i = 0; i < WIDE; i++) sum += bad[i];
    return sum == 0;
}

static double ideal_expand(const struct ideal_known *s, const struct ideal_group *g, double unit,
                           double log_rtol, double log_atol) {
    ideal_orders_fn *orders = ideal_orders_of(s);
    assert(s->n >= 1 && s->order > TRAILING);
    for (int p = 0; p < g->lanes; p += WIDE) {
        for (int a = 0; a < s->n; a++) {
            size_t row = (size_t)a * g->rows * LANES + (size_t)p;
            wide_put(g->angle + row, wide_get(g->phi + a * LANES + p));
            wide_put(g->angle + row + LANES, wide_get(g->rate + a * LANES + p) * unit);
        }
        orders(s, g, p);
    }
    return ideal_finite(s, g) ? ideal_reach(s, g, log_rtol, log_atol) : NAN;
}

/* ---- state inside a step */

/* adds a value to a sum of two doubles */
VEC_INLINE void ideal_sum(double *high, double *low, const double *from, const double *from_low,
                          wide add) {
    wide x = wide_get(from), more = add + wide_get(from_low), total = x + more, part = total - x;
    wide_put(low, (x - (total - part)) + (more - part));
    wide_put(high, total);
}

/* computes phi and unit phi' minus their start, and unit^2 phi'' */
struct ideal_gain {
    wide phi, rate, acc;
};

VEC_INLINE struct ideal_gain ideal_at(const struct ideal_known *s, const struct ideal_group *g,
                                      int a, int p, double x_) {
    const double *c = g->angle + (size_t)a * g->rows * LANES + p;
    wide x = wide_of(x_), zero = wide_of(0);
    struct ideal_gain sum = {zero, zero, zero};
    for (int j = s->order + 1; j >= 2; j--) {
        wide here = wide_get(c + j * LANES);
        sum.phi = wide_fma(sum.phi, x, here);
        sum.rate = wide_fma(sum.rate, x, here * (double)j);
        sum.acc = wide_fma(sum.acc, x, here * ((double)j * (j - 1)));
    }
    sum.phi = wide_fma(sum.phi, x, wide_get(c + LANES)) * x;
    sum.rate *= x;
    return sum;
}

static void ideal_advance(const struct ideal_known *s, const struct ideal_group *g, double unit,
                          double x) {
    double inverse = 1 / unit;
    for (int a = 0; a < s->n; a++)
        for (int p = 0; p < g->lanes; p += WIDE) {
            int at = a * LANES + p;
            struct ideal_gain sum = ideal_at(s, g, a, p, x);
            ideal_sum(g->end_phi + at, g->end_low + at, g->phi + at, g->phi_low + at, sum.phi);
            ideal_sum(g->end_rate + at, g->slow + at, g->rate + at, g->rate_low + at,
                      sum.rate * inverse);
        }
}

/* the value at x of a series of the motion */
static double ideal_horner(const double *series, int order, double x) {
    double sum = 0;
    for (int j = order; j >= 0; j--) sum = lanes1_fma(sum, x, series[j * LANES]);
    return sum;
}

/* The derivative of lambda = Re (F u*); for a pendulum with one arm, of m (g sin phi - l phi'^2).
 * `faster` is the derivative of the rate in units. */
VEC_INLINE wide ideal_force(const struct ideal_known *s, const struct ideal_group *g, int a, int p,
                            double x, wide more, wide faster) {
    size_t from = ideal_place(s, a, 0), row = (size_t)a * g->rows * LANES + (size_t)p;
    if (s->n > 1 || s->loaded) {
        double re = ideal_horner(s->turn_re + from, s->order + 1, x);
        double im = ideal_horner(s->turn_im + from, s->order + 1, x);
        wide along = wide_of(0), across = along, at = wide_of(x);
        for (int j = s->order - 1; j >= 0; j--) {
            along = wide_fma(along, at, wide_get(g->along + row + j * LANES));
            across = wide_fma(across, at, wide_get(g->across + row + j * LANES));
        }
        return wide_fma(along, wide_of(re), across * im);
    }
    double sine = ideal_horner(s->acc_re, s->order - 1, x);
    double cosine = ideal_horner(s->acc_im, s->order - 1, x);
    double rate = ideal_horner(s->rate, s->order, x), len = s->system.len[0];
    double lift = s->gravity * sine - len * rate * rate;
    wide sum = wide_get(g->mass + p) * lift;
    wide inner = wide_get(g->gravity + p) * (s->square * sine) + more * (s->gravity * cosine) -
                 wide_get(g->length + p) * (len * rate * rate) - faster * (2 * len * rate);
    return wide_fma(inner, wide_of(s->system.mass[0]), sum);
}

static void ideal_values(const struct ideal_known *s, const struct ideal_group *g, double unit,
                         double x, int all) {
    double inverse = 1 / unit, square = inverse * inverse;
    for (int a = 0; a < s->n; a++)
        for (int p = 0; p < g->lanes; p += WIDE) {
            int at = a * LANES + p;
            struct ideal_gain sum = ideal_at(s, g, a, p, x);
            wide phi = wide_get(g->phi + at) + (sum.phi + wide_get(g->phi_low + at));
            wide rate = wide_get(g->rate + at) + (sum.rate * inverse + wide_get(g->rate_low + at));
            wide_put(g->out[0] + at, phi);
            wide_put(g->out[1] + at, rate);
            if (!all) continue;
            wide_put(g->out[2] + at, sum.acc * square);
            wide_put(g->out[3] + at, square * ideal_force(s, g, a, p, x, phi, rate * unit));
        }
}

const struct ideal_kernel KERNEL_NAME(pend_kernel_ideal_) = {
    .know = ideal_know,
    .expand = ideal_expand,
    .advance = ideal_advance,
    .values = ideal_values,
};
