/* Series of the forces on a real pendulum (springs, friction, drives, drag) and of the power of the
 * non-conservative forces. For any kind of number.
 * Leaves to others: the motion (bodies_template, which includes this).
 * Invariant: a term that a pendulum does not have costs only a test. */
#pragma once

#include <assert.h>

#include "core/bodies/bodies_arms.h"
#include "core/bodies/harmonic_template.h"

/* ---- drives */

/* adds the input of a piece, a polynomial of degree 1 in time */
static inline void bodies_input(const struct bodies_system *s, const struct bodies_moment *now,
                                int a, num *drive) {
    num rise = bodies_get(s, PEND_TERM_INPUT_RATE, a);
    num since = num_add(num_sub(now->time, bodies_one(s, PEND_TERM_PIECE)), now->late);
    drive[0] = num_add(drive[0], num_fma(rise, since, bodies_get(s, PEND_TERM_INPUT, a)));
    drive[s->stride] = num_add(drive[s->stride], num_mul(rise, now->unit));
}

/* computes the series of the driven torques */
static inline void bodies_drive(const struct bodies_system *s, const struct bodies_moment *now,
                                int order) {
    if (!(s->need & BODIES_DRIVES)) return;
    arms square = arms_all(num_mul(now->unit, now->unit));
    for (int a = 0; a < s->n; a++) {
        num *drive = s->drive + bodies_row(s, a);
        for (int j = 0; j <= order; j++) drive[(size_t)j * s->stride] = num_of(0);
        drive[0] = bodies_get(s, PEND_TERM_TORQUE, a);
        if (s->terms->row[PEND_TERM_INPUT] >= 0) bodies_input(s, now, a, drive);
    }
    for (int i = 0; i < s->terms->harmonics; i++) {
        const struct pend_harmonic *h = &s->terms->harmonic[i];
        if (h->drives >= 0)
            bodies_harmonic(s->value + h->at, s->share, now, 0, order,
                            s->drive + bodies_row(s, h->drives), s->stride);
    }
    for (int a = 0; a < s->n; a += BODIES_ARMS) {
        num *drive = s->drive + bodies_row(s, a);
        for (int j = 0; j <= order; j++, drive += s->stride)
            arms_put(drive, arms_mul(square, arms_get(drive)));
    }
}

/* converts the values of joints and drag to the unit of time; padding arms of the last vector get a
 * non-zero drag speed */
static inline void bodies_scale(const struct bodies_system *s, const struct bodies_moment *now) {
    num unit = now->unit, square = num_mul(unit, unit);
    int last = (s->n + BODIES_ARMS - 1) / BODIES_ARMS * BODIES_ARMS;
    for (int a = 0; a < s->n && s->need & BODIES_JOINTS; a++) {
        s->damping[a] = num_mul(unit, bodies_get(s, PEND_TERM_DAMPING, a));
        s->stiffness[a] = num_mul(square, bodies_get(s, PEND_TERM_STIFFNESS, a));
        s->rest[a] = bodies_get(s, PEND_TERM_REST, a);
        s->slide[a] = num_mul(square, bodies_get(s, PEND_TERM_SLIDE, a));
        if (!(s->need & BODIES_FRICTION)) continue;
        s->friction[a] = num_mul(square, bodies_get(s, PEND_TERM_FRICTION, a));
        s->friction_scale[a] =
            num_div(num_of(1), num_mul(unit, bodies_get(s, PEND_TERM_FRICTION_SPEED, a)));
    }
    for (int a = 0; a < s->n && s->need & BODIES_AIR; a++) {
        s->air_slow[a] = num_mul(unit, bodies_get(s, PEND_TERM_DRAG, a));
        s->air_fast[a] = bodies_get(s, PEND_TERM_DRAG_QUADRATIC, a);
        s->air_least[a] = num_mul(unit, bodies_get(s, PEND_TERM_DRAG_SPEED, a));
    }
    for (int a = s->n; a < last; a++) s->air_least[a] = unit;
}

/* ---- products of series */

