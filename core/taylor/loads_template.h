/* The drives that the fast kernels support, as series about an instant: torques, the acceleration
 * and the velocity of the pivot, and products of series. Leaves to others: the orders of the motion
 * (small_loads_template), ensembles (lanes_loads_template).
 * Invariant: a harmonic costs one sine and one cosine per expansion. */
#pragma once

#include <string.h>

#include "core/bodies/harmonic_template.h"
#include "core/taylor/jets_loads.h"
#include "core/taylor/jets_system.h"

enum { LOADS_ORDERS = 48 };

/* the series of the pivot's motion, and gravity */
static void loads_pivot(const struct jets_system *s, const struct bodies_moment *now, int order) {
    const struct jets_loads *loads = s->loads;
    if (!loads->moves) {
        for (int j = 0; j < 2; j++)
            loads->lift_x[j] = loads->lift_y[j] = loads->slide_x[j] = loads->slide_y[j] = 0;
        loads->lift_y[0] = now->gravity;
        return;
    }
    struct bodies_system pivot = {.terms = loads->terms,
                                  .value = loads->value,
                                  .share = (num *)s->share,
                                  .need = loads->drag_per_mass != 0 ? BODIES_DRAG_PER_MASS : 0,
                                  .lift_x = loads->lift_x,
                                  .lift_y = loads->lift_y,
                                  .slide_x = loads->slide_x,
                                  .slide_y = loads->slide_y};
    bodies_drive_pivot(&pivot, now, order);
}

/* the pivot's acceleration in the frame of the first arm */
static void loads_lift(const struct jets_system *s, int order) {
    const struct jets_loads *loads = s->loads;
    double C = s->cosine[0] * s->inv_len[0], Z = s->sine[0] * s->inv_len[0];
    for (int k = 0; k < order; k++) {
        double x = loads->lift_x[k], y = loads->lift_y[k];
        loads->given[k * LOADS_STRIDE] = -(C * x + Z * y);
        loads->drop[k * LOADS_STRIDE] = Z * x - C * y;
    }
}

/* adds a torque on arm a, and the opposite torque on its parent, as forces across the arms */
VEC_INLINE void loads_twist(const struct jets_system *s, int a, double torque, double *forces) {
    int p = s->parent[a];
    forces[a] += torque * s->inv_len[a];
    if (p >= 0) forces[p] -= torque * s->inv_len[p];
}

/* the series of the given torques; in a row, forces start at index `from` */
static void loads_torques(const struct jets_system *s, const struct bodies_moment *now, int order,
                          int from) {
    const struct jets_loads *loads = s->loads;
    const struct pend_terms *terms = loads->terms;
    double *forces = loads->given + from, square = now->unit * now->unit;
    int fixed = terms->row[PEND_TERM_TORQUE], input = terms->row[PEND_TERM_INPUT],
        slide = terms->row[PEND_TERM_SLIDE], orders = jets_loads_torques(loads, order);
    for (int k = 0; k < (orders ? orders : 1); k++)
        memset(forces + k * LOADS_STRIDE, 0, (size_t)s->n * sizeof(double));
    for (int a = 0; a < s->n && fixed >= 0; a++)
        loads_twist(s, a, square * loads->value[fixed + a], forces);
    for (int a = 0; a < s->n && slide >= 0; a++)
        loads_twist(s, a, square * loads->value[slide + a], forces);
    for (int a = 0; a < s->n && input >= 0; a++) {
        double rise = loads->value[terms->row[PEND_TERM_INPUT_RATE] + a],
               since = (now->time - loads->value[terms->one[PEND_TERM_PIECE]]) + now->late;
        loads_twist(s, a, square * (loads->value[input + a] + rise * since), forces);
        loads_twist(s, a, square * (rise * now->unit), forces + LOADS_STRIDE);
    }
    for (int i = 0; i < terms->harmonics; i++) {
        int a = terms->harmonic[i].drives;
        double torque[LOADS_ORDERS];
        if (a < 0) continue;
        memset(torque, 0, (size_t)(order + 1) * sizeof(double));
        bodies_harmonic(loads->value + terms->harmonic[i].at, s->share, now, 0, order, torque, 1);
        for (int k = 0; k < order; k++)
            loads_twist(s, a, square * torque[k], forces + k * LOADS_STRIDE);
    }
}

/* the torques of the springs at the start */
static void loads_springs(const struct jets_system *s, double unit, double *forces) {
    const struct jets_loads *loads = s->loads;
    int stiff = loads->terms->row[PEND_TERM_STIFFNESS], rest = loads->terms->row[PEND_TERM_REST];
    for (int a = 0; a < s->n && stiff >= 0; a++) {
        double bent = loads->bend[a] - loads->value[rest + a];
        loads_twist(s, a, -(unit * unit) * loads->value[stiff + a] * bent, forces);
    }
}

/* sets the numbers of one expansion that depend on the values of the terms, and the pivot's motion
 */
static void loads_number(const struct jets_system *s, const double *value,
                         const struct bodies_moment *now, int order) {
    s->loads->value = value;
    s->loads->unit = now->unit;
    loads_pivot(s, now, s->loads->moves ? order : 1);
}

