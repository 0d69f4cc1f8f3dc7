/* The system of the general kernel, on top of the series of an ideal pendulum, for every kind of
 * number. Leaves to others: its own arrays (bodies_lay), memory (the including file).
 * Invariant: rates, forces and rotation factors are stored once, so that readers of a series need
 * not know which kernel computed it. */
#pragma once

#include "core/bodies/bodies_system.h"
#include "core/taylor/jets_system.h"

/** Returns a system that shares the arms and the series of `s`; bodies_lay sets its other arrays
 * afterwards. value: the values of the terms. O(1). */
static inline struct bodies_system jets_bodies(const struct jets_system *s,
                                               const struct pend_terms *terms, const num *value) {
    return (struct bodies_system){.n = s->n,
                                  .stride = s->stride,
                                  .tile = s->tile,
                                  .parent = s->parent,
                                  .terms = terms,
                                  .len = s->len,
                                  .mass = s->mass,
                                  .value = value,
                                  .rate = s->rate,
                                  .force = s->force,
                                  .turn_re = s->turn_re,
                                  .turn_im = s->turn_im};
}
