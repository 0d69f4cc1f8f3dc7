/* The tables of a chain of rods, computed once per step: for each piece of eight arms, the response
 * of every arm to a unit on the right-hand side of each.
 * Leaves to others: the orders that multiply by them (rods_template), the choice of chains (rods).
 * Invariant: products and sums of equal sign, except that J' < 0 reduces an arm's own inertia, of
 * which at least an eighth remains.
 *
 * A body with its center on its arm and its children at its tip is equivalent to the masses t = h /
 * l at its tip and M - t at its joint and an inertia J' = J - h l. The equations of an order are
 * those of an ideal chain with these masses, where the force across an arm is s = known - (J' /
 * l^2) w, w the acceleration across it. An arm acts on its neighbours only by its force (mu, s), so
 * that the responses are products of 2 x 2 matrices along the chain; for an ideal chain they are
 * products of numbers.
 *
 * P, the chain below a tip, and H, the chain above a joint, are symmetric forms: force per unit of
 * acceleration. The form at a body's joint, from P at its tip, is
 *     D = J + l^2 P_yy,    D Phi = [ M D + J P_xx + l^2 det P,  J' P_xy;  .,  M I_c + J_t P_yy ],
 *     D det Phi = M I_c (M + P_xx) + J_t (M P_yy + det P),
 * I_c and J_t the inertias about center and tip: all this is linear in (d, d P, d det P), with
 * positive factors except those of P_xy, and needs no division. The form at its tip, from H at its
 * joint, is the same with J and J_t exchanged. */
#pragma once

#include "core/taylor/large/chain_template.h"
#include "core/taylor/large/rods.h"

VEC_INLINE double *rods_at(const struct rods *rods, int piece) {
    return rods->numbers + (size_t)piece * RODS_NUMBERS;
}

/* a row shifted by one arm: the values of the arms' predecessors */
VEC_INLINE wide rods_last(const double *at, int row, int lane) {
    const double *before = lane ? at + lane - WIDE : at - RODS_NUMBERS + CHAIN_ARMS - WIDE;
    return wide_unshift(wide_get(before + row * CHAIN_ARMS), chain_get(at, row, lane));
}

#define RODS_GET(at, name, h) chain_get(at, RODS_##name, h)
#define RODS_PUT(at, name, h, x) chain_put(at, RODS_##name, h, x)
#define RODS_ONE(at, name) (at)[RODS_##name * CHAIN_ARMS]

/* a form in homogeneous coordinates: d, d times the form, and d times its determinant */
struct rods_form {
    double d, xx, xy, yy, n;
};

/* carries a form across an arm, from one end to the other; the arm's numbers begin at `at` */
VEC_INLINE struct rods_form rods_pass(const double *at, double near, double far,
                                      struct rods_form p) {
    double M = RODS_ONE(at, WHOLE), spread = RODS_ONE(at, SPREAD);
    double d = lanes1_fma(near, p.d, p.yy), all = lanes1_fma(M, p.d, p.xx);
    return (struct rods_form){.d = d,
                              .xx = lanes1_fma(M, d, lanes1_fma(near, p.xx, p.n)),
                              .xy = RODS_ONE(at, TWIST) * p.xy,
                              .yy = lanes1_fma(far, p.yy, spread * p.d),
                              .n = lanes1_fma(far, lanes1_fma(M, p.yy, p.n), spread * all)};
}

/* a form rotated by the angle between two arms: into the parent's axes if `way` is 1, into the
 * child's if -1; the child's numbers begin at `at` */
VEC_INLINE struct rods_form rods_turn(const double *at, double way, struct rods_form p) {
    double cc = RODS_ONE(at, SQUARE_C), zz = RODS_ONE(at, SQUARE_Z);
    double mixed = way * RODS_ONE(at, MIXED), twice = mixed + mixed;
    double xx = lanes1_fma(cc, p.xx, lanes1_fma(zz, p.yy, -twice * p.xy));
    double yy = lanes1_fma(zz, p.xx, lanes1_fma(cc, p.yy, twice * p.xy));
    double xy = lanes1_fma(mixed, p.xx - p.yy, RODS_ONE(at, TWICE) * p.xy);
    return (struct rods_form){p.d, xx, xy, yy, p.n};
}

VEC_INLINE struct rods_form rods_scaled(struct rods_form p) {
    double by = chain_scale(p.d + (p.xx + p.yy));
    return (struct rods_form){by * p.d, by * p.xx, by * p.xy, by * p.yy, by * p.n};
}

