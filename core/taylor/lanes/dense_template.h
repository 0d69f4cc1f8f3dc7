/* The orders of small trees by the inverse of the tree system of order 0, for any kind of number.
 * Leaves to others: memory, the sweeps (jets_template), the kinds of number (number).
 * Invariant: the stable sweeps compute the inverse, one unit right-hand side after the other. */
#pragma once

#include <string.h>

#include "core/taylor/jets_template.h"
#include "core/taylor/single_template.h"

/* the most arms of a tree; the arms in one loop, as many as the registers hold */
#ifdef __AVX512F__
enum { DENSE_MAX = 4, DENSE_LOOP = 2 };
#else
enum { DENSE_MAX = 4, DENSE_LOOP = 1 };
#endif

/* the responses phi'' and force of arm i to a unit of T_j (pull) and of c_j (side), at [j][i] */
struct dense_table {
    num rate_pull[DENSE_MAX][DENSE_MAX], rate_side[DENSE_MAX][DENSE_MAX];
    num force_pull[DENSE_MAX][DENSE_MAX], force_side[DENSE_MAX][DENSE_MAX];
};

/* the sweeps of one right-hand side */
struct dense_sweep {
    num push[DENSE_MAX], side[DENSE_MAX], bias[DENSE_MAX], late[DENSE_MAX], sum_side[DENSE_MAX];
};

VEC_INLINE int dense_parent(const struct jets_system *s, int n, int k) {
    return n == 2 ? 0 : s->parent[k];
}

/* leaves to root, as jets_up, for one unit: an inward pull W on arm j, or a force across it */
VEC_INLINE void dense_up(const struct jets_system *s, int n, int j, int across,
                         struct dense_sweep *x) {
    num zero = num_of(0), heave = across ? zero : num_mul(s->eff[j], s->len[j]);
    for (int k = 0; k < n; k++) x->side[k] = x->push[k] = x->sum_side[k] = zero;
    if (across) x->side[j] = num_of(1);
    if (across && j) {
        int p = dense_parent(s, n, j);
        x->side[p] = num_neg(s->cosine[j]);
        x->push[p] = num_neg(s->sine[j]);
    }
    for (int k = 0; k < n && across; k++) x->push[k] = num_fma(s->lean[k], x->side[k], x->push[k]);
    for (int k = n - 1; k > 0; k--) {
        int p = dense_parent(s, n, k);
        num bias = k == j ? num_sub(x->push[k], heave) : x->push[k];
        x->bias[k] = bias;
        x->late[k] = x->sum_side[p];
        x->push[p] = num_fma(s->kappa[k], bias, x->push[p]);
        x->sum_side[p] = num_fma(s->sine[k], bias, x->sum_side[p]);
    }
    x->bias[0] = j ? x->push[0] : num_sub(x->push[0], heave);
}

/* root to leaves, as jets_down: the response of all arms */
VEC_INLINE void dense_down(const struct jets_system *s, int n, const struct dense_sweep *x,
                           num rate[], num force[]) {
    num early[DENSE_MAX], radial[DENSE_MAX], tangential[DENSE_MAX], zero = num_of(0);
    for (int k = 0; k < n; k++) early[k] = zero;
    for (int k = 0; k < n; k++) {
        int p = k ? dense_parent(s, n, k) : -1;
        num ar = zero, at = zero, tension = x->bias[0];
        if (k) {
            num across = num_sub(x->side[p], num_add(early[p], x->late[k]));
            early[p] = num_fma(s->sine[k], x->bias[k], early[p]);
            tension = num_fma(s->tau[k], across, num_mul(s->nu[k], x->bias[k]));
            ar = radial[p], at = tangential[p];
        }
        num shift = num_mul(num_sub(tension, x->push[k]), s->inv_eff[k]);
        radial[k] = k ? num_fma(s->kappa[k], ar, shift) : shift;
        tangential[k] = num_sub(num_mul(num_sub(x->side[k], x->sum_side[k]), s->inv[k]),
                                num_mul(s->lean[k], radial[k]));
        num gap =
            k ? num_add(num_sub(num_mul(s->sine[k], ar), num_mul(s->cosine[k], at)), tangential[k])
              : tangential[0];
        rate[k] = num_mul(gap, s->inv_len[k]);
        force[k] = k ? num_fma(num_mul(s->eff[k], s->kappa[k]), ar, tension) : tension;
    }
}

