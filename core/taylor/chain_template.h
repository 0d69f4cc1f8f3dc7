/* The orders of one chain: tensions from one product a piece, every piece at once.
 * Leaves to others: other trees (blocks_kernel), which chains (strand).
 * Invariant: an order waits for no sweep from arm to arm; the inverse is made of products and sums of one sign. */
#ifndef PEND_CHAIN_TEMPLATE_H
#define PEND_CHAIN_TEMPLATE_H

#include <string.h>

#include "core/simd/vec8_template.h"
#include "core/taylor/jets_system.h"
#include "core/simd/vec_isa.h"
#include "core/taylor/chain.h"

LANES_INLINE double *strand_at(const struct strand *strand, int piece) {
    return strand->numbers + (size_t)piece * STRAND_NUMBERS;
}

LANES_INLINE wide strand_get(const double *at, int row, int lane) { return wide_get(at + row * STRAND_ARMS + lane); }

LANES_INLINE void strand_put(double *at, int row, int lane, wide x) { wide_put(at + row * STRAND_ARMS + lane, x); }

/* of an address that is not a vector's */
LANES_INLINE wide strand_load(const double *at) {
    wide x;
    memcpy(&x, at, sizeof x);
    return x;
}

/* a row of the arms' neighbours */
LANES_INLINE wide strand_next(const double *at, int row, int lane) {
    const double *after = lane + WIDE < STRAND_ARMS ? at + lane + WIDE : at + STRAND_NUMBERS;
    return wide_shift(strand_get(at, row, lane), wide_get(after + row * STRAND_ARMS));
}

LANES_INLINE wide strand_last(const double *at, int row, int lane) {
    const double *before = lane ? at + lane - WIDE : at - STRAND_NUMBERS + STRAND_ARMS - WIDE;
    return wide_unshift(wide_get(before + row * STRAND_ARMS), strand_get(at, row, lane));
}

/* ---- once a step */

/* a power of two that brings x >= 1 to 1 .. 2 */
LANES_INLINE double strand_scale(double x) {
    unsigned long long bits, exponent = 0x7ffULL << 52;
    memcpy(&bits, &x, sizeof bits);
    bits = (0x7feULL << 52) - (bits & exponent);
    memcpy(&x, &bits, sizeof x);
    return x;
}

/*
 * The mass S = N / D that hangs on an arm's base, from that of the next: S = m (m + S') / (m + S' Z'^2), as a fraction,
 * so that no arm waits for a division; and N' / N = S' / (m + S'). Everything is positive.
 */
static void strand_masses(const struct jets_system *s, const struct strand *strand) {
    double N = s->mass[s->n - 1], D = 1;
    for (int piece = strand->count - 1; piece >= 0; piece--) {
        double *at = strand_at(strand, piece), scale = strand_scale(D);
        int last = s->n - 1 - piece * STRAND_ARMS;
        N *= scale, D *= scale;
        for (int i = last < STRAND_ARMS ? last : STRAND_ARMS - 1; i >= 0; i--) {
            double here = lanes1_fma(at[STRAND_MASS * STRAND_ARMS + i], D, N);
            D = lanes1_fma(N, at[STRAND_SPREAD * STRAND_ARMS + i], D);
            at[STRAND_N * STRAND_ARMS + i] = N;
            at[STRAND_N_LAST * STRAND_ARMS + i] = here;
            N = here;
        }
    }
    // the pivot neither spreads nor moves: what the root adds is its S
    strand_at(strand, 0)[STRAND_N_LAST * STRAND_ARMS] = D;
}

/* diagonal of the inverse: G = kappa^2 G_last + S m_last / (m_last + S) */
static void strand_gains(const struct jets_system *s, const struct strand *strand) {
    double gain = 0;
    for (int piece = 0; piece < strand->count; piece++) {
        double *at = strand_at(strand, piece);
        const double *more = at + STRAND_MORE * STRAND_ARMS, *each = at + STRAND_KAPPA * STRAND_ARMS;
        for (int i = 0; i < STRAND_ARMS; i += WIDE) {
            wide share = strand_get(at, STRAND_N, i) / strand_get(at, STRAND_N_LAST, i);
            wide kappa = wide_get(s->cosine + piece * STRAND_ARMS + i) * share;
            if (piece + i == 0) kappa[0] = 0;
            strand_put(at, STRAND_KAPPA, i, kappa);
            strand_put(at, STRAND_MORE, i, strand_get(at, STRAND_MASS, i) * share);
        }
        for (int i = 0; i < STRAND_ARMS; i++) {
            gain = lanes1_fma(each[i] * each[i], gain, more[i]);
            at[STRAND_GAIN * STRAND_ARMS + i] = gain;
        }
    }
}

