/* Series with derivatives of an ideal pendulum: the recurrences of trees without terms, whose
 * orders are those of small trees or of any tree.
 * Leaves to others: the recurrences (jets_template, dense_template), memory and the length of a
 * step (kernel_derivatives).
 * Invariant: the series stand where those of the general kernel stand. Seven derivatives of
 * two to eight arms take half of the time that they take there. */
#ifndef PEND_IDEAL_TEMPLATE_H
#define PEND_IDEAL_TEMPLATE_H

#include "core/bodies/bodies_template.h"
#include "core/taylor/dense_template.h"

/* arrays of one number an arm that the recurrences have beside those of the general kernel */
enum {
#define X(name) IDEAL_ARRAY_##name,
    JETS_ARRAYS(X)
#undef X
        IDEAL_ARRAYS
};

/* whether a pendulum has no terms at all */
static inline int ideal_is(const struct pend_terms *terms) {
    return !terms->count && !terms->harmonics;
}

/* the numbers that ideal_system takes */
static inline size_t ideal_numbers(int n) { return (size_t)IDEAL_ARRAYS * (size_t)n; }

/* the system of the same arms, whose cosines, sines and rates of order 0 are there; trees of
 * DENSE_MAX arms have a stride of n */
static struct jets_system ideal_system(const struct bodies_system *s, const int end[],
                                       const double share[], num *at) {
    size_t n = (size_t)s->n;
    struct jets_system made = {.n = s->n,
                               .tiles = (s->n + 7) / 8,
                               .stride = s->stride,
                               .tile = s->tile,
                               .parent = s->parent,
                               .end = end,
                               .share = share,
                               .rate = s->rate,
                               .force = s->force,
                               .turn_re = s->turn_re,
                               .turn_im = s->turn_im};
#define X(name) made.name = at, at += n;
    JETS_ARRAYS(X)
#undef X
    made.cosine = s->cosine, made.sine = s->sine;
    for (int k = 0; k < s->n; k++) {
        made.len[k] = s->len[k], made.mass[k] = s->mass[k];
        made.inv_len[k] = num_div(num_of(1), s->len[k]);
    }
    return made;
}

/* the series to an order, as bodies_orders; gravity in units */
static void ideal_orders(const struct jets_system *s, num gravity, int order) {
    jets_factor(s);
    if (s->n <= DENSE_MAX)
        dense_orders(s, gravity, order);
    else
        jets_orders(s, gravity, order);
}

#endif
