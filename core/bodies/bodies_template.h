/* The motion of a real pendulum, with bodies, springs, friction, drag and drives, as power series
 * in time, O(n) an order, written once for any kind of number. It is the general form: the quick
 * forms of ideal pendulums give what it gives, to rounding.
 * Leaves to others: memory (bodies_system), sines and cosines of the angles (the caller), drives
 * and friction (drives_template).
 * Invariant: the factorization adds positive terms only; no division in the orders.
 *
 * Derivation. Unknown time is x = t / unit; every quantity below is in it, forces times unit^2.
 * Gamma is drag_per_mass times unit. In the frame of an arm, fixed at the start, its joint has the
 * acceleration a = z'' + 2 Gamma z' + i g, and its point p the acceleration a + p U with
 *     U = u'' + 2 Gamma u' = i chi + kr,    u = e^{i (phi - phi_0)}.
 * Order k of U, with T_k = sum_{j>=1} u_j phi'_{k+1-j}:
 *     kr = -(k+1) (Im T - 2 Gamma Re u_{k+1}),    chi = (k+1) phi'_{k+1} + theta,
 *     theta = (k+1) (Re T + 2 Gamma Im u_{k+1}).
 * The force that the arm asks of its joint, and the balance of moments about the joint:
 *     F = M a + h U + sum F_c - f
 *     J (phi'' + 2 Gamma phi') + Im(conj(u) G) = tau,   G = conj(h) a + sum conj(p_c) F_c - l f.
 * Suppose F_c = Phi_c a_c + beta_c. Then with P = R Phi_c R^T, R the rotation by the child's angle,
 * and e = i p_c:
 *     D = J + sum <e, P e>, x = i h + sum P e, X = x / D, Phi = M + sum P - x x^T / D,
 *     chi = m / D - <X, a>,  m = tau - Im(conj(u) G)_known + J ki - K kr - sum <e, R beta_c> + l
 * f_y beta = y kr - f + sum R beta_c + X m,    y = h + sum P p,  K = sum <e, P p>, ki = theta - 2
 * Gamma phi'_k. Phi is formed without a difference: a body alone has M / J (I_c + M c c^T), and a
 * child adds N^T (D P + det P p p^T) N / (D + <e, P e>),   N = 1 - e X^T, which is what its own
 * form leaves when the arm gives way (Woodbury). */
#ifndef PEND_BODIES_TEMPLATE_H
#define PEND_BODIES_TEMPLATE_H

#include <assert.h>

#include "core/bodies/bodies_number.h"
#include "core/bodies/bodies_system.h"

/* what is computed for several arms at once */
#if defined NUMBER_VEC && NUMBER_VEC == 1
enum { BODIES_ARMS = WIDE };
typedef wide arms;
#define arms_of wide_of
#define arms_all wide_of
#define arms_fma wide_fma
#define arms_get wide_load
VEC_INLINE arms arms_add(arms x, arms y) { return x + y; }
VEC_INLINE arms arms_sub(arms x, arms y) { return x - y; }
VEC_INLINE arms arms_mul(arms x, arms y) { return x * y; }
VEC_INLINE arms arms_neg(arms x) { return -x; }
VEC_INLINE void arms_put(num *at, arms x) { memcpy(at, &x, sizeof x); }
#else
enum { BODIES_ARMS = 1 };
typedef num arms;
#define arms_of num_of
#define arms_fma num_fma
#define arms_add num_add
#define arms_sub num_sub
#define arms_mul num_mul
#define arms_neg num_neg
VEC_INLINE arms arms_all(num x) { return x; }
VEC_INLINE arms arms_get(const num *at) { return *at; }
VEC_INLINE void arms_put(num *at, arms x) { *at = x; }
#endif

/* the number of a term of arm k, 0 where there is none */
VEC_INLINE num bodies_get(const struct bodies_system *s, enum pend_term_row row, int k) {
    return s->terms->row[row] < 0 ? num_of(0) : s->value[s->terms->row[row] + k];
}

VEC_INLINE num bodies_one(const struct bodies_system *s, enum pend_term_one one) {
    return s->terms->one[one] < 0 ? num_of(0) : s->value[s->terms->one[one]];
}

#include "core/bodies/cart_template.h"
#include "core/bodies/drives_template.h"

/* ---- the factorization */

