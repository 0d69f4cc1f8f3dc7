/* What acts on a real pendulum, order by order of its series: springs, friction, drives, the air;
 * and the power of what does not conserve energy. For any kind of number.
 * Leaves to others: the motion (bodies_template, which includes this).
 * Invariant: what a pendulum has not costs it nothing but a test. */
#ifndef PEND_DRIVES_TEMPLATE_H
#define PEND_DRIVES_TEMPLATE_H

/* The instant that a series is expanded about, and its unit. */
struct bodies_moment {
    num unit;       /* s, a power of two */
    num gravity;    /* m/s^2 times unit^2 */
    num time, late; /* s, the request's own time as a sum of two */
};

/* ---- drives */

/* Adds the derivative of order `from` of a harmonic as a series: A w^(from+j) / j! cos(theta +
 * (from
 * + j) pi / 2), w = omega unit, for j = 0 .. order, to every `step`-th number. */
static inline void bodies_harmonic(const struct bodies_system *s, const struct bodies_moment *now,
                                   int at, int from, int order, num *to, size_t step) {
    num sine, cosine, size = s->value[at], w = num_mul(s->value[at + 1], now->unit);
    num_drive(s->value[at + 1], now->time, now->late, s->value[at + 2], &sine, &cosine);
    num cycle[4] = {cosine, num_neg(sine), num_neg(cosine), sine};
    for (int j = 0; j < from; j++) size = num_mul(size, w);
    for (int j = 0; j <= order; j++) {
        num *here = to + (size_t)j * step;
        *here = num_fma(size, cycle[(from + j) % 4], *here);
        size = num_div(num_mul(size, w), num_of(j + 1));
    }
}

/* the pivot's z' and z'' + 2 gamma z', and gravity */
static inline void bodies_drive_pivot(const struct bodies_system *s,
                                      const struct bodies_moment *now, int order) {
    num zero = num_of(0), square = num_mul(now->unit, now->unit);
    for (int j = 0; j <= order; j++)
        s->lift_x[j] = s->lift_y[j] = s->slide_x[j] = s->slide_y[j] = zero;
    for (int i = 0; i < s->terms->harmonics; i++) {
        const struct pend_harmonic *h = &s->terms->harmonic[i];
        if (h->drives >= 0) break;
        int across = h->drives == PEND_DRIVE_PIVOT_X;
        bodies_harmonic(s, now, h->at, 2, order, across ? s->lift_x : s->lift_y, 1);
        bodies_harmonic(s, now, h->at, 1, order, across ? s->slide_x : s->slide_y, 1);
    }
    num x = num_mul(square, bodies_one(s, PEND_TERM_PIVOT_ACCELERATION_X));
    num y = num_mul(square, bodies_one(s, PEND_TERM_PIVOT_ACCELERATION_Y));
    num since = num_div(num_add(now->time, now->late), now->unit);
    s->slide_x[0] = num_fma(x, since, s->slide_x[0]);
    s->slide_y[0] = num_fma(y, since, s->slide_y[0]);
    if (order > 0) {
        s->slide_x[1] = num_add(s->slide_x[1], x);
        s->slide_y[1] = num_add(s->slide_y[1], y);
    }
    s->lift_x[0] = num_add(s->lift_x[0], x);
    s->lift_y[0] = num_add(num_add(s->lift_y[0], y), now->gravity);
    if (!(s->need & BODIES_MIST)) return;
    num twice = num_mul(num_mul(num_of(2), now->unit), bodies_one(s, PEND_TERM_DRAG_PER_MASS));
    for (int j = 0; j <= order; j++) {
        s->lift_x[j] = num_fma(twice, s->slide_x[j], s->lift_x[j]);
        s->lift_y[j] = num_fma(twice, s->slide_y[j], s->lift_y[j]);
    }
}

/* the series of all drives */
static inline void bodies_drive(const struct bodies_system *s, const struct bodies_moment *now,
                                int order) {
    bodies_drive_pivot(s, now, order);
    if (!(s->need & BODIES_DRIVES)) return;
    num square = num_mul(now->unit, now->unit);
    for (int a = 0; a < s->n; a++) {
        num *drive = s->drive + bodies_row(s, a);
        for (int j = 0; j <= order; j++) drive[(size_t)j * s->stride] = num_of(0);
    }
    for (int i = 0; i < s->terms->harmonics; i++) {
        const struct pend_harmonic *h = &s->terms->harmonic[i];
        if (h->drives >= 0)
            bodies_harmonic(s, now, h->at, 0, order, s->drive + bodies_row(s, h->drives),
                            s->stride);
    }
    for (int a = 0; a < s->n; a++) {
        num *drive = s->drive + bodies_row(s, a);
        drive[0] = num_add(drive[0], bodies_get(s, PEND_TERM_TORQUE, a));
        for (int j = 0; j <= order; j++)
            drive[(size_t)j * s->stride] = num_mul(square, drive[(size_t)j * s->stride]);
    }
}