/* forces that a unit at each arm of a piece makes in it: G_ij = G_ii kappa_{i+1} .. kappa_j for i <= j, symmetric */
LANES_INLINE void strand_green(double *at) {
    enum { LAST = STRAND_ARMS - 1 };
    // unit + LAST - i has 1 in lane i
    static const double unit[2 * STRAND_ARMS] = {[LAST] = 1};
    const double *kappa = at + STRAND_KAPPA * STRAND_ARMS, *gain = at + STRAND_GAIN * STRAND_ARMS;
    for (int h = 0; h < STRAND_ARMS; h += WIDE) {
        // what goes on from arm i to those after it, then what arrives at i from those up to it
        wide on[STRAND_ARMS], way = strand_load(unit + h), here = wide_of(0);
        for (int i = LAST; i > 0; i--) {
            on[i] = wide_of(kappa[i]) * way;
            way = strand_load(unit + LAST - i + 1 + h) + on[i];
        }
        strand_put(at, STRAND_BEFORE, h, wide_of(kappa[0]) * way);
        for (int i = 0; i < STRAND_ARMS; i++) {
            here = wide_fma(wide_of(kappa[i]), here, wide_of(gain[i]) * strand_load(unit + LAST - i + h));
            wide column = i < LAST ? wide_fma(wide_of(gain[i]), on[i + 1], here) : here;
            strand_put(at, STRAND_GREEN + i, h, column);
        }
        strand_put(at, STRAND_AFTER, h, here);
    }
    double *ends = at + STRAND_ENDS * STRAND_ARMS;
    ends[STRAND_THROUGH] = at[STRAND_BEFORE * STRAND_ARMS + LAST];
    ends[STRAND_BACK] = kappa[0] / gain[0];
}

/* what follows from the angles alone, an arm at a time */
static void strand_coefficients(const struct jets_system *s, const struct strand *strand) {
    for (int a = 0; a < strand->count * STRAND_ARMS; a += WIDE) {
        int h = a % STRAND_ARMS;
        double *at = strand_at(strand, a / STRAND_ARMS);
        wide C = wide_get(s->cosine + a), Z = wide_get(s->sine + a);
        wide C_next = strand_load(s->cosine + a + 1), Z_next = strand_load(s->sine + a + 1);
        wide above = strand_get(at, STRAND_ABOVE, h), below = strand_get(at, STRAND_BELOW, h);
        wide part = strand_get(at, STRAND_PART, h), lean_last = Z * above, lean_next = -Z_next * below;
        strand_put(at, STRAND_SPREAD, h, Z * lean_last);
        strand_put(at, STRAND_LEAN_NEXT, h, lean_next);
        strand_put(at, STRAND_LEAN_LAST, h, lean_last);
        strand_put(at, STRAND_TURN_NEXT, h, lean_next * part);
        strand_put(at, STRAND_TURN_LAST, h, lean_last * part);
        strand_put(at, STRAND_SIDE, h, (above + below) * part);
        strand_put(at, STRAND_SIDE_NEXT, h, -(C_next * below) * part);
        strand_put(at, STRAND_SIDE_LAST, h, -(C * above) * part);
    }
}

static void strand_prepare(const struct jets_system *s, const struct strand *strand) {
    strand_coefficients(s, strand);
    strand_masses(s, strand);
    strand_gains(s, strand);
    for (int piece = 0; piece < strand->count; piece++) strand_green(strand_at(strand, piece));
}

/* ---- once an order */

/* T and c of an order, or parts of them */
struct strand_sums {
    wide Tr, Ti, cr, ci;
};

LANES_INLINE struct strand_sums strand_sums_get(const double *at, int row, int lane) {
    return (struct strand_sums){strand_get(at, row, lane), strand_get(at, row + 1, lane), strand_get(at, row + 2, lane),
                                strand_get(at, row + 3, lane)};
}

LANES_INLINE void strand_sums_put(double *at, int row, int lane, struct strand_sums x) {
    strand_put(at, row, lane, x.Tr);
    strand_put(at, row + 1, lane, x.Ti);
    strand_put(at, row + 2, lane, x.cr);
    strand_put(at, row + 3, lane, x.ci);
}

