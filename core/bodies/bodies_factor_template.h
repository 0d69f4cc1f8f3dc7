/* The factorization of a real pendulum's linear system: the resistance of every sub-tree to the
 * acceleration of its base, and the coefficients of the sweeps of an order. For any kind of number,
 * once per step.
 * Leaves to others: the orders (bodies_template, whose head has the derivation).
 * Invariant: with point masses on massless arms no number is a difference of nearly equal ones, so
 * that no ratio of masses costs digits.
 *
 * N = 1 - e X^T maps the acceleration of the joint to that of a point p of the arm, which turns
 * freely; D N is
 *     sum of m (|p'|^2 - e e'^T) over the arm's own masses, sum of (<e', w> - e w^T) over children,
 * w = P e', P = R Phi R^T of a child at p', e' = i p'. For a mass or a child at p itself the
 * component across vanishes, which the difference in brackets would give only up to rounding. There
 *     <e, w> - e w^T = -(i w) p^T,   and of a child's own w   R^T i w = -adj(Phi) place;
 * for the arm's own masses, of center c, it is their I_c + M c c^T - (e - i c) (i h)^T.
 * Phi is formed without a difference too: a body alone has M / J (I_c + M c c^T), and a child adds
 * N^T (D P + det P p p^T) N / (D + <e, P e>), its own form reduced by the free turning of the arm
 * (Woodbury). The force beta of a child contributes N^T R beta to its parent.
 *
 * The force of an arm between a heavy one and a light joint is the small difference of beta of the
 * heavy one and of Phi times an acceleration. If Phi has rank one, as for point masses at tips, it
 * follows from its parent's numbers without that difference (bodies_hold): from a, kr and beta, and
 * from nu, the moments on the parent without the arm's own, as D F = (P B + det P p p^T) a + (D' P
 * p - K' w + det P |p|^2 p) kr + w nu + (D' - p (i w)^T) beta, B is N at p without the arm, D' and
 * K' the parent's D and K without it. */
#pragma once

#include "core/bodies/bodies_number.h"
#include "core/bodies/bodies_system.h"

/* the value of a term of arm k; 0 if absent */
VEC_INLINE num bodies_get(const struct bodies_system *s, enum pend_term_row row, int k) {
    return s->terms->row[row] < 0 ? num_of(0) : s->value[s->terms->row[row] + k];
}

VEC_INLINE num bodies_one(const struct bodies_system *s, enum pend_term_one one) {
    return s->terms->one[one] < 0 ? num_of(0) : s->value[s->terms->one[one]];
}

/*
 * A pivot on a cart of mass M at position x. Let r be the direction of the rail and p = -i r. The
 * acceleration a + r x'' of the cart equals a + i p chi with chi = x'', that of the point p of a
 * body in a frame that does not turn. So the cart is an arm with a point mass M at p, to which all
 * arms of the pivot are attached, with J = M |p|^2 = M, and u = 1: it has no series, and T and kr
 * vanish. Its balance of moments is then the balance of forces along the rail,
 *     (M + <r, sum P r>) x'' = tau - M <r, a> - <r, sum R beta_c>,
 * tau the forces along the rail (drives_template), and the force at its joint is that of the
 * rail. */

/* p, the point of the cart's mass, where all its children are attached */
static inline void bodies_cart_point(const struct bodies_system *s) {
    num zero = num_of(0), sine, cosine;
    num_drive(zero, zero, zero, bodies_one(s, PEND_TERM_RAIL), &sine, &cosine);
    s->point_x[0] = sine, s->point_y[0] = num_neg(cosine);
}

/** The frame of the cart, which is that of the axes, and its position, stored where other arms have
 * the angle to the parent. The caller sets the rate. */
static inline void bodies_cart_start(const struct bodies_system *s, num place) {
    s->cosine[0] = num_of(1), s->sine[0] = num_of(0);
    s->bend[0] = place;
}

/* the frame of the cart does not turn: order k of u is 0 for k > 0 */
static inline void bodies_cart_still(const struct bodies_system *s, int k) {
    size_t at = bodies_row(s, 0) + (size_t)k * s->stride;
    s->turn_re[at] = s->turn_im[at] = num_of(0);
}