/* computes the values known before the first order */
static void loads_begin(const struct jets_system *s, const double *value,
                        const struct bodies_moment *now, int order, int from) {
    struct jets_loads *loads = s->loads;
    int drag_per_mass = loads->terms->one[PEND_TERM_DRAG_PER_MASS];
    loads->drag_per_mass = drag_per_mass < 0 ? 0 : 2 * value[drag_per_mass] * now->unit;
    loads_number(s, value, now, order);
    if (!loads->bodies) loads_lift(s, loads->moves ? order : 1);
    if (loads->bodies) loads->bodies->value = value;
    if (loads->couples) loads_torques(s, now, order, from);
}

/* ---- power */

/* adds sum_{j <= k} a_j b_{k-j} to the orders k below `order`; a and b have LOADS_MARGIN zeros
 * before and enough zeros after them */
static void loads_product(const double *a, const double *b, int order, double *sum) {
    for (int k = 0; k < order; k += WIDE) {
        wide all = wide_load(sum + k);
        int last = k + WIDE < order ? k + WIDE : order;
        for (int j = 0; j < last; j++) all = wide_fma(wide_of(a[j]), wide_load(b + k - j), all);
        memcpy(sum + k, &all, sizeof all);
    }
}

/* order k of the rotation factors of arm a, k > 0 */
VEC_INLINE void loads_turn(const struct jets_system *s, int a, int k, double *re, double *im) {
    *re = k > 1 ? -s->turn_re[k * 8 + a] : 0;
    *im = k > 1 ? s->turn_im[k * 8 + a] : s->rate[a];
}

/* the series of the velocity v of each arm's joint, and of M v + 2 h u'; rows of 8 arms */
struct loads_ways {
    _Alignas(64) double x[LOADS_ORDERS][8], y[LOADS_ORDERS][8], rate[LOADS_ORDERS][8];
    _Alignas(64) double all_x[LOADS_ORDERS][8], all_y[LOADS_ORDERS][8], inertia[8];
};

static void loads_ways(const struct jets_system *s, int order, struct loads_ways *to) {
    const struct bodies_system *b = s->loads->bodies;
    for (int a = 0; a < s->n; a++) {
        int p = s->parent[a];
        double C = s->cosine[a], Z = s->sine[a], re, im;
        to->inertia[a] = b->inertia[a];
        for (int k = 0; k < order; k++) {
            double x = s->loads->slide_x[k], y = s->loads->slide_y[k], vx, vy;
            if (p >= 0) x = to->x[k][p], y = to->y[k][p];
            vx = C * x + Z * y, vy = C * y - Z * x;
            if (p >= 0) {
                loads_turn(s, p, k + 1, &re, &im);
                vx += (k + 1) * (b->place_x[a] * re - b->place_y[a] * im);
                vy += (k + 1) * (b->place_y[a] * re + b->place_x[a] * im);
            }
            loads_turn(s, a, k + 1, &re, &im);
            re *= 2 * (k + 1), im *= 2 * (k + 1);
            to->x[k][a] = vx, to->y[k][a] = vy, to->rate[k][a] = s->rate[k * 8 + a];
            to->all_x[k][a] = b->body[a] * vx + (b->moment_x[a] * re - b->moment_y[a] * im);
            to->all_y[k][a] = b->body[a] * vy + (b->moment_y[a] * re + b->moment_x[a] * im);
        }
    }
}

/* adds the heat of drag per mass, orders below `order`: 2 gamma times the sum of m |v|^2, to which
 * an arm contributes M |v|^2 + 2 Re (conj(v) h u') + J phi'^2 */
static void loads_haze(const struct jets_system *s, int order, double *sum) {
    struct loads_ways way;
    memset(&way, 0, sizeof way);
    loads_ways(s, order, &way);
    for (int k = 0; k < order; k++)
        for (int a = 0; a < s->n; a += WIDE) {
            wide all = wide_of(0), spin = wide_of(0);
            for (int j = 0; j <= k; j++) {
                all = wide_fma(wide_get(way.x[j] + a), wide_get(way.all_x[k - j] + a), all);
                all = wide_fma(wide_get(way.y[j] + a), wide_get(way.all_y[k - j] + a), all);
                spin = wide_fma(wide_get(way.rate[j] + a), wide_get(way.rate[k - j] + a), spin);
            }
            all = wide_fma(wide_get(way.inertia + a), spin, all);
            for (int i = 0; i < WIDE; i++) sum[k] += s->loads->drag_per_mass * all[i];
        }
}

/* adds the power of the pivot's force, orders below `order` */
static void loads_pivot_force(const struct jets_system *s, int order, double *sum) {
    const struct jets_loads *loads = s->loads;
    double C = s->cosine[0], Z = s->sine[0], force[2][LOADS_ORDERS];
    for (int k = 0; k < order; k++) {
        force[0][k] = C * loads->pivot_force_x[k] - Z * loads->pivot_force_y[k];
        force[1][k] = Z * loads->pivot_force_x[k] + C * loads->pivot_force_y[k];
    }
    loads_product(force[0], loads->slide_x, order, sum);
    loads_product(force[1], loads->slide_y, order, sum);
}
