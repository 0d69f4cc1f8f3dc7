/* The orders of real pendulums of point masses, for any vector of doubles, one pendulum per lane:
 * torques between arms, and a pivot that moves. The recurrences are those of small_loads_template.
 * Leaves to others: other real pendulums (bodies_template), memory and angles (ensemble).
 * Invariant: the numbers of springs, friction and drives have the places of the general kernel,
 * whose function computes the power. */
#pragma once

#include "core/bodies/bodies_template.h"
#include "core/taylor/lanes/dense_template.h"
#include "core/taylor/jets_loads.h"

/* A pendulum's systems, the instant and the orders to compute; whether forces beyond order 0 are
 * requested; and the series of forces in fixed axes, real and imaginary parts. */
struct lanes_loads {
    const struct jets_system *s;
    const struct bodies_system *b;
    struct bodies_moment now;
    int order, moves, forces;
    num *along, *across;
};

/* the series of all drives and of gravity */
static void lanes_drives(const struct lanes_loads *x) {
    const struct bodies_system *b = x->b;
    for (int j = 0; j <= x->order && b->terms->harmonics; j++) b->share[j] = num_of(x->s->share[j]);
    b->lift_x[0] = num_of(0), b->lift_y[0] = x->now.gravity;
    if (x->moves) bodies_drive_pivot(b, &x->now, x->order);
    bodies_drive(b, &x->now, x->order);
}

/* writes the sum of the torques of order k on every arm to `couple`; returns 0 if there are none */
VEC_INLINE int lanes_couple(const struct lanes_loads *x, int k) {
    const struct bodies_system *b = x->b;
    const int *row = b->terms->row;
    int springs = row[PEND_TERM_STIFFNESS], losses = row[PEND_TERM_DAMPING],
        drives = b->need & BODIES_DRIVES;
    if (springs < 0 && losses < 0 && !drives) return 0;
    for (int a = 0; a < b->n; a++) {
        num torque = num_of(0);
        int p = b->parent[a];
        size_t at = bodies_row(b, a) + (size_t)k * b->stride;
        b->swing[at] = bodies_swing(b, a, k);
        if (drives) torque = b->drive[at];
        if (losses >= 0) {
            num loss = num_neg(b->value[losses + a] * x->now.unit * b->swing[at]);
            b->loss[at] = loss;
            torque += loss;
        }
        if (springs >= 0) {
            num bent = k ? b->swing[at - b->stride] * x->s->share[k - 1]
                         : b->bend[a] - b->value[row[PEND_TERM_REST] + a];
            torque -= b->value[springs + a] * (x->now.unit * x->now.unit) * bent;
        }
        b->couple[a] = torque;
        if (p >= 0) b->couple[p] -= torque;
    }
    return 1;
}

/* the acceleration of the pivot, order k, along and across the first arm */
VEC_INLINE void lanes_lift(const struct lanes_loads *x, int k, num *along, num *across) {
    num C = x->s->cosine[0], Z = x->s->sine[0], dx = x->b->lift_x[k], dy = x->b->lift_y[k];
    *along = num_fma(C, dx, Z * dy);
    *across = num_sub(C * dy, Z * dx);
}

/* ---- a pendulum with one arm */

/*
 * With u = e^{i (phi - phi_0)} and a the acceleration of the pivot in the axes of the start
 *     phi'' = tau / (m l^2) - Im (conj(u) a) / l    lambda = m [Re (conj(u) a) - l phi'^2]
 * where Im (conj(u) a) is a product without sums if the pivot is at rest.
 */
struct lanes_arm {
    num re[SINGLE_ROWS], im[SINGLE_ROWS], rate[SINGLE_ROWS], along[SINGLE_ROWS],
        across[SINGLE_ROWS], back[SINGLE_ROWS]; /* `back` is minus the component along the arm */
};

/* Re (conj(u) (x + i y)) of order k. The newest coefficients come last, and the two sums do not
 * depend on each other, as in single_convolve. */
VEC_INLINE num lanes_weigh(const num re[], const num im[], const num x[], const num y[], int k,
                           int moves) {
    num zero = num_of(0), a[2] = {zero, zero}, b[2] = {zero, zero};
    int j = 0;
    for (; j + 1 < k && moves; j += 2) {
        for (int i = 0; i < 2; i++) {
            a[i] = num_fma(re[j + i], x[k - j - i], a[i]);
            b[i] = num_fma(im[j + i], y[k - j - i], b[i]);
        }
    }
    if (j < k && moves) {
        a[1] = num_fma(re[j], x[k - j], a[1]);
        b[1] = num_fma(im[j], y[k - j], b[1]);
    }
    a[0] = num_fma(re[k], x[0], a[0]);
    b[0] = num_fma(im[k], y[0], b[0]);
    return (a[0] + a[1]) + (b[0] + b[1]);
}