/* order k of the cart's speed x'; its velocity is i p x', p = point_x + i point_y of row 0 */
VEC_INLINE num bodies_cart_speed(const struct bodies_system *s, int k) {
    return s->rate[bodies_row(s, 0) + (size_t)k * s->stride];
}

/* Order k of the product of the cart's momentum and the pivot's velocity. Twice this is the cart's
 * contribution to sum m |v|^2; for other arms this sum contains the series of u. */
static inline num bodies_cart_sweep(const struct bodies_system *s, int k, int low) {
    num sum = num_of(0), hx = s->moment_x[0], hy = s->moment_y[0];
    for (int j = low; j <= k - low; j++) {
        size_t back = bodies_row(s, 0) + (size_t)(k - j) * s->stride;
        num across = num_mul(hx, s->base_way_y[back]);
        across = num_sub(across, num_mul(hy, s->base_way_x[back]));
        sum = num_fma(bodies_cart_speed(s, j), across, sum);
    }
    return sum;
}

/* Adds a mass at x + i y to an arm: updates `body`, the first moment, and the inertia about the
 * common center, which grows by m m' |c - c'|^2 / (m + m'). */
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

/* computes the vector from an arm's center to its tip, accurate to the last digit, and the tip's
 * share of the mass */
static inline void bodies_tail(const struct bodies_system *s, int k, num M) {
    num zero = num_of(0), rod = bodies_get(s, PEND_TERM_ROD, k), l = s->len[k];
    s->tail_x[k] = s->tail_y[k] = s->tip_rest[k] = zero;
    s->tip_share[k] = num_of(1);
    if (s->terms->row[PEND_TERM_ROD] < 0 && s->terms->row[PEND_TERM_BODY] < 0) return;
    if (!k && pend_terms_cart(s->terms)) return;
    num body = bodies_get(s, PEND_TERM_BODY, k), part = num_div(num_of(1), M);
    num x = num_sub(l, bodies_get(s, PEND_TERM_CENTER_X, k));
    num y = bodies_get(s, PEND_TERM_CENTER_Y, k);
    x = num_fma(num_mul(rod, l), num_of(0.5), num_mul(body, x));
    s->tail_x[k] = num_mul(part, x);
    s->tail_y[k] = num_neg(num_mul(part, num_mul(body, y)));
    s->tip_share[k] = num_mul(part, s->mass[k]);
    s->tip_rest[k] = num_mul(part, num_add(rod, body));
}

/* computes M, h, J and the form of an arm without children */
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
    num across = num_fma(hy, heap.y, heap.spread);
    num J = num_fma(hx, heap.x, across), inverse = num_div(num_of(1), J);
    num part = num_mul(M, inverse);
    s->body[k] = M, s->moment_x[k] = hx, s->moment_y[k] = hy;
    s->inertia[k] = s->total[k] = J;
    s->inv_total[k] = inverse;
    s->center_x[k] = heap.x, s->center_y[k] = heap.y, s->spread[k] = heap.spread;
    bodies_tail(s, k, M);
    s->form_xx[k] = num_mul(part, num_fma(hx, heap.x, heap.spread));
    s->form_xy[k] = num_mul(part, num_mul(hx, heap.y));
    s->form_yy[k] = num_mul(part, across);
    s->form_det[k] = num_mul(num_mul(M, part), heap.spread);
    s->pull_x[k] = s->pull_y[k] = s->hang_x[k] = s->hang_y[k] = s->hang_e[k] = zero;
    s->late_x[k] = s->late_y[k] = s->other_x[k] = s->other_y[k] = s->other_e[k] = zero;
    s->hang_p[k] = s->other_p[k] = zero;
    s->draw_x[k] = hx, s->draw_y[k] = hy, s->twist[k] = zero;
}

