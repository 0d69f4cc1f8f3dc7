/* Propagation of small errors of a state over one step, for any kind of number: the equations of
 * the orders, linearized about the motion. They share the motion's tree system of order 0.
 * Leaves to others: the motion's series to at least the same order (dense_template, which the
 * including file includes first), the kinds of number (number).
 * Invariant: the motion's series are only read; the arrays of its sweeps are overwritten. */
#pragma once

/* The change `x` of the motion `s` is a system of the same tree, of which only the series are
 * used. */

/* adds the products of u_j with a rate and with a force to four sums, as dense_add */
VEC_INLINE void change_add(num sum[4], num re, num im, num rate, num force) {
    sum[0] = num_fma(re, rate, sum[0]);
    sum[1] = num_fma(im, rate, sum[1]);
    sum[2] = num_fma(re, force, sum[2]);
    sum[3] = num_fma(im, force, sum[3]);
}

/* the change of T and c of order k of arm i: every product has one factor of the motion and one of
 * the change. Row -1 of forces is zero. */
VEC_INLINE void change_known(const struct jets_system *s, const struct jets_system *x, int n, int k,
                             int i, num sum[4]) {
    const num *own = s->rate + (k + 1) * n + i, *own_force = s->force + k * n + i;
    const num *other = x->rate + k * n + i, *other_force = x->force + (k - 1) * n + i;
    for (int j = 0; j < 4; j++) sum[j] = num_of(0);
    for (int j = 0; j <= k + 1; j++, own -= n, own_force -= n)
        change_add(sum, x->turn_re[j * n + i], x->turn_im[j * n + i], *own, *own_force);
    for (int j = 1; j <= k + 1; j++, other -= n, other_force -= n)
        change_add(sum, s->turn_re[j * n + i], s->turn_im[j * n + i], *other, *other_force);
}

/* stores the series of order 0 of the change: arm i turned by the error of its angle, and the error
 * of its rate, in units */
VEC_INLINE void change_start(const struct jets_system *s, const struct jets_system *x, int n,
                             int i) {
    x->turn_re[i] = num_of(0);
    x->turn_re[n + i] = num_neg(num_mul(s->rate[i], x->turn_im[i]));
    x->turn_im[n + i] = x->rate[i];
}

VEC_INLINE void change_dense(const struct jets_system *s, const struct jets_system *x, int order,
                             int n) {
    const struct dense_table *table = (const struct dense_table *)(const void *)s->answers;
    struct dense_order known, newest;
    for (int i = 0; i < n; i++) change_start(s, x, n, i);
    for (int k = 0; k < order; k++) {
        for (int i = 0; i < n; i++) {
            num sum[4];
            change_known(s, x, n, k, i, sum);
            known.re[i] = sum[0], known.im[i] = sum[1], known.rate[i] = sum[2],
            known.force[i] = sum[3];
        }
        dense_solve(s, table, n, k, &known, &newest);
        dense_keep(x, n, k, &newest);
    }
}

VEC_INLINE void change_swept(const struct jets_system *s, const struct jets_system *x, int order) {
    struct jets_system both = *s;
    both.rate = x->rate;
    both.force = x->force;
    both.turn_re = x->turn_re;
    both.turn_im = x->turn_im;
    for (int i = 0; i < s->n; i++) change_start(s, x, s->n, i);
    for (int k = 0; k < order; k++) {
        for (int i = 0; i < s->n; i++) {
            num sum[4];
            change_known(s, x, s->n, k, i, sum);
            jets_prepare(s, k, i, sum[0], sum[1], sum[2], sum[3]);
        }
        jets_up(s);
        jets_down(s, num_of(0));
        jets_learn(&both, k);
    }
}

/* a pendulum with one arm, whose rotation factors are not stored: computes u of the motion again
 * and applies the linearized recurrences of its orders */
VEC_INLINE void change_single(const struct jets_system *s, const struct jets_system *x, num gravity,
                              int order) {
    num pull = num_mul(gravity, s->inv_len[0]), C = s->cosine[0], Z = s->sine[0],
        angle = x->turn_im[0];
    num swing = num_mul(num_mul(num_of(2), s->len[0]), num_mul(s->rate[0], x->rate[0]));
    s->turn_re[0] = num_of(1);
    s->turn_im[0] = x->turn_re[0] = num_of(0);
    x->force[0] = num_mul(s->mass[0], num_sub(num_mul(num_mul(gravity, C), angle), swing));
    for (int k = 0; k < order; k++) {
        num own[2] = {num_of(0), num_of(0)}, more[2] = {num_of(0), num_of(0)},
            share = num_of(s->share[k]);
        for (int j = 0; j <= k; j++) {
            num rate = s->rate[k - j], other = x->rate[k - j];
            own[0] = num_fma(s->turn_re[j], rate, own[0]);
            own[1] = num_fma(s->turn_im[j], rate, own[1]);
            more[0] = num_fma(x->turn_re[j], rate, num_fma(s->turn_re[j], other, more[0]));
            more[1] = num_fma(x->turn_im[j], rate, num_fma(s->turn_im[j], other, more[1]));
        }
        num across = num_sub(num_mul(Z, x->turn_im[k]), num_mul(C, x->turn_re[k]));
        s->turn_re[k + 1] = num_neg(num_mul(share, own[1]));
        s->turn_im[k + 1] = num_mul(share, own[0]);
        x->turn_re[k + 1] = num_neg(num_mul(share, more[1]));
        x->turn_im[k + 1] = num_mul(share, more[0]);
        x->rate[k + 1] = num_mul(num_mul(share, pull), across);
    }
}

/* Computes the change's rates of orders 1 .. order, and its forces of order 0. Input, in units: the
 * errors of the angles in the imaginary turns of order 0, and of the rates in the rates of order 0.
 * The stride is n. */
VEC_INLINE void change_orders(const struct jets_system *s, const struct jets_system *x, num gravity,
                              int order) {
    if (s->n == 1)
        change_single(s, x, gravity, order);
    else if (s->n == 2)
        change_dense(s, x, order, 2);
    else if (s->n == 3)
        change_dense(s, x, order, 3);
    else if (s->n <= DENSE_MAX)
        change_dense(s, x, order, 4);
    else
        change_swept(s, x, order);
}