/* a body of a mass at x + i y joins those of an arm: `body`, first moment so far, and the inertia
 * about the common center, to which a pair adds m m' |c - c'|^2 / (m + m') */
struct bodies_heap {
    num mass, x, y, spread;
};

static inline void bodies_heap_add(struct bodies_heap *heap, num mass, num x, num y, num inertia) {
    num sum = num_add(heap->mass, mass), least = num_of(1e-250);
    num part = num_div(mass, num_add(sum, least));
    num dx = num_sub(x, heap->x), dy = num_sub(y, heap->y);
    num square = num_fma(dx, dx, num_mul(dy, dy));
    heap->spread = num_add(heap->spread, inertia);
    heap->spread = num_fma(num_mul(heap->mass, part), square, heap->spread);
    heap->x = num_fma(part, dx, heap->x);
    heap->y = num_fma(part, dy, heap->y);
    heap->mass = sum;
}

/* an arm alone: M, h, J, and its form */
static inline void bodies_alone(const struct bodies_system *s, int k) {
    num l = s->len[k], zero = num_of(0), rod = bodies_get(s, PEND_TERM_ROD, k);
    struct bodies_heap heap = {s->mass[k], l, zero, zero};
    if (!k && pend_terms_cart(s->terms)) heap.x = s->point_x[0], heap.y = s->point_y[0];
    if (s->terms->row[PEND_TERM_ROD] >= 0)
        bodies_heap_add(&heap, rod, num_mul(l, num_of(0.5)), zero,
                        num_div(num_mul(rod, num_mul(l, l)), num_of(12)));
    if (s->terms->row[PEND_TERM_BODY] >= 0)
        bodies_heap_add(&heap, bodies_get(s, PEND_TERM_BODY, k),
                        bodies_get(s, PEND_TERM_CENTER_X, k), bodies_get(s, PEND_TERM_CENTER_Y, k),
                        bodies_get(s, PEND_TERM_INERTIA, k));
    num M = heap.mass, hx = num_mul(M, heap.x), hy = num_mul(M, heap.y);
    num J = num_add(heap.spread, num_fma(hx, heap.x, num_mul(hy, heap.y)));
    num inverse = num_div(num_of(1), J), part = num_mul(M, inverse);
    s->body[k] = M, s->moment_x[k] = hx, s->moment_y[k] = hy;
    s->inertia[k] = s->total[k] = J;
    s->lever_x[k] = num_neg(num_mul(hy, inverse));
    s->lever_y[k] = num_mul(hx, inverse);
    s->form_xx[k] = num_mul(part, num_fma(hx, heap.x, heap.spread));
    s->form_xy[k] = num_mul(part, num_mul(hx, heap.y));
    s->form_yy[k] = num_mul(part, num_fma(hy, heap.y, heap.spread));
    s->form_det[k] = num_mul(num_mul(M, part), heap.spread);
    s->draw_x[k] = hx, s->draw_y[k] = hy, s->twist[k] = zero;
}

