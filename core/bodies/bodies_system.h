/* The arrays that the general kernel works on, for every kind of number.
 * Leaves to others: the arithmetic (bodies_template), allocating the memory (bodies, jets,
 * ensemble, extended).
 * Invariant: a series is stored in tiles of eight arms, all orders of a tile together, like those
 * of the ideal pendulum. */
#pragma once

#include <stddef.h>

#include "core/tree/terms.h"

#if defined PEND_ISA || defined NUMBER_OTHER
#include "core/simd/number.h"
#else
typedef double num; /* files that only lay out memory count it in doubles */
#endif

// clang-format off
/*
 * Arrays, one value per arm. All vectors are in the frame of the arm, whose axes are fixed at the
 * state that is expanded about.
 *
 * cosine, sine, bend       of the angle to the parent (of the first arm: to the axes), which the
 *                          caller fills in; the angle to the parent itself, of the first arm theta
 * point_x, point_y         attachment point of the arm, in its parent's frame
 * body, moment_x, moment_y  M, h = sum of m p
 * inertia                  J = sum of m |p|^2
 * center_x, center_y, spread  c = h / M; the inertia about the center
 * tail_x, tail_y           from the center to the tip
 * tip_share, tip_rest      the fraction of M that is at the tip, and 1 minus this fraction
 * total, inv_total         D, the inertia of the arm with its sub-tree; 1 / D
 * lever_x, lever_y         X = x / D
 * form_xx, form_xy, form_yy  Phi: the force on the base per unit of its acceleration
 * form_det                 its determinant
 * pull_x, pull_y           w = sum of P e of the children at the tip
 * hang_x, hang_y, hang_e, hang_p  the same for children attached elsewhere; the sums of <e, w>
 *                          and <p, w>
 * early_x, early_y, early_e, early_p  the same sums over the siblings added before the arm
 * late_x, late_y           sums over the children at the tip that were added after the arm
 * other_x, other_y, other_e, other_p  the same for children attached elsewhere
 * draw_x, draw_y           z = y - X K: the force on the base per unit of Re u''
 * twist                    K = sum of <e, P p>: the torque about the joint, per unit of Re u''
 * place_x, place_y         attachment point, rotated into the arm's frame: conj(R) p
 * carry_xx ... carry_yy    R^T (1 - e X^T): the base's acceleration per unit of the parent's
 * give_xx ... give_yy      1 - e X^T of the tip
 * stem_x, stem_y           from the parent's center to the attachment point, in the arm's frame
 * sway_xx ... sway_yy, swing_x, swing_y, turn_x, turn_y, keep_xx ... keep_yy
 *                          the arm's force per unit of the acceleration of its parent's base, of
 *                          the parent's kr, of a moment on the parent, and of the arm's beta
 * wind_x, wind_y, known    of the current order: T, and Im (conj u G) without the unknown term
 * next_x, next_y, next_known  the known parts of these for the next order
 * turned, pulled           theta and kr, the known parts of u''
 * couple                   tau, all torques on the arm
 * drag_x, drag_y           drag on the tip
 * asked_x, asked_y         beta: the force on the base, without the term of its acceleration
 * answer                   m, then m / D, then chi
 * early_m, late_m          moments on the parent without the arm's own: from the siblings after it;
 *                          and the moments on the arm from the children visited so far
 * reach_x, reach_y         the force at the joint, which the parent exerts
 * heave_x, heave_y         conj(p - c) times this force: its contribution to the parent's G
 * base_x, base_y           acceleration of the base
 * speed_x, speed_y         velocity of the base
 * damping ... slide        values of the joint's terms, in units of time
 * air_slow ... air_share   values of drag, in units of time; half the inverse of order 0 of drag's
 *                          square root */
