/* Real pendulums in the lanes of an ensemble, one per lane: their series, the balance of their
 * energies, and the propagation of small errors. Included by the kernel, after the numbers.
 * Leaves to others: the equations of motion (bodies_template), steps (kernel_ensemble).
 * Invariant: lanes may differ in the values of the terms, lengths, masses, gravity and start. */
#pragma once

#include "core/bodies/bodies_template.h"
#include "core/taylor/jets_bodies.h"
#include "core/taylor/lanes/lanes_bodies_template.h"
#include "core/taylor/lanes/lanes_loads_template.h"
#include "core/tree/turns.h"

/* rad, the largest coordinate of a neighbour's distance, small enough for linear errors; and the
 * size below which an error counts as 0 */
static const double real_near = 0x1p-20, real_least = 0x1p-1000;

/* Returns how many numbers a series up to `order` needs in addition to those of an ideal pendulum;
 * 0 for an ideal pendulum. */
static size_t real_numbers(const struct pend_terms *terms, int n, size_t series, int order) {
    return terms ? bodies_numbers(terms, (size_t)n, series, order) : 0;
}

/* lays out the additional arrays; the others are those of an ideal pendulum */
static void real_lay(struct bodies_system *b, const struct ensemble_lanes *lanes,
                     const struct jets_system *s, size_t series, int order, num *memory) {
    *b = jets_bodies(s, lanes->terms, (const num *)(const void *)lanes->value);
    bodies_lay(b, (size_t)s->n, series, order, memory);
}

/* the instant of a state, in the unit of time */
VEC_INLINE struct bodies_moment real_moment(const struct ensemble_lanes *lanes, num unit,
                                            num gravity) {
    num start = NUM_(get)(lanes->start), time = NUM_(get)(lanes->from.time);
    num sum = start + time, part = sum - start;
    return (struct bodies_moment){unit, gravity, sum, (start - (sum - part)) + (time - part)};
}

/* sines and cosines of the angles to the parents, and these angles */
static void real_bend(const struct bodies_system *b, const num phi[], const num low[]) {
    for (int k = 0; k < b->n; k++) {
        int p = pend_terms_holder(b->terms, b->parent, k);
        num x = phi[k], y = p < 0 ? num_of(0) : phi[p], d = x - y, back = x - d;
        num rest = (low[k] - (p < 0 ? num_of(0) : low[p])) + ((x - (d + back)) + (back - y));
        num_turn(d, rest, &b->sine[k], &b->cosine[k]);
        b->bend[k] = p < 0 ? (d + M_PI_2) + (rest + PEND_QUARTER_LOW) : d + rest;
    }
    if (pend_terms_cart(b->terms)) bodies_cart_start(b, phi[0] + low[0]);
}

/* computes the orders by the fast form if it supports the pendulum, otherwise by the general form;
 * forces beyond order 0 on request */
static void real_orders(const struct jets_system *s, const struct bodies_system *b,
                        const struct bodies_moment *now, int order, int forces) {
    if (s->n <= DENSE_MAX && jets_loads_known(b->terms)) {
        lanes_orders(s, b, now, order, forces);
        return;
    }
    if (s->n <= DENSE_MAX && lanes_bodies_known(b->terms)) {
        lanes_bodies(s, b, now, order, forces);
        return;
    }
    bodies_orders(b, now, order);
    if (forces) bodies_forces(b, order);
}

/* computes the series of a state */
static __attribute__((noinline)) void real_expand(const struct ensemble_lanes *lanes,
                                                  const struct jets_system *s,
                                                  const struct bodies_system *b, num unit,
                                                  num gravity, int order) {
    const struct ensemble_state *from = &lanes->from;
    struct bodies_moment now = real_moment(lanes, unit, gravity);
    real_bend(b, (const num *)(const void *)from->phi, (const num *)(const void *)from->phi_low);
    for (int k = 0; k < b->n; k++) b->rate[k] = NUM_(get)(from->rate + (size_t)k * WIDE) * unit;
    real_orders(s, b, &now, order, lanes->forces);
}

/* the step of x units, or the shorter one that dry friction in joints requires */
static num real_reach(const struct bodies_system *b, num x) {
    return b->need & BODIES_FRICTION ? bodies_reach(b, x) : x;
}

/* The work of the pivot in x units from the orders beyond those of its power, times unit^2, as in
 * pend_exchange_beyond. */
