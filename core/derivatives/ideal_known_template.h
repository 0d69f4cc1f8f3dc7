/* For one step of an ideal pendulum: the data of its motion that its derivatives need, and the
 * solution of the tree system of order 0 for eight right-hand sides at once.
 * Leaves to others: the orders (kernel_ideal, which includes this), the factorization
 * (jets_factor, ideal_loads_template). Invariant: the sweeps of point masses are those of
 * jets_template, with plain numbers as coefficients. */
#pragma once

#include <assert.h>
#include <string.h>

#include "core/derivatives/ideal_loads_template.h"
#include "core/derivatives/ideal_system.h"
#include "core/simd/vec8_template.h"
#include "core/taylor/jets_factor.h"

/* ---- data of the motion */

/* u' = i phi' u; the newest coefficients come last */
static void ideal_turns(const struct ideal_known *s, size_t tile) {
    double *re = s->turn_re + tile, *im = s->turn_im + tile;
    const double *rate = s->rate + tile;
    for (int p = 0; p < VEC8; p += WIDE) {
        wide_put(re + p, wide_of(1));
        wide_put(im + p, wide_of(0));
        for (int j = 0; j <= s->order; j++) {
            wide even = wide_get(rate + j * IDEAL_LANES + p), odd = wide_of(0);
            wide x = even, y = odd, odd_x = odd, odd_y = odd;
            int i = 1;
            for (; i < j; i += 2) {
                const double *u = re + i * IDEAL_LANES + p, *v = im + i * IDEAL_LANES + p;
                odd = wide_get(rate + (j - i) * IDEAL_LANES + p);
                even = wide_get(rate + (j - i - 1) * IDEAL_LANES + p);
                odd_x = wide_fma(wide_get(u), odd, odd_x);
                odd_y = wide_fma(wide_get(v), odd, odd_y);
                x = wide_fma(wide_get(u + IDEAL_LANES), even, x);
                y = wide_fma(wide_get(v + IDEAL_LANES), even, y);
            }
            if (i == j) {
                odd = wide_get(rate + p);
                odd_x = wide_fma(wide_get(re + j * IDEAL_LANES + p), odd, odd_x);
                odd_y = wide_fma(wide_get(im + j * IDEAL_LANES + p), odd, odd_y);
            }
            wide share = wide_of(s->system.share[j]);
            wide_put(re + (j + 1) * IDEAL_LANES + p, -share * (y + odd_y));
            wide_put(im + (j + 1) * IDEAL_LANES + p, share * (x + odd_x));
        }
    }
}

/* as ideal_turns, for two to eight arms, whose stored series have real parts with the opposite
 * sign, except in the first two orders (small_template) */
static void ideal_kept_turns(const struct ideal_known *s) {
    for (int p = 0; p < VEC8; p += WIDE) {
        wide_put(s->turn_re + p, wide_of(1));
        wide_put(s->turn_im + p, wide_of(0));
        wide_put(s->turn_re + IDEAL_LANES + p, wide_of(0));
        wide_put(s->turn_im + IDEAL_LANES + p, wide_get(s->rate + p));
    }
    for (int i = 2 * IDEAL_LANES; i < (s->order + 2) * IDEAL_LANES; i += WIDE) {
        wide_put(s->turn_re + i, -wide_get(s->kept_re + i));
        wide_put(s->turn_im + i, wide_get(s->kept_im + i));
    }
}

/* accelerations of the tips minus the acceleration of gravity */
static void ideal_accelerations(const struct ideal_known *s) {
    for (int k = 0; k < s->n; k++) {
        int up = s->system.parent[k];
        double C = s->system.cosine[k], Z = s->system.sine[k], len = s->system.len[k];
        const double *held_re = up < 0 ? s->lift_x : s->acc_re + ideal_place(s, up, 0);
        const double *held_im = up < 0 ? s->lift_y : s->acc_im + ideal_place(s, up, 0);
        int span = up < 0 ? 1 : IDEAL_LANES;
        for (int j = 0; j < s->order; j++) {
            size_t at = ideal_place(s, k, j);
            double factor = len * (j + 1) * (j + 2), re = 0, im = j ? 0 : s->gravity;
            if (held_re) re = held_re[j * span], im = held_im[j * span];
            s->acc_re[at] = C * re + Z * im + factor * s->turn_re[at + 2 * IDEAL_LANES];
            s->acc_im[at] = C * im - Z * re + factor * s->turn_im[at + 2 * IDEAL_LANES];
        }
    }
}