/* the child c, whose form is complete, joins arm p */
static inline void bodies_join(const struct bodies_system *s, int c, int p) {
    num C = s->cosine[c], Z = s->sine[c], px = s->point_x[c], py = s->point_y[c];
    num A = s->form_xx[c], B = s->form_xy[c], E = s->form_yy[c], det = s->form_det[c];
    // P = R Phi R^T
    num AC = num_sub(num_mul(A, C), num_mul(B, Z)), BC = num_sub(num_mul(B, C), num_mul(E, Z));
    num AZ = num_fma(A, Z, num_mul(B, C)), BZ = num_fma(B, Z, num_mul(E, C));
    num Pxx = num_sub(num_mul(C, AC), num_mul(Z, BC)), Pyy = num_fma(Z, AZ, num_mul(C, BZ));
    num Pxy = num_fma(Z, AC, num_mul(C, BC));
    // P p, and P e with e = i p
    num Qx = num_fma(Pxx, px, num_mul(Pxy, py)), Qy = num_fma(Pxy, px, num_mul(Pyy, py));
    num Ex = num_sub(num_mul(Pxy, px), num_mul(Pxx, py));
    num Ey = num_sub(num_mul(Pyy, px), num_mul(Pxy, py));
    num add = num_sub(num_mul(px, Ey), num_mul(py, Ex)), D = s->total[p];
    num inverse = num_div(num_of(1), num_add(D, add)), own = num_mul(D, inverse);
    num turn = num_mul(det, inverse);
    // what is left of P: (D P + det p p^T) / (D + <e, P e>)
    num Wxx = num_fma(own, Pxx, num_mul(turn, num_mul(px, px)));
    num Wxy = num_fma(own, Pxy, num_mul(turn, num_mul(px, py)));
    num Wyy = num_fma(own, Pyy, num_mul(turn, num_mul(py, py)));
    // N = 1 - e X^T
    num X = s->lever_x[p], Y = s->lever_y[p];
    num Nxx = num_fma(py, X, num_of(1)), Nxy = num_mul(py, Y);
    num Nyx = num_neg(num_mul(px, X)), Nyy = num_sub(num_of(1), num_mul(px, Y));
    num Vxx = num_fma(Wxx, Nxx, num_mul(Wxy, Nyx)), Vxy = num_fma(Wxx, Nxy, num_mul(Wxy, Nyy));
    num Vyx = num_fma(Wxy, Nxx, num_mul(Wyy, Nyx)), Vyy = num_fma(Wxy, Nxy, num_mul(Wyy, Nyy));
    num Uxx = num_fma(Nxx, Vxx, num_mul(Nyx, Vyx)), Uyy = num_fma(Nxy, Vxy, num_mul(Nyy, Vyy));
    num Uxy = num_fma(Nxx, Vxy, num_mul(Nyx, Vyy));
    // det W = det P (D + <e, P e>) D / (D + <e, P e>)^2 for det p p^T = 0
    num det_N = num_sub(num_fma(py, X, num_of(1)), num_mul(px, Y));
    num det_U = num_mul(num_mul(det, own), num_mul(det_N, det_N));
    num F = s->form_xx[p], G = s->form_xy[p], H = s->form_yy[p];
    num mixed = num_sub(num_fma(F, Uyy, num_mul(H, Uxx)), num_mul(num_of(2), num_mul(G, Uxy)));
    s->form_det[p] = num_add(s->form_det[p], num_add(det_U, mixed));
    s->form_xx[p] = num_add(F, Uxx);
    s->form_xy[p] = num_add(G, Uxy);
    s->form_yy[p] = num_add(H, Uyy);
    // X + N^T P e / (D + <e, P e>)
    s->lever_x[p] = num_fma(inverse, num_fma(Nxx, Ex, num_mul(Nyx, Ey)), X);
    s->lever_y[p] = num_fma(inverse, num_fma(Nxy, Ex, num_mul(Nyy, Ey)), Y);
    s->total[p] = num_add(D, add);
    s->draw_x[p] = num_add(s->draw_x[p], Qx);
    s->draw_y[p] = num_add(s->draw_y[p], Qy);
    s->twist[p] = num_add(s->twist[p], num_sub(num_mul(px, Qy), num_mul(py, Qx)));
}

/* where arm k hangs on its parent, in the parent's frame */
static inline void bodies_point(const struct bodies_system *s, int k) {
    int p = s->parent[k];
    if (p <= 0 && pend_terms_cart(s->terms)) {
        if (p < 0) bodies_cart_point(s);
        s->point_x[k] = s->point_x[0], s->point_y[k] = s->point_y[0];
        return;
    }
    s->point_x[k] = p < 0 ? num_of(0) : s->len[p];
    s->point_y[k] = num_of(0);
    if (!s->terms->hung[k]) return;
    s->point_x[k] = s->value[s->terms->row[PEND_TERM_AT_X] + k];
    s->point_y[k] = s->value[s->terms->row[PEND_TERM_AT_Y] + k];
}

/* what the sweeps multiply by at arm k, whose own form and whose parent's are complete: a sweep's
 * way from arm to arm is then two or three products long */
