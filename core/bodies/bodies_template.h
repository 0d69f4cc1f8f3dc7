/* The motion of a real pendulum, with bodies, springs, friction, drag and drives, as power series
 * in time, O(n) per order, for any kind of number. It is the general form: the fast forms for ideal
 * pendulums agree with it up to rounding.
 * Leaves to others: memory (bodies_system), sines and cosines of the angles (the caller), drives
 * and friction (drives_template).
 * Invariant: the factorization adds positive terms only; no division in the orders.
 *
 * Derivation. The variable is x = t / unit. All quantities below are in this unit of time, forces
 * times unit^2. Gamma is drag_per_mass times unit. In the frame of an arm, fixed at the start, let
 * its joint have the acceleration a = z'' + 2 Gamma z' + i g, and its point p the acceleration a +
 * p U with
 *     U = u'' + 2 Gamma u' = i chi + kr,    u = e^{i (phi - phi_0)}.
 * Order k of U, with T_k = sum_{j>=1} u_j phi'_{k+1-j}:
 *     kr = -(k+1) (Im T - 2 Gamma Re u_{k+1}),    chi = (k+1) phi'_{k+1} + theta,
 *     theta = (k+1) (Re T + 2 Gamma Im u_{k+1}).
 * The force F on the arm at its joint, and the balance of moments about the joint:
 *     F = M a + h U + sum F_c - f
 *     J (phi'' + 2 Gamma phi') + Im(conj(u) [conj(h) a + sum conj(p_c) F_c - l f]) = tau.
 * The balance of moments about the center c, the inertia about which is I, has no large terms that
 * cancel for heavy masses:
 *     I (phi'' + 2 Gamma phi') + Im(conj(u) G) = tau,
 *     G = conj(c) F + sum conj(p_c - c) F_c - conj(l - c) f.
 * Suppose F_c = Phi_c a_c + beta_c. Then with P = R Phi_c R^T, R the rotation by the child's angle,
 * and e = i p_c:
 *     D = J + sum <e, P e>,   x = i h + sum P e,   X = x / D,   Phi = M + sum P - x x^T / D,
 *     chi = m / D - <X, a>,   m = mu - K kr + l f_y - sum <e, R beta_c>,
 *     mu = tau - Im(conj(u) G)_known + I ((k+1) Re T_k + 2 Gamma Re T_{k-1}),
 *     beta = z kr + X mu - N_tip^T f + sum N_c^T R beta_c,    N = 1 - e X^T,
 *     z = h + sum N_c^T P p,   K = sum <e, P p>,   a_c = R^T N_c a + conj(R) p (kr + i m / D).
 * bodies_factor_template computes Phi, N and their products without cancellation. */
#pragma once

#include "core/bodies/bodies_factor_template.h"
#include "core/bodies/drives_template.h"

/* ---- an order */

/* sums of an order: T, and the terms of Im (conj u G) with Re u and those with Im u */
struct bodies_sums {
    arms Tr, Ti, known, less;
};

/* adds the products of the turns of order j at `u` with rates and G of matching orders */
VEC_INLINE void bodies_meet(const struct bodies_system *s, size_t u, size_t rate, size_t push,
                            struct bodies_sums *sum) {
    arms ur = arms_get(s->turn_re + u), ui = arms_get(s->turn_im + u), w = arms_get(s->rate + rate);
    sum->Tr = arms_fma(ur, w, sum->Tr);
    sum->Ti = arms_fma(ui, w, sum->Ti);
    sum->known = arms_fma(ur, arms_get(s->push_y + push), sum->known);
    sum->less = arms_fma(ui, arms_get(s->push_x + push), sum->less);
}

/* bodies_meet without G */
VEC_INLINE void bodies_wind(const struct bodies_system *s, size_t u, size_t rate,
                            struct bodies_sums *sum) {
    arms w = arms_get(s->rate + rate);
    sum->Tr = arms_fma(arms_get(s->turn_re + u), w, sum->Tr);
    sum->Ti = arms_fma(arms_get(s->turn_im + u), w, sum->Ti);
}

/* computes theta, kr, m and beta of order k for the arms from a on, without their children's
 * contributions */
