/* The next coefficients of the series in numbers of 32 digits, from the known terms of an order:
 * for small trees by the inverse of the tree system, for others by its sweeps.
 * Leaves to others: the known terms (extended_known_template), the step (kernel_extended).
 * Invariant: from order `precise` on only one double of each number is computed, the other is 0. */
#pragma once

#include "core/extended/extended_known_template.h"
#include "core/taylor/jets_template.h"

enum { DENSE_MAX = 4 /* maximum number of arms of a tree whose orders are solved by an inverse */ };

/* 1 / (j + 1) to all digits, from its high part */
VEC_INLINE num extended_share(const double share[], int j) {
    wide high = wide_of(share[j]);
    num rest = NUM_(product)(high, wide_of(j + 1));
    return (num){high, ((1 - rest.high) - rest.low) * high};
}

/* ---- orders of small trees, by the inverse of the tree system */

/* the responses phi'' and force of arm i to a unit of T_j (pull) and of c_j (side), at [j][i] */
struct extended_table {
    num rate_pull[DENSE_MAX][DENSE_MAX], rate_side[DENSE_MAX][DENSE_MAX];
    num force_pull[DENSE_MAX][DENSE_MAX], force_side[DENSE_MAX][DENSE_MAX];
};

/* the response of all arms to the right-hand side in heave and drag_im */
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

/* computes order k from its known terms; lift and drop are the components of gravity at the root */
VEC_INLINE void extended_solve(const struct jets_system *s, const struct extended_table *table,
                               int n, int k, num gravity, const struct extended_known known[]) {
    num share = extended_share(s->share, k), turn_share = extended_share(s->share, k + 1),
        pull[DENSE_MAX], side[DENSE_MAX], drop = num_of(0);
    for (int j = 0; j < n; j++) {
        pull[j] = known[j].wind_im;
        side[j] = num_mul(known[j].drag_im, share);
    }
    if (k == 0) {
        // gravity acts as a pull on the root
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

VEC_INLINE void extended_small_of(const struct jets_system *s, const struct extended_packs *packs,
                                  num gravity, int order, int precise, int n) {
    struct extended_table table;
    extended_invert(s, &table);
    extended_pack(s, packs, 0);
    for (int k = 0; k < order; k++) {
        struct extended_known known[DENSE_MAX];
        struct extended_rough rough[DENSE_MAX];
        if (k < precise) {
            for (int i = 0; i < n; i++) known[i] = extended_find(s, packs, (size_t)n, k, i);
            extended_solve(s, &table, n, k, gravity, known);
        } else {
            for (int i = 0; i < n; i++)
                rough[i] = extended_convolve_rough(s, packs, (size_t)n, k, i);
            extended_solve_rough(s, &table, n, k, rough);
        }
        extended_pack(s, packs, k + 1);
    }
}

static void extended_small(const struct jets_system *s, const struct extended_packs *packs,
                           num gravity, int order, int precise) {
    if (s->n == 1)
        extended_small_of(s, packs, gravity, order, precise, 1);
    else if (s->n == 2)
        extended_small_of(s, packs, gravity, order, precise, 2);
    else if (s->n == 3)
        extended_small_of(s, packs, gravity, order, precise, 3);
    else
        extended_small_of(s, packs, gravity, order, precise, 4);
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

static void extended_orders(const struct jets_system *s, const struct extended_packs *packs,
                            num gravity, int order, int precise) {
    for (int i = 0; i < s->n; i++) {
        s->stiff[i] = num_mul(s->eff[i], s->kappa[i]);
        s->weight[i] = num_mul(s->eff[i], s->len[i]);
    }
    extended_pack(s, packs, 0);
    for (int k = 0; k < order; k++) {
        for (int i = 0; i < s->n; i++) {
            struct extended_known x;
            if (k < precise) {
                x = extended_find(s, packs, s->stride, k, i);
            } else {
                struct extended_rough y = extended_convolve_rough(s, packs, s->stride, k, i);
                x = (struct extended_known){num_from(y.wind_re), num_from(y.wind_im),
                                            num_from(y.drag_re), num_from(y.drag_im)};
            }
            jets_prepare(s, k, i, x.wind_re, x.wind_im, x.drag_re, x.drag_im);
        }
        jets_up(s);
        jets_down(s, k ? num_of(0) : gravity);
        extended_learn(s, k);
        extended_pack(s, packs, k + 1);
    }
}