/* ---- torques at the joints */

/* coefficient k of the rate of arm a relative to its parent */
VEC_INLINE num bodies_swing(const struct bodies_system *s, int a, int k) {
    int p = pend_terms_holder(s->terms, s->parent, a);
    size_t at = (size_t)k * s->stride;
    num w = s->rate[bodies_row(s, a) + at];
    return p < 0 ? w : num_sub(w, s->rate[bodies_row(s, p) + at]);
}

/* tanh of the joint's speed over the friction's, to order k: y' = (1 - y^2) x' */
static inline num bodies_grip(const struct bodies_system *s, const struct bodies_moment *now, int a,
                              int k) {
    size_t row = bodies_row(s, a), stride = s->stride;
    num scale = num_div(num_of(1), num_mul(bodies_get(s, PEND_TERM_FRICTION_SPEED, a), now->unit));
    num y = num_of(0);
    if (!k) {
        y = num_tanh(num_mul(bodies_swing(s, a, 0), scale));
    } else {
        for (int j = 1; j <= k; j++) {
            num x = num_mul(num_mul(bodies_swing(s, a, j), scale), num_of(j));
            y = num_fma(x, s->grip_rest[row + (size_t)(k - j) * stride], y);
        }
        y = num_div(y, num_of(k));
    }
    s->grip[row + (size_t)k * stride] = y;
    num rest = num_of(k ? 0 : 1);
    for (int j = 0; j <= k; j++)
        rest = num_sub(rest, num_mul(s->grip[row + (size_t)j * stride],
                                     s->grip[row + (size_t)(k - j) * stride]));
    s->grip_rest[row + (size_t)k * stride] = rest;
    return y;
}

/* what the friction of the joint of arm a does, order k */
static inline num bodies_lose(const struct bodies_system *s, const struct bodies_moment *now, int a,
                              int k) {
    num loss =
        num_mul(num_mul(bodies_get(s, PEND_TERM_DAMPING, a), now->unit), bodies_swing(s, a, k));
    if (s->need & BODIES_GRIP) {
        num size = num_mul(bodies_get(s, PEND_TERM_FRICTION, a), num_mul(now->unit, now->unit));
        loss = num_fma(size, bodies_grip(s, now, a, k), loss);
    }
    loss = num_neg(loss);
    s->loss[bodies_row(s, a) + (size_t)k * s->stride] = loss;
    return loss;
}

/* what the spring of the joint of arm a does, order k */
VEC_INLINE num bodies_spring(const struct bodies_system *s, const struct bodies_moment *now, int a,
                             int k, num share) {
    num bent = k ? num_mul(bodies_swing(s, a, k - 1), share)
                 : num_sub(s->bend[a], bodies_get(s, PEND_TERM_REST, a));
    num stiff = num_mul(bodies_get(s, PEND_TERM_STIFFNESS, a), num_mul(now->unit, now->unit));
    return num_neg(num_mul(stiff, bent));
}

/* the sum of all torques on every arm */
static inline void bodies_couple(const struct bodies_system *s, const struct bodies_moment *now,
                                 int k) {
    int stiff = s->terms->row[PEND_TERM_STIFFNESS] >= 0;
    for (int a = 0; a < s->n; a++) s->couple[a] = num_of(0);
    if (!stiff && !(s->need & (BODIES_LOSSES | BODIES_DRIVES))) return;
    num share = num_div(num_of(1), num_of(k ? k : 1));
    for (int a = 0; a < s->n; a++) {
        num torque = num_of(0);
        int p = pend_terms_holder(s->terms, s->parent, a);
        if (stiff) torque = bodies_spring(s, now, a, k, share);
        if (s->need & BODIES_LOSSES) torque = num_add(torque, bodies_lose(s, now, a, k));
        if (s->need & BODIES_DRIVES)
            torque = num_add(torque, s->drive[bodies_row(s, a) + (size_t)k * s->stride]);
        s->couple[a] = num_add(s->couple[a], torque);
        if (p >= 0) s->couple[p] = num_sub(s->couple[p], torque);
    }
}

/* ---- the air */