/* computes the form below each tip, from the last arm on, and the form above each joint, from the
 * first on: side by side, because each recurrence waits for its previous arm */
static void rods_forms(const struct jets_system *s, const struct rods *rods) {
    struct rods_form hung = {.d = 1}, held = {.n = 1};
    for (int i = 0; i < s->n; i++) {
        int k = s->n - 1 - i;
        double *at = rods_at(rods, k / CHAIN_ARMS) + k % CHAIN_ARMS;
        RODS_ONE(at, HUNG_D) = hung.d, RODS_ONE(at, HUNG_XX) = hung.xx;
        RODS_ONE(at, HUNG_XY) = hung.xy, RODS_ONE(at, HUNG_YY) = hung.yy;
        RODS_ONE(at, HUNG_N) = hung.n;
        hung = rods_pass(at, RODS_ONE(at, NEAR), RODS_ONE(at, FAR), hung);
        hung = rods_turn(at, 1, hung);
        if (k % CHAIN_ARMS == 0) hung = rods_scaled(hung);
        at = rods_at(rods, i / CHAIN_ARMS) + i % CHAIN_ARMS;
        if (i) held = rods_turn(at, -1, held);
        if (i && i % CHAIN_ARMS == 0) held = rods_scaled(held);
        RODS_ONE(at, HELD_D) = held.d, RODS_ONE(at, HELD_XX) = held.xx;
        RODS_ONE(at, HELD_XY) = held.xy, RODS_ONE(at, HELD_YY) = held.yy;
        RODS_ONE(at, HELD_N) = held.n;
        held = rods_pass(at, RODS_ONE(at, FAR), RODS_ONE(at, NEAR), held);
    }
}

/* the forms at an arm's ends: P at the tip, divided by its d; H at the joint; determinants */
struct rods_ends {
    wide p, r, q, det, d, hp, hr, hq, hdet;
};

VEC_INLINE struct rods_ends rods_ends(const double *at, int h) {
    wide by = wide_of(1) / (RODS_GET(at, HUNG_D, h) + RODS_GET(at, VOID, h));
    return (struct rods_ends){
        by * RODS_GET(at, HUNG_XX, h), by * RODS_GET(at, HUNG_XY, h), by * RODS_GET(at, HUNG_YY, h),
        by * RODS_GET(at, HUNG_N, h),  RODS_GET(at, HELD_D, h),       RODS_GET(at, HELD_XX, h),
        RODS_GET(at, HELD_XY, h),      RODS_GET(at, HELD_YY, h),      RODS_GET(at, HELD_N, h)};
}

/* the form of an arm with its sub-tree at its joint, times `a` = D / l^2 */
struct rods_whole {
    wide a, line, xx, xy, yy, n;
};

VEC_INLINE struct rods_whole rods_whole(const double *at, int h, const struct rods_ends *e) {
    wide M = RODS_GET(at, WHOLE, h), near = RODS_GET(at, NEAR, h), far = RODS_GET(at, FAR, h);
    wide spread = RODS_GET(at, SPREAD, h), a = near + e->q, line = wide_fma(near, e->p, e->det);
    return (struct rods_whole){.a = a,
                               .line = line,
                               .xx = wide_fma(M, a, line),
                               .xy = RODS_GET(at, TWIST, h) * e->r,
                               .yy = wide_fma(far, e->q, spread),
                               .n = wide_fma(far, wide_fma(M, e->q, e->det), spread * (M + e->p))};
}

/*
 * The responses of arms to their own units. With Q = t + P, B = M - t + H and det over a product of
 * forms at joint and tip (X: D / l^2 times det (Phi + H)), an acceleration r along an arm and a
 * known force s across it give
 *     mu = [det Q det B + J' / l^2 (Q_xx det B + B_xx det Q)] / X r + y s,    w = - y r + det (Q +
 * B) / X s, y = (Q_xy det B + B_xy det Q) / X. */