/* adds u times a rate and a force */
LANES_INLINE void strand_add(struct strand_sums *x, wide ur, wide ui, wide rate, wide force) {
    x->Tr = wide_fma(ur, rate, x->Tr);
    x->Ti = wide_fma(ui, rate, x->Ti);
    x->cr = wide_fma(ur, force, x->cr);
    x->ci = wide_fma(ui, force, x->ci);
}

/* the series of WIDE arms */
struct strand_series {
    const double *re, *im, *rate, *force;
};

LANES_INLINE struct strand_series strand_series(const struct jets_system *s, int piece, int lane) {
    size_t row = (size_t)piece * s->tile + (size_t)lane;
    return (struct strand_series){s->turn_re + row, s->turn_im + row, s->rate + row, s->force + row};
}

LANES_INLINE wide strand_order(const double *series, int order) { return wide_get(series + order * STRAND_ARMS); }

/* adds the product with u_j to the sums of order k, or to those of order k + 1 */
LANES_INLINE void strand_term(const struct strand_series *x, int j, int k, struct strand_sums *sum) {
    strand_add(sum, strand_order(x->re, j), strand_order(x->im, j), strand_order(x->rate, k + 1 - j),
               strand_order(x->force, k - j));
}

/*
 * Of T and c of orders k and k + 1 the terms without a coefficient from order k - 2 on: they are added up while that
 * order and the next are solved, which waits.
 */
LANES_INLINE void strand_old(const struct jets_system *s, const struct strand *strand, int piece, int k) {
    double *at = strand_at(strand, piece);
    wide zero = wide_of(0);
    for (int h = 0; h < STRAND_ARMS; h += WIDE) {
        struct strand_series x = strand_series(s, piece, h);
        struct strand_sums now = {zero, zero, zero, zero}, next = now;
        const double *re = x.re + 3 * STRAND_ARMS, *im = x.im + 3 * STRAND_ARMS;
        const double *rate = x.rate + (k - 2) * STRAND_ARMS, *force = x.force + (k - 3) * STRAND_ARMS;
        wide w = wide_get(rate), f = wide_get(force);
        strand_add(&now, wide_get(re), wide_get(im), w, f);
        for (int j = 4; j < k; j++) {
            re += STRAND_ARMS, im += STRAND_ARMS, rate -= STRAND_ARMS, force -= STRAND_ARMS;
            wide ur = wide_get(re), ui = wide_get(im);
            LANES_PIN(ur);
            LANES_PIN(ui);
            strand_add(&next, ur, ui, w, f);
            w = wide_get(rate), f = wide_get(force);
            LANES_PIN(w);
            LANES_PIN(f);
            strand_add(&now, ur, ui, w, f);
        }
        strand_sums_put(at, STRAND_OLD_TR, h, now);
        strand_sums_put(at, STRAND_OLDER_TR, h, next);
    }
}

/* T and c of an even order k, and of order k + 1 but for the terms that order k is needed for */
LANES_INLINE struct strand_sums strand_even(const struct jets_system *s, double *at, int piece, int h, int k) {
    struct strand_series x = strand_series(s, piece, h);
    wide zero = wide_of(0), first = strand_order(x.rate, 0);
    struct strand_sums now = {zero, zero, zero, zero}, next = now;
    if (k < 4) {
        for (int j = 2; j <= k + 1; j++) {
            strand_add(&now, strand_order(x.re, j), strand_order(x.im, j), strand_order(x.rate, k + 1 - j),
                       j <= k ? strand_order(x.force, k - j) : zero);
            strand_term(&x, j, k + 1, &next);
        }
    } else {
        now = strand_sums_get(at, STRAND_OLD_TR, h);
        next = strand_sums_get(at, STRAND_OLDER_TR, h);
        strand_term(&x, k, k, &now);
        strand_term(&x, k, k + 1, &next);
        strand_term(&x, 3, k + 1, &next);
        wide ur = strand_order(x.re, k + 1), ui = strand_order(x.im, k + 1);
        now.Tr = wide_fma(ur, first, now.Tr);
        now.Ti = wide_fma(ui, first, now.Ti);
        strand_add(&next, ur, ui, strand_order(x.rate, 1), strand_order(x.force, 0));
        strand_term(&x, 2, k, &now);
        strand_term(&x, 2, k + 1, &next);
    }
    strand_sums_put(at, STRAND_NEXT_TR, h, next);
    // u_1 is imaginary
    now.Ti = wide_fma(first, strand_order(x.rate, k), now.Ti);
    if (k) now.ci = wide_fma(first, strand_order(x.force, k - 1), now.ci);
    return now;
}