#define BODIES_ARRAYS(X) \
    X(cosine) X(sine) X(bend) X(point_x) X(point_y) X(body) X(moment_x) X(moment_y) X(inertia) \
    X(center_x) X(center_y) X(spread) X(tail_x) X(tail_y) X(tip_share) X(tip_rest) \
    X(total) X(inv_total) X(lever_x) X(lever_y) \
    X(form_xx) X(form_xy) X(form_yy) X(form_det) \
    X(pull_x) X(pull_y) X(hang_x) X(hang_y) X(hang_e) X(hang_p) X(early_x) X(early_y) \
    X(early_e) X(early_p) X(late_x) X(late_y) X(other_x) X(other_y) X(other_e) X(other_p) \
    X(draw_x) X(draw_y) X(twist) X(stem_x) X(stem_y) X(sway_xx) X(sway_xy) X(sway_yx) X(sway_yy) \
    X(swing_x) X(swing_y) X(turn_x) X(turn_y) X(keep_xx) X(keep_xy) X(keep_yx) X(keep_yy) \
    X(early_m) X(late_m) \
    X(place_x) X(place_y) X(carry_xx) X(carry_xy) X(carry_yx) X(carry_yy) X(give_xx) X(give_xy) \
    X(give_yx) X(give_yy) X(wind_x) X(wind_y) X(known) X(next_x) X(next_y) X(next_known) \
    X(turned) X(pulled) X(couple) X(drag_x) X(drag_y) X(asked_x) X(asked_y) X(answer) X(reach_x) \
    X(reach_y) X(heave_x) X(heave_y) X(base_x) X(base_y) X(speed_x) X(speed_y) X(damping) \
    X(stiffness) X(rest) X(friction) X(friction_scale) X(slide) X(air_slow) X(air_fast) \
    X(air_least) X(air_share)
/*
 * Series in addition to those of rates, forces and turns.
 *
 * push_x, push_y           G
 * tip_x, tip_y             the force that the arm passes on at its tip
 * swing                    the arm's rate relative to its parent
 * loss, drive              torques at the arm's joint: of friction, and from drives
 * way_x, way_y             velocity of the tip
 * air_x, air_y             the air's force on the tip
 * air_part                 sqrt(|v|^2 + e^2) with the sign of the unit
 * friction_curve,
 * friction_rest            w = (1 - |tanh|) / 2 of the joint's speed, and w - w^2
 * base_way_x, base_way_y   velocity of the joint */
#define BODIES_SERIES(X) \
    X(push_x, 1) X(push_y, 1) X(tip_x, 1) X(tip_y, 1) X(swing, BODIES_JOINTS) \
    X(loss, BODIES_LOSSES) X(drive, BODIES_DRIVES) X(way_x, BODIES_AIR) X(way_y, BODIES_AIR) \
    X(air_x, BODIES_AIR) X(air_y, BODIES_AIR) X(air_part, BODIES_FAST_AIR) \
    X(friction_curve, BODIES_FRICTION) X(friction_rest, BODIES_FRICTION) \
    X(base_way_x, BODIES_DRAG_PER_MASS) X(base_way_y, BODIES_DRAG_PER_MASS)
// clang-format on

/* Which series a pendulum needs. */
enum bodies_need {
    BODIES_LOSSES = 2,
    BODIES_DRIVES = 4,
    BODIES_AIR = 8,
    BODIES_FAST_AIR = 16,
    BODIES_FRICTION = 32,
    BODIES_DRAG_PER_MASS = 64,
    BODIES_SPRINGS = 128,
    BODIES_PIVOT = 256,
    BODIES_SHAPE = 512, /* masses other than points at tips, or arms attached elsewhere */
    BODIES_JOINTS = BODIES_LOSSES | BODIES_DRIVES | BODIES_SPRINGS
};

/** Returns the bits of bodies_need that apply to a pendulum. Bit 0 is always set. O(harmonics). */
static inline unsigned bodies_needs(const struct pend_terms *terms) {
    static const struct {
        enum pend_term_row row;
        unsigned need;
    } rows[] = {
        {PEND_TERM_ROD, BODIES_SHAPE},
        {PEND_TERM_BODY, BODIES_SHAPE},
        {PEND_TERM_AT_X, BODIES_SHAPE},
        {PEND_TERM_DAMPING, BODIES_LOSSES},
        {PEND_TERM_FRICTION, BODIES_LOSSES | BODIES_FRICTION},
        {PEND_TERM_STIFFNESS, BODIES_SPRINGS},
        {PEND_TERM_TORQUE, BODIES_DRIVES},
        {PEND_TERM_INPUT, BODIES_DRIVES},
        {PEND_TERM_SLIDE, BODIES_LOSSES},
        {PEND_TERM_DRAG, BODIES_AIR},
        {PEND_TERM_DRAG_QUADRATIC, BODIES_AIR | BODIES_FAST_AIR},
    };
    const int *one = terms->one;
    unsigned need = 1;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
        if (terms->row[rows[i].row] >= 0) need |= rows[i].need;
    for (int i = 0; i < terms->harmonics; i++)
        need |= terms->harmonic[i].drives < 0 ? BODIES_PIVOT : BODIES_DRIVES;
    if (one[PEND_TERM_PIVOT_ACCELERATION_X] >= 0 || one[PEND_TERM_PIVOT_TRACK] >= 0)
        need |= BODIES_PIVOT;
    if (one[PEND_TERM_DRAG_PER_MASS] >= 0) need |= BODIES_DRAG_PER_MASS;
    return need;
}