VEC_INLINE void dense_invert(const struct jets_system *s, int n, struct dense_table *table) {
    struct dense_sweep x;
    for (int j = 0; j < n; j++) {
        dense_up(s, n, j, 0, &x);
        dense_down(s, n, &x, table->rate_pull[j], table->force_pull[j]);
        dense_up(s, n, j, 1, &x);
        dense_down(s, n, &x, table->rate_side[j], table->force_side[j]);
    }
}

/* the newest coefficients of all arms, one order, kept in registers */
struct dense_order {
    num re[DENSE_MAX], im[DENSE_MAX], rate[DENSE_MAX], force[DENSE_MAX];
};

/* the sums of order k and of order k + 1 for the arms of one loop */
struct dense_sums {
    num now[4][DENSE_LOOP], next[4][DENSE_LOOP];
};

/* adds the product of u_j with a rate and a force to four sums of one arm */
VEC_INLINE void dense_add(num sum[4][DENSE_LOOP], int a, num re, num im, num rate, num force) {
    sum[0][a] = num_fma(re, rate, sum[0][a]);
    sum[1][a] = num_fma(im, rate, sum[1][a]);
    sum[2][a] = num_fma(re, force, sum[2][a]);
    sum[3][a] = num_fma(im, force, sum[3][a]);
}

/* T and c of order k, and of order k + 1 without the terms that need order k, in one pass, so that
 * loaded values serve both. Row -1 of the forces is zero. Used for the first orders, in which old
 * and new coefficients coincide. */
VEC_INLINE void dense_first(const struct jets_system *s, int n, int k, struct dense_order *now,
                            struct dense_order *next) {
    for (int i = 0; i < n; i++) {
        num zero = num_of(0), x[8] = {zero, zero, zero, zero, zero, zero, zero, zero};
        const num *rate = s->rate + i, *force = s->force + i, *re = s->turn_re + i,
                  *im = s->turn_im + i;
        for (int j = 1; j <= k + 1; j++) {
            num ur = re[j * n], ui = im[j * n];
            x[0] = num_fma(ur, rate[(k + 1 - j) * n], x[0]);
            x[1] = num_fma(ui, rate[(k + 1 - j) * n], x[1]);
            x[2] = num_fma(ur, force[(k - j) * n], x[2]);
            x[3] = num_fma(ui, force[(k - j) * n], x[3]);
            if (j == 1) continue;
            x[4] = num_fma(ur, rate[(k + 2 - j) * n], x[4]);
            x[5] = num_fma(ui, rate[(k + 2 - j) * n], x[5]);
            x[6] = num_fma(ur, force[(k + 1 - j) * n], x[6]);
            x[7] = num_fma(ui, force[(k + 1 - j) * n], x[7]);
        }
        now->re[i] = x[0], now->im[i] = x[1], now->rate[i] = x[2], now->force[i] = x[3];
        next->re[i] = x[4], next->im[i] = x[5], next->rate[i] = x[6], next->force[i] = x[7];
    }
}

/* dense_first from order 4 on, for `count` arms from i on. Products of coefficients known two
 * orders ago come first, so that the processor can start them while it still solves for the newest;
 * products with the newest follow. */