/* T and c of an odd order k: the terms that were missing */
LANES_INLINE struct strand_sums strand_odd(const struct jets_system *s, double *at, int piece, int h, int k) {
    struct strand_series x = strand_series(s, piece, h);
    struct strand_sums now = strand_sums_get(at, STRAND_NEXT_TR, h);
    wide first = strand_order(x.rate, 0);
    now.Tr = wide_fma(strand_order(x.re, k + 1), first, now.Tr);
    now.Ti = wide_fma(strand_order(x.im, k + 1), first, now.Ti);
    now.Ti = wide_fma(first, strand_order(x.rate, k), now.Ti);
    now.ci = wide_fma(first, strand_order(x.force, k - 1), now.ci);
    return now;
}

LANES_INLINE void strand_known(const struct jets_system *s, const struct strand *strand, int k) {
    wide share = wide_of(s->share[k]);
    for (int piece = 0; piece < strand->count; piece++) {
        double *at = strand_at(strand, piece);
        for (int h = 0; h < STRAND_ARMS; h += WIDE) {
            struct strand_sums now = k % 2 ? strand_odd(s, at, piece, h, k) : strand_even(s, at, piece, h, k);
            strand_put(at, STRAND_TR, h, now.Tr);
            strand_put(at, STRAND_TI, h, now.Ti);
            strand_put(at, STRAND_CR, h, now.cr);
            strand_put(at, STRAND_S, h, now.ci * share);
        }
    }
}

/* right-hand sides, and what they say of phi'' without the tensions */
LANES_INLINE void strand_ask(const struct strand *strand) {
    for (int piece = 0; piece < strand->count; piece++) {
        double *at = strand_at(strand, piece);
        for (int h = 0; h < STRAND_ARMS; h += WIDE) {
            wide S = strand_get(at, STRAND_S, h), next = strand_next(at, STRAND_S, h);
            wide last = strand_last(at, STRAND_S, h);
            wide ask = strand_get(at, STRAND_PULL, h) * strand_get(at, STRAND_TI, h);
            ask = wide_fma(strand_get(at, STRAND_LEAN_NEXT, h), next, ask);
            strand_put(at, STRAND_ASK, h, wide_fma(strand_get(at, STRAND_LEAN_LAST, h), last, ask));
            wide known = strand_get(at, STRAND_SIDE, h) * S;
            known = wide_fma(strand_get(at, STRAND_SIDE_NEXT, h), next, known);
            strand_put(at, STRAND_KNOWN, h, wide_fma(strand_get(at, STRAND_SIDE_LAST, h), last, known));
        }
    }
}

/* the root hangs on the pivot, which has i gravity */
LANES_INLINE void strand_hang(const struct jets_system *s, const struct strand *strand, double gravity) {
    double *at = strand_at(strand, 0);
    at[STRAND_ASK * STRAND_ARMS] = lanes1_fma(s->sine[0], gravity, at[STRAND_ASK * STRAND_ARMS]);
    at[STRAND_KNOWN * STRAND_ARMS] -= s->cosine[0] * gravity * at[STRAND_PART * STRAND_ARMS];
}

/* every piece by itself */
LANES_INLINE void strand_pieces(const struct strand *strand) {
    for (int piece = 0; piece < strand->count; piece++) {
        double *at = strand_at(strand, piece);
        const double *ask = at + STRAND_ASK * STRAND_ARMS;
        for (int h = 0; h < STRAND_ARMS; h += WIDE) {
            wide sum[4];
            for (int i = 0; i < 4; i++) sum[i] = strand_get(at, STRAND_GREEN + i, h) * wide_of(ask[i]);
            for (int i = 0; i < 4; i++)
                sum[i] = wide_fma(strand_get(at, STRAND_GREEN + 4 + i, h), wide_of(ask[4 + i]), sum[i]);
            strand_put(at, STRAND_MU, h, (sum[0] + sum[1]) + (sum[2] + sum[3]));
        }
    }
}