/* computes the attachment point of arm k, in the parent's frame and in its own */
static inline void bodies_point(const struct bodies_system *s, int k) {
    int p = s->parent[k];
    num x = p < 0 ? num_of(0) : s->len[p], y = num_of(0), C = s->cosine[k], Z = s->sine[k];
    if (p <= 0 && pend_terms_cart(s->terms)) {
        if (p < 0) bodies_cart_point(s);
        x = s->point_x[0], y = s->point_y[0];
    } else if (s->terms->hung[k]) {
        x = s->value[s->terms->row[PEND_TERM_AT_X] + k];
        y = s->value[s->terms->row[PEND_TERM_AT_Y] + k];
    }
    s->point_x[k] = x, s->point_y[k] = y;
    s->place_x[k] = num_fma(C, x, num_mul(Z, y));
    s->place_y[k] = num_sub(num_mul(C, y), num_mul(Z, x));
}

/* a matrix; sums over children of w, <e, w> and <p, w>; a point of an arm, relative to its joint
 * and to its center */
struct bodies_matrix {
    num xx, xy, yx, yy;
};

struct bodies_pull {
    num x, y, e, p;
};

struct bodies_spot {
    num x, y, dx, dy;
};

/* attachment point of arm c on arm p */
static inline struct bodies_spot bodies_spot(const struct bodies_system *s, int c, int p) {
    num x = s->point_x[c], y = s->point_y[c];
    if (!bodies_hung(s, c)) return (struct bodies_spot){x, y, s->tail_x[p], s->tail_y[p]};
    return (struct bodies_spot){x, y, num_sub(x, s->center_x[p]), num_sub(y, s->center_y[p])};
}

/* D N at a point of arm p: the sum of the contributions of the arm alone, its children at the same
 * point, and its others */
static inline struct bodies_matrix bodies_remains(const struct bodies_system *s, int p,
                                                  const struct bodies_spot *at,
                                                  const struct bodies_pull *same,
                                                  const struct bodies_pull *other) {
    num hx = s->moment_x[p], hy = s->moment_y[p], cx = s->center_x[p], cy = s->center_y[p];
    num x = at->x, y = at->y, dx = at->dx, dy = at->dy, spread = s->spread[p];
    struct bodies_matrix N = {
        num_fma(hx, cx, num_sub(spread, num_mul(dy, hy))),
        num_fma(hx, cy, num_mul(dy, hx)),
        num_fma(hy, cx, num_mul(dx, hy)),
        num_fma(hy, cy, num_sub(spread, num_mul(dx, hx))),
    };
    N.xx = num_add(num_fma(y, other->x, other->e), num_fma(x, same->y, N.xx));
    N.xy = num_fma(y, num_add(same->y, other->y), N.xy);
    N.yx = num_sub(N.yx, num_mul(x, num_add(same->x, other->x)));
    N.yy = num_sub(N.yy, num_mul(y, same->x));
    N.yy = num_add(N.yy, num_sub(other->e, num_mul(x, other->y)));
    return N;
}

/* sums over the children of arm p added so far: the children at the tip, the others, and all */
static inline struct bodies_pull bodies_at_tip(const struct bodies_system *s, int p) {
    num l = s->len[p], x = s->pull_x[p], y = s->pull_y[p];
    return (struct bodies_pull){x, y, num_mul(l, y), num_mul(l, x)};
}

static inline struct bodies_pull bodies_off_tip(const struct bodies_system *s, int p) {
    return (struct bodies_pull){s->hang_x[p], s->hang_y[p], s->hang_e[p], s->hang_p[p]};
}

static inline struct bodies_pull bodies_both(struct bodies_pull a, struct bodies_pull b) {
    return (struct bodies_pull){num_add(a.x, b.x), num_add(a.y, b.y), num_add(a.e, b.e),
                                num_add(a.p, b.p)};
}

static const struct bodies_pull bodies_none;

/* D N at the attachment point of arm c, with the siblings added so far */
static inline struct bodies_matrix bodies_before(const struct bodies_system *s, int c, int p) {
    struct bodies_pull tip = bodies_at_tip(s, p), off = bodies_off_tip(s, p);
    struct bodies_spot at = bodies_spot(s, c, p);
    struct bodies_pull early = bodies_hung(s, c) ? off : tip, all = bodies_both(tip, off);
    s->early_x[c] = early.x, s->early_y[c] = early.y;
    s->early_e[c] = early.e, s->early_p[c] = early.p;
    if (bodies_hung(s, c)) return bodies_remains(s, p, &at, &bodies_none, &all);
    return bodies_remains(s, p, &at, &tip, &off);
}

