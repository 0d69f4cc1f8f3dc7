/* The orders of one chain: tensions from one matrix product per piece, for all pieces at once.
 * Without this form, in blocks, a trajectory by the method taylor takes more processor time: 42 %
 * more with 9 arms, 39 % with 32, 31 % with 100 and 15 % with 500.
 * Leaves to others: other trees (blocks_template), the choice of chains (chain).
 * Invariant: an order has no sweep from arm to arm; the inverse consists of products and sums of
 * equal sign. */
#pragma once

#include <string.h>

#include "core/simd/vec8_template.h"
#include "core/taylor/jets_system.h"
#include "core/simd/vec_isa.h"
#include "core/taylor/large/chain.h"
#include "core/taylor/large/couples_template.h"

VEC_INLINE double *chain_at(const struct chain *chain, int piece) {
    return chain->numbers + (size_t)piece * CHAIN_NUMBERS;
}

VEC_INLINE wide chain_get(const double *at, int row, int lane) {
    return wide_get(at + row * CHAIN_ARMS + lane);
}

VEC_INLINE void chain_put(double *at, int row, int lane, wide x) {
    wide_put(at + row * CHAIN_ARMS + lane, x);
}

/* loads from an address that need not be aligned */
VEC_INLINE wide chain_load(const double *at) {
    wide x;
    memcpy(&x, at, sizeof x);
    return x;
}

/* a row shifted by one arm: the values of the arms' successors */
VEC_INLINE wide chain_next(const double *at, int row, int lane) {
    const double *after = lane + WIDE < CHAIN_ARMS ? at + lane + WIDE : at + CHAIN_NUMBERS;
    return wide_shift(chain_get(at, row, lane), wide_get(after + row * CHAIN_ARMS));
}

VEC_INLINE wide chain_last(const double *at, int row, int lane) {
    const double *before = lane ? at + lane - WIDE : at - CHAIN_NUMBERS + CHAIN_ARMS - WIDE;
    return wide_unshift(wide_get(before + row * CHAIN_ARMS), chain_get(at, row, lane));
}

/* ---- once a step */

/* the power of two that scales x >= 1 into 1 .. 2 */
VEC_INLINE double chain_scale(double x) {
    unsigned long long bits, exponent = 0x7ffULL << 52;
    memcpy(&bits, &x, sizeof bits);
    bits = (0x7feULL << 52) - (bits & exponent);
    memcpy(&x, &bits, sizeof x);
    return x;
}

/* The effective mass S = N / D at an arm's base, from that of the next: S = m (m + S') / (m + S'
 * Z'^2). N and D are computed separately, so that no arm waits for a division; N' / N = S' / (m +
 * S'). All numbers are positive. */
static void chain_masses(const struct jets_system *s, const struct chain *chain) {
    double N = s->mass[s->n - 1], D = 1;
    for (int piece = chain->count - 1; piece >= 0; piece--) {
        double *at = chain_at(chain, piece), scale = chain_scale(D);
        int last = s->n - 1 - piece * CHAIN_ARMS;
        N *= scale, D *= scale;
        for (int i = last < CHAIN_ARMS ? last : CHAIN_ARMS - 1; i >= 0; i--) {
            double here = lanes1_fma(at[CHAIN_MASS * CHAIN_ARMS + i], D, N);
            D = lanes1_fma(N, at[CHAIN_SPREAD * CHAIN_ARMS + i], D);
            at[CHAIN_N * CHAIN_ARMS + i] = N;
            at[CHAIN_N_LAST * CHAIN_ARMS + i] = here;
            N = here;
        }
    }
    // the pivot does not move: with D here, the root's share N / N_LAST is its S
    chain_at(chain, 0)[CHAIN_N_LAST * CHAIN_ARMS] = D;
}

