/* The orders of real pendulums of up to DENSE_MAX bodies, for any vector of doubles, one pendulum
 * per lane, by the inverse of their system. The recurrences are those of small_loads_template.
 * Leaves to others: drives and torques (lanes_loads_template), the factorization
 * (bodies_factor_template, whose sweeps these are), drag per mass and forces on tips
 * (bodies_template).
 * Invariant: the stable sweeps compute the inverse, one unit after the other; series have the
 * places of the general kernel. */
#pragma once

#include "core/taylor/lanes/lanes_loads_template.h"

/* responses of arm i (phi'' and Re G, in the axes of the start) to unit loads: -kr of each arm
 * (pull), a moment on it (side), and the pivot's acceleration along and across the first arm
 * (lift) */
struct lanes_table {
    num rate_pull[DENSE_MAX][DENSE_MAX], rate_side[DENSE_MAX][DENSE_MAX];
    num push_pull[DENSE_MAX][DENSE_MAX], push_side[DENSE_MAX][DENSE_MAX];
    num rate_lift[2][DENSE_MAX], push_lift[2][DENSE_MAX];
};

/* values of the sweeps: forces on the bases, moments over D, kr, and the accelerations of the
 * bases */
struct lanes_probe {
    num x[DENSE_MAX], y[DENSE_MAX], answer[DENSE_MAX], base_x[DENSE_MAX], base_y[DENSE_MAX];
};

/* leaves to root, for a unit of the moment or of the kr of arm j */
VEC_INLINE void lanes_climb(const struct bodies_system *b, int n, int j, int moment,
                            struct lanes_probe *u) {
    num zero = num_of(0);
    for (int i = 0; i < n; i++) u->x[i] = u->y[i] = u->answer[i] = zero;
    if (j < 0) return;
    u->x[j] = moment ? b->lever_x[j] : b->draw_x[j];
    u->y[j] = moment ? b->lever_y[j] : b->draw_y[j];
    u->answer[j] = (moment ? num_of(1) : num_neg(b->twist[j])) * b->inv_total[j];
    for (int c = j; c > 0; c = b->parent[c]) {
        int p = b->parent[c];
        num x = u->x[c], y = u->y[c];
        u->x[p] = num_fma(b->carry_xx[c], x, b->carry_yx[c] * y);
        u->y[p] = num_fma(b->carry_xy[c], x, b->carry_yy[c] * y);
        num m = num_sub(b->place_y[c] * x, b->place_x[c] * y);
        u->answer[p] = m * b->inv_total[p];
    }
}

/* root to leaves: the responses of all arms; `pulled` is the arm whose kr is 1, or -1 */
VEC_INLINE void lanes_descend(const struct bodies_system *b, int n, int pulled, num sign,
                              struct lanes_probe *u, num rate[], num push[]) {
    for (int i = 0; i < n; i++) {
        num x = u->base_x[i], y = u->base_y[i];
        if (i) {
            int p = b->parent[i];
            num ax = u->base_x[p], ay = u->base_y[p], chi = u->answer[p];
            num px = b->place_x[i], py = b->place_y[i];
            x = num_neg(py * chi), y = px * chi;
            if (p == pulled) x += px, y += py;
            u->base_x[i] = x = num_fma(b->carry_xx[i], ax, num_fma(b->carry_xy[i], ay, x));
            u->base_y[i] = y = num_fma(b->carry_yx[i], ax, num_fma(b->carry_yy[i], ay, y));
        }
        num way = num_fma(b->lever_x[i], x, b->lever_y[i] * y);
        rate[i] = sign * (u->answer[i] - way);
        num fx = num_fma(b->form_xx[i], x, num_fma(b->form_xy[i], y, u->x[i]));
        num fy = num_fma(b->form_xy[i], x, num_fma(b->form_yy[i], y, u->y[i]));
        push[i] = sign * num_fma(b->center_x[i], fx, b->center_y[i] * fy);
        if (!i) continue;
        num stem = num_fma(b->stem_x[i], fx, b->stem_y[i] * fy);
        push[b->parent[i]] = num_fma(sign, stem, push[b->parent[i]]);
    }
}

VEC_INLINE void lanes_invert(const struct bodies_system *b, int n, struct lanes_table *t) {
    struct lanes_probe u;
    num one = num_of(1), zero = num_of(0);
    u.base_x[0] = u.base_y[0] = zero;
    for (int j = 0; j < n; j++) {
        lanes_climb(b, n, j, 1, &u);
        lanes_descend(b, n, -1, one, &u, t->rate_side[j], t->push_side[j]);
        lanes_climb(b, n, j, 0, &u);
        lanes_descend(b, n, j, num_neg(one), &u, t->rate_pull[j], t->push_pull[j]);
    }
    for (int i = 0; i < 2; i++) {
        lanes_climb(b, n, -1, 0, &u);
        u.base_x[0] = i ? zero : one, u.base_y[0] = i ? one : zero;
        lanes_descend(b, n, -1, one, &u, t->rate_lift[i], t->push_lift[i]);
    }
}

