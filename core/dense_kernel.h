/* The orders of small trees by the inverse of the tree system of order 0, for any kind of number.
 * Leaves to others: memory, what a number is (the including file, which includes jets_kernel.h first).
 * Invariant: the inverse is built by the stable sweeps, one unit right-hand side after the other. */
#ifndef PEND_DENSE_KERNEL_H
#define PEND_DENSE_KERNEL_H

#include "core/jets_kernel.h"

enum { DENSE_MAX = 4 };

/* what a unit of T_j (pull) and of c_j (side) does to phi'' and to the force of arm i: [j][i] */
struct dense_table {
    num rate_pull[DENSE_MAX][DENSE_MAX], rate_side[DENSE_MAX][DENSE_MAX];
    num force_pull[DENSE_MAX][DENSE_MAX], force_side[DENSE_MAX][DENSE_MAX];
};

/* the answer of all arms to the right-hand side in heave and drag_im */
LANES_INLINE void dense_answer(const struct jets_system *s, int n, num rate[], num force[]) {
    num zero = num_of(0);
    for (int k = 0; k < n; k++) {
        s->sum_push[k] = s->sum_side[k] = s->sum_cos[k] = s->sum_sin[k] = s->early[k] = zero;
    }
    jets_up(s);
    jets_down(s, zero);
    for (int i = 0; i < n; i++) {
        num ar = s->from_radial[i], at = s->from_tangential[i], stiff = num_mul(s->eff[i], s->kappa[i]);
        num gap = num_add(num_sub(num_mul(s->sine[i], ar), num_mul(s->cosine[i], at)), s->tangential[i]);
        rate[i] = num_mul(gap, s->inv_len[i]);
        force[i] = num_fma(stiff, ar, s->tension[i]);
    }
}

LANES_INLINE void dense_invert(const struct jets_system *s, int n, struct dense_table *table) {
    num zero = num_of(0);
    for (int k = 0; k < n; k++) s->heave[k] = s->drag_im[k] = zero;
    for (int j = 0; j < n; j++) {
        s->heave[j] = num_mul(s->eff[j], s->len[j]);
        dense_answer(s, n, table->rate_pull[j], table->force_pull[j]);
        s->heave[j] = zero;
        s->drag_im[j] = num_of(1);
        dense_answer(s, n, table->rate_side[j], table->force_side[j]);
        s->drag_im[j] = zero;
    }
}

/* the series of one order of all arms, newest in registers */
struct dense_order {
    num re[DENSE_MAX], im[DENSE_MAX], rate[DENSE_MAX], force[DENSE_MAX];
};

/*
 * T and c of order k, and of order k + 1 but for the terms that order k is needed for, in one pass: what is loaded serves
 * both. Row -1 of the forces is zero.
 */
LANES_INLINE void dense_known(const struct jets_system *s, int n, int k, const struct dense_order *first,
                              struct dense_order *now, struct dense_order *next) {
    for (int i = 0; i < n; i++) {
        num zero = num_of(0), x[8] = {zero, zero, zero, zero, zero, zero, zero, zero};
        const num *re = s->turn_re + 2 * n + i, *im = s->turn_im + 2 * n + i;
        const num *rate = s->rate + k * n + i, *force = s->force + (k - 1) * n + i;
        num w = *rate, f = *force;
        NUM_PIN(w);
        NUM_PIN(f);
        // u_1 is imaginary
        x[1] = num_mul(first->im[i], w);
        x[3] = num_mul(first->im[i], f);
#pragma GCC unroll 2
        for (int j = 2; j <= k + 1; j++, re += n, im += n) {
            num ur = *re, ui = *im;
            NUM_PIN(ur);
            NUM_PIN(ui);
            x[4] = num_fma(ur, w, x[4]);
            x[5] = num_fma(ui, w, x[5]);
            x[6] = num_fma(ur, f, x[6]);
            x[7] = num_fma(ui, f, x[7]);
            rate -= n, force -= n;
            w = *rate, f = *force;
            NUM_PIN(w);
            NUM_PIN(f);
            x[0] = num_fma(ur, w, x[0]);
            x[1] = num_fma(ui, w, x[1]);
            x[2] = num_fma(ur, f, x[2]);
            x[3] = num_fma(ui, f, x[3]);
        }
        now->re[i] = x[0], now->im[i] = x[1], now->rate[i] = x[2], now->force[i] = x[3];
        next->re[i] = x[4], next->im[i] = x[5], next->rate[i] = x[6], next->force[i] = x[7];
    }
}