static void rods_own(double *at, int h, double scale, const struct rods_ends *e,
                     const struct rods_whole *f) {
    wide M = RODS_GET(at, WHOLE, h), t = RODS_GET(at, TIP, h), own = RODS_GET(at, JOINT, h);
    wide X = wide_fma(f->xx, e->hq, RODS_GET(at, VOID, h)), sum = e->p + e->q;
    X = wide_fma(f->yy, e->hp, wide_fma(f->a, e->hdet, X));
    X = wide_fma(e->d, f->n, wide_fma(wide_of(-2) * f->xy, e->hr, X));
    wide all = wide_fma(M, M + sum, e->det);
    all = wide_fma(e->d, all, wide_fma(M + e->p, e->hq, e->hdet));
    all = wide_fma(M + e->q, e->hp, wide_fma(wide_of(-2) * e->r, e->hr, all));
    wide Q = wide_fma(t, t + sum, e->det), joint = own * e->d;
    wide B = wide_fma(own, joint + (e->hp + e->hq), e->hdet), by = wide_of(1) / X;
    wide turned = wide_fma(t + e->p, B, (joint + e->hp) * Q);
    wide line = wide_fma(RODS_GET(at, TWIST, h), turned, Q * B);
    RODS_PUT(at, LINE_LINE, h, line * by * (1 / scale));
    RODS_PUT(at, LINE_SIDE, h, wide_fma(e->r, B, e->hr * Q) * by);
    RODS_PUT(at, SIDE_SIDE, h, all * by * scale);
    // ((1 / Q) + (1 / B)) as symmetric forms: the reaction to the force (mu, s)
    wide part = wide_of(scale) / (Q + RODS_GET(at, VOID, h));
    wide other = wide_of(scale) / (B + RODS_GET(at, VOID, h));
    RODS_PUT(at, BACK_XX, h, wide_fma(t + e->q, part, (joint + e->hq) * other));
    RODS_PUT(at, BACK_XY, h, -wide_fma(e->r, part, e->hr * other));
    RODS_PUT(at, BACK_YY, h, wide_fma(t + e->p, part, (joint + e->hp) * other));
}

/* the response of an arm to the force of its predecessor, whose tip has the mass `tip` */
static void rods_on(const struct jets_system *s, double *at, int h, int k, double scale,
                    const struct rods_ends *e, const struct rods_whole *f) {
    wide M = RODS_GET(at, WHOLE, h), t = RODS_GET(at, TIP, h), spread = RODS_GET(at, SPREAD, h);
    wide tip = rods_last(at, RODS_TIP, h), node = RODS_GET(at, NODE, h);
    wide by = wide_fma(tip, wide_fma(tip, f->a, f->xx + f->yy), f->n);
    by = wide_of(1) / (by + RODS_GET(at, VOID, h));
    wide line = wide_fma(t, f->a, f->line);
    wide more = wide_fma(RODS_GET(at, FAR, h), wide_fma(e->q, t, e->det), spread * (t + e->p));
    wide xx = wide_fma(tip, line, more) * by, xy = f->xy * node * by;
    wide yx = -(e->r * node) * by * scale;
    wide yy = wide_fma(t + e->q, tip + M, wide_fma(t, e->p, e->det)) * by * -scale;
    wide C = wide_get(s->cosine + k), Z = wide_get(s->sine + k);
    RODS_PUT(at, ON_XX, h, wide_fma(xx, C, -(xy * Z)));
    RODS_PUT(at, ON_XY, h, wide_fma(xx, Z, xy * C));
    RODS_PUT(at, ON_YX, h, wide_fma(yx, C, -(yy * Z)));
    RODS_PUT(at, ON_YY, h, wide_fma(yx, Z, yy * C));
}

static void rods_coefficients(const struct jets_system *s, const struct rods *rods) {
    for (int k = 0; k < rods->count * CHAIN_ARMS; k += WIDE) {
        double *at = rods_at(rods, k / CHAIN_ARMS);
        int h = k % CHAIN_ARMS;
        struct rods_ends ends = rods_ends(at, h);
        struct rods_whole whole = rods_whole(at, h, &ends);
        rods_own(at, h, rods->scale, &ends, &whole);
        rods_on(s, at, h, k, rods->scale, &ends, &whole);
    }
    // the pivot is not an arm and exerts no such force
    double *at = rods_at(rods, 0);
    RODS_ONE(at, ON_XX) = RODS_ONE(at, ON_XY) = RODS_ONE(at, ON_YX) = RODS_ONE(at, ON_YY) = 0;
}

/* Matrices of arm i of a piece: its response to its own units; E, its force (mu, s) per unit; and
 * the effects of its predecessor's force, K on its response and F on its force. */
