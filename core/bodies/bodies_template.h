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

#include "core/bodies/bodies_number.h"
#include "core/bodies/bodies_system.h"

/* arms that a convolution takes at once */
#if defined NUMBER_VEC && NUMBER_VEC == 1
enum { BODIES_ARMS = WIDE };
typedef wide arms;
#define arms_of wide_of
#define arms_fma wide_fma
#define arms_get wide_load
VEC_INLINE arms arms_neg(arms x) { return -x; }
VEC_INLINE void arms_put(num *at, arms x) { memcpy(at, &x, sizeof x); }
#else
enum { BODIES_ARMS = 1 };
typedef num arms;
#define arms_of num_of
#define arms_fma num_fma
#define arms_neg num_neg
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
    s->point_x[k] = p < 0 ? num_of(0) : s->len[p];
    s->point_y[k] = num_of(0);
    if (!s->terms->hung[k]) return;
    s->point_x[k] = s->value[s->terms->row[PEND_TERM_AT_X] + k];
    s->point_y[k] = s->value[s->terms->row[PEND_TERM_AT_Y] + k];
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
}

/* ---- an order */

/* 1 / (j + 1) */
VEC_INLINE num bodies_share(int j) { return num_div(num_of(1), num_of(j + 1)); }

/* theta, kr, and the known parts of Im (conj u G) and of the force along the arm at its tip */
static inline void bodies_convolve(const struct bodies_system *s, int k, num gamma) {
    size_t stride = s->stride;
    num more = num_of(k + 1), twice = num_mul(num_of(2), gamma);
    for (int a = 0; a < s->n; a += BODIES_ARMS) {
        size_t row = bodies_row(s, a);
        const num *re = s->turn_re + row, *im = s->turn_im + row;
        const num *rate = s->rate + row + (size_t)(k + 1) * stride;
        arms Tr = arms_of(0), Ti = arms_of(0), known = arms_of(0), along = arms_of(0);
        for (int j = 1; j <= k + 1; j++) {
            size_t at = (size_t)j * stride;
            arms ur = arms_get(re + at), ui = arms_get(im + at), w = arms_get(rate - at);
            Tr = arms_fma(ur, w, Tr);
            Ti = arms_fma(ui, w, Ti);
            if (j > k) break;
            size_t back = row + (size_t)(k - j) * stride;
            arms gx = arms_get(s->push_x + back), gy = arms_get(s->push_y + back);
            known = arms_fma(ur, gy, known);
            known = arms_fma(arms_neg(ui), gx, known);
            along = arms_fma(ur, arms_get(s->tip_x + back), along);
            along = arms_fma(ui, arms_get(s->tip_y + back), along);
        }
        arms_put(s->wind_x + a, Tr);
        arms_put(s->wind_y + a, Ti);
        arms_put(s->known + a, known);
        arms_put(s->along + a, along);
    }
    for (int a = 0; a < s->n; a++) {
        size_t next = bodies_row(s, a) + (size_t)(k + 1) * stride;
        s->turned[a] = num_mul(more, num_fma(twice, s->turn_im[next], s->wind_x[a]));
        s->pulled[a] = num_mul(more, num_sub(num_mul(twice, s->turn_re[next]), s->wind_y[a]));
    }
}

/* leaves to root: the force that each arm asks of its base, but for the base's acceleration */
static inline void bodies_up(const struct bodies_system *s, int k, num gamma) {
    int air = s->need & BODIES_AIR ? 1 : 0;
    num twice = num_mul(num_of(2), gamma);
    for (int a = 0; a < s->n; a++) {
        num w = s->rate[bodies_row(s, a) + (size_t)k * s->stride], kr = s->pulled[a];
        num ki = num_sub(s->turned[a], num_mul(twice, w));
        num m = num_sub(num_fma(s->inertia[a], ki, s->couple[a]), s->known[a]);
        m = num_sub(m, num_mul(s->twist[a], kr));
        s->asked_x[a] = num_mul(s->draw_x[a], kr);
        s->asked_y[a] = num_mul(s->draw_y[a], kr);
        if (air) {
            s->asked_x[a] = num_sub(s->asked_x[a], s->drag_x[a]);
            s->asked_y[a] = num_sub(s->asked_y[a], s->drag_y[a]);
            m = num_fma(s->len[a], s->drag_y[a], m);
        }
        s->answer[a] = m;
    }
    for (int c = s->n - 1; c >= 0; c--) {
        num m = s->answer[c];
        s->asked_x[c] = num_fma(s->lever_x[c], m, s->asked_x[c]);
        s->asked_y[c] = num_fma(s->lever_y[c], m, s->asked_y[c]);
        s->answer[c] = num_mul(m, s->inv_total[c]);
        if (!c) break;
        int p = s->parent[c];
        num C = s->cosine[c], Z = s->sine[c];
        num x = num_sub(num_mul(C, s->asked_x[c]), num_mul(Z, s->asked_y[c]));
        num y = num_fma(Z, s->asked_x[c], num_mul(C, s->asked_y[c]));
        s->asked_x[p] = num_add(s->asked_x[p], x);
        s->asked_y[p] = num_add(s->asked_y[p], y);
        num moment = num_sub(num_mul(s->point_x[c], y), num_mul(s->point_y[c], x));
        s->answer[p] = num_sub(s->answer[p], moment);
    }
}

