/* The power series of a tree's motion, written once for any kind of number: included by files
 * that define the numbers.
 * Leaves to others: memory, sines and cosines (jets), what a number is (the including file).
 * Invariant: no division in the orders; every arm does the same operations. */
#ifndef PEND_JETS_TEMPLATE_H
#define PEND_JETS_TEMPLATE_H

#include "core/taylor/jets_factor.h"

/* what follows from T and c alone, and sums set to nothing for the sweeps of order k */
static inline void jets_prepare(const struct jets_system *s, int k, int a, wide Tr, wide Ti,
                                wide cr, wide ci) {
    wide_put(s->wind_re + a, Tr);
    wide_put(s->wind_im + a, Ti);
    wide_put(s->drag_re + a, cr);
    wide_put(s->drag_im + a, ci);
    wide_put(s->heave + a, wide_mul(wide_mul(wide_get(s->weight + a), wide_of(k + 1)), Ti));
    wide_put(s->sum_side + a, wide_of(0));
    wide_put(s->sum_cos + a, wide_of(0));
    wide_put(s->sum_sin + a, wide_of(0));
    wide_put(s->early + a, wide_of(0));
}

/*
 * T and c of order k, and of order k + 1 but for the terms that order k is needed for, in one pass:
 * what is loaded serves both. Row -1 of the forces is zero.
 */
static inline void jets_known(const struct jets_system *s, int k) {
    size_t stride = s->stride;
    for (int a = 0; a < s->n; a += WIDE) {
        size_t row = jets_row(s, a), last = row + (size_t)k * stride;
        const num *re = s->turn_re + row + 2 * stride, *im = s->turn_im + row + 2 * stride;
        const num *rate = s->rate + last, *force = s->force + last - stride;
        wide w = wide_get(rate), f = wide_get(force), first = wide_get(s->rate + row);
        // u_1 is imaginary
        wide Tr = wide_of(0), Ti = wide_mul(first, w), cr = wide_of(0), ci = wide_mul(first, f);
        wide next_Tr = wide_of(0), next_Ti = wide_of(0), next_cr = wide_of(0), next_ci = wide_of(0);
        for (int j = 2; j <= k + 1; j++, re += stride, im += stride) {
            wide ur = wide_get(re), ui = wide_get(im);
            next_Tr = wide_fma(ur, w, next_Tr);
            next_Ti = wide_fma(ui, w, next_Ti);
            next_cr = wide_fma(ur, f, next_cr);
            next_ci = wide_fma(ui, f, next_ci);
            rate -= stride, force -= stride;
            w = wide_get(rate), f = wide_get(force);
            Tr = wide_fma(ur, w, Tr);
            Ti = wide_fma(ui, w, Ti);
            cr = wide_fma(ur, f, cr);
            ci = wide_fma(ui, f, ci);
        }
        jets_prepare(s, k, a, Tr, Ti, cr, ci);
        wide_put(s->next_wind_re + a, next_Tr);
        wide_put(s->next_wind_im + a, next_Ti);
        wide_put(s->next_drag_re + a, next_cr);
        wide_put(s->next_drag_im + a, next_ci);
    }
}

/* T and c of order k, the second of two: the terms that were missing */
static inline void jets_complete(const struct jets_system *s, int k) {
    for (int a = 0; a < s->n; a += WIDE) {
        size_t row = jets_row(s, a), now = row + (size_t)k * s->stride, last = now + s->stride;
        wide first = wide_get(s->rate + row);
        wide Tr = wide_fma(wide_get(s->turn_re + last), first, wide_get(s->next_wind_re + a));
        wide Ti = wide_fma(wide_get(s->turn_im + last), first, wide_get(s->next_wind_im + a));
        Ti = wide_fma(first, wide_get(s->rate + now), Ti);
        wide ci =
            wide_fma(first, wide_get(s->force + now - s->stride), wide_get(s->next_drag_im + a));
        jets_prepare(s, k, a, Tr, Ti, wide_get(s->next_drag_re + a), ci);
    }
}

/* known forces: along and across every arm, its children's included; the rest of each sweep's
 * start */
static void jets_gather(const struct jets_system *s) {
    for (int k = s->n - 1; k > 0; k--) {
        int p = s->parent[k];
        s->sum_cos[p] = num_fma(s->cosine[k], s->drag_im[k], s->sum_cos[p]);
        s->sum_sin[p] = num_fma(s->sine[k], s->drag_im[k], s->sum_sin[p]);
    }
    for (int a = 0; a < s->n; a += WIDE) {
        wide side = wide_sub(wide_get(s->drag_im + a), wide_get(s->sum_cos + a));
        wide_put(s->side + a, side);
        wide_put(s->push + a,
                 wide_sub(wide_mul(wide_get(s->lean + a), side), wide_get(s->sum_sin + a)));
    }
}