VEC_INLINE void bodies_prepare(const struct bodies_system *s, int a, int k, num gamma, arms Tr,
                               arms Ti, arms known) {
    size_t now = bodies_row(s, a) + (size_t)k * s->stride, next = now + s->stride;
    arms more = arms_of(k + 1), spun = arms_mul(more, Tr), turned = spun, pulled = arms_neg(Ti);
    if (s->need & BODIES_DRAG_PER_MASS) {
        // (u' / i)_k - phi'_k = T_{k-1}, computed without a difference
        arms twice = arms_all(num_mul(num_of(2), gamma));
        if (k) spun = arms_fma(twice, arms_get(s->wind_x + a), spun);
        turned = arms_fma(twice, arms_get(s->rate + now), spun);
        pulled = arms_fma(twice, arms_get(s->turn_re + next), pulled);
    }
    pulled = arms_mul(more, pulled);
    arms m = arms_fma(arms_get(s->spread + a), spun, arms_get(s->couple + a));
    m = arms_sub(m, known);
    arms x = arms_mul(arms_get(s->draw_x + a), pulled);
    arms y = arms_mul(arms_get(s->draw_y + a), pulled);
    x = arms_fma(arms_get(s->lever_x + a), m, x);
    y = arms_fma(arms_get(s->lever_y + a), m, y);
    if (s->need & BODIES_AIR) {
        arms fx = arms_get(s->drag_x + a), fy = arms_get(s->drag_y + a);
        x = arms_sub(x, arms_mul(arms_get(s->give_xx + a), fx));
        y = arms_sub(y, arms_mul(arms_get(s->give_xy + a), fx));
        x = arms_sub(x, arms_mul(arms_get(s->give_yx + a), fy));
        y = arms_sub(y, arms_mul(arms_get(s->give_yy + a), fy));
        m = arms_fma(arms_get(s->len + a), fy, m);
    }
    arms_put(s->wind_x + a, Tr);
    arms_put(s->wind_y + a, Ti);
    arms_put(s->turned + a, turned);
    arms_put(s->pulled + a, pulled);
    arms_put(s->asked_x + a, x);
    arms_put(s->asked_y + a, y);
    arms_put(s->answer + a, m);
}

/* The sums of orders k (even) and k + 1, without the terms that need order k, so that numbers are
 * loaded once for both. The terms that need order k - 1 are added last. */
static inline void bodies_convolve(const struct bodies_system *s, int k, num gamma) {
    size_t stride = s->stride, last = (size_t)k * stride;
    for (int a = 0; a < s->n; a += BODIES_ARMS) {
        size_t row = bodies_row(s, a);
        arms none = arms_of(0);
        struct bodies_sums now = {none, none, none, none}, next = now;
        for (size_t j = 3 * stride; j <= last; j += stride) {
            size_t back = row + last - j, ahead = back + stride;
            bodies_meet(s, row + j, ahead, back, &now);
            bodies_meet(s, row + j, ahead + stride, ahead, &next);
        }
        if (k) {
            size_t two = row + 2 * stride, end = row + last + stride, back = row + last - stride;
            bodies_meet(s, two, back, back - stride, &now);
            bodies_meet(s, two, back + stride, back, &next);
            bodies_wind(s, end, row, &now);
            bodies_meet(s, end, row + stride, row, &next);
        }
        // u_1 is imaginary
        arms first = arms_get(s->turn_im + row + stride);
        now.Ti = arms_fma(first, arms_get(s->rate + row + last), now.Ti);
        if (k) now.less = arms_fma(first, arms_get(s->push_x + row + last - stride), now.less);
        arms_put(s->next_x + a, next.Tr);
        arms_put(s->next_y + a, next.Ti);
        arms_put(s->next_known + a, arms_sub(next.known, next.less));
        bodies_prepare(s, a, k, gamma, now.Tr, now.Ti, arms_sub(now.known, now.less));
    }
}

/* the missing terms of the sums of order k, the second of two orders */
static inline void bodies_complete(const struct bodies_system *s, int k, num gamma) {
    for (int a = 0; a < s->n; a += BODIES_ARMS) {
        size_t row = bodies_row(s, a), now = row + (size_t)k * s->stride;
        struct bodies_sums sum = {arms_get(s->next_x + a), arms_get(s->next_y + a),
                                  arms_get(s->next_known + a), arms_of(0)};
        bodies_wind(s, now + s->stride, row, &sum);
        arms first = arms_get(s->turn_im + row + s->stride);
        sum.Ti = arms_fma(first, arms_get(s->rate + now), sum.Ti);
        sum.less = arms_fma(first, arms_get(s->push_x + now - s->stride), sum.less);
        bodies_prepare(s, a, k, gamma, sum.Tr, sum.Ti, arms_sub(sum.known, sum.less));
    }
}

