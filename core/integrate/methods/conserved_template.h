/* Real pendulums that keep their energy, in angles and momenta: rates from momenta, and the force
 * on each angle, for the lanes of the symplectic kernel, which includes this after its numbers.
 * Leaves to others: the stages (kernel_symplectic), the factorization (bodies_template).
 * Invariant: O(n); friction and drives are not supported.
 *
 * Derivation. In the frame of an arm, v is the velocity of its joint; its body has the mass M, the
 * first moment h and the inertia J about the joint. Child c is attached at p_c, and its sub-tree
 * has the momentum P_c:
 *     P = M v + i h phi' + sum P_c,    L = conj(h) v + i J phi' + sum conj(p_c) P_c.
 * The momentum of the angle is p = Im L, and the kinetic energy has the derivative -phi' Re L with
 * respect to the angle at fixed rates. (Re M)^-1 p are the accelerations that torques p cause in a
 * pendulum at rest without gravity; order 0 of the general kernel computes them. A cart is an arm
 * whose u is 1 (bodies_factor_template): the momentum of its position is Im L, and the kinetic
 * energy does not depend on the position. */
#pragma once

#include "core/bodies/bodies_template.h"
#include "core/tree/turns.h"

/*
 * For every arm, in addition to the system of bodies:
 *
 * length, load              those of the tree, m and kg
 * weight_x, weight_y        h + sum p_c m_c, where m_c is the mass of the sub-tree of child c; g
 *                           times this is the torque of gravity
 * swing                     J + sum m_c |p_c|^2
 * mass                      M + sum m_c
 * couple_x, couple_y        L
 * pull                      the generalized force on the angle */
#define CONSERVED_ARRAYS(X)                                                                        \
    X(length) X(load) X(weight_x) X(weight_y) X(swing) X(mass) X(couple_x) X(couple_y) X(pull)

struct conserved {
    struct bodies_system body;
    num *value; /* values of the terms */
#define X(name) num *name;
    CONSERVED_ARRAYS(X)
#undef X
};

enum {
#define X(name) CONSERVED_##name,
    CONSERVED_ARRAYS(X)
#undef X
        CONSERVED_COUNT
};

/* number of values that a pendulum needs: its arrays, the list of its terms, and the pivot's
 * acceleration */
static size_t conserved_numbers(const struct pend_terms *terms, int n) {
    if (!terms) return 0;
    return (size_t)(BODIES_ARRAY_COUNT + CONSERVED_COUNT) * (size_t)n + (size_t)terms->count + 2;
}

/* lays out a pendulum in memory of conserved_numbers values */
static struct conserved conserved_view(const struct pend_terms *terms, int n, const int parent[],
                                       num *at) {
    size_t row = (size_t)n;
    num *own = at + BODIES_ARRAY_COUNT * row, *value = own + CONSERVED_COUNT * row;
    struct conserved c = {.value = value,
#define X(name) .name = own + CONSERVED_##name * row,
                          CONSERVED_ARRAYS(X)
#undef X
    };
    c.body = (struct bodies_system){.n = n,
                                    .parent = parent,
                                    .terms = terms,
                                    .value = value,
                                    .len = c.length,
                                    .mass = c.load,
                                    .lift_x = value + terms->count,
                                    .lift_y = value + terms->count + 1,
#define X(name) .name = at + BODIES_ARRAY_##name * row,
                                    BODIES_ARRAYS(X)
#undef X
    };
    return c;
}

/* copies the values of a pendulum, and adds up the masses and moments of each arm's sub-tree */
static void conserved_load(const struct conserved *c, const double len[], const double mass[],
                           const double value[]) {
    const struct bodies_system *b = &c->body;
    for (int j = 0; j < b->terms->count; j++) c->value[j] = num_of(value[j]);
    for (int k = 0; k < b->n; k++) {
        c->length[k] = num_of(len[k]);
        c->load[k] = num_of(mass[k]);
        bodies_point(b, k);
        bodies_alone(b, k);
        c->weight_x[k] = b->moment_x[k], c->weight_y[k] = b->moment_y[k];
        c->swing[k] = b->inertia[k], c->mass[k] = b->body[k];
    }
    for (int k = b->n - 1; k > 0; k--) {
        int p = b->parent[k];
        num x = b->point_x[k], y = b->point_y[k], m = c->mass[k];
        c->mass[p] += m;
        c->weight_x[p] = num_fma(m, x, c->weight_x[p]);
        c->weight_y[p] = num_fma(m, y, c->weight_y[p]);
        c->swing[p] = num_fma(m, x * x + y * y, c->swing[p]);
    }
    b->lift_x[0] = b->lift_y[0] = num_of(0);
}