/* the series of sin phi and cos phi of a pendulum with one arm, up to order - 1, from the motion's
 * series: phi'_{k+1} = -G cos_k / (k + 1), and the force is 3 m g sin_k from order 1 on
 * (single_template) */
static void ideal_pulled(const struct ideal_known *s, double pull, double weight) {
    double per = -1 / pull, lift = 1 / (3 * weight);
    s->acc_re[0] = s->system.sine[0], s->acc_im[0] = s->system.cosine[0];
    for (int j = 1; j < s->order; j++) {
        s->acc_re[j * IDEAL_LANES] = s->force[j * IDEAL_LANES] * lift;
        s->acc_im[j * IDEAL_LANES] = s->rate[(j + 1) * IDEAL_LANES] * (j + 1) * per;
    }
}

/* as ideal_pulled, from the arm's rotation factors, if gravity is negligible */
static void ideal_afloat(const struct ideal_known *s) {
    double C = s->system.cosine[0], Z = s->system.sine[0];
    ideal_turns(s, 0);
    for (int j = 0; j < s->order; j++) {
        double re = s->turn_re[j * IDEAL_LANES], im = s->turn_im[j * IDEAL_LANES];
        s->acc_re[j * IDEAL_LANES] = Z * re + C * im;
        s->acc_im[j * IDEAL_LANES] = C * re - Z * im;
    }
}

static void ideal_alone(const struct ideal_known *s) {
    const double least = 0x1p-500; // in units; far above the smallest normal double
    double pull = s->gravity * s->system.inv_len[0], weight = s->gravity * s->system.mass[0];
    if (fabs(pull) > least && fabs(weight) > least)
        ideal_pulled(s, pull, weight);
    else
        ideal_afloat(s);
}

/* ---- the tree system of order 0 */

/* The known terms of one order of an arm: E, and the force across the arm. */
struct ideal_sums {
    wide re, im, across;
};

/* A solution of the system: the acceleration of the angle divided by `factor`, and the force along
 * the arm. */
struct ideal_answer {
    wide x, along;
};

/* Rows of eight numbers per arm: the sums of two orders and the solutions, for more than
 * IDEAL_DENSE arms; the contribution of a varying mass; intermediate results of the sweeps. */
enum {
    WORK_NOW,
    WORK_NEXT = 3,
    WORK_ANSWER = 6,
    WORK_MASS_RE = 8,
    WORK_MASS_IM,
    WORK_PUSH,
    WORK_SIDE,
    WORK_BIAS,
    WORK_LATE,
    WORK_SUM,
    WORK_EARLY,
    WORK_RADIAL,
    WORK_TANGENTIAL
};
static_assert((int)WORK_TANGENTIAL < (int)IDEAL_WORK, "IDEAL_WORK rows");

/* address of row `what` of an arm */
VEC_INLINE double *ideal_row(const struct ideal_group *g, int n, int what, int k) {
    return g->work + ((size_t)what * (size_t)n + (size_t)k) * IDEAL_LANES;
}

#define ROW(what, k) (ideal_row(g, s->n, what, k) + p)
#define GET(what, k) wide_get(ROW(what, k))
#define PUT(what, k, x) wide_put(ROW(what, k), x)

/* Leaves to root, as in jets_up: the imaginary part of E times a factor acts as a pull. */
VEC_INLINE void ideal_up(const struct ideal_known *s, const struct ideal_group *g, int p,
                         const struct ideal_sums sum[], double factor) {
    const struct jets_system *t = &s->system;
    for (int k = 0; k < s->n; k++) {
        PUT(WORK_SIDE, k, sum[k].across);
        PUT(WORK_PUSH, k, wide_of(0));
        PUT(WORK_SUM, k, wide_of(0));
        PUT(WORK_EARLY, k, wide_of(0));
    }
    for (int k = s->n - 1; k > 0; k--) {
        int up = t->parent[k];
        wide across = sum[k].across;
        PUT(WORK_SIDE, up, GET(WORK_SIDE, up) - t->cosine[k] * across);
        PUT(WORK_PUSH, up, GET(WORK_PUSH, up) - t->sine[k] * across);
    }
    for (int k = s->n - 1; k >= 0; k--) {
        int up = t->parent[k];
        wide push = wide_fma(wide_of(t->lean[k]), GET(WORK_SIDE, k), GET(WORK_PUSH, k));
        wide bias = push - t->eff[k] * t->len[k] * factor * sum[k].im;
        PUT(WORK_PUSH, k, push);
        PUT(WORK_BIAS, k, bias);
        if (up < 0) break;
        wide late = GET(WORK_SUM, up);
        PUT(WORK_LATE, k, late);
        PUT(WORK_PUSH, up, wide_fma(wide_of(t->kappa[k]), bias, GET(WORK_PUSH, up)));
        PUT(WORK_SUM, up, wide_fma(wide_of(t->sine[k]), bias, late));
    }
}