/* what an arm that is solved adds at its tip and to G, and then, by its force on its parent, to the
 * parent's */
static inline void bodies_pass(const struct bodies_system *s, int k, int a, num chi) {
    size_t row = bodies_row(s, a) + (size_t)k * s->stride;
    num ax = s->base_x[a], ay = s->base_y[a], l = s->len[a], m = s->mass[a];
    num hx = s->moment_x[a], hy = s->moment_y[a];
    s->push_x[row] = num_fma(hx, ax, num_mul(hy, ay));
    s->push_y[row] = num_sub(num_mul(hx, ay), num_mul(hy, ax));
    s->tip_x[row] = num_mul(m, num_fma(l, s->pulled[a], ax));
    s->tip_y[row] = num_mul(m, num_fma(l, chi, ay));
    if (s->need & BODIES_AIR) {
        s->push_x[row] = num_sub(s->push_x[row], num_mul(l, s->drag_x[a]));
        s->push_y[row] = num_sub(s->push_y[row], num_mul(l, s->drag_y[a]));
        s->tip_x[row] = num_sub(s->tip_x[row], s->drag_x[a]);
        s->tip_y[row] = num_sub(s->tip_y[row], s->drag_y[a]);
    }
    num fx = num_add(s->asked_x[a], num_fma(s->form_xx[a], ax, num_mul(s->form_xy[a], ay)));
    num fy = num_add(s->asked_y[a], num_fma(s->form_xy[a], ax, num_mul(s->form_yy[a], ay)));
    num C = s->cosine[a], Z = s->sine[a], px = s->point_x[a], py = s->point_y[a];
    num x = num_sub(num_mul(C, fx), num_mul(Z, fy)), y = num_fma(Z, fx, num_mul(C, fy));
    if (!a) {
        s->haul_x[k] = x, s->haul_y[k] = y;
        return;
    }
    size_t up = bodies_row(s, s->parent[a]) + (size_t)k * s->stride;
    s->push_x[up] = num_add(s->push_x[up], num_fma(px, x, num_mul(py, y)));
    s->push_y[up] = num_add(s->push_y[up], num_sub(num_mul(px, y), num_mul(py, x)));
    if (s->terms->hung[a]) return;
    s->tip_x[up] = num_add(s->tip_x[up], x);
    s->tip_y[up] = num_add(s->tip_y[up], y);
}

/* root to leaves: accelerations, and the coefficients of order k + 1 */
static inline void bodies_down(const struct bodies_system *s, int k) {
    num share = bodies_share(k), turn_share = bodies_share(k + 1);
    for (int a = 0; a < s->n; a++) {
        int p = s->parent[a];
        num x = s->lift_x[k], y = s->lift_y[k];
        if (p >= 0) {
            // the parent's chi is in `answer` by now
            num px = s->point_x[a], py = s->point_y[a], kr = s->pulled[p], chi = s->answer[p];
            x = num_add(s->base_x[p], num_sub(num_mul(px, kr), num_mul(py, chi)));
            y = num_add(s->base_y[p], num_fma(py, kr, num_mul(px, chi)));
        }
        num C = s->cosine[a], Z = s->sine[a];
        num ax = num_fma(C, x, num_mul(Z, y)), ay = num_sub(num_mul(C, y), num_mul(Z, x));
        num chi = num_sub(s->answer[a], num_fma(s->lever_x[a], ax, num_mul(s->lever_y[a], ay)));
        s->base_x[a] = ax, s->base_y[a] = ay, s->answer[a] = chi;
        bodies_pass(s, k, a, chi);
        size_t row = bodies_row(s, a), next = row + (size_t)(k + 1) * s->stride;
        s->rate[next] = num_mul(num_sub(chi, s->turned[a]), share);
    }
    for (int a = 0; a < s->n; a++) {
        size_t row = bodies_row(s, a), now = row + (size_t)k * s->stride, next = now + s->stride;
        num Tr = s->wind_x[a], Ti = s->wind_y[a];
        s->turn_re[next + s->stride] = num_neg(num_mul(Ti, turn_share));
        s->turn_im[next + s->stride] = num_mul(num_add(s->rate[next], Tr), turn_share);
        s->force[now] = num_add(s->along[a], s->tip_x[now]);
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
        bodies_up(s, k, gamma);
        bodies_down(s, k);
    }
}

#endif