/* Leaves to root: beta, and m / D. If the next arm is the parent, its values stay in registers. */
static inline void bodies_up(const struct bodies_system *s) {
    int last = s->n - 1;
    num ax = s->asked_x[last], ay = s->asked_y[last];
    for (int c = last; c > 0; c--) {
        int p = s->parent[c];
        num x = num_fma(s->carry_xx[c], ax, s->asked_x[p]);
        num y = num_fma(s->carry_xy[c], ax, s->asked_y[p]);
        num before = s->answer[p], moment = num_fma(s->place_y[c], ax, before);
        s->early_m[c] = before;
        x = num_fma(s->carry_yx[c], ay, x);
        y = num_fma(s->carry_yy[c], ay, y);
        s->answer[p] = num_sub(moment, num_mul(s->place_x[c], ay));
        s->asked_x[p] = x, s->asked_y[p] = y;
        ax = x, ay = y;
        if (p != c - 1) ax = s->asked_x[c - 1], ay = s->asked_y[c - 1];
    }
    for (int a = 0; a < s->n; a += BODIES_ARMS) {
        arms m = arms_get(s->answer + a);
        m = arms_sub(m, arms_mul(arms_get(s->twist + a), arms_get(s->pulled + a)));
        arms_put(s->answer + a, arms_mul(m, arms_get(s->inv_total + a)));
    }
}

/* computes the force at the joint of arm a from the acceleration (ax, ay) of its parent's base;
 * `late` has the moments on the parent from its children before a */
VEC_INLINE void bodies_pull(const struct bodies_system *s, int a, num ax, num ay, num late) {
    int p = s->parent[a];
    num kr = s->pulled[p], m = num_add(s->early_m[a], late);
    num bx = s->asked_x[a], by = s->asked_y[a];
    num fx = num_fma(s->sway_xx[a], ax, num_mul(s->sway_xy[a], ay));
    num fy = num_fma(s->sway_yx[a], ax, num_mul(s->sway_yy[a], ay));
    num gx = num_fma(s->swing_x[a], kr, num_mul(s->turn_x[a], m));
    num gy = num_fma(s->swing_y[a], kr, num_mul(s->turn_y[a], m));
    fx = num_fma(s->keep_xx[a], bx, num_fma(s->keep_xy[a], by, fx));
    fy = num_fma(s->keep_yx[a], bx, num_fma(s->keep_yy[a], by, fy));
    late = num_fma(s->place_y[a], bx, late);
    s->late_m[p] = num_sub(late, num_mul(s->place_x[a], by));
    s->reach_x[a] = num_add(fx, gx);
    s->reach_y[a] = num_add(fy, gy);
}

/* computes the joint forces of the arms from a on, from the accelerations of their own bases */
VEC_INLINE void bodies_feel(const struct bodies_system *s, int a) {
    arms x = arms_get(s->base_x + a), y = arms_get(s->base_y + a), xy = arms_get(s->form_xy + a);
    arms fx = arms_fma(arms_get(s->form_xx + a), x, arms_mul(xy, y));
    arms fy = arms_fma(xy, x, arms_mul(arms_get(s->form_yy + a), y));
    arms_put(s->reach_x + a, arms_add(arms_get(s->asked_x + a), fx));
    arms_put(s->reach_y + a, arms_add(arms_get(s->asked_y + a), fy));
}

/* root to leaves: accelerations, and forces at the joints; with point masses, by the coefficients
 * of bodies_hold */