struct rods_one {
    wide ll, ls, ss, e_yx, e_yy, k_xx, k_xy, k_yx, k_yy, f_yx, f_yy, resist;
};

VEC_INLINE struct rods_one rods_one(const double *at, int i) {
    const double *x = at + i;
    double resist = RODS_ONE(x, RESIST), ls = RODS_ONE(x, LINE_SIDE), yx = RODS_ONE(x, ON_YX);
    double ss = RODS_ONE(x, SIDE_SIDE), yy = RODS_ONE(x, ON_YY);
    return (struct rods_one){wide_of(RODS_ONE(x, LINE_LINE)),
                             wide_of(ls),
                             wide_of(ss),
                             wide_of(resist * ls),
                             wide_of(1 - resist * ss),
                             wide_of(RODS_ONE(x, ON_XX)),
                             wide_of(RODS_ONE(x, ON_XY)),
                             wide_of(yx),
                             wide_of(yy),
                             wide_of(-resist * yx),
                             wide_of(-resist * yy),
                             wide_of(resist)};
}

/* a 2 x 2 matrix in each lane */
struct rods_four {
    wide xx, xy, yx, yy;
};

VEC_INLINE double *rods_green(double *at, int i, int table, int h) {
    return at + (RODS_GREEN + table * CHAIN_ARMS + i) * CHAIN_ARMS + h;
}

/* By reciprocity, the responses of arms to units at later arms are, up to signs, the responses of
 * the later arms to units at the earlier ones. This computes, along the chain from the first arm,
 * the responses of arm i to units at arms up to i. */
VEC_INLINE void rods_outward(double *at, int h) {
    enum { LAST = CHAIN_ARMS - 1 };
    static const double unit[2 * CHAIN_ARMS] = {[LAST] = 1};
    wide zero = wide_of(0);
    // the force of arm i, along and across, per unit of both right-hand sides
    struct rods_four force = {zero, zero, zero, zero};
    for (int i = 0; i < CHAIN_ARMS; i++) {
        struct rods_one x = rods_one(at, i);
        wide here = chain_load(unit + LAST - i + h);
        wide line_asked = wide_fma(x.k_xx, force.xx, x.k_xy * force.yx);
        wide line_known = wide_fma(x.k_xx, force.xy, x.k_xy * force.yy);
        wide way_asked = wide_fma(x.k_yx, force.xx, x.k_yy * force.yx);
        wide way_known = wide_fma(x.k_yx, force.xy, x.k_yy * force.yy);
        line_asked = wide_fma(here, x.ll, line_asked);
        wide_put(rods_green(at, i, 0, h), line_asked);
        wide_put(rods_green(at, i, 1, h), wide_fma(here, x.ls, -way_asked));
        wide_put(rods_green(at, i, 2, h), wide_fma(-here, x.ls, -line_known));
        line_known = wide_fma(here, x.ls, line_known);
        way_asked = wide_fma(-here, x.ls, way_asked);
        way_known = wide_fma(here, x.ss, way_known);
        wide_put(rods_green(at, i, 3, h), way_known);
        force.xx = line_asked, force.xy = line_known;
        force.yx = -x.resist * way_asked;
        force.yy = wide_fma(-x.resist, way_known, here);
    }
}

VEC_INLINE void rods_green_add(double *at, int i, int table, int h, wide x) {
    double *to = rods_green(at, i, table, h);
    wide_put(to, wide_get(to) + x);
}

/* computes the responses of the arms after i to units at arm i, and of all arms to values from the
 * piece before */
