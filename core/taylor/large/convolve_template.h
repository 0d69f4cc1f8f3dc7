/* The convolutions of a tree's series, two orders in one pass: T and c of jets_system, arms in
 * lanes. With torques between the arms (`couples`), the series of the forces in fixed axes replace
 * lambda, as in small_loads_template, and Im c is their known part. Leaves to others: storing the
 * results until needed (blocks_template).
 * Invariant: `row` is the index at which the series of the arms begin; tiles of eight arms. */
#pragma once

#include "core/taylor/jets_loads.h"
#include "core/taylor/jets_system.h"

enum { CONVOLVE_STRIDE = 8 };

struct convolved {
    wide Tr, Ti, cr, ci;
};

/* T and c of order k, and in *next those of order k + 1 without the terms that need order k, so
 * that every coefficient is loaded once for both. Row -1 of the forces is zero. */
VEC_INLINE struct convolved convolve(const struct jets_system *s, size_t row, int k, int couples,
                                     struct convolved *next_) {
    enum { STRIDE = CONVOLVE_STRIDE };
    const double *re = s->turn_re + row + 2 * STRIDE, *im = s->turn_im + row + 2 * STRIDE;
    const double *rate = s->rate + row + (size_t)k * STRIDE,
                 *force = s->force + row + (size_t)k * STRIDE - STRIDE;
    const double *cross = couples ? s->loads->cross + row + (size_t)k * STRIDE - STRIDE : force;
    wide w = wide_get(rate), f = wide_get(force), g = couples ? wide_get(cross) : f,
         first = wide_get(s->rate + row), zero = wide_of(0);
    // u_1 is imaginary
    struct convolved now = {zero, first * w, zero, first * f}, next = {zero, zero, zero, zero};
    for (int j = 2; j <= k + 1; j++, re += STRIDE, im += STRIDE) {
        wide ur = wide_get(re), ui = wide_get(im);
        VEC_PIN(ur);
        VEC_PIN(ui);
        next.Tr = wide_fma(ur, w, next.Tr);
        next.Ti = wide_fma(ui, w, next.Ti);
        next.cr = wide_fma(ur, g, next.cr);
        next.ci = wide_fma(ui, f, next.ci);
        rate -= STRIDE, force -= STRIDE;
        w = wide_get(rate), f = wide_get(force);
        VEC_PIN(w);
        VEC_PIN(f);
        g = f;
        if (couples) {
            cross -= STRIDE;
            g = wide_get(cross);
            VEC_PIN(g);
        }
        now.Tr = wide_fma(ur, w, now.Tr);
        now.Ti = wide_fma(ui, w, now.Ti);
        now.cr = wide_fma(ur, g, now.cr);
        now.ci = wide_fma(ui, f, now.ci);
    }
    if (couples) {
        now.ci -= now.cr, next.ci -= next.cr;
        now.cr = next.cr = zero;
    }
    *next_ = next;
    return now;
}

/* the missing terms of T and c of order k, the second of two orders; Re c has none */
VEC_INLINE struct convolved convolve_rest(const struct jets_system *s, size_t row, int k,
                                          struct convolved known) {
    enum { STRIDE = CONVOLVE_STRIDE };
    size_t now = row + (size_t)k * STRIDE;
    wide first = wide_get(s->rate + row);
    known.Tr = wide_fma(wide_get(s->turn_re + now + STRIDE), first, known.Tr);
    known.Ti = wide_fma(wide_get(s->turn_im + now + STRIDE), first, known.Ti);
    known.Ti = wide_fma(first, wide_get(s->rate + now), known.Ti);
    known.ci = wide_fma(first, wide_get(s->force + now - STRIDE), known.ci);
    return known;
}