/* the coefficients of an order from its sums */
VEC_INLINE void lanes_solve(const struct lanes_loads *x, const struct lanes_table *table, int n,
                            int k, const struct lanes_sums sum[]) {
    const struct bodies_system *b = x->b;
    num share = num_of(x->s->share[k]), more = num_of(k + 1), along = more, across = more;
    num turn_share = num_of(x->s->share[k + 1]), side[DENSE_MAX], moment[DENSE_MAX];
    int couples = lanes_couple(x, k), moves = x->moves || !k;
    for (int i = 0; i < n; i++) {
        side[i] = sum[i].less - sum[i].known;
        if (couples) side[i] += b->couple[i];
        moment[i] = num_fma(b->spread[i], sum[i].Tr, side[i] * share);
    }
    if (moves) {
        lanes_lift(x, k, &along, &across);
        along *= share, across *= share;
    }
    for (int i = 0; i < n; i++) {
        num chi = num_of(0), push = num_of(0);
        for (int j = 0; j < n; j++) {
            chi = num_fma(moment[j], table->rate_side[j][i], chi);
            push = num_fma(moment[j], table->push_side[j][i], push);
            chi = num_fma(sum[j].Ti, table->rate_pull[j][i], chi);
            push = num_fma(sum[j].Ti, table->push_pull[j][i], push);
        }
        if (moves) {
            chi = num_fma(table->rate_lift[0][i], along, chi);
            push = num_fma(table->push_lift[0][i], along, push);
            chi = num_fma(table->rate_lift[1][i], across, chi);
            push = num_fma(table->push_lift[1][i], across, push);
        }
        size_t now = (size_t)(k * n + i);
        num rate = chi - sum[i].Tr;
        x->along[now] = push * more;
        x->across[now] = num_sub(side[i], more * b->spread[i] * rate);
        b->rate[now + (size_t)n] = rate;
        b->turn_re[now + 2 * (size_t)n] = num_neg(sum[i].Ti * turn_share);
        b->turn_im[now + 2 * (size_t)n] = chi * turn_share;
    }
}

VEC_INLINE void lanes_rigid(const struct lanes_loads *x, int n) {
    struct lanes_table table;
    lanes_invert(x->b, n, &table);
    for (int k = 0; k < x->order; k += 2) {
        struct lanes_sums now[DENSE_MAX], next[DENSE_MAX];
        for (int i = 0; i < n; i++) lanes_convolve(x, n, k, i, &now[i], &next[i]);
        lanes_solve(x, &table, n, k, now);
        if (k + 1 == x->order) break;
        for (int i = 0; i < n; i++) lanes_complete(x, n, k + 1, i, &next[i]);
        lanes_solve(x, &table, n, k + 1, next);
    }
}

/* computes the forces at the tips and of the pivot for orders below `order`, from the series of the
 * motion, by the sweeps of the general kernel */
static void lanes_tips(const struct lanes_loads *x, int order) {
    const struct bodies_system *b = x->b;
    for (int k = 0; k < order; k++) {
        num way = num_of((k + 1) * (k + 2));
        if (k && !x->moves) b->lift_x[k] = b->lift_y[k] = num_of(0);
        for (int a = 0; a < b->n; a++) {
            size_t row = (size_t)k * b->stride + (size_t)a, turn = row + 2 * b->stride;
            num kr = way * b->turn_re[turn], chi = way * b->turn_im[turn];
            num m = num_fma(b->spread[a], chi, x->across[row]);
            b->pulled[a] = kr, b->answer[a] = m;
            b->asked_x[a] = num_fma(b->lever_x[a], m, b->draw_x[a] * kr);
            b->asked_y[a] = num_fma(b->lever_y[a], m, b->draw_y[a] * kr);
        }
        bodies_up(b);
        bodies_down(b, k);
        for (int a = 0; a < b->n; a++) bodies_tip(b, (size_t)k * b->stride + (size_t)a, a);
        for (int a = 1; a < b->n; a++) bodies_tip_child(b, a, k);
        bodies_pivot_force_first(b, k);
    }
}

/** Returns non-zero if lanes_bodies supports the terms: those of lanes_orders, with masses other
 * than points at tips or arms attached elsewhere. O(1). */
static inline int lanes_bodies_known(const struct pend_terms *terms) {
    struct pend_terms points = *terms; // `terms` with masses at the tips
    int shaped = 0;
    for (int r = 0; r < PEND_TERM_ROWS; r++) {
        if (!jets_loads_shape(r)) continue;
        shaped |= terms->row[r] >= 0;
        points.row[r] = -1;
    }
    return shaped && jets_loads_known(&points);
}

/** lanes_orders for bodies. O(n order^2). */
static inline void lanes_bodies(const struct jets_system *s, const struct bodies_system *b,
                                const struct bodies_moment *now, int order, int forces) {
    const struct pend_terms *terms = b->terms;
    int moves = (terms->harmonics && terms->harmonic[0].drives < 0) ||
                terms->one[PEND_TERM_PIVOT_ACCELERATION_X] >= 0;
    struct lanes_loads x = {s, b, *now, order, moves, forces, b->push_x, b->push_y};
    for (int k = 0; k < s->n; k++) {
        s->sine[k] = b->sine[k], s->cosine[k] = b->cosine[k];
        s->turn_re[s->n + k] = num_of(0);
        s->turn_im[s->n + k] = s->rate[k];
    }
    assert(s->n <= DENSE_MAX && s->stride == (size_t)s->n && b->need & BODIES_SHAPE);
    lanes_drives(&x);
    bodies_factor(b);
    if (s->n == 1)
        lanes_rigid(&x, 1);
    else if (s->n == 2)
        lanes_rigid(&x, 2);
    else if (s->n == 3)
        lanes_rigid(&x, 3);
    else
        lanes_rigid(&x, 4);
    lanes_tips(&x, moves || forces ? order : 1);
    for (int k = 0; k < s->n; k++) s->force[k] = b->tip_x[k];
    if (forces) bodies_forces(b, order);
}
