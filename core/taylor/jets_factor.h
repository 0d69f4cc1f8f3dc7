/* The tree system of order 0, factorized: the response of a tree to forces, written once for any
 * kind of number.
 * Leaves to others: memory, sines and cosines (jets), the kinds of number (number), the orders
 * (*_template).
 * Invariant: one division per arm, no cancellation; every arm does the same operations. */
#pragma once

#include "core/taylor/jets_system.h"

/* adds child c to the sums over the children of its parent p, and stores in c the sums over its
 * later siblings */
static void jets_join(const struct jets_system *s, int c, int p) {
    num C = s->cosine[c], Z = s->sine[c], S = s->eff[c];
    num sp = s->sum_p[p], sr = s->sum_r[p], sq = s->sum_q[p];
    num SC = num_mul(S, C), SZ = num_mul(S, Z);
    s->late_q[c] = sq;
    s->late_r[c] = sr;
    // p Z^2 - 2 r Z C + q C^2 = Z (p Z - r C) + C (q C - r Z)
    num turned = num_add(num_mul(Z, num_sub(num_mul(sp, Z), num_mul(sr, C))),
                         num_mul(C, num_sub(num_mul(sq, C), num_mul(sr, Z))));
    s->sum_d[p] = num_fma(S, turned, s->sum_d[p]);
    s->sum_p[p] = num_fma(SC, C, sp);
    s->sum_r[p] = num_fma(SC, Z, sr);
    s->sum_q[p] = num_fma(SZ, Z, sq);
}

/* computes the effect of each child c of k on k (kappa, nu, tau), from sums over the siblings
 * without c itself */
static void jets_share(const struct jets_system *s, int k) {
    num early_q = num_of(0), early_r = num_of(0), inv = s->inv[k];
    for (int c = k + 1; c < s->end[k]; c = s->end[c]) {
        num C = s->cosine[c], Z = s->sine[c], SZ = num_mul(s->eff[c], Z);
        num others = num_add(s->mass[k], num_add(early_q, s->late_q[c]));
        num lean = num_add(early_r, s->late_r[c]);
        s->kappa[c] = num_mul(inv, num_sub(num_mul(C, others), num_mul(Z, lean)));
        s->nu[c] = num_mul(inv, others);
        s->tau[c] = num_mul(inv, SZ);
        early_q = num_fma(SZ, Z, early_q);
        early_r = num_fma(SZ, C, early_r);
    }
}

/* factorizes the tree system of order 0; cosine and sine must be set */
static void jets_factor(const struct jets_system *s) {
    for (int k = 0; k < s->n; k++)
        s->sum_p[k] = s->sum_r[k] = s->sum_q[k] = s->sum_d[k] = num_of(0);
    for (int k = s->n - 1; k >= 0; k--) {
        num m = s->mass[k], q = s->sum_q[k];
        num inv = num_div(num_of(1), num_add(m, q));
        num S = num_mul(num_add(num_mul(m, num_add(m, num_add(s->sum_p[k], q))), s->sum_d[k]), inv);
        s->inv[k] = inv;
        s->lean[k] = num_mul(s->sum_r[k], inv);
        s->eff[k] = S;
        s->inv_eff[k] = num_div(num_of(1), S);
        jets_share(s, k);
        if (k) jets_join(s, k, s->parent[k]);
    }
    s->kappa[0] = s->tau[0] = num_of(0);
    s->nu[0] = num_of(1);
}