static inline void bodies_down(const struct bodies_system *s, int k) {
    num x = s->lift_x[k], y = s->lift_y[k], C = s->cosine[0], Z = s->sine[0];
    num ax = num_fma(C, x, num_mul(Z, y)), ay = num_sub(num_mul(C, y), num_mul(Z, x));
    s->base_x[0] = ax, s->base_y[0] = ay;
    num xy = s->form_xy[0];
    int shaped = (s->need & BODIES_SHAPE) != 0;
    s->reach_x[0] = num_fma(s->form_xx[0], ax, num_fma(xy, ay, s->asked_x[0]));
    s->reach_y[0] = num_fma(xy, ax, num_fma(s->form_yy[0], ay, s->asked_y[0]));
    for (int a = 1; a < s->n; a++) {
        int p = s->parent[a];
        num kr = s->pulled[p], chi = s->answer[p], px = s->place_x[a], py = s->place_y[a];
        num late = num_of(0);
        x = num_sub(num_mul(px, kr), num_mul(py, chi));
        y = num_fma(py, kr, num_mul(px, chi));
        if (p != a - 1) ax = s->base_x[p], ay = s->base_y[p], late = s->late_m[p];
        if (!shaped) bodies_pull(s, a, ax, ay, late);
        x = num_fma(s->carry_xx[a], ax, x);
        y = num_fma(s->carry_yx[a], ax, y);
        x = num_fma(s->carry_xy[a], ay, x);
        y = num_fma(s->carry_yy[a], ay, y);
        s->base_x[a] = ax = x, s->base_y[a] = ay = y;
    }
    for (int a = 0; a < s->n; a += BODIES_ARMS) {
        arms across = arms_mul(arms_get(s->lever_y + a), arms_get(s->base_y + a));
        arms way = arms_fma(arms_get(s->lever_x + a), arms_get(s->base_x + a), across);
        arms_put(s->answer + a, arms_sub(arms_get(s->answer + a), way));
        if (shaped) bodies_feel(s, a);
    }
}

/* The forces at the tips of arms from a on. With point masses this is the force at the joint;
 * otherwise the children's forces are still missing. */
VEC_INLINE void bodies_tip(const struct bodies_system *s, size_t row, int a) {
    arms x = arms_get(s->reach_x + a), y = arms_get(s->reach_y + a);
    if (s->need & BODIES_SHAPE) {
        arms m = arms_get(s->mass + a), l = arms_get(s->len + a);
        x = arms_mul(m, arms_fma(l, arms_get(s->pulled + a), arms_get(s->base_x + a)));
        y = arms_mul(m, arms_fma(l, arms_get(s->answer + a), arms_get(s->base_y + a)));
        if (s->need & BODIES_AIR) {
            x = arms_sub(x, arms_get(s->drag_x + a));
            y = arms_sub(y, arms_get(s->drag_y + a));
        }
    }
    arms_put(s->tip_x + row, x);
    arms_put(s->tip_y + row, y);
}

/* adds the force of arm a to that at its parent's tip, order k */
VEC_INLINE void bodies_tip_child(const struct bodies_system *s, int a, int k) {
    size_t up = bodies_row(s, s->parent[a]) + (size_t)k * s->stride;
    num C = s->cosine[a], Z = s->sine[a], x = s->reach_x[a], y = s->reach_y[a];
    if (bodies_hung(s, a)) return;
    s->tip_x[up] = num_add(s->tip_x[up], num_sub(num_mul(C, x), num_mul(Z, y)));
    s->tip_y[up] = num_add(s->tip_y[up], num_fma(Z, x, num_mul(C, y)));
}

/* adds the forces of the arms, beginning with arm a, to their own G and that of their parents */
static inline void bodies_press(const struct bodies_system *s, size_t row, int a) {
    arms x = arms_get(s->reach_x + a), y = arms_get(s->reach_y + a);
    arms cx = arms_get(s->center_x + a), cy = arms_get(s->center_y + a);
    arms px = arms_get(s->stem_x + a), py = arms_get(s->stem_y + a);
    arms push_x = arms_fma(cx, x, arms_mul(cy, y));
    arms push_y = arms_sub(arms_mul(cx, y), arms_mul(cy, x));
    if (s->need & BODIES_AIR && s->need & BODIES_SHAPE) {
        arms fx = arms_get(s->drag_x + a), fy = arms_get(s->drag_y + a);
        arms dx = arms_get(s->tail_x + a), dy = arms_get(s->tail_y + a);
        push_x = arms_sub(push_x, arms_fma(dx, fx, arms_mul(dy, fy)));
        push_y = arms_sub(push_y, arms_sub(arms_mul(dx, fy), arms_mul(dy, fx)));
    }
    arms_put(s->push_x + row, push_x);
    arms_put(s->push_y + row, push_y);
    if (!(s->need & BODIES_SHAPE)) return;
    arms_put(s->heave_x + a, arms_fma(px, x, arms_mul(py, y)));
    arms_put(s->heave_y + a, arms_sub(arms_mul(px, y), arms_mul(py, x)));
}

/* the force that the pivot exerts, in fixed axes: the force at the first joint */
VEC_INLINE void bodies_pivot_force_first(const struct bodies_system *s, int k) {
    num C = s->cosine[0], Z = s->sine[0], x = s->reach_x[0], y = s->reach_y[0];
    s->pivot_force_x[k] = num_sub(num_mul(C, x), num_mul(Z, y));
    s->pivot_force_y[k] = num_fma(Z, x, num_mul(C, y));
}

