/* The power series of a tree's motion, for any kind of number. This is the general form: the fast
 * forms (small, chain, blocks) give the same coefficients up to rounding.
 * Leaves to others: memory, sines and cosines (jets), the kinds of number (number).
 * Invariant: no division in the orders; every arm does the same operations. */
#pragma once

#include "core/taylor/jets_factor.h"

/* computes for arm a the values that depend only on T and c, and clears its sums for order k */
static inline void jets_prepare(const struct jets_system *s, int k, int a, num Tr, num Ti, num cr,
                                num ci) {
    s->wind_re[a] = Tr;
    s->wind_im[a] = Ti;
    s->drag_re[a] = cr;
    s->drag_im[a] = ci;
    s->heave[a] = num_mul(num_mul(s->weight[a], num_of(k + 1)), Ti);
    s->sum_side[a] = num_of(0);
    s->sum_cos[a] = num_of(0);
    s->sum_sin[a] = num_of(0);
    s->early[a] = num_of(0);
}

/* T and c of order k, and of order k + 1 without the terms that need order k, in one pass, so that
 * every coefficient is loaded once for both. Row -1 of the forces is zero. */
static inline void jets_known(const struct jets_system *s, int k) {
    size_t stride = s->stride;
    for (int a = 0; a < s->n; a++) {
        size_t row = jets_row(s, a), last = row + (size_t)k * stride;
        const num *re = s->turn_re + row + 2 * stride, *im = s->turn_im + row + 2 * stride;
        const num *rate = s->rate + last, *force = s->force + last - stride;
        num w = *rate, f = *force, first = s->rate[row];
        // u_1 is imaginary
        num Tr = num_of(0), Ti = num_mul(first, w), cr = num_of(0), ci = num_mul(first, f);
        num next_Tr = num_of(0), next_Ti = num_of(0), next_cr = num_of(0), next_ci = num_of(0);
        for (int j = 2; j <= k + 1; j++, re += stride, im += stride) {
            num ur = *re, ui = *im;
            next_Tr = num_fma(ur, w, next_Tr);
            next_Ti = num_fma(ui, w, next_Ti);
            next_cr = num_fma(ur, f, next_cr);
            next_ci = num_fma(ui, f, next_ci);
            rate -= stride, force -= stride;
            w = *rate, f = *force;
            Tr = num_fma(ur, w, Tr);
            Ti = num_fma(ui, w, Ti);
            cr = num_fma(ur, f, cr);
            ci = num_fma(ui, f, ci);
        }
        jets_prepare(s, k, a, Tr, Ti, cr, ci);
        s->next_wind_re[a] = next_Tr;
        s->next_wind_im[a] = next_Ti;
        s->next_drag_re[a] = next_cr;
        s->next_drag_im[a] = next_ci;
    }
}

/* the missing terms of T and c of order k, the second of two orders */
static inline void jets_complete(const struct jets_system *s, int k) {
    for (int a = 0; a < s->n; a++) {
        size_t row = jets_row(s, a), now = row + (size_t)k * s->stride, last = now + s->stride;
        num first = s->rate[row];
        num Tr = num_fma(s->turn_re[last], first, s->next_wind_re[a]);
        num Ti = num_fma(s->turn_im[last], first, s->next_wind_im[a]);
        Ti = num_fma(first, s->rate[now], Ti);
        num ci = num_fma(first, s->force[now - s->stride], s->next_drag_im[a]);
        jets_prepare(s, k, a, Tr, Ti, s->next_drag_re[a], ci);
    }
}

/* sets the known forces along and across every arm, including those of its children, and clears the
 * other sums of the sweeps */
static void jets_gather(const struct jets_system *s) {
    for (int k = s->n - 1; k > 0; k--) {
        int p = s->parent[k];
        s->sum_cos[p] = num_fma(s->cosine[k], s->drag_im[k], s->sum_cos[p]);
        s->sum_sin[p] = num_fma(s->sine[k], s->drag_im[k], s->sum_sin[p]);
    }
    for (int a = 0; a < s->n; a++) {
        num side = num_sub(s->drag_im[a], s->sum_cos[a]);
        s->side[a] = side;
        s->push[a] = num_sub(num_mul(s->lean[a], side), s->sum_sin[a]);
    }
}

/* leaves to root: the constant term of the force on an arm's base */
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

/* the constant term of mu, where tension is solved first, from sums over the siblings without the
 * arm itself */
static void jets_tension(const struct jets_system *s, num gravity) {
    s->others[0] = s->from_side[0] = num_of(0);
    for (int k = 1; k < s->n; k++) {
        int p = s->parent[k];
        num early = s->early[p];
        s->others[k] = num_add(early, s->late[k]);
        s->early[p] = num_fma(s->sine[k], s->bias[k], early);
        s->from_side[k] = s->side[p];
    }
    for (int a = 0; a < s->n; a++) {
        num across = num_sub(s->from_side[a], s->others[a]);
        num tension = num_fma(s->tau[a], across, num_mul(s->nu[a], s->bias[a]));
        s->tension[a] = tension;
        s->shift[a] = num_mul(num_sub(tension, s->push[a]), s->inv_eff[a]);
        num rest = num_sub(s->side[a], s->sum_side[a]);
        s->rest[a] = num_mul(rest, s->inv[a]);
    }
    // the acceleration of the pivot is i gravity
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

/* stores the coefficients of order k and computes from them the next coefficient of u */
static inline void jets_learn(const struct jets_system *s, int k) {
    num share = num_of(s->share[k]), turn_share = num_of(s->share[k + 1]);
    for (int a = 0; a < s->n; a++) {
        size_t now = jets_row(s, a) + (size_t)k * s->stride, next = now + s->stride,
               after = next + s->stride;
        num ar = s->from_radial[a], at = s->from_tangential[a], Tr = s->wind_re[a];
        num C = s->cosine[a], Z = s->sine[a];
        num gap = num_add(num_sub(num_mul(Z, ar), num_mul(C, at)), s->tangential[a]);
        num acc = num_sub(num_mul(gap, s->inv_len[a]), num_mul(num_of(k + 1), Tr));
        num lambda = num_sub(num_fma(s->stiff[a], ar, s->tension[a]), s->drag_re[a]);
        num rate = num_mul(acc, share);
        s->force[now] = lambda;
        s->rate[next] = rate;
        s->turn_re[after] = num_neg(num_mul(s->wind_im[a], turn_share));
        s->turn_im[after] = num_mul(num_add(rate, Tr), turn_share);
    }
}

/* computes all orders: rate_1 .. rate_order and force_0 .. force_{order - 1} from rate_0, cosine
 * and sine */
static inline void jets_orders(const struct jets_system *s, num gravity, int order) {
    for (int a = 0; a < s->n; a++) {
        s->stiff[a] = num_mul(s->eff[a], s->kappa[a]);
        s->weight[a] = num_mul(s->eff[a], s->len[a]);
        size_t row = jets_row(s, a), first = row + s->stride;
        s->turn_re[first] = num_of(0);
        s->turn_im[first] = s->rate[row];
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
