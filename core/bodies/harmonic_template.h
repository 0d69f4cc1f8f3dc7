/* Harmonic drives as series about an instant, and the motion of a driven pivot, for any kind of
 * number; used by the general kernel and the fast kernels.
 * Leaves to others: torques other than drives (drives_template, loads_template).
 * Invariant: a harmonic costs one sine and one cosine per expansion. */
#pragma once

#include "core/bodies/bodies_factor_template.h"

/* The instant about which a series is expanded, and its unit. */
struct bodies_moment {
    num unit;       /* s, a power of two */
    num gravity;    /* m/s^2 times unit^2 */
    num time, late; /* s, in the time of the request: the instant as a sum of two doubles */
};

/* Adds the series of derivative number `from` of a harmonic to every `step`-th number: A w^(from+j)
 * / j! cos(theta + (from + j) pi / 2), w = omega unit, for j = 0 .. order. */
static inline void bodies_harmonic(const num harmonic[], const num share[],
                                   const struct bodies_moment *now, int from, int order, num *to,
                                   size_t step) {
    num sine, cosine, size = harmonic[0], w = num_mul(harmonic[1], now->unit);
    num_drive(harmonic[1], now->time, now->late, harmonic[2], &sine, &cosine);
    num cycle[4] = {cosine, num_neg(sine), num_neg(cosine), sine};
    for (int j = 0; j < from; j++) size = num_mul(size, w);
    for (int j = 0; j <= order; j++) {
        num *here = to + (size_t)j * step;
        *here = num_fma(size, cycle[(from + j) % 4], *here);
        if (j < order) size = num_mul(size, num_mul(w, share[j]));
    }
}

/* adds the pivot's track of a piece, a cubic in time */
static inline void bodies_track(const struct bodies_system *s, const struct bodies_moment *now,
                                int order) {
    num since = num_add(num_sub(now->time, bodies_one(s, PEND_TERM_PIECE)), now->late);
    num half = num_mul(since, num_of(0.5)), square = num_mul(now->unit, now->unit);
    for (int y = 0; y < 2; y++) {
        const num *track = s->value + s->terms->one[PEND_TERM_PIVOT_TRACK] + y;
        num *slide = y ? s->slide_y : s->slide_x;
        num speed = num_fma(since, num_fma(half, track[6], track[4]), track[2]);
        slide[0] = num_fma(now->unit, speed, slide[0]);
        slide[1] = num_fma(square, num_fma(since, track[6], track[4]), slide[1]);
        if (order < 2) continue;
        slide[2] = num_fma(num_mul(square, num_mul(now->unit, num_of(0.5))), track[6], slide[2]);
    }
}

/* computes the pivot's z' up to `order`, and z'' + 2 gamma z' plus gravity up to one order less */
static inline void bodies_drive_pivot(const struct bodies_system *s,
                                      const struct bodies_moment *now, int order) {
    num zero = num_of(0), square = num_mul(now->unit, now->unit);
    for (int j = 0; j <= order; j++)
        s->lift_x[j] = s->lift_y[j] = s->slide_x[j] = s->slide_y[j] = zero;
    for (int i = 0; i < s->terms->harmonics; i++) {
        const struct pend_harmonic *h = &s->terms->harmonic[i];
        if (h->drives >= 0) break;
        num *slide = h->drives == PEND_DRIVE_PIVOT_X ? s->slide_x : s->slide_y;
        bodies_harmonic(s->value + h->at, s->share, now, 1, order, slide, 1);
    }
    num x = num_mul(square, bodies_one(s, PEND_TERM_PIVOT_ACCELERATION_X));
    num y = num_mul(square, bodies_one(s, PEND_TERM_PIVOT_ACCELERATION_Y));
    num since = num_div(num_add(now->time, now->late), now->unit);
    s->slide_x[0] = num_fma(x, since, s->slide_x[0]);
    s->slide_y[0] = num_fma(y, since, s->slide_y[0]);
    s->slide_x[1] = num_add(s->slide_x[1], x);
    s->slide_y[1] = num_add(s->slide_y[1], y);
    if (s->terms->one[PEND_TERM_PIVOT_TRACK] >= 0) bodies_track(s, now, order);
    for (int j = 0; j < order; j++) {
        s->lift_x[j] = num_mul(num_of(j + 1), s->slide_x[j + 1]);
        s->lift_y[j] = num_mul(num_of(j + 1), s->slide_y[j + 1]);
    }
    s->lift_y[0] = num_add(s->lift_y[0], now->gravity);
    if (!(s->need & BODIES_DRAG_PER_MASS)) return;
    num twice = num_mul(num_mul(num_of(2), now->unit), bodies_one(s, PEND_TERM_DRAG_PER_MASS));
    for (int j = 0; j < order; j++) {
        s->lift_x[j] = num_fma(twice, s->slide_x[j], s->lift_x[j]);
        s->lift_y[j] = num_fma(twice, s->slide_y[j], s->lift_y[j]);
    }
}