/* root to leaves: accelerations of the angles, and forces along the arms; as in jets_down */
VEC_INLINE void ideal_down(const struct ideal_known *s, const struct ideal_group *g, int p,
                           double inverse, struct ideal_answer answer[]) {
    const struct jets_system *t = &s->system;
    for (int k = 0; k < s->n; k++) {
        int up = t->parent[k];
        wide tension = GET(WORK_BIAS, k), from_r = wide_of(0), from_t = wide_of(0);
        if (up >= 0) {
            wide early = GET(WORK_EARLY, up), bias = tension;
            wide across = GET(WORK_SIDE, up) - (early + GET(WORK_LATE, k));
            PUT(WORK_EARLY, up, wide_fma(wide_of(t->sine[k]), bias, early));
            tension = wide_fma(wide_of(t->tau[k]), across, t->nu[k] * bias);
            from_r = GET(WORK_RADIAL, up), from_t = GET(WORK_TANGENTIAL, up);
        }
        wide shift = (tension - GET(WORK_PUSH, k)) * t->inv_eff[k];
        wide radial = wide_fma(wide_of(t->kappa[k]), from_r, shift);
        wide rest = (GET(WORK_SIDE, k) - GET(WORK_SUM, k)) * t->inv[k];
        wide tangential = rest - t->lean[k] * radial;
        PUT(WORK_RADIAL, k, radial);
        PUT(WORK_TANGENTIAL, k, tangential);
        wide gap = t->sine[k] * from_r - t->cosine[k] * from_t + tangential;
        answer[k].x = gap * (t->inv_len[k] * inverse);
        answer[k].along = wide_fma(wide_of(t->eff[k] * t->kappa[k]), from_r, tension);
    }
}

/* leaves to root for bodies, with the factors of ideal_bodies_factor */
VEC_INLINE void ideal_bodies_up(const struct ideal_known *s, const struct ideal_group *g, int p,
                                const struct ideal_sums sum[], double factor) {
    const struct jets_system *t = &s->system;
    for (int k = 0; k < s->n; k++) {
        PUT(WORK_PUSH, k, wide_of(0));
        PUT(WORK_SIDE, k, wide_of(0));
    }
    for (int k = s->n - 1; k >= 0; k--) {
        int up = t->parent[k];
        wide known = sum[k].im * (-t->len[k] * factor), side = sum[k].across - GET(WORK_SIDE, k);
        wide along = wide_fma(side, wide_of(s->slip_along[k]), GET(WORK_PUSH, k));
        along = wide_fma(known, wide_of(s->bear[k]), along);
        wide gain = side * s->yield[k] - known * s->slip_along[k];
        PUT(WORK_BIAS, k, along);
        PUT(WORK_LATE, k, gain);
        if (up < 0) continue;
        wide across = sum[k].across - s->twist[k] * gain;
        PUT(WORK_PUSH, up, GET(WORK_PUSH, up) + (t->cosine[k] * along - t->sine[k] * across));
        PUT(WORK_SIDE, up, GET(WORK_SIDE, up) + (t->sine[k] * along + t->cosine[k] * across));
    }
}