struct bodies_system {
    int n;
    size_t stride, tile; /* index distance from one order to the next; from one tile of eight arms
                          * to the next */
    unsigned need;       /* bits of enum bodies_need */
    const int *parent;
    const struct pend_terms *terms;
    const num *len, *mass; /* m; kg, masses at the tips */
    const num *value;      /* values of the terms */
    num *rate, *force, *turn_re,
        *turn_im;           /* series; order j of arm k at bodies_row(k) + j stride */
    num *lift_x, *lift_y;   /* of the pivot: z'' + 2 gamma z' plus gravity, order + 1
                             * coefficients */
    num *slide_x, *slide_y; /* series of the pivot's z'; order + 1 coefficients */
    num *share;             /* 1 / (j + 1), order + 1 numbers */
    num *pivot_force_x,
        *pivot_force_y; /* the force that the pivot exerts, in fixed axes; `order` coefficients */
#define X(name) num *name;
    BODIES_ARRAYS(X)
#undef X
#define X(name, need) num *name;
    BODIES_SERIES(X)
#undef X
};

/** Returns non-zero if arm k is attached elsewhere than at the default point of its siblings: the
 * tip, or the cart. O(1). */
static inline int bodies_hung(const struct bodies_system *s, int k) {
    return s->terms->hung[k] && !(s->parent[k] == 0 && pend_terms_cart(s->terms));
}

/** Returns the index at which the series of arm k start. */
static inline size_t bodies_row(const struct bodies_system *s, int k) {
    return (size_t)(k / 8) * s->tile + (size_t)(k % 8);
}

enum {
#define X(name) BODIES_ARRAY_##name,
    BODIES_ARRAYS(X)
#undef X
        BODIES_ARRAY_COUNT,
    BODIES_PIVOT_SERIES = 7
};

/** Returns the number of numbers that bodies_lay needs. `seats`: size of an array with one value
 * per arm; `series`: size of a series; `order`: the highest order. O(harmonics). */
static inline size_t bodies_numbers(const struct pend_terms *terms, size_t seats, size_t series,
                                    int order) {
    unsigned need = bodies_needs(terms);
    size_t count = 0;
#define X(name, needs) count += need & (needs) ? 1 : 0;
    BODIES_SERIES(X)
#undef X
    return count * series + BODIES_ARRAY_COUNT * seats +
           (size_t)BODIES_PIVOT_SERIES * ((size_t)(order + 8) / 8 * 8);
}

/** Places the arrays of a system in memory of bodies_numbers; the caller sets the other members. */
static inline void bodies_lay(struct bodies_system *s, size_t seats, size_t series, int order,
                              num *at) {
    s->need = bodies_needs(s->terms);
#define X(name, needs)                                                                             \
    s->name = s->need & (needs) ? at : NULL;                                                       \
    if (s->name) at += series;
    BODIES_SERIES(X)
#undef X
#define X(name) s->name = at, at += seats;
    BODIES_ARRAYS(X)
#undef X
    size_t pivot = (size_t)(order + 8) / 8 * 8;
    s->lift_x = at, s->lift_y = at + pivot;
    s->slide_x = at + 2 * pivot, s->slide_y = at + 3 * pivot;
    s->pivot_force_x = at + 4 * pivot, s->pivot_force_y = at + 5 * pivot;
    s->share = at + 6 * pivot;
}
