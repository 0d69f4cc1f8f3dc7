#include "core/bodies/kernel_bodies.h"

#include <math.h>

#include "core/tree/turns.h"

#include "core/bodies/bodies_template.h"

/* computes the angles to the parents, their sines and cosines, and the rates per unit of time */
static void kernel_start(const struct bodies_system *s, const struct bodies_state *state,
                         double unit) {
    for (int k = 0; k < s->n; k++) {
        int p = pend_terms_holder(s->terms, s->parent, k);
        double x = state->phi[k], y = p < 0 ? 0 : state->phi[p], low = 0, d = x - y, back = x - d;
        if (state->phi_low) low = state->phi_low[k] - (p < 0 ? 0 : state->phi_low[p]);
        low += (x - (d + back)) + (back - y);
        num_turn(d, low, &s->sine[k], &s->cosine[k]);
        s->bend[k] = p < 0 ? (d + M_PI_2) + (low + PEND_QUARTER_LOW) : d + low;
        s->rate[bodies_row(s, k)] = state->rate[k] * unit;
    }
    if (pend_terms_cart(s->terms))
        bodies_cart_start(s, state->phi[0] + (state->phi_low ? state->phi_low[0] : 0));
}

static void kernel_orders(const struct bodies_system *s, const struct bodies_state *state,
                          double gravity, double unit, int order) {
    struct bodies_moment now = {unit, gravity * (unit * unit), state->time, state->late};
    kernel_start(s, state, unit);
    bodies_orders(s, &now, order);
}

static double kernel_reach(const struct bodies_system *s, double far) {
    return s->need & BODIES_FRICTION ? bodies_reach(s, far) : far;
}

const struct bodies_kernel KERNEL_NAME(pend_kernel_bodies_) = {
    .orders = kernel_orders, .forces = bodies_forces, .power = bodies_power, .reach = kernel_reach};