VEC_INLINE void dense_known(const struct jets_system *s, int n, int k, int i, int count,
                            struct dense_order *now, struct dense_order *next) {
    struct dense_sums x;
    const num *re = s->turn_re + 3 * n + i, *im = s->turn_im + 3 * n + i;
    const num *rate = s->rate + (k - 2) * n + i, *force = s->force + (k - 3) * n + i;
    num w[DENSE_LOOP], f[DENSE_LOOP], zero = num_of(0);
    for (int a = 0; a < count; a++) {
        w[a] = rate[a], f[a] = force[a];
        for (int b = 0; b < 4; b++) x.now[b][a] = x.next[b][a] = zero;
        dense_add(x.now, a, re[a], im[a], w[a], f[a]);
    }
#pragma GCC unroll 2
    for (int j = 4; j < k; j++) {
        re += n, im += n, rate -= n, force -= n;
        for (int a = 0; a < count; a++) {
            num ur = re[a], ui = im[a];
            NUM_PIN(ur);
            NUM_PIN(ui);
            dense_add(x.next, a, ur, ui, w[a], f[a]);
            w[a] = rate[a], f[a] = force[a];
            NUM_PIN(w[a]);
            NUM_PIN(f[a]);
            dense_add(x.now, a, ur, ui, w[a], f[a]);
        }
    }
    for (int a = 0; a < count; a++) {
        const num *first = s->rate + i + a, *base = s->force + i + a;
        const num *ur = s->turn_re + i + a, *ui = s->turn_im + i + a;
        dense_add(x.now, a, ur[k * n], ui[k * n], first[n], base[0]);
        dense_add(x.next, a, ur[k * n], ui[k * n], first[2 * n], base[n]);
        x.now[0][a] = num_fma(ur[(k + 1) * n], first[0], x.now[0][a]);
        x.now[1][a] = num_fma(ui[(k + 1) * n], first[0], x.now[1][a]);
        dense_add(x.next, a, ur[(k + 1) * n], ui[(k + 1) * n], first[n], base[0]);
        dense_add(x.next, a, ur[3 * n], ui[3 * n], first[(k - 1) * n], base[(k - 2) * n]);
        dense_add(x.now, a, ur[2 * n], ui[2 * n], first[(k - 1) * n], base[(k - 2) * n]);
        dense_add(x.next, a, ur[2 * n], ui[2 * n], first[k * n], base[(k - 1) * n]);
        // u_1 is imaginary
        x.now[1][a] = num_fma(ui[n], first[k * n], x.now[1][a]);
        x.now[3][a] = num_fma(ui[n], base[(k - 1) * n], x.now[3][a]);
        now->re[i + a] = x.now[0][a], now->im[i + a] = x.now[1][a];
        now->rate[i + a] = x.now[2][a], now->force[i + a] = x.now[3][a];
        next->re[i + a] = x.next[0][a], next->im[i + a] = x.next[1][a];
        next->rate[i + a] = x.next[2][a], next->force[i + a] = x.next[3][a];
    }
}

/* dense_known for all arms. The number of arms in a loop is a constant of each call; otherwise
 * their sums would be in memory, and three arms take longer than four. */
VEC_INLINE void dense_all_known(const struct jets_system *s, int n, int k, struct dense_order *now,
                                struct dense_order *next) {
    const int left = n % DENSE_LOOP;
    for (int i = 0; i + DENSE_LOOP <= n; i += DENSE_LOOP)
        dense_known(s, n, k, i, DENSE_LOOP, now, next);
    if (left) dense_known(s, n, k, n - left, left, now, next);
}

/* the terms of order k + 1 that need the coefficients of order k */
VEC_INLINE void dense_complete(int n, const struct dense_order *first,
                               const struct dense_order *newest, struct dense_order *known) {
    for (int i = 0; i < n; i++) {
        known->im[i] = num_fma(first->im[i], newest->rate[i], known->im[i]);
        known->force[i] = num_fma(first->im[i], newest->force[i], known->force[i]);
        known->re[i] = num_fma(newest->re[i], first->rate[i], known->re[i]);
        known->im[i] = num_fma(newest->im[i], first->rate[i], known->im[i]);
    }
}