/* Adds the child's form, transformed to the parent's base, to that of the parent: N^T W N, from D N
 * and from W = (D P + det P p p^T) / (new D). */
static inline void bodies_form(const struct bodies_system *s, int p, const struct bodies_matrix *W,
                               const struct bodies_matrix *remains, num det) {
    num before = s->inv_total[p];
    struct bodies_matrix N = {num_mul(remains->xx, before), num_mul(remains->xy, before),
                              num_mul(remains->yx, before), num_mul(remains->yy, before)};
    num Vxx = num_fma(W->xx, N.xx, num_mul(W->xy, N.yx));
    num Vxy = num_fma(W->xx, N.xy, num_mul(W->xy, N.yy));
    num Vyx = num_fma(W->xy, N.xx, num_mul(W->yy, N.yx));
    num Vyy = num_fma(W->xy, N.xy, num_mul(W->yy, N.yy));
    num Uxx = num_fma(N.xx, Vxx, num_mul(N.yx, Vyx));
    num Uyy = num_fma(N.xy, Vxy, num_mul(N.yy, Vyy));
    num Uxy = num_fma(N.xx, Vxy, num_mul(N.yx, Vyy));
    num det_N = num_sub(num_mul(N.xx, N.yy), num_mul(N.xy, N.yx));
    num det_U = num_mul(det, num_mul(det_N, det_N));
    num F = s->form_xx[p], G = s->form_xy[p], H = s->form_yy[p];
    num mixed = num_sub(num_fma(F, Uyy, num_mul(H, Uxx)), num_mul(num_of(2), num_mul(G, Uxy)));
    s->form_det[p] = num_add(s->form_det[p], num_add(det_U, mixed));
    s->form_xx[p] = num_add(F, Uxx);
    s->form_xy[p] = num_add(G, Uxy);
    s->form_yy[p] = num_add(H, Uyy);
}

/* adds child c, whose form is complete, to arm p */
static inline void bodies_join(const struct bodies_system *s, int c, int p) {
    num C = s->cosine[c], Z = s->sine[c], px = s->point_x[c], py = s->point_y[c];
    num A = s->form_xx[c], B = s->form_xy[c], E = s->form_yy[c], det = s->form_det[c];
    // P = R Phi R^T
    num AC = num_sub(num_mul(A, C), num_mul(B, Z)), BC = num_sub(num_mul(B, C), num_mul(E, Z));
    num AZ = num_fma(A, Z, num_mul(B, C)), BZ = num_fma(B, Z, num_mul(E, C));
    num Pxx = num_sub(num_mul(C, AC), num_mul(Z, BC)), Pyy = num_fma(Z, AZ, num_mul(C, BZ));
    num Pxy = num_fma(Z, AC, num_mul(C, BC));
    // w = P e
    num wx = num_sub(num_mul(Pxy, px), num_mul(Pxx, py));
    num wy = num_sub(num_mul(Pyy, px), num_mul(Pxy, py));
    num add = num_sub(num_mul(px, wy), num_mul(py, wx)), D = s->total[p];
    num total = num_add(D, add), inverse = num_div(num_of(1), total), own = num_mul(D, inverse);
    num turn = num_mul(det, inverse);
    struct bodies_matrix remains = bodies_before(s, c, p), W;
    W.xx = num_fma(own, Pxx, num_mul(turn, num_mul(px, px)));
    W.xy = num_fma(own, Pxy, num_mul(turn, num_mul(px, py)));
    W.yy = num_fma(own, Pyy, num_mul(turn, num_mul(py, py)));
    // det W = det P D / (D + <e, P e>), because det p p^T = 0
    bodies_form(s, p, &W, &remains, num_mul(det, own));
    s->total[p] = total, s->inv_total[p] = inverse;
    if (!bodies_hung(s, c)) {
        s->pull_x[p] = num_add(s->pull_x[p], wx);
        s->pull_y[p] = num_add(s->pull_y[p], wy);
        return;
    }
    s->hang_x[p] = num_add(s->hang_x[p], wx);
    s->hang_y[p] = num_add(s->hang_y[p], wy);
    s->hang_e[p] = num_add(s->hang_e[p], add);
    s->hang_p[p] = num_add(s->hang_p[p], num_fma(px, wx, num_mul(py, wy)));
}