/* the terms of order k + 1 that the coefficients of order k are needed for */
LANES_INLINE void dense_complete(int n, const struct dense_order *first, const struct dense_order *newest,
                                 struct dense_order *known) {
    for (int i = 0; i < n; i++) {
        known->im[i] = num_fma(first->im[i], newest->rate[i], known->im[i]);
        known->force[i] = num_fma(first->im[i], newest->force[i], known->force[i]);
        known->re[i] = num_fma(newest->re[i], first->rate[i], known->re[i]);
        known->im[i] = num_fma(newest->im[i], first->rate[i], known->im[i]);
    }
}

/* the coefficients of order k from the known parts; lift and drop are gravity's, of the root */
LANES_INLINE void dense_solve(const struct jets_system *s, const struct dense_table *table, int n, int k, num lift,
                              num drop, const struct dense_order *known, struct dense_order *newest) {
    num share = num_of(s->share[k]), turn_share = num_of(s->share[k + 1]), order = num_of(k + 1);
    num pull[DENSE_MAX], side[DENSE_MAX];
    for (int j = 0; j < n; j++) {
        pull[j] = j ? known->im[j] : num_sub(known->im[j], lift);
        side[j] = num_mul(known->force[j], share);
    }
    for (int i = 0; i < n; i++) {
        num rate = i ? num_of(0) : num_neg(drop), force = num_of(0);
        for (int j = 0; j < n; j++) {
            rate = num_fma(side[j], table->rate_side[j][i], rate);
            force = num_fma(side[j], table->force_side[j][i], force);
        }
        for (int j = 0; j < n; j++) {
            rate = num_fma(pull[j], table->rate_pull[j][i], rate);
            force = num_fma(pull[j], table->force_pull[j][i], force);
        }
        newest->rate[i] = num_sub(rate, known->re[i]);
        newest->force[i] = num_sub(num_mul(order, force), known->rate[i]);
        newest->re[i] = num_neg(num_mul(turn_share, known->im[i]));
        newest->im[i] = num_mul(turn_share, rate);
    }
}

LANES_INLINE void dense_keep(const struct jets_system *s, int n, int k, const struct dense_order *x) {
    for (int i = 0; i < n; i++) {
        s->rate[(k + 1) * n + i] = x->rate[i];
        s->force[k * n + i] = x->force[i];
        s->turn_re[(k + 2) * n + i] = x->re[i];
        s->turn_im[(k + 2) * n + i] = x->im[i];
    }
}

LANES_INLINE void dense_orders_of(const struct jets_system *s, num gravity, int order, int n) {
    struct dense_table table;
    struct dense_order first, newest;
    dense_invert(s, n, &table);
    for (int i = 0; i < n; i++) {
        first.re[i] = first.force[i] = num_of(0);
        first.im[i] = first.rate[i] = s->rate[i];
    }
    // gravity is a pull on the root
    num per_len = num_mul(gravity, s->inv_len[0]), zero = num_of(0);
    num lift = num_mul(s->sine[0], per_len), drop = num_mul(s->cosine[0], per_len);
    for (int k = 0; k < order; k += 2) {
        struct dense_order now, next;
        dense_known(s, n, k, &first, &now, &next);
        dense_solve(s, &table, n, k, k ? zero : lift, k ? zero : drop, &now, &newest);
        dense_keep(s, n, k, &newest);
        if (k + 1 == order) break;
        dense_complete(n, &first, &newest, &next);
        dense_solve(s, &table, n, k + 1, zero, zero, &next, &newest);
        dense_keep(s, n, k + 1, &newest);
    }
}

/* all orders of a tree of up to DENSE_MAX arms whose stride is n */
static void dense_orders(const struct jets_system *s, num gravity, int order) {
    if (s->n == 1) dense_orders_of(s, gravity, order, 1);
    else if (s->n == 2) dense_orders_of(s, gravity, order, 2);
    else if (s->n == 3) dense_orders_of(s, gravity, order, 3);
    else dense_orders_of(s, gravity, order, 4);
}

#endif