static inline void bodies_ways(const struct bodies_system *s, int k) {
    num C = s->cosine[k], Z = s->sine[k], X = s->lever_x[k], Y = s->lever_y[k];
    num px = s->point_x[k], py = s->point_y[k];
    num x = num_fma(C, px, num_mul(Z, py)), y = num_sub(num_mul(C, py), num_mul(Z, px));
    s->place_x[k] = x, s->place_y[k] = y;
    s->bear_x[k] = num_sub(num_mul(C, X), num_mul(Z, Y));
    s->bear_y[k] = num_fma(Z, X, num_mul(C, Y));
    s->yield[k] = num_sub(num_mul(x, Y), num_mul(y, X));
    if (!k) return;
    num up_x = s->lever_x[s->parent[k]], up_y = s->lever_y[s->parent[k]];
    s->carry_xx[k] = num_fma(y, up_x, C);
    s->carry_xy[k] = num_fma(y, up_y, Z);
    s->carry_yx[k] = num_neg(num_fma(x, up_x, Z));
    s->carry_yy[k] = num_sub(C, num_mul(x, up_y));
}

static inline void bodies_factor(const struct bodies_system *s) {
    for (int k = 0; k < s->n; k++) {
        bodies_point(s, k);
        bodies_alone(s, k);
    }
    for (int k = s->n - 1; k >= 0; k--) {
        s->inv_total[k] = num_div(num_of(1), s->total[k]);
        if (k) bodies_join(s, k, s->parent[k]);
    }
    for (int k = 0; k < s->n; k++) bodies_ways(s, k);
}

/* ---- an order */

/* 1 / (j + 1) */
VEC_INLINE num bodies_share(int j) { return num_div(num_of(1), num_of(j + 1)); }

/* theta, kr, and the known parts of Im (conj u G) and of the force along the arm at its tip; then m
 * and the force asked of the base, both without the children */
static inline void bodies_convolve(const struct bodies_system *s, int k, num gamma) {
    size_t stride = s->stride;
    arms more = arms_of(k + 1), twice = arms_all(num_mul(num_of(2), gamma));
    for (int a = 0; a < s->n; a += BODIES_ARMS) {
        size_t row = bodies_row(s, a), next = (size_t)(k + 1) * stride;
        const num *re = s->turn_re + row, *im = s->turn_im + row, *rate = s->rate + row + next;
        const num *push_x = s->push_x + row + next - stride,
                  *tip_x = s->tip_x + row + next - stride;
        const num *push_y = s->push_y + row + next - stride,
                  *tip_y = s->tip_y + row + next - stride;
        arms ur = arms_get(re + next), ui = arms_get(im + next), w = arms_get(rate - next);
        arms Tr = arms_mul(ur, w), Ti = arms_mul(ui, w), known = arms_of(0), less = arms_of(0);
        arms along = arms_of(0), across = arms_of(0);
        arms turned = arms_mul(twice, ui), pulled = arms_mul(twice, ur);
        for (size_t at = stride; at < next; at += stride) {
            ur = arms_get(re + at), ui = arms_get(im + at), w = arms_get(rate - at);
            Tr = arms_fma(ur, w, Tr);
            Ti = arms_fma(ui, w, Ti);
            known = arms_fma(ur, arms_get(push_y - at), known);
            less = arms_fma(ui, arms_get(push_x - at), less);
            along = arms_fma(ur, arms_get(tip_x - at), along);
            across = arms_fma(ui, arms_get(tip_y - at), across);
        }
        turned = arms_mul(more, arms_add(turned, Tr));
        pulled = arms_mul(more, arms_sub(pulled, Ti));
        arms_put(s->wind_x + a, Tr);
        arms_put(s->wind_y + a, Ti);
        arms_put(s->turned + a, turned);
        arms_put(s->pulled + a, pulled);
        arms_put(s->along + a, arms_add(along, across));
        arms slow = arms_mul(twice, arms_get(rate - stride));
        arms m =
            arms_fma(arms_get(s->inertia + a), arms_sub(turned, slow), arms_get(s->couple + a));
        m = arms_sub(arms_sub(m, arms_sub(known, less)), arms_mul(arms_get(s->twist + a), pulled));
        arms x = arms_mul(arms_get(s->draw_x + a), pulled);
        arms y = arms_mul(arms_get(s->draw_y + a), pulled);
        if (s->need & BODIES_AIR) {
            x = arms_sub(x, arms_get(s->drag_x + a));
            y = arms_sub(y, arms_get(s->drag_y + a));
            m = arms_fma(arms_get(s->len + a), arms_get(s->drag_y + a), m);
        }
        arms_put(s->asked_x + a, x);
        arms_put(s->asked_y + a, y);
        arms_put(s->answer + a, m);
    }
}