static inline void lanes_single(const struct lanes_loads *x) {
    const struct jets_system *s = x->s;
    struct lanes_arm u;
    num inv = s->inv_len[0], mass = s->mass[0], light = inv * inv / mass;
    u.re[0] = num_of(1), u.im[0] = num_of(0), u.rate[0] = s->rate[0];
    for (int k = 0; k < (x->moves ? x->order : 1); k++) {
        lanes_lift(x, k, &u.along[k], &u.across[k]);
        u.back[k] = num_neg(u.along[k]);
    }
    for (int k = 0; k < x->order; k++) {
        // Im (conj(u) a) = Re (conj(u) (-i a))
        num across = lanes_weigh(u.re, u.im, u.across, u.back, k, x->moves);
        num acc = num_neg(across * inv), share = num_of(s->share[k]);
        if (lanes_couple(x, k)) acc = num_fma(x->b->couple[0], light, acc);
        if (x->forces || !k) {
            num square = num_of(0);
            num along = lanes_weigh(u.re, u.im, u.along, u.across, k, x->moves);
            for (int j = 0; j <= k; j++) square = num_fma(u.rate[j], u.rate[k - j], square);
            s->force[(size_t)k * s->stride] = mass * (along - s->len[0] * square);
        }
        struct single_pair sum = single_convolve(u.re, u.im, u.rate, k);
        u.re[k + 1] = num_neg(share * sum.im);
        u.im[k + 1] = share * sum.re;
        s->rate[(size_t)(k + 1) * s->stride] = u.rate[k + 1] = share * acc;
    }
    if (!x->moves) return;
    // the force of the pivot moves the mass: F = m (a + l u'')
    struct single_pair sum = single_convolve(u.re, u.im, u.rate, x->order);
    u.re[x->order + 1] = num_neg(sum.im * s->share[x->order]);
    u.im[x->order + 1] = sum.re * s->share[x->order];
    for (int k = 0; k < x->order; k++) {
        num way = s->len[0] * num_of((k + 1) * (k + 2)), C = s->cosine[0], Z = s->sine[0];
        num fx = mass * num_fma(way, u.re[k + 2], u.along[k]);
        num fy = mass * num_fma(way, u.im[k + 2], u.across[k]);
        x->b->pivot_force_x[k] = C * fx - Z * fy;
        x->b->pivot_force_y[k] = num_fma(Z, fx, C * fy);
    }
}

/* ---- several arms */

/* T of an order, and the known sums of Im (conj(u) F) with Re u and those with Im u */
struct lanes_sums {
    num Tr, Ti, known, less;
};

VEC_INLINE void lanes_add(struct lanes_sums *sum, num ur, num ui, num w, num x, num y) {
    sum->Tr = num_fma(ur, w, sum->Tr);
    sum->Ti = num_fma(ui, w, sum->Ti);
    sum->known = num_fma(ur, y, sum->known);
    sum->less = num_fma(ui, x, sum->less);
}

/* the sums of arm i of order k, which is even, and of order k + 1 without the terms that need order
 * k, so that loaded values serve both */
VEC_INLINE void lanes_convolve(const struct lanes_loads *x, int n, int k, int i,
                               struct lanes_sums *now, struct lanes_sums *next) {
    const struct bodies_system *b = x->b;
    const num *re = b->turn_re + i, *im = b->turn_im + i, *rate = b->rate + i;
    const num *along = x->along + i, *across = x->across + i;
    num zero = num_of(0), first = rate[0];
    *now = *next = (struct lanes_sums){zero, zero, zero, zero};
    if (k) {
        int at = (k - 1) * n;
        num w = rate[at], f = along[at - n], g = across[at - n];
        for (int j = 3; j <= k; j++) {
            at -= n;
            num ur = re[j * n], ui = im[j * n];
            NUM_PIN(ur);
            NUM_PIN(ui);
            lanes_add(next, ur, ui, w, f, g);
            w = rate[at], f = along[at - n], g = across[at - n];
            NUM_PIN(w);
            NUM_PIN(f);
            NUM_PIN(g);
            lanes_add(now, ur, ui, w, f, g);
        }
        at = k * n;
        lanes_add(now, re[2 * n], im[2 * n], rate[at - n], along[at - 2 * n], across[at - 2 * n]);
        lanes_add(next, re[2 * n], im[2 * n], rate[at], along[at - n], across[at - n]);
        num ur = re[at + n], ui = im[at + n];
        now->Tr = num_fma(ur, first, now->Tr);
        now->Ti = num_fma(ui, first, now->Ti);
        lanes_add(next, ur, ui, rate[n], along[0], across[0]);
        now->less = num_fma(first, along[at - n], now->less);
    }
    // u_1 is imaginary
    now->Ti = num_fma(first, rate[k * n], now->Ti);
}

/* the missing terms of the sums of order k, the second of two orders */
VEC_INLINE void lanes_complete(const struct lanes_loads *x, int n, int k, int i,
                               struct lanes_sums *sum) {
    const struct bodies_system *b = x->b;
    num first = b->rate[i];
    int now = k * n + i, next = now + n;
    sum->Tr = num_fma(b->turn_re[next], first, sum->Tr);
    sum->Ti = num_fma(b->turn_im[next], first, sum->Ti);
    sum->Ti = num_fma(first, b->rate[now], sum->Ti);
    sum->less = num_fma(first, x->along[now - n], sum->less);
}

