/* A pivot on a cart, in the general kernel, for any kind of number.
 * Leaves to others: the equations of motion (bodies_template), the forces along the rail, which are
 * the torques of arm 0 (drives_template).
 * Invariant: nothing here is called for a pendulum without a cart.
 *
 * Derivation. The cart of mass M at place x moves as the point p = -i r of a body whose frame does
 * not turn would, r the direction of the rail: its acceleration a + r x'' is a + i p chi with chi =
 * x''. So arm 0 is an arm with a point of mass M at p, where all arms of the pivot hang, with J = M
 * |p|^2 = M, whose u is 1 to all orders: u has no series, and neither T nor kr. Its balance of
 * moments is then the balance of forces along the rail,
 *     (M + <r, sum P r>) x'' = tau - M <r, a> - <r, sum R beta_c>,
 * tau the forces along the rail, and the force asked of its joint is what the rail exerts. */
#ifndef PEND_CART_TEMPLATE_H
#define PEND_CART_TEMPLATE_H

/* p, at which the cart's mass is and all its arms hang */
static inline void bodies_cart_point(const struct bodies_system *s) {
    num zero = num_of(0), sine, cosine;
    num_drive(zero, zero, zero, bodies_one(s, PEND_TERM_RAIL), &sine, &cosine);
    s->point_x[0] = sine, s->point_y[0] = num_neg(cosine);
}

/** The cart's frame, which is that of the axes, and its place: what the angles to the parents are
 * of other arms. The caller's rate stays. */
static inline void bodies_cart_start(const struct bodies_system *s, num place) {
    s->cosine[0] = num_of(1), s->sine[0] = num_of(0);
    s->bend[0] = place;
}

/* the cart's frame does not turn: order k of u is 0 for k > 0 */
static inline void bodies_cart_still(const struct bodies_system *s, int k) {
    size_t at = bodies_row(s, 0) + (size_t)k * s->stride;
    s->turn_re[at] = s->turn_im[at] = num_of(0);
}

/* order k of the speed x', with which the point p moves as i p x' */
VEC_INLINE num bodies_cart_speed(const struct bodies_system *s, int k) {
    return s->rate[bodies_row(s, 0) + (size_t)k * s->stride];
}

/* order k of the moment of the cart's speed with the pivot's velocity, whose double is its part of
 * the sum of m |v|^2 that the series of u has for other arms */
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

#endif