/* the coefficients of order k from the known parts */
VEC_INLINE void dense_solve(const struct jets_system *s, const struct dense_table *table, int n,
                            int k, const struct dense_order *known, struct dense_order *newest) {
    num share = num_of(s->share[k]), turn_share = num_of(s->share[k + 1]), order = num_of(k + 1);
    num turn_back = num_neg(turn_share), side[DENSE_MAX];
    for (int j = 0; j < n; j++) side[j] = num_mul(known->force[j], share);
    for (int i = 0; i < n; i++) {
        num rate = num_mul(side[0], table->rate_side[0][i]),
            force = num_mul(side[0], table->force_side[0][i]);
        for (int j = 1; j < n; j++) {
            rate = num_fma(side[j], table->rate_side[j][i], rate);
            force = num_fma(side[j], table->force_side[j][i], force);
        }
        for (int j = 0; j < n; j++) {
            rate = num_fma(known->im[j], table->rate_pull[j][i], rate);
            force = num_fma(known->im[j], table->force_pull[j][i], force);
        }
        newest->rate[i] = num_sub(rate, known->re[i]);
        newest->force[i] = num_fma(order, force, num_neg(known->rate[i]));
        newest->re[i] = num_mul(turn_back, known->im[i]);
        newest->im[i] = num_mul(turn_share, rate);
    }
}

/* order 0, with gravity acting on the root */
VEC_INLINE void dense_zeroth(const struct jets_system *s, const struct dense_table *table, int n,
                             num gravity, const struct dense_order *known,
                             struct dense_order *newest) {
    num per_len = num_mul(gravity, s->inv_len[0]), half = num_of(s->share[1]), pull[DENSE_MAX];
    for (int j = 0; j < n; j++) pull[j] = known->im[j];
    pull[0] = num_sub(pull[0], num_mul(s->sine[0], per_len));
    for (int i = 0; i < n; i++) {
        num rate = i ? num_of(0) : num_neg(num_mul(s->cosine[0], per_len)), force = num_of(0);
        for (int j = 0; j < n; j++) {
            rate = num_fma(pull[j], table->rate_pull[j][i], rate);
            force = num_fma(pull[j], table->force_pull[j][i], force);
        }
        newest->rate[i] = num_sub(rate, known->re[i]);
        newest->force[i] = num_sub(force, known->rate[i]);
        newest->re[i] = num_neg(num_mul(half, known->im[i]));
        newest->im[i] = num_mul(half, rate);
    }
}

VEC_INLINE void dense_keep(const struct jets_system *s, int n, int k, const struct dense_order *x) {
    for (int i = 0; i < n; i++) {
        s->rate[(k + 1) * n + i] = x->rate[i];
        s->force[k * n + i] = x->force[i];
        s->turn_re[(k + 2) * n + i] = x->re[i];
        s->turn_im[(k + 2) * n + i] = x->im[i];
    }
}

VEC_INLINE void dense_orders_of(const struct jets_system *s, num gravity, int order, int n) {
    struct dense_table table;
    struct dense_order first, newest;
    dense_invert(s, n, &table);
    if (s->answers) memcpy(s->answers, &table, sizeof table);
    for (int i = 0; i < n; i++) {
        first.re[i] = first.force[i] = num_of(0);
        first.im[i] = first.rate[i] = s->rate[i];
        s->turn_re[n + i] = num_of(0);
        s->turn_im[n + i] = s->rate[i];
    }
    for (int k = 0; k < order; k += 2) {
        struct dense_order now, next;
        if (k < 4)
            dense_first(s, n, k, &now, &next);
        else
            dense_all_known(s, n, k, &now, &next);
        if (k)
            dense_solve(s, &table, n, k, &now, &newest);
        else
            dense_zeroth(s, &table, n, gravity, &now, &newest);
        dense_keep(s, n, k, &newest);
        if (k + 1 == order) break;
        dense_complete(n, &first, &newest, &next);
        dense_solve(s, &table, n, k + 1, &next, &newest);
        dense_keep(s, n, k + 1, &newest);
    }
}

/* all orders of a tree of up to DENSE_MAX arms whose stride is n */
static void dense_orders(const struct jets_system *s, num gravity, int order) {
    if (s->n == 1)
        single_orders(s, gravity, order);
    else if (s->n == 2)
        dense_orders_of(s, gravity, order, 2);
    else if (s->n == 3)
        dense_orders_of(s, gravity, order, 3);
    else
        dense_orders_of(s, gravity, order, 4);
}