/* adds sum_{j <= k} x_j y_{k-j} */
VEC_INLINE arms bodies_product(const struct bodies_system *s, const num *x, const num *y, int k,
                               arms sum) {
    arms other = arms_of(0);
    y += (size_t)k * s->stride;
    for (int j = 0; j <= k; j++, x += s->stride, y -= s->stride) {
        arms swap = arms_fma(arms_get(x), arms_get(y), sum);
        sum = other, other = swap;
    }
    return arms_add(sum, other);
}

/* sum_{from <= j <= k - from} x_j x_{k-j} */
VEC_INLINE arms bodies_square(const struct bodies_system *s, const num *x, int k, int from) {
    const num *y = x + (size_t)(k - from) * s->stride;
    arms sum = arms_of(0);
    x += (size_t)from * s->stride;
    for (; x < y; x += s->stride, y -= s->stride) sum = arms_fma(arms_get(x), arms_get(y), sum);
    sum = arms_add(sum, sum);
    return x == y ? arms_fma(arms_get(x), arms_get(x), sum) : sum;
}

/* ---- torques at the joints */

/* coefficient k of the rate of arm a relative to its parent */
VEC_INLINE num bodies_swing(const struct bodies_system *s, int a, int k) {
    int p = pend_terms_holder(s->terms, s->parent, a);
    size_t at = (size_t)k * s->stride;
    num w = s->rate[bodies_row(s, a) + at];
    return p < 0 ? w : num_sub(w, s->rate[bodies_row(s, p) + at]);
}

/*
 * Order k of tanh x, x the joint's speed over the friction's, for the arms from a on.
 *
 * With the sign g of x at the start, tanh x = g (1 - 2 w), w = 1 / (e^{2 g x} + 1), and
 * w' = -2 g x' (w - w^2). A joint that turns fast has a tiny w, whose coefficients keep their
 * relative accuracy. While the joint slows down, w and its error grow by the same factor; an
 * absolute error of 1e-16 in tanh x would grow by that factor too. */
static inline arms bodies_friction(const struct bodies_system *s, int a, int k) {
    size_t row = bodies_row(s, a), stride = s->stride, last = row + (size_t)k * stride;
    arms scale = arms_get(s->friction_scale + a), w = arms_of(0), tanh_x;
    arms start = arms_mul(arms_get(s->swing + row), scale), sign = arms_sign(start);
    arms twice = arms_mul(arms_of(-2), sign);
    if (k) {
        for (int j = 1; j <= k; j++) {
            arms x = arms_mul(arms_get(s->swing + row + (size_t)j * stride), arms_of(j));
            w = arms_fma(x, arms_get(s->friction_rest + last - (size_t)j * stride), w);
        }
        w = arms_mul(w, arms_mul(arms_mul(twice, scale), arms_all(s->share[k - 1])));
        tanh_x = arms_mul(twice, w);
    } else {
        tanh_x = arms_mul(sign, arms_tanh(arms_mul(sign, start), &w));
    }
    arms_put(s->friction_curve + last, w);
    arms_put(s->friction_rest + last, arms_sub(w, bodies_square(s, s->friction_curve + row, k, 0)));
    return tanh_x;
}

/*
 * The longest step, in units, within which no joint's friction can change sign undetected; at most
 * `far`.
 *
 * While x = speed / friction speed is large, w is too small to limit the step by its size, and a
 * step would pass over the moment at which the joint stops. So x may change by 40 % or by 8,
 * whichever is larger; each of the orders 1 to 4 may contribute a quarter of this change. Below |x|
 * = 20 the coefficients of w limit the step. */
static inline num bodies_reach(const struct bodies_system *s, num far) {
    enum { ORDERS = 4 };
    arms least = arms_all(far);
    for (int a = 0; a < s->n; a += BODIES_ARMS) {
        size_t row = bodies_row(s, a);
        arms scale = arms_get(s->friction_scale + a), part = arms_of(2);
        for (int k = 0; k <= ORDERS; k++) {
            arms x = arms_mul(arms_get(s->swing + row + (size_t)k * s->stride), scale);
            x = arms_mul(x, arms_sign(x));
            if (!k) {
                part = arms_most(part, arms_mul(x, arms_of(0.1)));
                continue;
            }
            arms ratio = arms_div(part, arms_add(x, arms_of(0x1p-600)));
            arms root = arms_root(ratio), fourth = arms_root(root);
            if (k == 1) fourth = ratio;
            if (k == 2) fourth = root;
            if (k == 3) fourth = arms_neg(arms_most(arms_neg(root), arms_neg(fourth)));
            least = arms_neg(arms_most(arms_neg(least), arms_neg(fourth)));
        }
    }
#if defined NUMBER_VEC && NUMBER_VEC == 1
    for (int i = 0; i < WIDE; i++) far = fmin(far, least[i]);
    return far;
#else
    return least;
#endif
}

