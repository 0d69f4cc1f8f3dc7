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

/* T and c of order k; the newest coefficients, which are waited for, come last */
LANES_INLINE struct dense_order dense_known(const struct jets_system *s, int n, int k, const struct dense_order *first,
                                            const struct dense_order *newest) {
    struct dense_order x;
    for (int i = 0; i < n; i++) x.re[i] = x.im[i] = x.rate[i] = x.force[i] = num_of(0);
    for (int j = 2; j <= k; j++) {
        size_t turn = (size_t)j * (size_t)n, rate = (size_t)(k + 1 - j) * (size_t)n, force = rate - (size_t)n;
        for (int i = 0; i < n; i++) {
            num ur = s->turn_re[turn + (size_t)i], ui = s->turn_im[turn + (size_t)i];
            num w = s->rate[rate + (size_t)i], f = s->force[force + (size_t)i];
            NUM_PIN(ur);
            NUM_PIN(ui);
            NUM_PIN(w);
            NUM_PIN(f);
            x.re[i] = num_fma(ur, w, x.re[i]);
            x.im[i] = num_fma(ui, w, x.im[i]);
            x.rate[i] = num_fma(ur, f, x.rate[i]);
            x.force[i] = num_fma(ui, f, x.force[i]);
        }
    }
    for (int i = 0; i < n; i++) {
        if (k) {
            // u_1 is imaginary
            x.im[i] = num_fma(first->im[i], newest->rate[i], x.im[i]);
            x.force[i] = num_fma(first->im[i], newest->force[i], x.force[i]);
        }
        x.re[i] = num_fma(newest->re[i], first->rate[i], x.re[i]);
        x.im[i] = num_fma(newest->im[i], first->rate[i], x.im[i]);
    }
    return x;
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

LANES_INLINE void dense_orders_of(const struct jets_system *s, num gravity, int order, int n) {
    struct dense_table table;
    struct dense_order first, newest;
    dense_invert(s, n, &table);
    for (int i = 0; i < n; i++) {
        first.re[i] = first.force[i] = num_of(0);
        first.im[i] = first.rate[i] = s->rate[i];
    }
    newest = first;
    // gravity is a pull on the root
    num per_len = num_mul(gravity, s->inv_len[0]), zero = num_of(0);
    num lift = num_mul(s->sine[0], per_len), drop = num_mul(s->cosine[0], per_len);
    for (int k = 0; k < order; k++) {
        struct dense_order known = dense_known(s, n, k, &first, &newest);
        dense_solve(s, &table, n, k, k ? zero : lift, k ? zero : drop, &known, &newest);
        for (int i = 0; i < n; i++) {
            s->rate[(k + 1) * n + i] = newest.rate[i];
            s->force[k * n + i] = newest.force[i];
            s->turn_re[(k + 2) * n + i] = newest.re[i];
            s->turn_im[(k + 2) * n + i] = newest.im[i];
        }
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
