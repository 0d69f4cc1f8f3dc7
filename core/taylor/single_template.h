/* The orders of one arm alone, for any kind of number: phi'' = -(g / l) cos phi.
 * Leaves to others: memory, the kinds of number (number).
 * Invariant: without gravity all coefficients of the rate except the first are exactly 0. With the
 * tree's recurrences a constant rate would involve a difference, and drift by a rounding error per
 * step. */
#pragma once

#include "core/taylor/jets_system.h"

enum { SINGLE_ROWS = 48 };

struct single_pair {
    num re, im;
};

/* sums of u_j phi'_{k-j}, j = 0 .. k, added from the middle outwards, so that the newest
 * coefficients come last and the other products need not wait for them */
VEC_INLINE struct single_pair single_convolve(const num re[], const num im[], const num rate[],
                                              int k) {
    num zero = num_of(0), middle = k % 2 ? zero : rate[k / 2];
    struct single_pair low = {num_mul(re[k / 2], middle), num_mul(im[k / 2], middle)},
                       high = {zero, zero};
    for (int i = (k - 1) / 2, j = k - i; i >= 0 && k; i--, j++) {
        low =
            (struct single_pair){num_fma(re[i], rate[j], low.re), num_fma(im[i], rate[j], low.im)};
        high = (struct single_pair){num_fma(re[j], rate[i], high.re),
                                    num_fma(im[j], rate[i], high.im)};
    }
    return (struct single_pair){num_add(low.re, high.re), num_add(low.im, high.im)};
}

/*
 * With u = re + i im = e^{i (phi - phi_0)}, C and Z of phi_0, and G = g / l, all in units:
 *   phi'_{k+1} = -G (C re_k - Z im_k) / (k+1)
 *   re_{k+1} = -(sum im_j phi'_{k-j}) / (k+1)    im_{k+1} = (sum re_j phi'_{k-j}) / (k+1)
 *   lambda_k = m [g s_k - l (phi'^2)_k] = 3 m g s_k from order 1 on, s_k = Z re_k + C im_k,
 * since phi'^2 + 2 G sin phi is constant.
 */
VEC_INLINE void single_orders(const struct jets_system *s, num gravity, int order) {
    num re[SINGLE_ROWS], im[SINGLE_ROWS], rate[SINGLE_ROWS];
    num pull = num_mul(gravity, s->inv_len[0]), C = s->cosine[0], Z = s->sine[0];
    num weight = num_mul(gravity, s->mass[0]), thrice = num_mul(num_of(3), weight);
    re[0] = num_of(1), im[0] = num_of(0), rate[0] = s->rate[0];
    num swing = num_mul(num_mul(rate[0], s->len[0]), rate[0]);
    s->force[0] = num_sub(num_mul(weight, Z), num_mul(s->mass[0], swing));
    for (int k = 0; k < order; k++) {
        num share = num_of(s->share[k]), across = num_sub(num_mul(Z, im[k]), num_mul(C, re[k]));
        if (k)
            s->force[(size_t)k * s->stride] = num_mul(thrice, num_fma(Z, re[k], num_mul(C, im[k])));
        struct single_pair sum = single_convolve(re, im, rate, k);
        re[k + 1] = num_neg(num_mul(share, sum.im));
        im[k + 1] = num_mul(share, sum.re);
        rate[k + 1] = num_mul(num_mul(share, pull), across);
        s->rate[(size_t)(k + 1) * s->stride] = rate[k + 1];
    }
}