/* computes the diagonal of the inverse: G = kappa^2 G_last + S m_last / (m_last + S) */
static void chain_gains(const struct jets_system *s, const struct chain *chain) {
    double gain = 0;
    for (int piece = 0; piece < chain->count; piece++) {
        double *at = chain_at(chain, piece);
        const double *more = at + CHAIN_MORE * CHAIN_ARMS, *each = at + CHAIN_KAPPA * CHAIN_ARMS;
        for (int i = 0; i < CHAIN_ARMS; i += WIDE) {
            wide share = chain_get(at, CHAIN_N, i) / chain_get(at, CHAIN_N_LAST, i);
            wide kappa = wide_get(s->cosine + piece * CHAIN_ARMS + i) * share;
            if (piece + i == 0) kappa[0] = 0;
            chain_put(at, CHAIN_KAPPA, i, kappa);
            chain_put(at, CHAIN_MORE, i, chain_get(at, CHAIN_MASS, i) * share);
        }
        for (int i = 0; i < CHAIN_ARMS; i++) {
            gain = lanes1_fma(each[i] * each[i], gain, more[i]);
            at[CHAIN_GAIN * CHAIN_ARMS + i] = gain;
        }
    }
}

/* responses of a piece's arms to a unit force at each: G_ij = G_ii kappa_{i+1} .. kappa_j for i <=
 * j, symmetric */
VEC_INLINE void chain_green(double *at) {
    enum { LAST = CHAIN_ARMS - 1 };
    // loaded from unit + LAST - i, a vector has its 1 in lane i
    static const double unit[2 * CHAIN_ARMS] = {[LAST] = 1};
    const double *kappa = at + CHAIN_KAPPA * CHAIN_ARMS, *gain = at + CHAIN_GAIN * CHAIN_ARMS;
    for (int h = 0; h < CHAIN_ARMS; h += WIDE) {
        // first the effect of arm i on later arms, then the effect of earlier arms on arm i
        wide on[CHAIN_ARMS], way = chain_load(unit + h), here = wide_of(0);
        for (int i = LAST; i > 0; i--) {
            on[i] = wide_of(kappa[i]) * way;
            way = chain_load(unit + LAST - i + 1 + h) + on[i];
        }
        chain_put(at, CHAIN_BEFORE, h, wide_of(kappa[0]) * way);
        for (int i = 0; i < CHAIN_ARMS; i++) {
            here = wide_fma(wide_of(kappa[i]), here,
                            wide_of(gain[i]) * chain_load(unit + LAST - i + h));
            wide column = i < LAST ? wide_fma(wide_of(gain[i]), on[i + 1], here) : here;
            chain_put(at, CHAIN_GREEN + i, h, column);
        }
        chain_put(at, CHAIN_AFTER, h, here);
    }
    double *ends = at + CHAIN_ENDS * CHAIN_ARMS;
    ends[CHAIN_THROUGH] = at[CHAIN_BEFORE * CHAIN_ARMS + LAST];
    ends[CHAIN_BACK] = kappa[0] / gain[0];
}

/* computes the coefficients that depend on the angles alone, arm by arm */
static void chain_coefficients(const struct jets_system *s, const struct chain *chain) {
    for (int a = 0; a < chain->count * CHAIN_ARMS; a += WIDE) {
        int h = a % CHAIN_ARMS;
        double *at = chain_at(chain, a / CHAIN_ARMS);
        wide C = wide_get(s->cosine + a), Z = wide_get(s->sine + a);
        wide C_next = chain_load(s->cosine + a + 1), Z_next = chain_load(s->sine + a + 1);
        wide above = chain_get(at, CHAIN_ABOVE, h), below = chain_get(at, CHAIN_BELOW, h);
        wide part = chain_get(at, CHAIN_PART, h), lean_last = Z * above,
             lean_next = -Z_next * below;
        chain_put(at, CHAIN_SPREAD, h, Z * lean_last);
        chain_put(at, CHAIN_LEAN_NEXT, h, lean_next);
        chain_put(at, CHAIN_LEAN_LAST, h, lean_last);
        chain_put(at, CHAIN_TURN_NEXT, h, lean_next * part);
        chain_put(at, CHAIN_TURN_LAST, h, lean_last * part);
        chain_put(at, CHAIN_SIDE, h, (above + below) * part);
        chain_put(at, CHAIN_SIDE_NEXT, h, -(C_next * below) * part);
        chain_put(at, CHAIN_SIDE_LAST, h, -(C * above) * part);
    }
}