/* velocities of joints and tips, order k */
static inline void bodies_move(const struct bodies_system *s, int k) {
    num more = num_of(k + 1);
    for (int a = 0; a < s->n; a++) {
        size_t row = bodies_row(s, a) + (size_t)k * s->stride;
        int p = s->parent[a];
        num x = s->slide_x[k], y = s->slide_y[k];
        if (p >= 0) {
            size_t up = bodies_row(s, p) + (size_t)(k + 1) * s->stride;
            num re = num_mul(more, s->turn_re[up]), im = num_mul(more, s->turn_im[up]);
            if (!p && pend_terms_cart(s->terms)) im = bodies_cart_speed(s, k);
            num px = s->point_x[a], py = s->point_y[a];
            x = num_add(s->speed_x[p], num_sub(num_mul(px, re), num_mul(py, im)));
            y = num_add(s->speed_y[p], num_fma(py, re, num_mul(px, im)));
        }
        num C = s->cosine[a], Z = s->sine[a];
        num vx = num_fma(C, x, num_mul(Z, y)), vy = num_sub(num_mul(C, y), num_mul(Z, x));
        s->speed_x[a] = vx, s->speed_y[a] = vy;
        if (s->need & BODIES_MIST) s->base_way_x[row] = vx, s->base_way_y[row] = vy;
        if (!(s->need & BODIES_AIR)) continue;
        num l = num_mul(s->len[a], more);
        s->way_x[row] = num_fma(l, s->turn_re[row + s->stride], vx);
        s->way_y[row] = num_fma(l, s->turn_im[row + s->stride], vy);
    }
}

/* sqrt(|v|^2 + e^2) of the tip of arm a, order k */
static inline void bodies_rush(const struct bodies_system *s, const struct bodies_moment *now,
                               int a, int k) {
    size_t row = bodies_row(s, a), stride = s->stride, last = row + (size_t)k * stride;
    num least = num_mul(bodies_get(s, PEND_TERM_DRAG_SPEED, a), now->unit);
    num sum = k ? num_of(0) : num_mul(least, least);
    for (int j = 0; j <= k; j++) {
        size_t at = row + (size_t)j * stride, back = row + (size_t)(k - j) * stride;
        sum = num_fma(s->way_x[at], s->way_x[back], sum);
        sum = num_fma(s->way_y[at], s->way_y[back], sum);
    }
    s->air_size[last] = sum;
    if (!k) {
        // the root has the sign of the unit, by which speeds are multiplied: exact, a power of two
        num square = num_mul(now->unit, now->unit);
        s->air_part[last] = num_mul(now->unit, num_root(num_div(sum, square)));
        return;
    }
    for (int j = 1; j < k; j++)
        sum = num_sub(sum, num_mul(s->air_part[row + (size_t)j * stride],
                                   s->air_part[row + (size_t)(k - j) * stride]));
    s->air_part[last] = num_div(sum, num_mul(num_of(2), s->air_part[row]));
}

/* the air's force on the tip of arm a, order k */
static inline void bodies_blow(const struct bodies_system *s, const struct bodies_moment *now,
                               int a, int k) {
    size_t row = bodies_row(s, a), stride = s->stride, last = row + (size_t)k * stride;
    num b = num_neg(num_mul(bodies_get(s, PEND_TERM_DRAG, a), now->unit));
    num x = num_mul(b, s->way_x[last]), y = num_mul(b, s->way_y[last]);
    if (s->need & BODIES_FAST_AIR) {
        num fx = num_of(0), fy = num_of(0), d = bodies_get(s, PEND_TERM_DRAG_QUADRATIC, a);
        bodies_rush(s, now, a, k);
        for (int j = 0; j <= k; j++) {
            num r = s->air_part[row + (size_t)j * stride];
            size_t back = row + (size_t)(k - j) * stride;
            fx = num_fma(r, s->way_x[back], fx);
            fy = num_fma(r, s->way_y[back], fy);
        }
        x = num_sub(x, num_mul(d, fx));
        y = num_sub(y, num_mul(d, fy));
    }
    s->drag_x[a] = s->air_x[last] = x;
    s->drag_y[a] = s->air_y[last] = y;
}

/* all that acts on the arms, order k */
static inline void bodies_load(const struct bodies_system *s, const struct bodies_moment *now,
                               int k) {
    bodies_couple(s, now, k);
    if (s->need & (BODIES_AIR | BODIES_MIST)) bodies_move(s, k);
    for (int a = 0; a < s->n && s->need & BODIES_AIR; a++) bodies_blow(s, now, a, k);
}

/* ---- power */

/* adds sum_{j <= k} a_j b_{k-j} to coefficient k, both with the stride of series */
static inline num bodies_product(const struct bodies_system *s, const num *a, const num *b, int k,
                                 num sum) {
    for (int j = 0; j <= k; j++)
        sum = num_fma(a[(size_t)j * s->stride], b[(size_t)(k - j) * s->stride], sum);
    return sum;
}