/* computes the coefficients of order k of forces, and of order k + 1 of rates and turns */
static inline void bodies_close(const struct bodies_system *s, int k) {
    arms share = arms_all(s->share[k]), turn_share = arms_all(s->share[k + 1]);
    size_t now = (size_t)k * s->stride;
    for (int a = 0; a < s->n; a += BODIES_ARMS) {
        size_t row = bodies_row(s, a) + now, next = row + s->stride;
        arms chi = arms_get(s->answer + a), Tr = arms_get(s->wind_x + a);
        arms rate = arms_mul(arms_sub(chi, arms_get(s->turned + a)), share);
        bodies_tip(s, row, a);
        bodies_press(s, row, a);
        arms_put(s->rate + next, rate);
        arms_put(s->turn_re + next + s->stride,
                 arms_neg(arms_mul(arms_get(s->wind_y + a), turn_share)));
        arms_put(s->turn_im + next + s->stride, arms_mul(arms_add(rate, Tr), turn_share));
    }
    if (pend_terms_cart(s->terms)) bodies_cart_still(s, k + 2);
    bodies_pivot_force_first(s, k);
    for (int a = 1; a < s->n && s->need & BODIES_SHAPE; a++) {
        size_t up = bodies_row(s, s->parent[a]) + now;
        s->push_x[up] = num_add(s->push_x[up], s->heave_x[a]);
        s->push_y[up] = num_add(s->push_y[up], s->heave_y[a]);
        bodies_tip_child(s, a, k);
    }
}

/* ---- all orders */

/* Prepares all orders: the factorization, drives, and the first rotation factors. Requires angles,
 * rates of order 0 and the values of the arms. */
static inline void bodies_begin(const struct bodies_system *s, const struct bodies_moment *now,
                                int order) {
    for (int j = 0; j <= order; j++) s->share[j] = num_div(num_of(1), num_of(j + 1));
    bodies_factor(s);
    bodies_scale(s, now);
    bodies_drive_pivot(s, now, order);
    bodies_drive(s, now, order);
    for (int a = 0; a < s->n; a++) {
        size_t row = bodies_row(s, a);
        s->turn_re[row] = num_of(1);
        s->turn_im[row] = s->turn_re[row + s->stride] = num_of(0);
        s->turn_im[row + s->stride] = s->rate[row];
    }
    if (pend_terms_cart(s->terms)) bodies_cart_still(s, 1);
}

/** Computes all orders: rate_1 .. rate_order and force_0 from rate_0, cosine, sine and bend. The
 * turns include a row of order 0, which is 1. O(n order^2). */
static inline void bodies_orders(const struct bodies_system *s, const struct bodies_moment *now,
                                 int order) {
    num gamma = num_mul(bodies_one(s, PEND_TERM_DRAG_PER_MASS), now->unit);
    assert(s->n >= 1 && order >= 1);
    bodies_begin(s, now, order);
    for (int k = 0; k < order; k++) {
        bodies_load(s, now, k);
        if (k % 2)
            bodies_complete(s, k, gamma);
        else
            bodies_convolve(s, k, gamma);
        bodies_up(s);
        bodies_down(s, k);
        bodies_close(s, k);
    }
    for (int a = 0; a < s->n; a += BODIES_ARMS)
        arms_put(s->force + bodies_row(s, a), arms_get(s->tip_x + bodies_row(s, a)));
}

/** Computes the forces along the arms at their tips: force_1 .. force_{order - 1}, after
 * bodies_orders. O(n order^2). */
static inline void bodies_forces(const struct bodies_system *s, int order) {
    for (int a = 0; a < s->n; a += BODIES_ARMS)
        for (int k = 1; k < order; k++) {
            size_t row = bodies_row(s, a), last = row + (size_t)k * s->stride;
            arms along = arms_get(s->tip_x + last), across = arms_of(0);
            for (size_t j = s->stride; j <= last - row; j += s->stride) {
                along =
                    arms_fma(arms_get(s->turn_re + row + j), arms_get(s->tip_x + last - j), along);
                across =
                    arms_fma(arms_get(s->turn_im + row + j), arms_get(s->tip_y + last - j), across);
            }
            arms_put(s->force + last, arms_add(along, across));
        }
}
