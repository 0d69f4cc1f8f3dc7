/* Torques between the arms of a tree of more than eight arms, order by order: what springs,
 * friction and drives make of the angles and rates of an order, as forces across the arms; what the
 * pivot's motion is in an order; the forces along the arms, and the power of all. Leaves to others:
 * the orders themselves (chain_template, blocks_template, levels_template), the derivation
 * (small_loads_template), where arms sit (jets_loads). Invariant: one pass over the seats an order,
 * the same for every cutting. Ideal trees have none of it: `couples` is known where the orders are
 * compiled. */
#ifndef PEND_COUPLES_TEMPLATE_H
#define PEND_COUPLES_TEMPLATE_H

#include "core/simd/vec8_template.h"
#include "core/taylor/loads_template.h"

enum { COUPLES_ARMS = 8 };

/* ---- once a step */

VEC_INLINE int couples_seat(const struct jets_loads *loads, int k) {
    return loads->seat ? loads->seat[k] : k;
}

/* the drives' torques, all orders */
static void couples_motors(const struct jets_system *s, const struct loads_moment *now, int order) {
    const struct jets_loads *loads = s->loads;
    double square = now->unit * now->unit;
    for (int a = 0; a < loads->seats; a += COUPLES_ARMS)
        memset(loads->motor + jets_row(s, a), 0, (size_t)order * COUPLES_ARMS * sizeof(double));
    for (int i = 0; i < loads->terms->harmonics; i++) {
        const struct pend_harmonic *harmonic = &loads->terms->harmonic[i];
        double torque[LOADS_ORDERS] = {0};
        if (harmonic->drives < 0) continue;
        loads_harmonic(s, loads->value + harmonic->at, now, 0, order, torque);
        double *to = loads->motor + jets_row(s, couples_seat(loads, harmonic->drives));
        for (int k = 0; k < order; k++) to[k * COUPLES_ARMS] += square * torque[k];
    }
}

/* what is known before the first order; rates of order 0 are there */
static void couples_begin(const struct jets_system *s, const struct loads_moment *now, int order) {
    const struct jets_loads *loads = s->loads;
    const struct pend_terms *terms = loads->terms;
    const double *value = loads->value;
    double unit = now->unit, square = unit * unit;
    for (int k = 0; k < s->n; k++) {
        int at = couples_seat(loads, k);
        double stiff = square * pend_terms_get(terms, value, PEND_TERM_STIFFNESS, k);
        double bend = loads->springs ? loads->bend[k] : 0;
        loads->hold[at] = unit * pend_terms_get(terms, value, PEND_TERM_DAMPING, k);
        loads->stiff[at] = stiff;
        loads->fixed[at] = square * pend_terms_get(terms, value, PEND_TERM_TORQUE, k) -
                           stiff * (bend - pend_terms_get(terms, value, PEND_TERM_REST, k));
    }
    for (int a = 0; a < loads->seats; a += WIDE)
        wide_put(loads->spin + a, wide_get(s->rate + jets_row(s, a)));
    if (loads->drives) couples_motors(s, now, order);
}

/* ---- once an order */

/* numbers at the parents or first children of the seats from a on */
VEC_INLINE wide couples_beside(const double *at, int near, const int *seats, int a) {
    if (near != LOADS_APART) return wide_load(at + near + a % COUPLES_ARMS);
    return wide_gather(at, seats + a);
}

/* the torques of order k between arms and what carries them, from the rates in `spin` */
VEC_INLINE void couples_torques(const struct jets_system *s, int k) {
    const struct jets_loads *loads = s->loads;
    for (int a = 0; a < loads->seats; a += WIDE) {
        size_t row = jets_row(s, a) + (size_t)k * COUPLES_ARMS;
        int near = loads->near[a / COUPLES_ARMS].parent;
        wide slip = wide_get(loads->spin + a) - couples_beside(loads->spin, near, loads->parent, a);
        wide torque = wide_get(loads->fixed + a);
        wide_put(loads->slip + row, slip);
        if (k)
            torque = wide_get(loads->stiff + a) *
                     (wide_of(-s->share[k - 1]) * wide_get(loads->slip + row - COUPLES_ARMS));
        torque -= wide_get(loads->hold + a) * slip;
        if (loads->drives) torque += wide_get(loads->motor + row);
        wide_put(loads->torque + a, torque);
    }
}

/* the forces across of order k times the lengths go to `bent` */
static void couples_order(const struct jets_system *s, int k) {
    const struct jets_loads *loads = s->loads;
    couples_torques(s, k);
    for (int a = 0; a < loads->seats; a += WIDE) {
        int near = loads->near[a / COUPLES_ARMS].child;
        wide_put(loads->bent + a, wide_get(loads->torque + a) -
                                      couples_beside(loads->torque, near, loads->child, a));
    }
    for (int i = 0; i < loads->kids; i++)
        loads->bent[loads->kid[i].parent] -= loads->torque[loads->kid[i].child];
}

/*
 * The known force across over the order, from what the convolutions say of it (`ci`, less their
 * real parts); its series is kept.
 */