static void chain_prepare(const struct jets_system *s, const struct chain *chain) {
    chain_coefficients(s, chain);
    chain_masses(s, chain);
    chain_gains(s, chain);
    for (int piece = 0; piece < chain->count; piece++) chain_green(chain_at(chain, piece));
}

/* ---- once an order */

/* T and c of an order, or terms of them */
struct chain_sums {
    wide Tr, Ti, cr, ci;
};

VEC_INLINE struct chain_sums chain_sums_get(const double *at, int row, int lane) {
    return (struct chain_sums){chain_get(at, row, lane), chain_get(at, row + 1, lane),
                               chain_get(at, row + 2, lane), chain_get(at, row + 3, lane)};
}

VEC_INLINE void chain_sums_put(double *at, int row, int lane, struct chain_sums x) {
    chain_put(at, row, lane, x.Tr);
    chain_put(at, row + 1, lane, x.Ti);
    chain_put(at, row + 2, lane, x.cr);
    chain_put(at, row + 3, lane, x.ci);
}

/* adds u times a rate and a force; `cross` replaces the force for the real parts of u */
VEC_INLINE void chain_add(struct chain_sums *x, wide ur, wide ui, wide rate, wide force,
                          wide cross) {
    x->Tr = wide_fma(ur, rate, x->Tr);
    x->Ti = wide_fma(ui, rate, x->Ti);
    x->cr = wide_fma(ur, cross, x->cr);
    x->ci = wide_fma(ui, force, x->ci);
}

/* the series of WIDE arms */
struct chain_series {
    const double *re, *im, *rate, *force;
    const double *cross; /* with torques, the imaginary parts of the forces; otherwise the forces */
};

VEC_INLINE struct chain_series chain_series(const struct jets_system *s, int piece, int lane,
                                            int couples) {
    size_t row = (size_t)piece * s->tile + (size_t)lane;
    const double *force = s->force + row, *cross = couples ? s->loads->cross + row : force;
    return (struct chain_series){s->turn_re + row, s->turn_im + row, s->rate + row, force, cross};
}

VEC_INLINE wide chain_order(const double *series, int order) {
    return wide_get(series + order * CHAIN_ARMS);
}

/* adds the product with u_j to the sums of order k, or to those of order k + 1 */
VEC_INLINE void chain_term(const struct chain_series *x, int j, int k, struct chain_sums *sum) {
    chain_add(sum, chain_order(x->re, j), chain_order(x->im, j), chain_order(x->rate, k + 1 - j),
              chain_order(x->force, k - j), chain_order(x->cross, k - j));
}

/* The terms of T and c of orders k and k + 1 without coefficients from order k - 2 on. They are
 * added up during the latency of solving that order and the next. */
VEC_INLINE void chain_old(const struct jets_system *s, const struct chain *chain, int piece, int k,
                          int couples) {
    double *at = chain_at(chain, piece);
    wide zero = wide_of(0);
    for (int h = 0; h < CHAIN_ARMS; h += WIDE) {
        struct chain_series x = chain_series(s, piece, h, couples);
        struct chain_sums now = {zero, zero, zero, zero}, next = now;
        const double *re = x.re + 3 * CHAIN_ARMS, *im = x.im + 3 * CHAIN_ARMS;
        const double *rate = x.rate + (k - 2) * CHAIN_ARMS, *force = x.force + (k - 3) * CHAIN_ARMS;
        const double *cross = x.cross + (k - 3) * CHAIN_ARMS;
        wide w = wide_get(rate), f = wide_get(force), g = couples ? wide_get(cross) : f;
        chain_add(&now, wide_get(re), wide_get(im), w, f, g);
        for (int j = 4; j < k; j++) {
            re += CHAIN_ARMS, im += CHAIN_ARMS, rate -= CHAIN_ARMS, force -= CHAIN_ARMS;
            wide ur = wide_get(re), ui = wide_get(im);
            VEC_PIN(ur);
            VEC_PIN(ui);
            chain_add(&next, ur, ui, w, f, g);
            w = wide_get(rate), f = wide_get(force);
            VEC_PIN(w);
            VEC_PIN(f);
            g = f;
            if (couples) {
                cross -= CHAIN_ARMS;
                g = wide_get(cross);
                VEC_PIN(g);
            }
            chain_add(&now, ur, ui, w, f, g);
        }
        chain_sums_put(at, CHAIN_OLD_TR, h, now);
        chain_sums_put(at, CHAIN_OLDER_TR, h, next);
    }
}