#ifdef NUMBER_QUAD_DOUBLE
enum { BODIES_ORDERS = 80 };
#else
enum { BODIES_ORDERS = 48 };
#endif

/* adds the power of the torques of all joints, orders 0 .. order - 1: what `torque` gives to an arm
 * less what it takes from the parent. Each arm's share is summed in the arms' order. */
static inline void bodies_effort(const struct bodies_system *s, const num *torque, int order,
                                 num sum[]) {
    assert(order <= BODIES_ORDERS);
    for (int a = 0; a < s->n; a += BODIES_ARMS) {
        num swing[BODIES_ORDERS][BODIES_ARMS];
        const num *own = torque + bodies_row(s, a);
        int count = s->n - a < BODIES_ARMS ? s->n - a : BODIES_ARMS;
        for (int j = 0; j < order; j++)
            for (int i = 0; i < BODIES_ARMS; i++)
                swing[j][i] = i < count ? bodies_swing(s, a + i, j) : num_of(0);
        for (int k = 0; k < order; k++) {
            num share[BODIES_ARMS];
            arms all = arms_of(0);
            for (int j = 0; j <= k; j++)
                all = arms_fma(arms_get(own + (size_t)j * s->stride), arms_get(swing[k - j]), all);
            arms_put(share, all);
            for (int i = 0; i < count; i++) sum[k] = num_add(sum[k], share[i]);
        }
    }
}

/* half of what drag_per_mass takes over gamma, order k: sum of m |v|^2 of all masses of arm a. The
 * body's frame turns with u: |v_b|^2 M + 2 Re(conj(v_b) h u') + J phi'^2. */
static inline num bodies_sweep(const struct bodies_system *s, int a, int k, num sum) {
    size_t row = bodies_row(s, a), stride = s->stride;
    const num *x = s->base_way_x + row, *y = s->base_way_y + row;
    num square = bodies_product(s, y, y, k, bodies_product(s, x, x, k, num_of(0)));
    sum = num_fma(s->body[a], square, sum);
    sum =
        num_fma(s->inertia[a], bodies_product(s, s->rate + row, s->rate + row, k, num_of(0)), sum);
    for (int j = 0; j <= k; j++) {
        size_t at = row + (size_t)(j + 1) * stride;
        num re = num_mul(num_of(j + 1), s->turn_re[at]),
            im = num_mul(num_of(j + 1), s->turn_im[at]);
        if (!a && pend_terms_cart(s->terms)) im = bodies_cart_speed(s, j);
        num hx = num_sub(num_mul(s->moment_x[a], re), num_mul(s->moment_y[a], im));
        num hy = num_fma(s->moment_x[a], im, num_mul(s->moment_y[a], re));
        size_t back = (size_t)(k - j) * stride;
        num part = num_fma(x[back], hx, num_mul(y[back], hy));
        sum = num_fma(num_of(2), part, sum);
    }
    return sum;
}

/* the pivot's power, order k: Re(conj(F) z'), F the force that it exerts */
static inline num bodies_haul(const struct bodies_system *s, const num *force_x, const num *force_y,
                              int k) {
    num sum = num_of(0);
    for (int j = 0; j <= k; j++) {
        sum = num_fma(force_x[j], s->slide_x[k - j], sum);
        sum = num_fma(force_y[j], s->slide_y[k - j], sum);
    }
    return sum;
}

/**
 * The work that drives do and the heat that friction and the air take, per unit of time, as series:
 * coefficients 0 .. order - 1, J times unit^2; after bodies_orders. O(n order^2).
 */
static inline void bodies_power(const struct bodies_system *s, num unit, int order, num work[],
                                num heat[]) {
    num twice = num_mul(num_mul(num_of(2), bodies_one(s, PEND_TERM_DRAG_PER_MASS)), unit);
    for (int k = 0; k < order; k++) {
        work[k] = bodies_haul(s, s->haul_x, s->haul_y, k);
        heat[k] = num_of(0);
    }
    if (s->need & BODIES_DRIVES) bodies_effort(s, s->drive, order, work);
    if (s->need & BODIES_LOSSES) bodies_effort(s, s->loss, order, heat);
    for (int k = 0; k < order; k++) {
        num taken = heat[k], mist = num_of(0);
        for (int a = 0; a < s->n; a++) {
            size_t row = bodies_row(s, a);
            if (s->need & BODIES_AIR) {
                taken = bodies_product(s, s->air_x + row, s->way_x + row, k, taken);
                taken = bodies_product(s, s->air_y + row, s->way_y + row, k, taken);
            }
            if (s->need & BODIES_MIST) mist = bodies_sweep(s, a, k, mist);
        }
        heat[k] = num_sub(num_mul(twice, mist), taken);
    }
}

#endif