/* Computes D N at the attachment point of arm c with all siblings but without c itself, and the
 * siblings' sums. Moves c to the group of siblings added after the next one. */
static inline struct bodies_matrix bodies_beside(const struct bodies_system *s, int c, int p,
                                                 const struct bodies_spot *at,
                                                 const struct bodies_pull *own,
                                                 struct bodies_pull *group) {
    struct bodies_pull tip = bodies_at_tip(s, p), off = bodies_off_tip(s, p), late;
    struct bodies_pull early = {s->early_x[c], s->early_y[c], s->early_e[c], s->early_p[c]};
    num none = num_of(0);
    if (!bodies_hung(s, c)) {
        late = (struct bodies_pull){s->late_x[p], s->late_y[p], none, none};
        struct bodies_pull same = bodies_both(early, late);
        late = bodies_both(late, *own);
        s->late_x[p] = late.x, s->late_y[p] = late.y;
        // all siblings are attached at one point
        same.e = num_sub(num_mul(at->x, same.y), num_mul(at->y, same.x));
        same.p = num_fma(at->x, same.x, num_mul(at->y, same.y));
        *group = bodies_both(same, off);
        return bodies_remains(s, p, at, &same, &off);
    }
    late = (struct bodies_pull){s->other_x[p], s->other_y[p], s->other_e[p], s->other_p[p]};
    *group = bodies_both(bodies_both(early, late), tip), late = bodies_both(late, *own);
    s->other_x[p] = late.x, s->other_y[p] = late.y;
    s->other_e[p] = late.e, s->other_p[p] = late.p;
    return bodies_remains(s, p, at, &bodies_none, group);
}

/* Computes the coefficients of the force of arm k; g = adj(Phi) place, Q is N without the arm,
 * rotated into its frame, and `group` the siblings' sums. */
static inline void bodies_hold(const struct bodies_system *s, int k, const struct bodies_matrix *Q,
                               const struct bodies_pull *group, num gx, num gy) {
    int p = s->parent[k];
    num x = s->place_x[k], y = s->place_y[k], px = s->point_x[k], py = s->point_y[k];
    num A = s->form_xx[k], B = s->form_xy[k], E = s->form_yy[k], inverse = s->inv_total[p];
    num less = num_add(s->inertia[p], group->e), det = s->form_det[k];
    num along = num_fma(A, x, num_mul(B, y)), across = num_fma(B, x, num_mul(E, y));
    num far = num_mul(det, num_fma(x, x, num_mul(y, y))), dx = num_mul(det, x),
        dy = num_mul(det, y);
    num V = num_fma(A, Q->xx, num_fma(B, Q->yx, num_mul(dx, px)));
    s->sway_xx[k] = num_mul(inverse, V);
    V = num_fma(A, Q->xy, num_fma(B, Q->yy, num_mul(dx, py)));
    s->sway_xy[k] = num_mul(inverse, V);
    V = num_fma(B, Q->xx, num_fma(E, Q->yx, num_mul(dy, px)));
    s->sway_yx[k] = num_mul(inverse, V);
    V = num_fma(B, Q->xy, num_fma(E, Q->yy, num_mul(dy, py)));
    s->sway_yy[k] = num_mul(inverse, V);
    V = num_fma(less, along, num_fma(far, x, num_mul(group->p, gy)));
    s->swing_x[k] = num_mul(inverse, V);
    V = num_sub(num_fma(less, across, num_mul(far, y)), num_mul(group->p, gx));
    s->swing_y[k] = num_mul(inverse, V);
    s->turn_x[k] = num_neg(num_mul(inverse, gy));
    s->turn_y[k] = num_mul(inverse, gx);
    s->keep_xx[k] = num_mul(inverse, num_fma(x, gx, less));
    s->keep_xy[k] = num_mul(inverse, num_mul(x, gy));
    s->keep_yx[k] = num_mul(inverse, num_mul(y, gx));
    s->keep_yy[k] = num_mul(inverse, num_fma(y, gy, less));
}