/* T and c of an even order k, and of order k + 1 without the terms that need order k */
VEC_INLINE struct chain_sums chain_even(const struct jets_system *s, double *at, int piece, int h,
                                        int k, int couples) {
    struct chain_series x = chain_series(s, piece, h, couples);
    wide zero = wide_of(0), first = chain_order(x.rate, 0);
    struct chain_sums now = {zero, zero, zero, zero}, next = now;
    if (k < 4) {
        for (int j = 2; j <= k + 1; j++) {
            chain_add(&now, chain_order(x.re, j), chain_order(x.im, j),
                      chain_order(x.rate, k + 1 - j), j <= k ? chain_order(x.force, k - j) : zero,
                      j <= k ? chain_order(x.cross, k - j) : zero);
            chain_term(&x, j, k + 1, &next);
        }
    } else {
        now = chain_sums_get(at, CHAIN_OLD_TR, h);
        next = chain_sums_get(at, CHAIN_OLDER_TR, h);
        chain_term(&x, k, k, &now);
        chain_term(&x, k, k + 1, &next);
        chain_term(&x, 3, k + 1, &next);
        wide ur = chain_order(x.re, k + 1), ui = chain_order(x.im, k + 1);
        now.Tr = wide_fma(ur, first, now.Tr);
        now.Ti = wide_fma(ui, first, now.Ti);
        chain_add(&next, ur, ui, chain_order(x.rate, 1), chain_order(x.force, 0),
                  chain_order(x.cross, 0));
        chain_term(&x, 2, k, &now);
        chain_term(&x, 2, k + 1, &next);
    }
    chain_sums_put(at, CHAIN_NEXT_TR, h, next);
    // u_1 is imaginary
    now.Ti = wide_fma(first, chain_order(x.rate, k), now.Ti);
    if (k) now.ci = wide_fma(first, chain_order(x.force, k - 1), now.ci);
    return now;
}

/* the missing terms of T and c of an odd order k */
VEC_INLINE struct chain_sums chain_odd(const struct jets_system *s, double *at, int piece, int h,
                                       int k) {
    struct chain_series x = chain_series(s, piece, h, 0);
    struct chain_sums now = chain_sums_get(at, CHAIN_NEXT_TR, h);
    wide first = chain_order(x.rate, 0);
    now.Tr = wide_fma(chain_order(x.re, k + 1), first, now.Tr);
    now.Ti = wide_fma(chain_order(x.im, k + 1), first, now.Ti);
    now.Ti = wide_fma(first, chain_order(x.rate, k), now.Ti);
    now.ci = wide_fma(first, chain_order(x.force, k - 1), now.ci);
    return now;
}

VEC_INLINE void chain_known(const struct jets_system *s, const struct chain *chain, int k,
                            int couples) {
    wide share = wide_of(s->share[k]);
    for (int piece = 0; piece < chain->count; piece++) {
        double *at = chain_at(chain, piece);
        size_t row = (size_t)piece * s->tile + (size_t)k * CHAIN_ARMS;
        for (int h = 0; h < CHAIN_ARMS; h += WIDE) {
            struct chain_sums now =
                k % 2 ? chain_odd(s, at, piece, h, k) : chain_even(s, at, piece, h, k, couples);
            chain_put(at, CHAIN_TR, h, now.Tr);
            chain_put(at, CHAIN_TI, h, now.Ti);
            if (!couples) chain_put(at, CHAIN_CR, h, now.cr);
            chain_put(at, CHAIN_S, h,
                      couples ? couples_across(s, row + (size_t)h, k, now.ci - now.cr)
                              : now.ci * share);
        }
    }
}