/* order k of point masses from its sums; stores the forces across the arms */
VEC_INLINE void lanes_order(const struct lanes_loads *x, const struct dense_table *table, int n,
                            int k, const struct lanes_sums sum[]) {
    const struct jets_system *s = x->s;
    struct dense_order asked, newest;
    num share = num_of(s->share[k]) * s->inv_len[0], along, across, zero = num_of(0);
    int couples = lanes_couple(x, k);
    for (int i = 0; i < n; i++) {
        num side = sum[i].less - sum[i].known;
        if (couples) side = num_fma(x->b->couple[i], s->inv_len[i], side);
        asked.re[i] = sum[i].Tr, asked.im[i] = sum[i].Ti;
        asked.rate[i] = zero, asked.force[i] = side;
        x->across[k * n + i] = side;
    }
    if (x->moves || !k) {
        lanes_lift(x, k, &along, &across);
        asked.im[0] -= along * share;
    }
    dense_solve(s, table, n, k, &asked, &newest);
    if (x->moves || !k) {
        newest.rate[0] -= across * share;
        newest.im[0] -= across * share * s->share[k + 1];
    }
    for (int i = 0; i < n; i++) newest.re[i] = num_neg(sum[i].Ti * s->share[k + 1]);
    dense_keep(s, n, k, &newest);
}

/* all orders of up to DENSE_MAX arms by the inverse */
VEC_INLINE void lanes_dense(const struct lanes_loads *x, int n) {
    struct dense_table table;
    dense_invert(x->s, n, &table);
    for (int k = 0; k < x->order; k += 2) {
        struct lanes_sums now[DENSE_MAX], next[DENSE_MAX];
        for (int i = 0; i < n; i++) lanes_convolve(x, n, k, i, &now[i], &next[i]);
        lanes_order(x, &table, n, k, now);
        if (k + 1 == x->order) break;
        for (int i = 0; i < n; i++) lanes_complete(x, n, k + 1, i, &next[i]);
        lanes_order(x, &table, n, k + 1, next);
    }
}

/* lambda = Re (conj(u) F) of orders below `order`, from the highest down, in place */
static void lanes_along(const struct lanes_loads *x) {
    const struct jets_system *s = x->s;
    for (int i = 0; i < s->n; i++)
        for (int k = x->order - 1; k > 0; k--) {
            num *force = s->force + i + (size_t)k * s->stride, sum = *force;
            const num *across = x->b->tip_y + i + (size_t)k * s->stride;
            sum = num_fma(s->rate[i], *(across - s->stride), sum);
            for (int j = 2; j <= k; j++) {
                size_t at = (size_t)j * s->stride;
                sum = num_fma(s->turn_re[at + (size_t)i], *(force - at), sum);
                sum = num_fma(s->turn_im[at + (size_t)i], *(across - at), sum);
            }
            *force = sum;
        }
}

static inline void lanes_several(const struct lanes_loads *x) {
    const struct jets_system *s = x->s;
    for (int i = 0; i < s->n; i++) {
        s->turn_re[s->n + i] = num_of(0);
        s->turn_im[s->n + i] = s->rate[i];
    }
    jets_factor(s);
    if (s->n == 2)
        lanes_dense(x, 2);
    else if (s->n == 3)
        lanes_dense(x, 3);
    else
        lanes_dense(x, 4);
    for (int k = 0; k < x->order && x->moves; k++) {
        size_t at = (size_t)k * s->stride;
        num fx = s->force[at], fy = x->b->tip_y[at], C = s->cosine[0], Z = s->sine[0];
        x->b->pivot_force_x[k] = C * fx - Z * fy;
        x->b->pivot_force_y[k] = num_fma(Z, fx, C * fy);
    }
    if (x->forces) lanes_along(x);
}

/** All orders of up to DENSE_MAX arms: rate_1 .. rate_order, force_0 and, on request, force_1 ..
 * force_{order - 1}, from rate_0, cosine, sine and bend; and the series that bodies_power needs.
 * O(n order^2). */
static inline void lanes_orders(const struct jets_system *s, const struct bodies_system *b,
                                const struct bodies_moment *now, int order, int forces) {
    const struct pend_terms *terms = b->terms;
    int moves = (terms->harmonics && terms->harmonic[0].drives < 0) ||
                terms->one[PEND_TERM_PIVOT_ACCELERATION_X] >= 0;
    struct lanes_loads x = {s, b, *now, order, moves, forces, s->force, b->tip_y};
    for (int k = 0; k < s->n; k++) s->sine[k] = b->sine[k], s->cosine[k] = b->cosine[k];
    lanes_drives(&x);
    if (s->n == 1)
        lanes_single(&x);
    else
        lanes_several(&x);
}