/* computes R^T N of arm k > 0, and adds its contribution to the parent's z and K */
static inline void bodies_carry(const struct bodies_system *s, int k) {
    int p = s->parent[k];
    num C = s->cosine[k], Z = s->sine[k], x = s->place_x[k], y = s->place_y[k];
    num px = s->point_x[k], py = s->point_y[k], inverse = s->inv_total[p];
    num A = s->form_xx[k], B = s->form_xy[k], E = s->form_yy[k];
    // adj(Phi) place; and w, which is i times this vector in the parent's frame
    num gx = num_sub(num_mul(E, x), num_mul(B, y)), gy = num_sub(num_mul(A, y), num_mul(B, x));
    struct bodies_pull own;
    own.x = num_neg(num_fma(Z, gx, num_mul(C, gy)));
    own.y = num_sub(num_mul(C, gx), num_mul(Z, gy));
    own.e = num_sub(num_mul(px, own.y), num_mul(py, own.x));
    own.p = num_fma(px, own.x, num_mul(py, own.y));
    struct bodies_spot at = bodies_spot(s, k, p);
    struct bodies_pull group;
    struct bodies_matrix Q = bodies_beside(s, k, p, &at, &own, &group), turned;
    turned.xx = num_fma(C, Q.xx, num_mul(Z, Q.yx)), turned.xy = num_fma(C, Q.xy, num_mul(Z, Q.yy));
    turned.yx = num_sub(num_mul(C, Q.yx), num_mul(Z, Q.xx));
    turned.yy = num_sub(num_mul(C, Q.yy), num_mul(Z, Q.xy));
    s->stem_x[k] = num_fma(C, at.dx, num_mul(Z, at.dy));
    s->stem_y[k] = num_sub(num_mul(C, at.dy), num_mul(Z, at.dx));
    if (!(s->need & BODIES_SHAPE)) bodies_hold(s, k, &turned, &group, gx, gy);
    num xx = num_fma(gx, px, turned.xx), xy = num_fma(gx, py, turned.xy);
    num yx = num_fma(gy, px, turned.yx), yy = num_fma(gy, py, turned.yy);
    s->carry_xx[k] = xx = num_mul(xx, inverse);
    s->carry_xy[k] = xy = num_mul(xy, inverse);
    s->carry_yx[k] = yx = num_mul(yx, inverse);
    s->carry_yy[k] = yy = num_mul(yy, inverse);
    num along = num_fma(A, x, num_mul(B, y)), across = num_fma(B, x, num_mul(E, y));
    s->draw_x[p] = num_fma(xx, along, num_fma(yx, across, s->draw_x[p]));
    s->draw_y[p] = num_fma(xy, along, num_fma(yy, across, s->draw_y[p]));
    s->twist[p] = num_add(s->twist[p], num_sub(num_mul(x, across), num_mul(y, along)));
}

/* computes X, and N at the tip, which drag needs */
static inline void bodies_lever(const struct bodies_system *s, int k) {
    num inverse = s->inv_total[k];
    struct bodies_pull tip = bodies_at_tip(s, k), off = bodies_off_tip(s, k);
    struct bodies_pull all = bodies_both(tip, off);
    s->lever_x[k] = num_mul(num_sub(all.x, s->moment_y[k]), inverse);
    s->lever_y[k] = num_mul(num_add(all.y, s->moment_x[k]), inverse);
    if (!(s->need & BODIES_AIR)) return;
    struct bodies_spot at = {s->len[k], num_of(0), s->tail_x[k], s->tail_y[k]};
    struct bodies_matrix N = bodies_remains(s, k, &at, &tip, &off);
    s->give_xx[k] = num_mul(N.xx, inverse), s->give_xy[k] = num_mul(N.xy, inverse);
    s->give_yx[k] = num_mul(N.yx, inverse), s->give_yy[k] = num_mul(N.yy, inverse);
}

static inline void bodies_factor(const struct bodies_system *s) {
    for (int k = 0; k < s->n; k++) {
        bodies_point(s, k);
        bodies_alone(s, k);
    }
    for (int k = s->n - 1; k > 0; k--) bodies_join(s, k, s->parent[k]);
    for (int k = 0; k < s->n; k++) {
        bodies_lever(s, k);
        if (k) bodies_carry(s, k);
    }
}
