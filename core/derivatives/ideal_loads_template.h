/* What real pendulums have beyond ideal ones when their motion is known: the forces along and
 * across arms from the motion, the answers of bodies to units or their factors, torques in the
 * joints.
 * Leaves to others: which pendulums there are (ideal_loads), points' answers
 * (ideal_known_template, which includes this).
 * Invariant: nothing here is a product of two series of derivatives. */
#ifndef PEND_IDEAL_LOADS_TEMPLATE_H
#define PEND_IDEAL_LOADS_TEMPLATE_H

#include <math.h>

#include "core/derivatives/ideal_system.h"
#include "core/simd/vec8_template.h"

/* ---- the motion's forces */

/* the forces that arms exert on their tips, in the arms' frames of the start */
static void ideal_hauls(const struct ideal_known *s) {
    for (int k = s->n - 1; k >= 0; k--) {
        double m = s->system.mass[k];
        for (int j = 0; j < s->order; j++) {
            size_t at = ideal_place(s, k, j);
            s->haul_re[at] = m * s->acc_re[at];
            s->haul_im[at] = m * s->acc_im[at];
        }
        for (int c = k + 1; c < s->system.end[k]; c = s->system.end[c]) {
            double C = s->system.cosine[c], Z = s->system.sine[c];
            for (int j = 0; j < s->order; j++) {
                size_t at = ideal_place(s, k, j), from = ideal_place(s, c, j);
                double re = s->haul_re[from], im = s->haul_im[from];
                s->haul_re[at] += C * re - Z * im;
                s->haul_im[at] += Z * re + C * im;
            }
        }
    }
}

/* Re (F u*), or Im, of the lanes from `from` on: two orders at once; F is (re, im), or (im, -re) */
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

/* forces along the arms, and across them where lengths vary */
static void ideal_forces(const struct ideal_known *s) {
    ideal_hauls(s);
    for (int k = 0; k < s->n; k += IDEAL_LANES)
        for (int p = 0; p < VEC8 && k + p < s->n; p += WIDE) {
            size_t from = ideal_place(s, k, 0) + (size_t)p;
            ideal_unwind(s, from, s->haul_re, s->haul_im, 1, s->force);
            if (s->lengths) ideal_unwind(s, from, s->haul_im, s->haul_re, -1, s->across);
        }
}

/* ---- the answers of bodies */

enum { IDEAL_SQUARE = IDEAL_DENSE * IDEAL_DENSE };

/* What couples the arms of a small tree at the start, [i * n + j]: the mass under both of two arms
 * times the cosine and the sine of the angle between them. */
struct ideal_coupling {
    double cosine[IDEAL_SQUARE], sine[IDEAL_SQUARE];
};

static void ideal_couple(const struct ideal_known *s, struct ideal_coupling *x) {
    double re[IDEAL_DENSE] = {0}, im[IDEAL_DENSE] = {0}, under[IDEAL_DENSE];
    int n = s->n;
    for (int k = n - 1; k >= 0; k--) {
        under[k] = s->system.mass[k];
        for (int c = k + 1; c < s->system.end[k]; c = s->system.end[c]) under[k] += under[c];
    }
    for (int k = 0; k < n; k++) {
        double C = s->system.cosine[k], Z = s->system.sine[k];
        int up = s->system.parent[k];
        double x_ = up < 0 ? 1 : re[up], y_ = up < 0 ? 0 : im[up];
        re[k] = x_ * C - y_ * Z, im[k] = x_ * Z + y_ * C;
    }
    for (int i = 0; i < n; i++)
        for (int j = i; j < n; j++) {
            double both = j < s->system.end[i] ? under[j] : 0;
            double C = both * (re[i] * re[j] + im[i] * im[j]);
            double Z = both * (re[i] * im[j] - im[i] * re[j]);
            x->cosine[i * n + j] = x->cosine[j * n + i] = C;
            x->sine[i * n + j] = Z, x->sine[j * n + i] = -Z;
        }
}

/* inverts a symmetric positive matrix in place, by Gauss and Jordan: the diagonal elements that it
 * divides by are those of Cholesky's factors */
static void ideal_inverse(int n, double m[]) {
    for (int k = 0; k < n; k++) {
        double per = 1 / m[k * n + k];
        m[k * n + k] = 1;
        for (int j = 0; j < n; j++) m[k * n + j] *= per;
        for (int i = 0; i < n; i++) {
            double factor = m[i * n + k];
            if (i == k) continue;
            m[i * n + k] = 0;
            for (int j = 0; j < n; j++) m[i * n + j] -= factor * m[k * n + j];
        }
    }
}

/* what accelerations and forces answer to a pull on an arm, and to a force across it: with y = l Re
 * E, H the cosines and N the sines of ideal_coupling
 *
 *     (H + J' / l^2) y = side + N l Im E,   force along = -N y - H l Im E */
static void ideal_body_table(const struct ideal_known *s) {
    struct ideal_coupling x;
    double inverse[IDEAL_SQUARE], answer[2 * IDEAL_SQUARE];
    int n = s->n;
    const double *len = s->system.len, *per = s->system.inv_len;
    ideal_couple(s, &x);
    memcpy(inverse, x.cosine, (size_t)(n * n) * sizeof *inverse);
    for (int k = 0; k < n; k++) inverse[k * n + k] += s->inertia[k] * per[k] * per[k];
    ideal_inverse(n, inverse);
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            double sum = 0;
            for (int c = 0; c < n; c++) sum += inverse[i * n + c] * x.sine[c * n + j];
            answer[i * 2 * n + j] = sum * len[j];
            answer[i * 2 * n + n + j] = inverse[i * n + j];
        }
    for (int i = 0; i < n; i++) {
        double *row = s->table + 2 * i * IDEAL_PITCH, *force = row + IDEAL_PITCH;
        for (int j = 0; j < 2 * n; j++) {
            double sum = j < n ? -x.cosine[i * n + j] * len[j] : 0;
            for (int c = 0; c < n; c++) sum -= x.sine[i * n + c] * answer[c * 2 * n + j];
            row[j] = answer[i * 2 * n + j] * per[i];
            force[j] = sum;
        }
    }
}

/* The same of more arms, from the leaves to the root. The tip of an arm, with all that hangs there,
 * opposes P a + q to an acceleration a; with that of the joint a_0, the one along that is known rho
 * and y across, the balance of the arm
 *
 *     side = (P a + q) across + (J' / l^2) y,   a = a_0 + (rho, y)
 *
 * gives y, and A a_0 + b as what the joint opposes. With D = P_yy + J' / l^2 the joint yields P_xy
 * / D and P_yy / D (slip), A_xx = P_xx - P_xy^2 / D (bear), and the rest of A is J' / l^2 (twist)
 * times the slip. */
static void ideal_bodies_factor(const struct ideal_known *s) {
    const double *mass = s->system.mass, *per = s->system.inv_len;
    double *xx = s->bear, *xy = s->slip_along, *yy = s->slip_across; // P, until its arm's turn
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

/* ---- what torques add to a group's forces across */

/* the change of the torque on arm a against its parent, order k */
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

/* the part of an arm's force across that does not move with what is asked for, order k; of the
 * sums an element is the real part of E, another the force across */
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

#endif
