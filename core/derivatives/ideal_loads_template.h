/* Additions for real pendulums with a known motion: the forces along and across arms, the
 * factorization for bodies, torques in the joints.
 * Leaves to others: the choice of pendulums (ideal_loads), point masses (ideal_known_template,
 * which includes this).
 * Invariant: this file contains no product of two series of derivatives. */
#pragma once

#include "core/derivatives/ideal_system.h"
#include "core/simd/vec8_template.h"

/* ---- the motion's forces */

/* the forces that arms exert on their tips, in the frames of the arms at the start */
static void ideal_hauls(const struct ideal_known *s) {
    for (int k = s->n - 1; k >= 0; k--) {
        double m = s->system.mass[k];
        for (int j = 0; j < s->order; j++) {
            size_t at = ideal_place(s, k, j);
            s->pivot_force_re[at] = m * s->acc_re[at];
            s->pivot_force_im[at] = m * s->acc_im[at];
        }
        for (int c = k + 1; c < s->system.end[k]; c = s->system.end[c]) {
            double C = s->system.cosine[c], Z = s->system.sine[c];
            for (int j = 0; j < s->order; j++) {
                size_t at = ideal_place(s, k, j), from = ideal_place(s, c, j);
                double re = s->pivot_force_re[from], im = s->pivot_force_im[from];
                s->pivot_force_re[at] += C * re - Z * im;
                s->pivot_force_im[at] += Z * re + C * im;
            }
        }
    }
}

/* Computes Re (F u*) or Im (F u*) for the lanes from `from` on, two orders at once. F is given as
 * (re, im) to get Re, and as (im, -re) to get Im. */
VEC_INLINE void ideal_unwind(const struct ideal_known *s, size_t from, const double *re,
                             const double *im, double sign, double *to) {
    const double *ur = s->turn_re + from, *ui = s->turn_im + from;
    for (int k = 0; k < s->order; k += 2) {
        const double *x = re + from + k * IDEAL_LANES, *y = im + from + k * IDEAL_LANES;
        wide now = wide_get(x), less = wide_of(0), next = wide_get(x + IDEAL_LANES);
        wide other = wide_get(y) * wide_get(ui + IDEAL_LANES); // the real part of u_1 is 0
        for (int j = 1; j <= k; j++) {
            wide u = wide_get(ur + j * IDEAL_LANES), v = wide_get(ui + j * IDEAL_LANES);
            wide ahead = wide_get(ui + (j + 1) * IDEAL_LANES);
            x -= IDEAL_LANES, y -= IDEAL_LANES;
            now = wide_fma(wide_get(x), u, now);
            less = wide_fma(wide_get(y), v, less);
            next = wide_fma(wide_get(x), wide_get(ur + (j + 1) * IDEAL_LANES), next);
            other = wide_fma(wide_get(y), ahead, other);
        }
        wide_put(to + from + k * IDEAL_LANES, now + sign * less);
        if (k + 1 < s->order) wide_put(to + from + (k + 1) * IDEAL_LANES, next + sign * other);
    }
}

/* computes the forces along the arms, and if lengths vary also those across */
static void ideal_forces(const struct ideal_known *s) {
    ideal_hauls(s);
    for (int k = 0; k < s->n; k += IDEAL_LANES)
        for (int p = 0; p < VEC8 && k + p < s->n; p += WIDE) {
            size_t from = ideal_place(s, k, 0) + (size_t)p;
            ideal_unwind(s, from, s->pivot_force_re, s->pivot_force_im, 1, s->force);
            if (s->lengths)
                ideal_unwind(s, from, s->pivot_force_im, s->pivot_force_re, -1, s->across);
        }
}

/* ---- the system of bodies */

/* The sweep from the leaves to the root. The tip of an arm with its load resists an acceleration a
 * with the force P a + q. With the acceleration a_0 of the joint, the known rho along the arm and y
 * across it, the balance of the arm
 *
 *     side = (P a + q) across + (J' / l^2) y,   a = a_0 + (rho, y)
 *
 * gives y and the force A a_0 + b at the joint. With D = P_yy + J' / l^2, the compliance of the
 * joint is P_xy / D and P_yy / D (slip), A_xx = P_xx - P_xy^2 / D (bear), and the other elements of
 * A are J' / l^2 (twist) times the slip. */