/* computes the torques of order k at the joints of the arms from a on */
static inline arms bodies_torque(const struct bodies_system *s, int a, int k) {
    size_t now = bodies_row(s, a) + (size_t)k * s->stride;
    arms torque = arms_of(0);
    if (s->need & BODIES_SPRINGS) {
        arms bent = arms_sub(arms_get(s->bend + a), arms_get(s->rest + a));
        if (k) bent = arms_mul(arms_get(s->swing + now - s->stride), arms_all(s->share[k - 1]));
        torque = arms_neg(arms_mul(arms_get(s->stiffness + a), bent));
    }
    if (s->need & BODIES_LOSSES) {
        arms loss = arms_mul(arms_get(s->damping + a), arms_get(s->swing + now));
        if (s->need & BODIES_FRICTION)
            loss = arms_fma(arms_get(s->friction + a), bodies_friction(s, a, k), loss);
        loss = arms_neg(loss);
        if (!k && s->terms->row[PEND_TERM_SLIDE] >= 0)
            loss = arms_add(loss, arms_get(s->slide + a));
        arms_put(s->loss + now, loss);
        torque = arms_add(torque, loss);
    }
    if (s->need & BODIES_DRIVES) torque = arms_add(torque, arms_get(s->drive + now));
    return torque;
}

/* computes order k of the sum of all torques on every arm */
static inline void bodies_couple(const struct bodies_system *s, int k) {
    size_t now = (size_t)k * s->stride;
    for (int a = 0; a < s->n; a++) s->swing[bodies_row(s, a) + now] = bodies_swing(s, a, k);
    for (int a = 0; a < s->n; a += BODIES_ARMS) arms_put(s->couple + a, bodies_torque(s, a, k));
    // an arm's torque is read before its children subtract theirs from it
    for (int a = 1; a < s->n; a++) {
        int p = pend_terms_holder(s->terms, s->parent, a);
        if (p < 0) continue;
        s->couple[p] = num_sub(s->couple[p], s->couple[a]);
    }
}

/* ---- drag */

/* velocities of joints and tips, order k */
static inline void bodies_move(const struct bodies_system *s, int k) {
    num more = num_of(k + 1), x = s->slide_x[k], y = s->slide_y[k];
    size_t now = (size_t)k * s->stride, next = now + s->stride;
    for (int a = 0; a < s->n; a++) {
        num C = s->cosine[a], Z = s->sine[a], vx, vy;
        int p = s->parent[a];
        if (p >= 0) x = s->speed_x[p], y = s->speed_y[p];
        vx = num_fma(C, x, num_mul(Z, y)), vy = num_sub(num_mul(C, y), num_mul(Z, x));
        if (p >= 0) {
            size_t up = bodies_row(s, p) + next;
            num re = num_mul(more, s->turn_re[up]), im = num_mul(more, s->turn_im[up]);
            if (!p && pend_terms_cart(s->terms)) im = bodies_cart_speed(s, k);
            num px = s->place_x[a], py = s->place_y[a];
            vx = num_add(vx, num_sub(num_mul(px, re), num_mul(py, im)));
            vy = num_add(vy, num_fma(py, re, num_mul(px, im)));
        }
        s->speed_x[a] = vx, s->speed_y[a] = vy;
    }
    for (int a = 0; a < s->n; a += BODIES_ARMS) {
        size_t row = bodies_row(s, a) + now;
        arms vx = arms_get(s->speed_x + a), vy = arms_get(s->speed_y + a);
        if (s->need & BODIES_DRAG_PER_MASS) arms_put(s->base_way_x + row, vx);
        if (s->need & BODIES_DRAG_PER_MASS) arms_put(s->base_way_y + row, vy);
        if (!(s->need & BODIES_AIR)) continue;
        arms l = arms_mul(arms_get(s->len + a), arms_of(k + 1));
        row += s->stride;
        vx = arms_fma(l, arms_get(s->turn_re + row), vx);
        vy = arms_fma(l, arms_get(s->turn_im + row), vy);
        arms_put(s->way_x + row - s->stride, vx);
        arms_put(s->way_y + row - s->stride, vy);
    }
}