/* leaves to root: m, and the force asked of the base but for what m and the base's acceleration
 * ask. Where the parent comes next, what it is asked is handed on, not read again. */
static inline void bodies_up(const struct bodies_system *s) {
    int last = s->n - 1;
    num ax = s->asked_x[last], ay = s->asked_y[last], m = s->answer[last];
    for (int c = last; c > 0; c--) {
        int p = s->parent[c];
        num C = s->cosine[c], Z = s->sine[c], moment = s->answer[p];
        num x = num_fma(C, ax, s->asked_x[p]), y = num_fma(Z, ax, s->asked_y[p]);
        moment = num_fma(s->place_y[c], ax, moment);
        x = num_sub(x, num_mul(Z, ay));
        y = num_fma(C, ay, y);
        moment = num_sub(moment, num_mul(s->place_x[c], ay));
        x = num_fma(s->bear_x[c], m, x);
        y = num_fma(s->bear_y[c], m, y);
        moment = num_sub(moment, num_mul(s->yield[c], m));
        s->asked_x[p] = x, s->asked_y[p] = y, s->answer[p] = moment;
        if (p == c - 1)
            ax = x, ay = y, m = moment;
        else
            ax = s->asked_x[c - 1], ay = s->asked_y[c - 1], m = s->answer[c - 1];
    }
    for (int a = 0; a < s->n; a += BODIES_ARMS) {
        arms all = arms_get(s->answer + a);
        arms fx = arms_fma(arms_get(s->lever_x + a), all, arms_get(s->asked_x + a));
        arms fy = arms_fma(arms_get(s->lever_y + a), all, arms_get(s->asked_y + a));
        arms_put(s->asked_x + a, fx);
        arms_put(s->asked_y + a, fy);
        arms_put(s->answer + a, arms_mul(all, arms_get(s->inv_total + a)));
    }
}

/* root to leaves: accelerations */
static inline void bodies_down(const struct bodies_system *s, int k) {
    num x = s->lift_x[k], y = s->lift_y[k], C = s->cosine[0], Z = s->sine[0];
    num ax = num_fma(C, x, num_mul(Z, y)), ay = num_sub(num_mul(C, y), num_mul(Z, x));
    s->base_x[0] = ax, s->base_y[0] = ay;
    for (int a = 1; a < s->n; a++) {
        int p = s->parent[a];
        num kr = s->pulled[p], chi = s->answer[p], px = s->place_x[a], py = s->place_y[a];
        x = num_sub(num_mul(px, kr), num_mul(py, chi));
        y = num_fma(py, kr, num_mul(px, chi));
        if (p != a - 1) ax = s->base_x[p], ay = s->base_y[p];
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
    }
}

/* what arms from arm a on add at their tips and to G, and their forces on their parents */
static inline void bodies_press(const struct bodies_system *s, size_t row, int a) {
    arms ax = arms_get(s->base_x + a), ay = arms_get(s->base_y + a), l = arms_get(s->len + a);
    arms hx = arms_get(s->moment_x + a), hy = arms_get(s->moment_y + a);
    arms m = arms_get(s->mass + a), fx = arms_get(s->asked_x + a), fy = arms_get(s->asked_y + a);
    arms push_x = arms_fma(hx, ax, arms_mul(hy, ay));
    arms push_y = arms_sub(arms_mul(hx, ay), arms_mul(hy, ax));
    arms tip_x = arms_mul(m, arms_fma(l, arms_get(s->pulled + a), ax));
    arms tip_y = arms_mul(m, arms_fma(l, arms_get(s->answer + a), ay));
    if (s->need & BODIES_AIR) {
        arms drag_x = arms_get(s->drag_x + a), drag_y = arms_get(s->drag_y + a);
        push_x = arms_sub(push_x, arms_mul(l, drag_x));
        push_y = arms_sub(push_y, arms_mul(l, drag_y));
        tip_x = arms_sub(tip_x, drag_x);
        tip_y = arms_sub(tip_y, drag_y);
    }
    arms_put(s->push_x + row, push_x);
    arms_put(s->push_y + row, push_y);
    arms_put(s->tip_x + row, tip_x);
    arms_put(s->tip_y + row, tip_y);
    arms xx = arms_get(s->form_xx + a), xy = arms_get(s->form_xy + a),
         yy = arms_get(s->form_yy + a);
    fx = arms_add(fx, arms_fma(xx, ax, arms_mul(xy, ay)));
    fy = arms_add(fy, arms_fma(xy, ax, arms_mul(yy, ay)));
    arms C = arms_get(s->cosine + a), Z = arms_get(s->sine + a);
    arms x = arms_sub(arms_mul(C, fx), arms_mul(Z, fy)), y = arms_fma(Z, fx, arms_mul(C, fy));
    arms px = arms_get(s->point_x + a), py = arms_get(s->point_y + a);
    arms_put(s->reach_x + a, x);
    arms_put(s->reach_y + a, y);
    arms_put(s->heave_x + a, arms_fma(px, x, arms_mul(py, y)));
    arms_put(s->heave_y + a, arms_sub(arms_mul(px, y), arms_mul(py, x)));
}