VEC_INLINE wide couples_across(const struct jets_system *s, int a, int k, wide ci) {
    const struct jets_loads *loads = s->loads;
    wide cross = wide_fma(wide_get(loads->bent + a), wide_get(loads->part + a), ci);
    wide_put(loads->cross + jets_row(s, a) + (size_t)k * COUPLES_ARMS, cross);
    return cross * wide_of(s->share[k]);
}

/* what order k finds at the pivot: its acceleration over the order, gravity included */
struct couples_lift {
    double x, y;
};

VEC_INLINE struct couples_lift couples_lift(const struct jets_system *s, double gravity, int k) {
    const struct jets_loads *loads = s->loads;
    if (!loads) return (struct couples_lift){0, k ? 0 : gravity};
    if (k && !loads->moves) return (struct couples_lift){0, 0};
    return (struct couples_lift){loads->lift_x[k] * s->share[k], loads->lift_y[k] * s->share[k]};
}

/* ---- behind the orders */

/* lambda from F: Re (conj(u) F), from the highest order down, in place */
static void couples_along(const struct jets_system *s, int order) {
    for (int a = 0; a < s->loads->seats; a += WIDE) {
        size_t row = jets_row(s, a);
        const double *re = s->turn_re + row, *im = s->turn_im + row, *cross = s->loads->cross + row;
        double *force = s->force + row;
        wide first = wide_get(s->rate + row);
        for (int k = order - 1; k > 0; k--) {
            wide sum = wide_get(force + k * COUPLES_ARMS), less = wide_of(0);
            sum = wide_fma(first, wide_get(cross + (k - 1) * COUPLES_ARMS), sum);
            for (int j = 2; j <= k; j++) {
                size_t back = (size_t)(k - j) * COUPLES_ARMS;
                sum = wide_fma(wide_get(im + j * COUPLES_ARMS), wide_get(cross + back), sum);
                less = wide_fma(wide_get(re + j * COUPLES_ARMS), wide_get(force + back), less);
            }
            wide_put(force + k * COUPLES_ARMS, sum + less);
        }
    }
}

/* the force that the pivot exerts, along the first arm's axes */
static void couples_haul(const struct jets_system *s, int order) {
    const struct jets_loads *loads = s->loads;
    size_t row = jets_row(s, couples_seat(loads, 0));
    for (int k = 0; k < order; k++) {
        size_t now = row + (size_t)k * COUPLES_ARMS;
        double x = s->force[now], y = loads->couples ? loads->cross[now] : 0;
        for (int j = 1; j <= k && !loads->couples; j++) {
            double lambda = s->force[now - (size_t)j * COUPLES_ARMS];
            x += s->turn_re[row + (size_t)j * COUPLES_ARMS] * lambda;
            y += s->turn_im[row + (size_t)j * COUPLES_ARMS] * lambda;
        }
        loads->haul_x[k] = x;
        loads->haul_y[k] = y;
    }
}

/* adds the sum over the arms of a factor, or of 1, times rates relative to the parent times a
 * series in tiles; orders below `order` */
static void couples_product(const struct jets_system *s, const double *factor, const double *with,
                            int order, double *sum) {
    wide all[LOADS_ORDERS][COUPLES_ARMS / WIDE];
    memset(all, 0, sizeof all);
    for (int a = 0; a < s->loads->seats; a += WIDE) {
        size_t row = jets_row(s, a);
        const double *slip = s->loads->slip + row, *other = with + row;
        wide size = factor ? wide_get(factor + a) : wide_of(1);
        for (int k = 0; k < order; k++) {
            wide part = wide_of(0);
            for (int j = 0; j <= k; j++)
                part = wide_fma(wide_get(other + j * COUPLES_ARMS),
                                wide_get(slip + (k - j) * COUPLES_ARMS), part);
            wide *to = &all[k][a % COUPLES_ARMS / WIDE];
            *to = wide_fma(size, part, *to);
        }
    }
    for (int k = 0; k < order; k++)
        for (int i = 0; i < COUPLES_ARMS; i++) sum[k] += all[k][i / WIDE][i % WIDE];
}

/* the constant torques' power */
static void couples_constant(const struct jets_system *s, int order, double *sum) {
    const struct jets_loads *loads = s->loads;
    double square = loads->unit * loads->unit;
    for (int a = 0; a < s->n; a++) {
        size_t row = jets_row(s, couples_seat(loads, a));
        double torque = square * pend_terms_get(loads->terms, loads->value, PEND_TERM_TORQUE, a);
        for (int k = 0; k < order; k++)
            sum[k] += torque * loads->slip[row + (size_t)k * COUPLES_ARMS];
    }
}

static void couples_power(const struct jets_system *s, int order, double *work, double *heat) {
    const struct jets_loads *loads = s->loads;
    if (loads->losses) couples_product(s, loads->hold, loads->slip, order, heat);
    if (loads->drives) couples_product(s, NULL, loads->motor, order, work);
    if (loads->terms->row[PEND_TERM_TORQUE] >= 0) couples_constant(s, order, work);
    if (loads->moves) loads_haul(s, order, work);
}

#endif