/* sqrt(|v|^2 + e^2) of the tips of arms from arm a on, order k */
static inline void bodies_air_speed(const struct bodies_system *s, const struct bodies_moment *now,
                                    int a, int k) {
    size_t row = bodies_row(s, a), last = row + (size_t)k * s->stride;
    arms sum = bodies_square(s, s->way_x + row, k, 0);
    sum = arms_add(sum, bodies_square(s, s->way_y + row, k, 0));
    if (!k) {
        // the root has the sign of the unit, which multiplies speeds; this is exact, because the
        // unit is a power of two
        arms least = arms_get(s->air_least + a), unit = arms_all(now->unit);
        sum = arms_fma(least, least, sum);
        arms root = arms_mul(unit, arms_root(arms_div(sum, arms_mul(unit, unit))));
        arms_put(s->air_part + last, root);
        arms_put(s->air_share + a, arms_div(arms_of(0.5), root));
        return;
    }
    sum = arms_sub(sum, bodies_square(s, s->air_part + row, k, 1));
    arms_put(s->air_part + last, arms_mul(sum, arms_get(s->air_share + a)));
}

/* computes order k of the drag on the tips of the arms from a on */
static inline void bodies_air_force(const struct bodies_system *s, const struct bodies_moment *now,
                                    int a, int k) {
    size_t row = bodies_row(s, a), last = row + (size_t)k * s->stride;
    arms b = arms_get(s->air_slow + a), none = arms_of(0);
    arms x = arms_mul(b, arms_get(s->way_x + last)), y = arms_mul(b, arms_get(s->way_y + last));
    if (s->need & BODIES_FAST_AIR) {
        arms d = arms_get(s->air_fast + a);
        bodies_air_speed(s, now, a, k);
        x = arms_fma(d, bodies_product(s, s->air_part + row, s->way_x + row, k, none), x);
        y = arms_fma(d, bodies_product(s, s->air_part + row, s->way_y + row, k, none), y);
    }
    x = arms_neg(x), y = arms_neg(y);
    arms_put(s->drag_x + a, x);
    arms_put(s->drag_y + a, y);
    arms_put(s->air_x + last, x);
    arms_put(s->air_y + last, y);
}

/* computes order k of all forces on the arms */
static inline void bodies_load(const struct bodies_system *s, const struct bodies_moment *now,
                               int k) {
    if (s->need & BODIES_JOINTS) bodies_couple(s, k);
    if (s->need & (BODIES_AIR | BODIES_DRAG_PER_MASS)) bodies_move(s, k);
    for (int a = 0; a < s->n && s->need & BODIES_AIR; a += BODIES_ARMS)
        bodies_air_force(s, now, a, k);
}

/* ---- power */

/* maximum number of orders of a series whose power is computed */
enum { BODIES_ORDERS = 48 };

/* Order k of sum m |v|^2 over the masses of an arm, for the arms from a on: half the power of drag
 * per mass, divided by gamma. The frame of the body turns with u: |v_b|^2 M + 2 Re(conj(v_b) h u')
 * + J phi'^2. `low` is, here and in the functions below, the lowest order of a factor. */
static inline arms bodies_sweep(const struct bodies_system *s, int a, int k, int low) {
    size_t row = bodies_row(s, a), stride = s->stride;
    const num *x = s->base_way_x + row, *y = s->base_way_y + row;
    arms square = arms_add(bodies_square(s, x, k, low), bodies_square(s, y, k, low));
    arms spin = bodies_square(s, s->rate + row, k, low), part = arms_of(0), other = arms_of(0);
    for (int j = low; j <= k - low; j++) {
        size_t at = row + (size_t)(j + 1) * stride, back = (size_t)(k - j) * stride;
        arms re = arms_mul(arms_of(j + 1), arms_get(s->turn_re + at));
        arms im = arms_mul(arms_of(j + 1), arms_get(s->turn_im + at));
        arms vx = arms_get(x + back), vy = arms_get(y + back);
        part = arms_fma(vy, im, arms_fma(vx, re, part));
        other = arms_sub(arms_fma(vy, re, other), arms_mul(vx, im));
    }
    part = arms_fma(arms_get(s->moment_y + a), other, arms_mul(arms_get(s->moment_x + a), part));
    spin = arms_mul(arms_get(s->inertia + a), spin);
    return arms_add(arms_fma(arms_get(s->body + a), square, spin), arms_add(part, part));
}