static num real_beyond(const struct bodies_system *b, int order, num x) {
    num sum = num_of(0);
    for (int k = 2 * order - 2; k >= order; k--) {
        num part = num_of(0);
        for (int j = k - order + 1; j < order; j++) {
            part = num_fma(b->pivot_force_x[j], b->slide_x[k - j], part);
            part = num_fma(b->pivot_force_y[j], b->slide_y[k - j], part);
        }
        sum = num_fma(sum, x, part * (1.0 / (k + 1)));
    }
    for (int k = 0; k < order; k++) sum *= x;
    return sum;
}

/* Computes the work of drives minus the heat of friction in a step of x units, J; stores its series
 * for fractions of the step. */
static __attribute__((noinline)) void real_balance(const struct ensemble_lanes *lanes,
                                                   const struct bodies_system *b, num unit, num x) {
    num sum = num_of(0), inverse = 1 / unit, work[ENSEMBLE_ORDER_MAX], heat[ENSEMBLE_ORDER_MAX];
    bodies_power(b, unit, lanes->order, lanes->order, work, heat);
    for (int j = lanes->order - 1; j >= 0; j--) {
        num c = (work[j] - heat[j]) * lanes->share[j] * (inverse * inverse);
        sum = num_fma(sum, x, c);
        NUM_(put)(lanes->power + (size_t)j * WIDE, c);
    }
    if (b->need & BODIES_PIVOT) sum += real_beyond(b, lanes->order, x) * (inverse * inverse);
    NUM_(put)(lanes->to.gain, NUM_(get)(lanes->from.gain) + sum * x);
}

/* A time, s, that converts the error of a rate to that of an angle. Dry friction is linear only for
 * rates that are small compared with its friction speed, so the joint with the smallest such speed
 * decides. */
static num real_time(const struct ensemble_lanes *lanes, num length) {
    const double linear = 1e-5;
    const struct pend_terms *terms = lanes->terms;
    num time = num_abs(length);
    for (int k = 0; k < lanes->n && terms->row[PEND_TERM_FRICTION] >= 0; k++) {
        size_t speed = (size_t)(terms->row[PEND_TERM_FRICTION_SPEED] + k) * WIDE;
        time = num_max(time, num_of(real_near / linear) / NUM_(get)(lanes->value + speed));
    }
    return time;
}

/* Computes the series of the errors, to first order, as in neighbour.c: the series `s` of a
 * neighbour, displaced in the direction of the errors, minus the series of the motion. Stores it in
 * the rates of `near`. Returns the largest error of a force at the start, times unit^2. */
static __attribute__((noinline)) num real_spread(const struct ensemble_lanes *lanes,
                                                 const struct jets_system *s,
                                                 const struct bodies_system *own,
                                                 const struct bodies_system *near, num unit,
                                                 num gravity, num x) {
    const struct ensemble_doubt *doubt = &lanes->doubt;
    const struct ensemble_state *from = &lanes->from;
    struct bodies_moment now = real_moment(lanes, unit, gravity);
    num most = num_of(real_least), force = num_of(0), time = real_time(lanes, x * unit);
    const num *error_phi = (const num *)(const void *)doubt->phi,
              *error_rate = (const num *)(const void *)doubt->rate;
    // scratch: arrays of the series that are not needed yet
    num *phi = near->turned, *low = near->pulled;
    for (int k = 0; k < own->n; k++)
        most = num_max(most, num_max(num_abs(error_phi[k]), num_abs(error_rate[k] * time)));
    num scale = real_near / most, share = 1 / scale;
    for (int k = 0; k < own->n; k++) {
        num base = NUM_(get)(from->phi + (size_t)k * WIDE), add = scale * error_phi[k];
        num sum = base + add, part = sum - base;
        phi[k] = sum;
        low[k] =
            ((base - (sum - part)) + (add - part)) + NUM_(get)(from->phi_low + (size_t)k * WIDE);
        near->rate[k] =
            num_fma(scale, error_rate[k], NUM_(get)(from->rate + (size_t)k * WIDE)) * unit;
    }
    real_bend(near, phi, low);
    real_orders(s, near, &now, doubt->order, 0);
    for (int k = 0; k < own->n; k++) {
        near->rate[k] = error_rate[k] * unit;
        for (int j = 1; j <= doubt->order; j++) {
            size_t at = (size_t)j * own->stride + (size_t)k;
            near->rate[at] = (near->rate[at] - own->rate[at]) * share;
        }
        force = num_max(force, num_abs(near->force[k] - own->force[k]) * share);
    }
    return force;
}