/* computes the right-hand sides, and their contribution to phi'' without the tensions */
VEC_INLINE void chain_ask(const struct chain *chain) {
    for (int piece = 0; piece < chain->count; piece++) {
        double *at = chain_at(chain, piece);
        for (int h = 0; h < CHAIN_ARMS; h += WIDE) {
            wide S = chain_get(at, CHAIN_S, h), next = chain_next(at, CHAIN_S, h);
            wide last = chain_last(at, CHAIN_S, h);
            wide ask = chain_get(at, CHAIN_PULL, h) * chain_get(at, CHAIN_TI, h);
            ask = wide_fma(chain_get(at, CHAIN_LEAN_NEXT, h), next, ask);
            chain_put(at, CHAIN_ASK, h, wide_fma(chain_get(at, CHAIN_LEAN_LAST, h), last, ask));
            wide known = chain_get(at, CHAIN_SIDE, h) * S;
            known = wide_fma(chain_get(at, CHAIN_SIDE_NEXT, h), next, known);
            chain_put(at, CHAIN_KNOWN, h, wide_fma(chain_get(at, CHAIN_SIDE_LAST, h), last, known));
        }
    }
}

/* the pivot's contribution to the right-hand side of the root */
VEC_INLINE void chain_hang(const struct jets_system *s, const struct chain *chain,
                           struct couples_lift lift) {
    double *at = chain_at(chain, 0), C = s->cosine[0], Z = s->sine[0], across = C * lift.y;
    at[CHAIN_ASK * CHAIN_ARMS] = lanes1_fma(Z, lift.y, at[CHAIN_ASK * CHAIN_ARMS]);
    if (lift.x != 0) {
        at[CHAIN_ASK * CHAIN_ARMS] += C * lift.x;
        across -= Z * lift.x;
    }
    at[CHAIN_KNOWN * CHAIN_ARMS] -= across * at[CHAIN_PART * CHAIN_ARMS];
}

/* solves every piece as if it had no neighbours */
VEC_INLINE void chain_pieces(const struct chain *chain) {
    for (int piece = 0; piece < chain->count; piece++) {
        double *at = chain_at(chain, piece);
        const double *ask = at + CHAIN_ASK * CHAIN_ARMS;
        for (int h = 0; h < CHAIN_ARMS; h += WIDE) {
            wide sum[4];
            for (int i = 0; i < 4; i++)
                sum[i] = chain_get(at, CHAIN_GREEN + i, h) * wide_of(ask[i]);
            for (int i = 0; i < 4; i++)
                sum[i] =
                    wide_fma(chain_get(at, CHAIN_GREEN + 4 + i, h), wide_of(ask[4 + i]), sum[i]);
            chain_put(at, CHAIN_MU, h, (sum[0] + sum[1]) + (sum[2] + sum[3]));
        }
    }
}

/* couples the pieces: two recurrences, one from each end, run side by side */
VEC_INLINE void chain_join(const struct chain *chain) {
    enum { MU = CHAIN_MU * CHAIN_ARMS, ENDS = CHAIN_ENDS * CHAIN_ARMS };
    double before = 0, after = 0;
    for (int piece = 0; piece < chain->count; piece++) {
        double *front = chain_at(chain, piece), *back = chain_at(chain, chain->count - 1 - piece);
        front[ENDS + CHAIN_FROM_BEFORE] = before;
        back[ENDS + CHAIN_FROM_AFTER] = after;
        before = lanes1_fma(front[ENDS + CHAIN_THROUGH], before, front[MU + CHAIN_ARMS - 1]);
        after = lanes1_fma(back[ENDS + CHAIN_THROUGH], after, back[ENDS + CHAIN_BACK] * back[MU]);
    }
}

VEC_INLINE void chain_tensions(const struct chain *chain) {
    for (int piece = 0; piece < chain->count; piece++) {
        double *at = chain_at(chain, piece);
        const double *ends = at + CHAIN_ENDS * CHAIN_ARMS;
        for (int h = 0; h < CHAIN_ARMS; h += WIDE) {
            wide mu = wide_fma(chain_get(at, CHAIN_BEFORE, h), wide_of(ends[CHAIN_FROM_BEFORE]),
                               chain_get(at, CHAIN_MU, h));
            mu = wide_fma(chain_get(at, CHAIN_AFTER, h), wide_of(ends[CHAIN_FROM_AFTER]), mu);
            chain_put(at, CHAIN_MU, h, mu);
        }
    }
}