static void ideal_bodies_factor(const struct ideal_known *s) {
    const double *mass = s->system.mass, *per = s->system.inv_len;
    double *xx = s->bear, *xy = s->slip_along,
           *yy = s->slip_across; // contains P until the sweep reaches the arm
    for (int k = 0; k < s->n; k++) xx[k] = yy[k] = mass[k], xy[k] = 0;
    for (int k = s->n - 1; k >= 0; k--) {
        int up = s->system.parent[k];
        double C = s->system.cosine[k], Z = s->system.sine[k];
        double own = s->inertia[k] * per[k] * per[k], give = 1 / (yy[k] + own);
        double along = xy[k] * give, across = yy[k] * give;
        s->bear[k] = xx[k] - xy[k] * along;
        s->slip_along[k] = along, s->slip_across[k] = across;
        s->yield[k] = give, s->twist[k] = own;
        if (up < 0) continue;
        double x = s->bear[k], y = own * across, both = own * along;
        xx[up] += C * C * x - 2 * C * Z * both + Z * Z * y;
        xy[up] += C * Z * (x - y) + (C * C - Z * Z) * both;
        yy[up] += Z * Z * x + 2 * C * Z * both + C * C * y;
    }
}

/* ---- effect of torques on the forces across the arms of a group */

/* the derivative, of order k, of the torque on arm a from its joint to the parent */
VEC_INLINE wide ideal_torque(const struct ideal_known *s, const struct ideal_group *g, int a, int k,
                             int p) {
    int up = s->system.parent[a];
    size_t row = (size_t)k * IDEAL_LANES + (size_t)p, span = g->rows * IDEAL_LANES;
    const double *own = g->angle + (size_t)a * span + row;
    wide bend = wide_get(own), slip = wide_get(own + IDEAL_LANES);
    if (up >= 0) {
        const double *held = g->angle + (size_t)up * span + row;
        bend -= wide_get(held), slip -= wide_get(held + IDEAL_LANES);
    }
    wide sum = slip * (-s->hold[a] * s->unit * (k + 1));
    sum = wide_fma(bend, wide_of(-s->stiff[a] * s->square), sum);
    if (!g->pairs) return sum;
    double rate = s->rate[ideal_place(s, a, k)], angle = s->bend[a];
    if (up >= 0) rate -= s->rate[ideal_place(s, up, k)];
    if (k) angle = s->rate[ideal_place(s, a, k - 1)] * s->system.share[k - 1];
    if (k && up >= 0) angle -= s->rate[ideal_place(s, up, k - 1)] * s->system.share[k - 1];
    wide rubs = wide_get(g->hold + a * IDEAL_LANES + p);
    wide pulls = wide_get(g->stiff + a * IDEAL_LANES + p);
    sum = wide_fma(rubs, wide_of(-rate * s->unit), sum);
    sum = wide_fma(pulls, wide_of(-angle * s->square), sum);
    return k ? sum : wide_fma(wide_get(g->torque + a * IDEAL_LANES + p), wide_of(s->square), sum);
}

/* The terms of order k of the force across an arm that do not depend on the solution. Of each pair
 * of sums, one belongs to the real part of E, the other to the force across. */
VEC_INLINE wide ideal_resist(const struct ideal_known *s, const struct ideal_group *g, int a, int k,
                             int p, wide re) {
    double more = (double)(k + 1) * (k + 2), per = s->system.inv_len[a];
    wide sum = re * (s->inertia[a] * per * more);
    if (g->pairs)
        sum = wide_fma(wide_get(g->inertia + a * IDEAL_LANES + p),
                       wide_of(-s->rate[ideal_place(s, a, k + 1)] * (k + 1) * per), sum);
    if (g->lengths)
        sum = wide_fma(wide_get(g->length + a * IDEAL_LANES + p),
                       wide_of(-s->across[ideal_place(s, a, k)]), sum);
    return sum;
}