/* what the pieces do to each other: two sums from end to end, which go side by side */
LANES_INLINE void strand_join(const struct strand *strand) {
    enum { MU = STRAND_MU * STRAND_ARMS, ENDS = STRAND_ENDS * STRAND_ARMS };
    double before = 0, after = 0;
    for (int piece = 0; piece < strand->count; piece++) {
        double *front = strand_at(strand, piece), *back = strand_at(strand, strand->count - 1 - piece);
        front[ENDS + STRAND_FROM_BEFORE] = before;
        back[ENDS + STRAND_FROM_AFTER] = after;
        before = lanes1_fma(front[ENDS + STRAND_THROUGH], before, front[MU + STRAND_ARMS - 1]);
        after = lanes1_fma(back[ENDS + STRAND_THROUGH], after, back[ENDS + STRAND_BACK] * back[MU]);
    }
}

LANES_INLINE void strand_tensions(const struct strand *strand) {
    for (int piece = 0; piece < strand->count; piece++) {
        double *at = strand_at(strand, piece);
        const double *ends = at + STRAND_ENDS * STRAND_ARMS;
        for (int h = 0; h < STRAND_ARMS; h += WIDE) {
            wide mu = wide_fma(strand_get(at, STRAND_BEFORE, h), wide_of(ends[STRAND_FROM_BEFORE]),
                               strand_get(at, STRAND_MU, h));
            mu = wide_fma(strand_get(at, STRAND_AFTER, h), wide_of(ends[STRAND_FROM_AFTER]), mu);
            strand_put(at, STRAND_MU, h, mu);
        }
    }
}

/* the coefficients of order k and what they make of u */
LANES_INLINE void strand_learn(const struct jets_system *s, const struct strand *strand, int k) {
    wide order = wide_of(k + 1), share = wide_of(s->share[k + 1]);
    for (int piece = 0; piece < strand->count; piece++) {
        const double *at = strand_at(strand, piece);
        size_t row = (size_t)piece * s->tile + (size_t)k * STRAND_ARMS;
        for (int h = 0; h < STRAND_ARMS; h += WIDE) {
            wide mu = strand_get(at, STRAND_MU, h), turned = strand_get(at, STRAND_KNOWN, h);
            turned = wide_fma(strand_get(at, STRAND_TURN_NEXT, h), strand_next(at, STRAND_MU, h), turned);
            turned = wide_fma(strand_get(at, STRAND_TURN_LAST, h), strand_last(at, STRAND_MU, h), turned);
            size_t now = row + (size_t)h, next = now + STRAND_ARMS, after = next + STRAND_ARMS;
            wide_put(s->rate + next, turned - strand_get(at, STRAND_TR, h));
            wide_put(s->force + now, wide_fma(mu, order, -strand_get(at, STRAND_CR, h)));
            wide_put(s->turn_re + after, -strand_get(at, STRAND_TI, h) * share);
            wide_put(s->turn_im + after, turned * share);
        }
    }
}

/* a quarter of the pieces */
LANES_INLINE void strand_quarter(const struct jets_system *s, const struct strand *strand, int quarter, int k) {
    if (k < 4) return;
    int end = strand->count * (quarter + 1) / 4;
    for (int piece = strand->count * quarter / 4; piece < end; piece++) strand_old(s, strand, piece, k);
}

/* order k, and meanwhile half of the old terms of order `later` */
LANES_INLINE void strand_solve(const struct jets_system *s, const struct strand *strand, double gravity, int k,
                               int later, int half) {
    strand_known(s, strand, k);
    strand_ask(strand);
    if (gravity != 0) strand_hang(s, strand, gravity);
    strand_pieces(strand);
    strand_join(strand);
    strand_quarter(s, strand, 2 * half, later);
    strand_tensions(strand);
    strand_learn(s, strand, k);
    strand_quarter(s, strand, 2 * half + 1, later);
}

/* all orders: rate_1 .. rate_order and force_0 .. force_{order - 1} from rate_0, cosine and sine */
static void strand_orders(const struct jets_system *s, double gravity, int order) {
    const struct strand *strand = s->strand;
    strand_prepare(s, strand);
    for (int piece = 0; piece < strand->count; piece++) {
        for (int h = 0; h < STRAND_ARMS; h += WIDE) {
            size_t row = (size_t)piece * s->tile + (size_t)h;
            wide_put(s->turn_re + row + STRAND_ARMS, wide_of(0));
            wide_put(s->turn_im + row + STRAND_ARMS, wide_get(s->rate + row));
        }
    }
    for (int k = 0; k < order; k += 2) {
        int later = k + 2 < order ? k + 2 : 0;
        strand_solve(s, strand, k ? 0 : gravity, k, later, 0);
        if (k + 1 < order) strand_solve(s, strand, 0, k + 1, later, 1);
    }
}

#endif