/* stores the coefficients of order k and computes the next ones of u */
VEC_INLINE void chain_learn(const struct jets_system *s, const struct chain *chain, int k,
                            int couples) {
    wide order = wide_of(k + 1), share = wide_of(s->share[k + 1]);
    for (int piece = 0; piece < chain->count; piece++) {
        const double *at = chain_at(chain, piece);
        size_t row = (size_t)piece * s->tile + (size_t)k * CHAIN_ARMS;
        for (int h = 0; h < CHAIN_ARMS; h += WIDE) {
            wide mu = chain_get(at, CHAIN_MU, h), turned = chain_get(at, CHAIN_KNOWN, h);
            turned =
                wide_fma(chain_get(at, CHAIN_TURN_NEXT, h), chain_next(at, CHAIN_MU, h), turned);
            turned =
                wide_fma(chain_get(at, CHAIN_TURN_LAST, h), chain_last(at, CHAIN_MU, h), turned);
            size_t now = row + (size_t)h, next = now + CHAIN_ARMS, after = next + CHAIN_ARMS;
            wide rate = turned - chain_get(at, CHAIN_TR, h);
            wide_put(s->rate + next, rate);
            if (couples) wide_put(s->loads->spin + piece * CHAIN_ARMS + h, rate);
            wide_put(s->force + now,
                     couples ? mu * order : wide_fma(mu, order, -chain_get(at, CHAIN_CR, h)));
            wide_put(s->turn_re + after, -chain_get(at, CHAIN_TI, h) * share);
            wide_put(s->turn_im + after, turned * share);
        }
    }
}

/* the index of the first piece of a quarter */
VEC_INLINE void chain_quarter(const struct jets_system *s, const struct chain *chain, int quarter,
                              int k, int couples) {
    if (k < 4) return;
    int end = chain->count * (quarter + 1) / 4;
    for (int piece = chain->count * quarter / 4; piece < end; piece++)
        chain_old(s, chain, piece, k, couples);
}

/* solves order k, interleaved with half of the old terms of order `later` */
VEC_INLINE void chain_solve(const struct jets_system *s, const struct chain *chain,
                            struct couples_lift lift, int k, int later, int half, int couples) {
    if (couples) couples_chain_order(s, k);
    chain_known(s, chain, k, couples);
    chain_ask(chain);
    if (lift.y != 0 || lift.x != 0) chain_hang(s, chain, lift);
    chain_pieces(chain);
    chain_join(chain);
    chain_quarter(s, chain, 2 * half, later, couples);
    chain_tensions(chain);
    chain_learn(s, chain, k, couples);
    chain_quarter(s, chain, 2 * half + 1, later, couples);
}

/* all orders: rate_1 .. rate_order and force_0 .. force_{order - 1} from rate_0, cosine and sine */
VEC_INLINE void chain_all(const struct jets_system *s, double gravity, int order, int couples) {
    const struct chain *chain = s->chain;
    chain_prepare(s, chain);
    for (int piece = 0; piece < chain->count; piece++) {
        for (int h = 0; h < CHAIN_ARMS; h += WIDE) {
            size_t row = (size_t)piece * s->tile + (size_t)h;
            wide_put(s->turn_re + row + CHAIN_ARMS, wide_of(0));
            wide_put(s->turn_im + row + CHAIN_ARMS, wide_get(s->rate + row));
        }
    }
    for (int k = 0; k < order; k += 2) {
        int later = k + 2 < order ? k + 2 : 0;
        chain_solve(s, chain, couples_lift(s, gravity, k), k, later, 0, couples);
        if (k + 1 < order)
            chain_solve(s, chain, couples_lift(s, gravity, k + 1), k + 1, later, 1, couples);
    }
}

static void chain_orders(const struct jets_system *s, double gravity, int order) {
    chain_all(s, gravity, order, 0);
}

/* all orders, with torques between the arms */
static void chain_coupled_orders(const struct jets_system *s, double gravity, int order) {
    chain_all(s, gravity, order, 1);
}
