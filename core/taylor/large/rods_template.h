/* The orders of one chain of rods: forces from two matrix products per piece of eight arms, for all
 * pieces at once.
 * Leaves to others: the tables (rods_table_template), the sums of an order (chain_template),
 * torques between the arms (couples_template), the choice of chains (rods). Invariant: an order has
 * no sweep from arm to arm.
 *
 * The series F = f u in fixed axes replace lambda, as in small_loads_template. F are the forces of
 * massless arms with points at their tips and an inertia J': (mu, s) of an order are its real and
 * imaginary parts, and s_k = tau_k / l + (J' / l) (k + 1) Re T_k - (J' / l^2) w_k - sum_{j>=1} (Re
 * u_j Im F_{k-j} - Im u_j Re F_{k-j}). The force at an arm's tip is F minus (t - m) times the
 * acceleration of the tip, m the point mass there; that at its joint is F plus (M - t) times the
 * acceleration of the joint. */
#pragma once

#include "core/taylor/large/rods_table_template.h"

/* computes T and c of order k, the accelerations required along the arms, and the known forces
 * across them */
VEC_INLINE void rods_known(const struct jets_system *s, const struct rods *rods, int k,
                           int torques) {
    wide share = wide_of(s->share[k]);
    for (int piece = 0; piece < rods->count; piece++) {
        double *own = rods_at(rods, piece), *at = chain_at(s->chain, piece);
        const double *cross = s->loads->cross + (size_t)piece * s->tile + (size_t)k * CHAIN_ARMS;
        for (int h = 0; h < CHAIN_ARMS; h += WIDE) {
            struct chain_sums now =
                k % 2 ? chain_odd(s, at, piece, h, k) : chain_even(s, at, piece, h, k, 1);
            wide known = now.ci - now.cr;
            if (torques) known += wide_get(cross + h);
            chain_put(at, CHAIN_TR, h, now.Tr);
            chain_put(at, CHAIN_TI, h, now.Ti);
            RODS_PUT(own, ASK, h, chain_get(at, CHAIN_PULL, h) * now.Ti);
            RODS_PUT(own, KNOWN, h, wide_fma(RODS_GET(own, WIND, h), now.Tr, known * share));
        }
    }
}

/* the pivot's acceleration in the axes of the first arm */
struct rods_lift {
    double along, across;
};

/* the pivot's contribution to the right-hand side of the root */
VEC_INLINE struct rods_lift rods_hang(const struct jets_system *s, const struct rods *rods,
                                      struct couples_lift lift) {
    double *at = rods_at(rods, 0), C = s->cosine[0], Z = s->sine[0];
    struct rods_lift x = {lanes1_fma(C, lift.x, Z * lift.y), lanes1_fma(C, lift.y, -(Z * lift.x))};
    RODS_ONE(at, ASK) += x.along;
    RODS_ONE(at, KNOWN) = lanes1_fma(RODS_ONE(at, RESIST), x.across, RODS_ONE(at, KNOWN));
    return x;
}

/* solves every piece as if it had no neighbours */
VEC_INLINE void rods_pieces(const struct rods *rods) {
    for (int piece = 0; piece < rods->count; piece++) {
        double *at = rods_at(rods, piece);
        const double *ask = at + RODS_ASK * CHAIN_ARMS, *known = at + RODS_KNOWN * CHAIN_ARMS;
        for (int h = 0; h < CHAIN_ARMS; h += WIDE) {
            wide zero = wide_of(0), mu[2] = {zero, zero}, way[2] = {zero, zero};
            for (int i = 0; i < CHAIN_ARMS; i++) {
                wide r = wide_of(ask[i]), f = wide_of(known[i]);
                mu[0] = wide_fma(wide_get(rods_green(at, i, 0, h)), r, mu[0]);
                mu[1] = wide_fma(wide_get(rods_green(at, i, 1, h)), f, mu[1]);
                way[0] = wide_fma(wide_get(rods_green(at, i, 2, h)), r, way[0]);
                way[1] = wide_fma(wide_get(rods_green(at, i, 3, h)), f, way[1]);
            }
            RODS_PUT(at, MU, h, mu[0] + mu[1]);
            RODS_PUT(at, WAY, h, way[0] + way[1]);
        }
    }
}

/* two numbers passed between pieces */
struct rods_pair {
    double x, y;
};