/* root to leaves for bodies: accelerations of the angles, and forces along the arms */
VEC_INLINE void ideal_bodies_down(const struct ideal_known *s, const struct ideal_group *g, int p,
                                  const struct ideal_sums sum[], double factor, double inverse,
                                  struct ideal_answer answer[]) {
    const struct jets_system *t = &s->system;
    for (int k = 0; k < s->n; k++) {
        int up = t->parent[k];
        wide radial = wide_of(0), tangential = radial;
        if (up >= 0) {
            wide r = GET(WORK_RADIAL, up), v = GET(WORK_TANGENTIAL, up);
            radial = t->cosine[k] * r + t->sine[k] * v;
            tangential = t->cosine[k] * v - t->sine[k] * r;
        }
        wide late = s->slip_along[k] * radial + s->slip_across[k] * tangential;
        wide gain = GET(WORK_LATE, k) - late;
        wide along = wide_fma(wide_of(s->bear[k]), radial, GET(WORK_BIAS, k));
        double bent = s->twist[k] * s->slip_along[k];
        answer[k].along = wide_fma(wide_of(bent), tangential, along);
        answer[k].x = gain * (t->inv_len[k] * inverse);
        PUT(WORK_RADIAL, k, radial - sum[k].im * (t->len[k] * factor));
        PUT(WORK_TANGENTIAL, k, tangential + gain);
    }
}

/* solves the system by the sweeps for the known terms of an order */
VEC_INLINE void ideal_swept(const struct ideal_known *s, const struct ideal_group *g, int p,
                            const struct ideal_sums sum[], double factor, double inverse,
                            struct ideal_answer answer[]) {
    if (s->bodies) {
        ideal_bodies_up(s, g, p, sum, factor);
        ideal_bodies_down(s, g, p, sum, factor, inverse, answer);
    } else {
        ideal_up(s, g, p, sum, factor);
        ideal_down(s, g, p, inverse, answer);
    }
}

/* Computes the accelerations and forces of up to IDEAL_DENSE arms in response to a unit pull on
 * each arm, and to a unit force across it. Each lane is one unit load; `from` is the first of
 * eight. */
static void ideal_table_part(const struct ideal_known *s, const struct ideal_group *group,
                             int from) {
    for (int p = 0; p < VEC8; p += WIDE) {
        struct ideal_sums unit[IDEAL_DENSE];
        struct ideal_answer answer[IDEAL_DENSE];
        for (int k = 0; k < s->n; k++) {
            double pull[IDEAL_PITCH] = {0}, side[IDEAL_PITCH] = {0};
            pull[k] = side[s->n + k] = 1;
            unit[k] = (struct ideal_sums){wide_of(0), wide_load(pull + from + p),
                                          wide_load(side + from + p)};
        }
        ideal_swept(s, group, p, unit, 1, 1, answer);
        for (int k = 0; k < s->n; k++) {
            double *row = s->table + 2 * k * IDEAL_PITCH + from + p;
            wide_put(row, answer[k].x);
            wide_put(row + IDEAL_PITCH, answer[k].along);
        }
    }
}

static void ideal_table(const struct ideal_known *s) {
    double work[IDEAL_WORK * IDEAL_DENSE * IDEAL_LANES] __attribute__((aligned(64)));
    struct ideal_group group = {.work = work};
    for (int from = 0; from < 2 * s->n; from += VEC8) ideal_table_part(s, &group, from);
}

/* the angles between arms at the start */
static void ideal_angles(const struct ideal_known *s) {
    for (int k = 0; k < s->n; k += WIDE) {
        wide x = wide_of(0), low = x, cosine, sine;
        size_t bytes = (size_t)(s->n - k < WIDE ? s->n - k : WIDE) * sizeof(double);
        memcpy(&x, s->system.angle + k, bytes);
        memcpy(&low, s->system.angle_low + k, bytes);
        WIDE_(sincos)(x, low, &sine, &cosine);
        memcpy(s->system.cosine + k, &cosine, bytes);
        memcpy(s->system.sine + k, &sine, bytes);
    }
}

static void ideal_know(const struct ideal_known *s) {
    ideal_angles(s);
    if (s->n == 1 && !s->loaded) {
        ideal_alone(s);
        return;
    }
    if (s->kept_re) ideal_kept_turns(s);
    for (int k = 0; k < s->n && !s->kept_re; k += IDEAL_LANES) ideal_turns(s, ideal_place(s, k, 0));
    if (s->bodies)
        ideal_bodies_factor(s);
    else
        jets_factor(&s->system);
    if (s->masses || s->loaded) ideal_accelerations(s);
    if (s->loaded) ideal_forces(s);
    if (s->n <= IDEAL_DENSE) ideal_table(s);
}