/* adds to *sum the numbers of the arms from a on, in the order of the arms */
VEC_INLINE void bodies_gain(const struct bodies_system *s, int a, arms all, num *sum) {
    num part[BODIES_ARMS];
    arms_put(part, all);
    for (int i = 0; i < BODIES_ARMS && a + i < s->n; i++) *sum = num_add(*sum, part[i]);
}

/* order k of the heat of friction and drag of the arms from a on */
static inline arms bodies_taken(const struct bodies_system *s, int a, int k, int low, arms twice) {
    size_t row = bodies_row(s, a) + (size_t)low * s->stride;
    int left = k - 2 * low;
    arms heat = arms_of(0);
    if (s->need & BODIES_LOSSES)
        heat = bodies_product(s, s->loss + row, s->swing + row, left, heat);
    if (s->need & BODIES_AIR) {
        heat = bodies_product(s, s->air_x + row, s->way_x + row, left, heat);
        heat = bodies_product(s, s->air_y + row, s->way_y + row, left, heat);
    }
    heat = arms_neg(heat);
    return s->need & BODIES_DRAG_PER_MASS ? arms_fma(twice, bodies_sweep(s, a, k, low), heat)
                                          : heat;
}

/* the pivot's power, order k: Re(conj(F) z') with the force F that it exerts */
static inline num bodies_haul(const struct bodies_system *s, int k, int low) {
    num sum = num_of(0);
    for (int j = low; j <= k - low; j++) {
        sum = num_fma(s->pivot_force_x[j], s->slide_x[k - j], sum);
        sum = num_fma(s->pivot_force_y[j], s->slide_y[k - j], sum);
    }
    return sum;
}

/**
 * Computes the power of drives, and of friction and drag, as series in the unit of time:
 * coefficients 0 .. count - 1, J times unit^2; after bodies_orders.
 *
 * order  known order of the factors, at most BODIES_ORDERS.
 * count  order .. 2 order - 1: from `order` on only products of known factors. They matter for
 *        terms that are fast compared with the pendulum.
 *
 * O(n order count).
 */
static inline void bodies_power(const struct bodies_system *s, num unit, int order, int count,
                                num work[], num heat[]) {
    num drag_per_mass = num_mul(num_of(2), bodies_one(s, PEND_TERM_DRAG_PER_MASS));
    num cart = num_mul(num_of(2), num_mul(drag_per_mass, unit));
    arms twice = arms_all(num_mul(drag_per_mass, unit));
    int driven = s->need & BODIES_PIVOT;
    assert(order >= 1 && order <= BODIES_ORDERS && count >= order && count < 2 * order);
    for (int k = 0; k < count; k++) {
        int low = k < order ? 0 : k - order + 1;
        work[k] = driven ? bodies_haul(s, k, low) : num_of(0);
        heat[k] = num_of(0);
        for (int a = 0; a < s->n; a += BODIES_ARMS) {
            size_t row = bodies_row(s, a) + (size_t)low * s->stride;
            if (s->need & BODIES_DRIVES) {
                arms gain =
                    bodies_product(s, s->drive + row, s->swing + row, k - 2 * low, arms_of(0));
                bodies_gain(s, a, gain, &work[k]);
            }
            if (s->need & (BODIES_LOSSES | BODIES_AIR | BODIES_DRAG_PER_MASS))
                bodies_gain(s, a, bodies_taken(s, a, k, low, twice), &heat[k]);
        }
        if (s->need & BODIES_DRAG_PER_MASS && pend_terms_cart(s->terms))
            heat[k] = num_fma(cart, bodies_cart_sweep(s, k, low), heat[k]);
    }
}