VEC_INLINE void rods_inward(double *at, int h) {
    enum { LAST = CHAIN_ARMS - 1 };
    static const double unit[2 * CHAIN_ARMS] = {[LAST] = 1};
    wide zero = wide_of(0);
    struct rods_four way = {zero, zero, zero, zero}; // per unit of the force of arm i
    for (int i = LAST; i >= 0; i--) {
        struct rods_one x = rods_one(at, i);
        if (i < LAST) {
            rods_green_add(at, i, 0, h, wide_fma(way.xx, x.ll, way.xy * x.e_yx));
            rods_green_add(at, i, 1, h, wide_fma(way.xx, x.ls, way.xy * x.e_yy));
            rods_green_add(at, i, 2, h, wide_fma(way.yx, x.ll, way.yy * x.e_yx));
            rods_green_add(at, i, 3, h, wide_fma(way.yx, x.ls, way.yy * x.e_yy));
        }
        wide here = chain_load(unit + LAST - i + h);
        struct rods_four last = way;
        way.xx = wide_fma(last.xx, x.k_xx, wide_fma(last.xy, x.f_yx, here * x.k_xx));
        way.xy = wide_fma(last.xx, x.k_xy, wide_fma(last.xy, x.f_yy, here * x.k_xy));
        way.yx = wide_fma(last.yx, x.k_xx, wide_fma(last.yy, x.f_yx, here * x.k_yx));
        way.yy = wide_fma(last.yx, x.k_xy, wide_fma(last.yy, x.f_yy, here * x.k_yy));
    }
    RODS_PUT(at, BEFORE_XX, h, way.xx);
    RODS_PUT(at, BEFORE_XY, h, way.xy);
    RODS_PUT(at, BEFORE_YX, h, way.yx);
    RODS_PUT(at, BEFORE_YY, h, way.yy);
    // values from the piece after act like a right-hand side of the last arm
    wide resist = wide_of((at + LAST)[RODS_RESIST * CHAIN_ARMS]);
    wide end = chain_load(unit + h);
    RODS_PUT(at, AFTER_XX, h, wide_get(rods_green(at, LAST, 0, h)));
    RODS_PUT(at, AFTER_XY, h, resist * wide_get(rods_green(at, LAST, 1, h)));
    RODS_PUT(at, AFTER_YX, h, wide_get(rods_green(at, LAST, 2, h)));
    RODS_PUT(at, AFTER_YY, h, wide_fma(resist, wide_get(rods_green(at, LAST, 3, h)), -end));
}

/* computes the coupling of a piece with its neighbours */
static void rods_bounds(double *at) {
    enum { LAST = CHAIN_ARMS - 1 };
    double *ends = at + RODS_ENDS * CHAIN_ARMS, *through = ends + RODS_THROUGH;
    double *back = ends + RODS_BACK, turn = -(at + LAST)[RODS_RESIST * CHAIN_ARMS];
    through[0] = (at + LAST)[RODS_BEFORE_XX * CHAIN_ARMS];
    through[1] = (at + LAST)[RODS_BEFORE_XY * CHAIN_ARMS];
    through[2] = turn * (at + LAST)[RODS_BEFORE_YX * CHAIN_ARMS];
    through[3] = turn * (at + LAST)[RODS_BEFORE_YY * CHAIN_ARMS];
    double resist = RODS_ONE(at, RESIST), xx = RODS_ONE(at, BACK_XX), xy = RODS_ONE(at, BACK_XY);
    double yx = -resist * xy, yy = -lanes1_fma(resist, RODS_ONE(at, BACK_YY), 1);
    back[0] = lanes1_fma(RODS_ONE(at, ON_XX), xx, RODS_ONE(at, ON_YX) * yx);
    back[1] = lanes1_fma(RODS_ONE(at, ON_XX), xy, RODS_ONE(at, ON_YX) * yy);
    back[2] = lanes1_fma(RODS_ONE(at, ON_XY), xx, RODS_ONE(at, ON_YY) * yx);
    back[3] = lanes1_fma(RODS_ONE(at, ON_XY), xy, RODS_ONE(at, ON_YY) * yy);
}

/* computes the products of cosines and sines that rotate forms */
static void rods_angles(const struct jets_system *s, const struct rods *rods) {
    for (int k = 0; k < rods->count * CHAIN_ARMS; k += WIDE) {
        double *at = rods_at(rods, k / CHAIN_ARMS);
        wide C = wide_get(s->cosine + k), Z = wide_get(s->sine + k);
        int h = k % CHAIN_ARMS;
        RODS_PUT(at, SQUARE_C, h, C * C);
        RODS_PUT(at, SQUARE_Z, h, Z * Z);
        RODS_PUT(at, MIXED, h, C * Z);
        RODS_PUT(at, TWICE, h, (C - Z) * (C + Z));
    }
}

static void rods_prepare(const struct jets_system *s, const struct rods *rods) {
    rods_angles(s, rods);
    rods_forms(s, rods);
    rods_coefficients(s, rods);
    for (int piece = 0; piece < rods->count; piece++) {
        double *at = rods_at(rods, piece);
        for (int h = 0; h < CHAIN_ARMS; h += WIDE) {
            rods_outward(at, h);
            rods_inward(at, h);
        }
        rods_bounds(at);
    }
}