/* the force of an arm, as if its piece had no neighbours */
VEC_INLINE struct rods_pair rods_force(const double *at) {
    return (struct rods_pair){RODS_ONE(at, MU), lanes1_fma(-RODS_ONE(at, RESIST), RODS_ONE(at, WAY),
                                                           RODS_ONE(at, KNOWN))};
}

/* a b + c d + e */
VEC_INLINE double rods_two(double a, double b, double c, double d, double e) {
    return lanes1_fma(a, b, lanes1_fma(c, d, e));
}

/* couples the pieces: two recurrences, one from each end, run side by side */
VEC_INLINE void rods_join(const struct rods *rods) {
    struct rods_pair before = {0, 0}, after = {0, 0}, last, first, f;
    for (int piece = 0; piece < rods->count; piece++) {
        double *front = rods_at(rods, piece), *back = rods_at(rods, rods->count - 1 - piece);
        double *ends = front + RODS_ENDS * CHAIN_ARMS;
        const double *m = ends + RODS_THROUGH;
        ends[RODS_FROM_BEFORE] = before.x, ends[RODS_FROM_BEFORE + 1] = before.y;
        f = rods_force(front + CHAIN_ARMS - 1);
        last.x = rods_two(m[0], before.x, m[1], before.y, f.x);
        last.y = rods_two(m[2], before.x, m[3], before.y, f.y);
        ends = back + RODS_ENDS * CHAIN_ARMS;
        m = ends + RODS_THROUGH;
        const double *b = ends + RODS_BACK;
        ends[RODS_FROM_AFTER] = after.x, ends[RODS_FROM_AFTER + 1] = after.y;
        f = rods_force(back);
        first.x = rods_two(m[0], after.x, m[2], after.y, rods_two(b[0], f.x, b[1], f.y, 0));
        first.y = rods_two(m[1], after.x, m[3], after.y, rods_two(b[2], f.x, b[3], f.y, 0));
        before = last, after = first;
    }
}

/* stores the coefficients of order k and computes the next ones of u */
VEC_INLINE void rods_learn(const struct jets_system *s, const struct rods *rods, int k,
                           double across, int torques) {
    wide order = wide_of(k + 1), share = wide_of(s->share[k + 1]);
    for (int piece = 0; piece < rods->count; piece++) {
        const double *own = rods_at(rods, piece), *at = chain_at(s->chain, piece);
        const double *from = own + RODS_ENDS * CHAIN_ARMS + RODS_FROM_BEFORE;
        wide b_x = wide_of(from[0]), b_y = wide_of(from[1]);
        wide a_x = wide_of(from[2]), a_y = wide_of(from[3]);
        size_t row = (size_t)piece * s->tile + (size_t)k * CHAIN_ARMS;
        for (int h = 0; h < CHAIN_ARMS; h += WIDE) {
            wide mu = wide_fma(RODS_GET(own, BEFORE_XX, h), b_x, RODS_GET(own, MU, h));
            wide way = wide_fma(RODS_GET(own, BEFORE_YX, h), b_x, RODS_GET(own, WAY, h));
            wide mu_y = RODS_GET(own, BEFORE_XY, h) * b_y,
                 way_y = RODS_GET(own, BEFORE_YY, h) * b_y;
            mu = wide_fma(RODS_GET(own, AFTER_XX, h), a_x, mu);
            way = wide_fma(RODS_GET(own, AFTER_YX, h), a_x, way);
            mu += wide_fma(RODS_GET(own, AFTER_XY, h), a_y, mu_y);
            way += wide_fma(RODS_GET(own, AFTER_YY, h), a_y, way_y);
            wide side = wide_fma(-RODS_GET(own, RESIST, h), way, RODS_GET(own, KNOWN, h));
            if (piece + h == 0) way[0] -= across;
            size_t now = row + (size_t)h, next = now + CHAIN_ARMS, after = next + CHAIN_ARMS;
            wide turned = way * chain_get(at, CHAIN_PART, h);
            wide rate = turned - chain_get(at, CHAIN_TR, h);
            wide_put(s->rate + next, rate);
            if (torques) wide_put(s->loads->spin + piece * CHAIN_ARMS + h, rate);
            wide_put(s->force + now, mu * order);
            wide_put(s->loads->cross + now, side * order);
            wide_put(s->turn_re + after, -chain_get(at, CHAIN_TI, h) * share);
            wide_put(s->turn_im + after, turned * share);
        }
    }
}