/* computes angles relative to the parents, their sines and cosines, and the factorization */
static void conserved_place(const struct conserved *c, const num phi[], const num low[]) {
    const struct bodies_system *b = &c->body;
    for (int k = 0; k < b->n; k++) {
        int p = pend_terms_holder(b->terms, b->parent, k);
        num x = phi[k], y = p < 0 ? num_of(0) : phi[p], d = x - y, back = x - d;
        num rest = (low[k] - (p < 0 ? num_of(0) : low[p])) + ((x - (d + back)) + (back - y));
        num_turn(d, rest, &b->sine[k], &b->cosine[k]);
        b->bend[k] = p < 0 ? (d + M_PI_2) + (rest + PEND_QUARTER_LOW) : d + rest;
    }
    if (pend_terms_cart(b->terms)) bodies_cart_start(b, phi[0] + low[0]);
    bodies_factor(b);
}

/* computes phi' = (Re M)^-1 p, after conserved_place */
static void conserved_rates(const struct conserved *c, const num momentum[], num rate[]) {
    const struct bodies_system *b = &c->body;
    for (int k = 0; k < b->n; k++) {
        b->pulled[k] = num_of(0);
        b->answer[k] = momentum[k];
        b->asked_x[k] = b->lever_x[k] * momentum[k];
        b->asked_y[k] = b->lever_y[k] * momentum[k];
    }
    bodies_up(b);
    bodies_down(b, 0);
    for (int k = 0; k < b->n; k++) rate[k] = b->answer[k];
}

/* computes L of all arms from their rates, after conserved_place */
static void conserved_flow(const struct conserved *c, const num rate[]) {
    const struct bodies_system *b = &c->body;
    for (int k = 0; k < b->n; k++) {
        int p = b->parent[k];
        num C = b->cosine[k], Z = b->sine[k], x = num_of(0), y = num_of(0), w = rate[k];
        if (p >= 0) {
            x = b->speed_x[p] - b->point_y[k] * rate[p];
            y = num_fma(b->point_x[k], rate[p], b->speed_y[p]);
        }
        num vx = num_fma(C, x, Z * y), vy = C * y - Z * x, M = b->body[k];
        num hx = b->moment_x[k], hy = b->moment_y[k];
        b->speed_x[k] = vx, b->speed_y[k] = vy;
        b->reach_x[k] = M * vx - hy * w;
        b->reach_y[k] = num_fma(M, vy, hx * w);
        c->couple_x[k] = num_fma(hx, vx, hy * vy);
        c->couple_y[k] = num_fma(b->inertia[k], w, hx * vy - hy * vx);
    }
    for (int k = b->n - 1; k > 0; k--) {
        int p = b->parent[k];
        num C = b->cosine[k], Z = b->sine[k], px = b->point_x[k], py = b->point_y[k];
        num x = C * b->reach_x[k] - Z * b->reach_y[k],
            y = num_fma(Z, b->reach_x[k], C * b->reach_y[k]);
        b->reach_x[p] += x, b->reach_y[p] += y;
        c->couple_x[p] += num_fma(px, x, py * y);
        c->couple_y[p] += px * y - py * x;
    }
}

/* computes the generalized forces on the angles, after conserved_flow, from motion, gravity and
 * springs; up_re, up_im: e^{i phi} */
static void conserved_pull(const struct conserved *c, double gravity, const num rate[],
                           const num up_re[], const num up_im[]) {
    const struct bodies_system *b = &c->body;
    int stiff = b->terms->row[PEND_TERM_STIFFNESS] >= 0;
    // the frame of a cart does not rotate
    if (pend_terms_cart(b->terms)) c->pull[0] = -gravity * c->weight_x[0];
    for (int k = pend_terms_cart(b->terms) ? 1 : 0; k < b->n; k++) {
        num fall = c->weight_x[k] * up_re[k] - c->weight_y[k] * up_im[k];
        c->pull[k] = -num_fma(rate[k], c->couple_x[k], gravity * fall);
    }
    for (int k = 0; k < b->n && stiff; k++) {
        int p = pend_terms_holder(b->terms, b->parent, k);
        num bent = b->bend[k] - bodies_get(b, PEND_TERM_REST, k);
        num torque = bodies_get(b, PEND_TERM_STIFFNESS, k) * bent;
        c->pull[k] -= torque;
        if (p >= 0) c->pull[p] += torque;
    }
}