/* the coefficients of order k of forces, and of order k + 1 of rates and turns */
static inline void bodies_close(const struct bodies_system *s, int k) {
    arms share = arms_all(bodies_share(k)), turn_share = arms_all(bodies_share(k + 1));
    size_t now = (size_t)k * s->stride;
    for (int a = 0; a < s->n; a += BODIES_ARMS) {
        size_t row = bodies_row(s, a) + now, next = row + s->stride;
        arms chi = arms_get(s->answer + a), Tr = arms_get(s->wind_x + a);
        arms rate = arms_mul(arms_sub(chi, arms_get(s->turned + a)), share);
        bodies_press(s, row, a);
        arms_put(s->rate + next, rate);
        arms_put(s->turn_re + next + s->stride,
                 arms_neg(arms_mul(arms_get(s->wind_y + a), turn_share)));
        arms_put(s->turn_im + next + s->stride, arms_mul(arms_add(rate, Tr), turn_share));
    }
    if (pend_terms_cart(s->terms)) bodies_cart_still(s, k + 2);
    s->haul_x[k] = s->reach_x[0], s->haul_y[k] = s->reach_y[0];
    for (int a = 1; a < s->n; a++) {
        size_t up = bodies_row(s, s->parent[a]) + now;
        s->push_x[up] = num_add(s->push_x[up], s->heave_x[a]);
        s->push_y[up] = num_add(s->push_y[up], s->heave_y[a]);
        if (s->terms->hung[a]) continue;
        s->tip_x[up] = num_add(s->tip_x[up], s->reach_x[a]);
        s->tip_y[up] = num_add(s->tip_y[up], s->reach_y[a]);
    }
    for (int a = 0; a < s->n; a += BODIES_ARMS) {
        size_t row = bodies_row(s, a) + now;
        arms_put(s->force + row, arms_add(arms_get(s->along + a), arms_get(s->tip_x + row)));
    }
}

/* ---- all orders */

/* what begins all orders: the factorization, drives, and the first turns. Angles, rates of order 0
 * and the arms' numbers are there. */
static inline void bodies_begin(const struct bodies_system *s, const struct bodies_moment *now,
                                int order) {
    bodies_factor(s);
    bodies_drive(s, now, order);
    for (int a = 0; a < s->n; a++) {
        size_t row = bodies_row(s, a);
        s->turn_re[row] = num_of(1);
        s->turn_im[row] = s->turn_re[row + s->stride] = num_of(0);
        s->turn_im[row + s->stride] = s->rate[row];
    }
    if (pend_terms_cart(s->terms)) bodies_cart_still(s, 1);
}

/**
 * All orders: rate_1 .. rate_order and force_0 .. force_{order - 1} from rate_0, cosine, sine and
 * bend. The turns have a row of order 0 here, which is 1. O(n order^2).
 */
static inline void bodies_orders(const struct bodies_system *s, const struct bodies_moment *now,
                                 int order) {
    num gamma = num_mul(bodies_one(s, PEND_TERM_DRAG_PER_MASS), now->unit);
    bodies_begin(s, now, order);
    for (int k = 0; k < order; k++) {
        bodies_load(s, now, k);
        bodies_convolve(s, k, gamma);
        if (pend_terms_cart(s->terms)) bodies_cart_mist(s, k, gamma);
        bodies_up(s);
        bodies_down(s, k);
        bodies_close(s, k);
    }
}

#endif