/* solves order k; in between adds half of those terms of order `later` that lower orders give */
VEC_INLINE void rods_solve(const struct jets_system *s, double gravity, int k, int later, int half,
                           int torques) {
    const struct rods *rods = s->rods;
    struct couples_lift lift = couples_lift(s, gravity, k);
    struct rods_lift hang = {0, 0};
    if (torques) couples_chain_order(s, k);
    rods_known(s, rods, k, torques);
    if (lift.y != 0 || lift.x != 0) hang = rods_hang(s, rods, lift);
    rods_pieces(rods);
    rods_join(rods);
    chain_quarter(s, s->chain, 2 * half, later, 1);
    rods_learn(s, rods, k, hang.across, torques);
    chain_quarter(s, s->chain, 2 * half + 1, later, 1);
}

/* all orders of rates, turns and F from rate_0, cosine and sine */
VEC_INLINE void rods_all(const struct jets_system *s, double gravity, int order, int torques) {
    const struct rods *rods = s->rods;
    assert(rods && s->chain && rods->count == s->chain->count && rods->count == s->tiles);
    rods_prepare(s, rods);
    for (int piece = 0; piece < rods->count; piece++) {
        for (int h = 0; h < CHAIN_ARMS; h += WIDE) {
            size_t row = (size_t)piece * s->tile + (size_t)h;
            wide_put(s->turn_re + row + CHAIN_ARMS, wide_of(0));
            wide_put(s->turn_im + row + CHAIN_ARMS, wide_get(s->rate + row));
        }
    }
    for (int k = 0; k < order; k += 2) {
        int later = k + 2 < order ? k + 2 : 0;
        rods_solve(s, gravity, k, later, 0, torques);
        if (k + 1 < order) rods_solve(s, gravity, k + 1, later, 1, torques);
    }
}

/* in place, for orders from `first` to below `order`: the forces at the tips from F */
static void rods_tips(const struct jets_system *s, int first, int order) {
    const struct rods *rods = s->rods;
    for (int k = first; k < order; k++) {
        for (int piece = 0; piece < rods->count; piece++) {
            const double *own = rods_at(rods, piece);
            size_t row = (size_t)piece * s->tile + (size_t)k * CHAIN_ARMS, next = row + s->tile;
            int last = piece + 1 == rods->count;
            for (int h = 0; h < CHAIN_ARMS; h += WIDE) {
                size_t now = row + (size_t)h, after = h + WIDE < CHAIN_ARMS ? now + WIDE : next;
                wide re = wide_get(s->force + now), im = wide_get(s->loads->cross + now);
                int end = last && h + WIDE == CHAIN_ARMS, a = piece * CHAIN_ARMS + h + 1;
                wide zero = wide_of(0), share = RODS_GET(own, SHARE, h);
                wide x = wide_shift(re, end ? zero : wide_get(s->force + after));
                wide y = wide_shift(im, end ? zero : wide_get(s->loads->cross + after));
                wide C = wide_load(s->cosine + a), Z = wide_load(s->sine + a);
                wide_put(s->force + now, re - share * (re - (C * x - Z * y)));
                wide_put(s->loads->cross + now, im - share * (im - wide_fma(Z, x, C * y)));
            }
        }
    }
}

/* the force that the pivot exerts, along the first arm's axes */
static void rods_haul(const struct jets_system *s, int order) {
    const struct jets_loads *loads = s->loads;
    double own = RODS_ONE(rods_at(s->rods, 0), JOINT) / s->rods->scale;
    double C = s->cosine[0], Z = s->sine[0];
    for (int k = 0; k < order; k++) {
        size_t at = (size_t)k * CHAIN_ARMS;
        double x = loads->lift_x[k], y = loads->lift_y[k];
        loads->pivot_force_x[k] = s->force[at] + own * (C * x + Z * y);
        loads->pivot_force_y[k] = loads->cross[at] + own * (C * y - Z * x);
    }
}

static void rods_orders(const struct jets_system *s, double gravity, int order) {
    rods_all(s, gravity, order, 0);
}

/* all orders, with torques between the arms */
static void rods_coupled_orders(const struct jets_system *s, double gravity, int order) {
    rods_all(s, gravity, order, 1);
}