/* leaves to root: the constant part of the force an arm asks for */
static void jets_up(const struct jets_system *s) {
    jets_gather(s);
    for (int k = s->n - 1; k > 0; k--) {
        int p = s->parent[k];
        num bias = num_sub(s->push[k], s->heave[k]);
        s->bias[k] = bias;
        s->late[k] = s->sum_side[p];
        s->push[p] = num_fma(s->kappa[k], bias, s->push[p]);
        s->sum_side[p] = num_fma(s->sine[k], bias, s->sum_side[p]);
    }
    s->bias[0] = num_sub(s->push[0], s->heave[0]);
}

/* the constant part of mu, tension first: the siblings' part leaves the arm itself out */
static void jets_tension(const struct jets_system *s, num gravity) {
    s->others[0] = s->from_side[0] = num_of(0);
    for (int k = 1; k < s->n; k++) {
        int p = s->parent[k];
        num early = s->early[p];
        s->others[k] = num_add(early, s->late[k]);
        s->early[p] = num_fma(s->sine[k], s->bias[k], early);
        s->from_side[k] = s->side[p];
    }
    for (int a = 0; a < s->n; a += WIDE) {
        wide across = wide_sub(wide_get(s->from_side + a), wide_get(s->others + a));
        wide tension = wide_fma(wide_get(s->tau + a), across,
                                wide_mul(wide_get(s->nu + a), wide_get(s->bias + a)));
        wide_put(s->tension + a, tension);
        wide_put(s->shift + a,
                 wide_mul(wide_sub(tension, wide_get(s->push + a)), wide_get(s->inv_eff + a)));
        wide rest = wide_sub(wide_get(s->side + a), wide_get(s->sum_side + a));
        wide_put(s->rest + a, wide_mul(rest, wide_get(s->inv + a)));
    }
    // the root hangs on the pivot, which has i gravity
    num lift = num_mul(s->sine[0], gravity);
    s->tension[0] = num_fma(s->eff[0], lift, s->bias[0]);
    s->shift[0] = num_mul(num_sub(s->tension[0], s->push[0]), s->inv_eff[0]);
}

/* root to leaves: accelerations of the tips in their arms' frames */
static void jets_down(const struct jets_system *s, num gravity) {
    jets_tension(s, gravity);
    s->from_radial[0] = num_of(0);
    s->from_tangential[0] = gravity;
    s->radial[0] = s->shift[0];
    s->tangential[0] = num_sub(s->rest[0], num_mul(s->lean[0], s->radial[0]));
    for (int k = 1; k < s->n; k++) {
        int p = s->parent[k];
        num ar = s->radial[p], radial = num_fma(s->kappa[k], ar, s->shift[k]);
        s->from_radial[k] = ar;
        s->from_tangential[k] = s->tangential[p];
        s->radial[k] = radial;
        s->tangential[k] = num_sub(s->rest[k], num_mul(s->lean[k], radial));
    }
}

/* the coefficients of order k and what they make of u */
static inline void jets_learn(const struct jets_system *s, int k) {
    wide share = wide_of(s->share[k]), turn_share = wide_of(s->share[k + 1]);
    for (int a = 0; a < s->n; a += WIDE) {
        size_t now = jets_row(s, a) + (size_t)k * s->stride, next = now + s->stride,
               after = next + s->stride;
        wide ar = wide_get(s->from_radial + a), at = wide_get(s->from_tangential + a),
             Tr = wide_get(s->wind_re + a);
        wide C = wide_get(s->cosine + a), Z = wide_get(s->sine + a);
        wide gap =
            wide_add(wide_sub(wide_mul(Z, ar), wide_mul(C, at)), wide_get(s->tangential + a));
        wide acc = wide_sub(wide_mul(gap, wide_get(s->inv_len + a)), wide_mul(wide_of(k + 1), Tr));
        wide lambda = wide_sub(wide_fma(wide_get(s->stiff + a), ar, wide_get(s->tension + a)),
                               wide_get(s->drag_re + a));
        wide rate = wide_mul(acc, share);
        wide_put(s->force + now, lambda);
        wide_put(s->rate + next, rate);
        wide_put(s->turn_re + after, wide_neg(wide_mul(wide_get(s->wind_im + a), turn_share)));
        wide_put(s->turn_im + after, wide_mul(wide_add(rate, Tr), turn_share));
    }
}

/* all orders: rate_1 .. rate_order and force_0 .. force_{order - 1} from rate_0, cosine and sine */
static inline void jets_orders(const struct jets_system *s, num gravity, int order) {
    for (int a = 0; a < s->n; a += WIDE) {
        wide_put(s->stiff + a, wide_mul(wide_get(s->eff + a), wide_get(s->kappa + a)));
        wide_put(s->weight + a, wide_mul(wide_get(s->eff + a), wide_get(s->len + a)));
        size_t row = jets_row(s, a), first = row + s->stride;
        wide_put(s->turn_re + first, wide_of(0));
        wide_put(s->turn_im + first, wide_get(s->rate + row));
    }
    for (int k = 0; k < order; k++) {
        if (k % 2)
            jets_complete(s, k);
        else
            jets_known(s, k);
        jets_up(s);
        jets_down(s, k ? num_of(0) : gravity);
        jets_learn(s, k);
    }
}

#endif
