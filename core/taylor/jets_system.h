/* The arrays that the power-series kernels work on, for every kind of number.
 * Leaves to others: the numbers and the arithmetic (jets_template), memory (jets).
 * Invariant: one block; a series is stored in tiles of eight arms, all orders of a tile
 * together. */
#pragma once

#include <stddef.h>

#if defined PEND_ISA || defined NUMBER_OTHER
#include "core/simd/number.h"
#else
typedef double num; /* files that only lay out memory count it in doubles */
#endif

// clang-format off
/*
 * Arrays, one value per arm, of the factorization and of the sweeps of an order. Sums go over the
 * arm's children unless another set is named.
 *
 * len, inv_len, mass                of the arm; inv_len is 1 / len
 * angle, angle_low                  to the parent, as a sum of two
 * cosine, sine                      of that angle
 * eff, inv_eff                      S, 1 / S
 * inv, lean                         1 / (m + q), r / (m + q)
 * kappa, nu, tau                    effect of an arm on its parent; nu, tau where tension is
 *                                   solved first
 * stiff, weight                     S kappa, S l
 * sum_p .. sum_d                    the sums p, r and q, and the remainder of their determinant
 * late, late_q, late_r              the same sums over the later siblings
 * early                             sums over the children visited so far
 * wind, drag (re, im)               T and c of this order
 * next_wind, next_drag (re, im)     known parts of T and c of the next order
 * heave                             S l (k + 1) Im T
 * push, bias                        h, and f = h - heave
 * side                              the known force across the arm
 * sum_side, sum_cos, sum_sin        sums of Z f, C s, Z s
 * from_side, others                 the parent's `side`; sum of Z f over the siblings
 * shift, rest                       radial without the parent's part; tangential without the
 *                                   radial part
 * tension                           the part of mu that does not depend on the parent
 * radial, tangential                acceleration of the tip
 * from_radial, from_tangential      acceleration of the parent's tip */
#define JETS_FACTOR_ARRAYS(X) \
    X(len) X(inv_len) X(mass) X(angle) X(angle_low) X(cosine) X(sine) X(eff) X(inv_eff) X(inv) \
    X(lean) X(kappa) X(nu) \
    X(tau) X(sum_p) X(sum_r) X(sum_q) X(sum_d) X(late_q) X(late_r)
#define JETS_SWEEP_ARRAYS(X) \
    X(stiff) X(weight) X(late) X(early) X(wind_re) X(wind_im) X(drag_re) X(drag_im) \
    X(next_wind_re) X(next_wind_im) \
    X(next_drag_re) X(next_drag_im) X(heave) X(push) X(bias) X(side) X(sum_side) X(sum_cos) \
    X(sum_sin) X(from_side) \
    X(others) X(shift) X(rest) X(tension) X(radial) X(tangential) X(from_radial) X(from_tangential)
#define JETS_ARRAYS(X) JETS_FACTOR_ARRAYS(X) JETS_SWEEP_ARRAYS(X)
// clang-format on

struct jets_system {
    int n, tiles;        /* number of arms; number of tiles of eight in the series */
    size_t stride, tile; /* index distance from one order to the next; from one tile of eight arms
                          * to the next */
    const int *parent, *end;
    /* For a tree of more than eight arms, in doubles, jets sets one of these two, depending on the
     * tree; otherwise both are NULL. */
    const struct blocks *blocks;
    const struct chain *chain;
    const struct rods *rods;  /* in addition to `chain`, for a chain of rods; otherwise NULL */
    struct jets_loads *loads; /* for a real pendulum that the fast kernels support; NULL = ideal */
    const double *share;      /* 1 / (j + 1) of order j */
    num *rate, *force, *turn_re,
        *turn_im; /* series: order j of arm k at jets_row(k) + j * stride */
    num *answers; /* for a small tree: the responses of its arms to unit forces, for
                   * pend_jets_spread; NULL = not stored */
#define X(name) num *name;
    JETS_ARRAYS(X)
#undef X
};

/* The least and the largest number of orders for error propagation over a step. */
enum { JETS_SPREAD = 4, JETS_SPREAD_MAX = 32 };

/* The step over which errors are propagated. */
struct jets_spread {
    int order;      /* JETS_SPREAD .. JETS_SPREAD_MAX, order of the motion's series; higher orders
                     * are not used */
    double x, unit; /* length of the step in units; the unit, s */
    double least;   /* propagation ends when two successive terms are smaller than this, relative to
                     * the error */
};

/** Returns the index at which the series of arm k start. */
static inline size_t jets_row(const struct jets_system *s, int k) {
    return (size_t)(k / 8) * s->tile + (size_t)(k % 8);
}
