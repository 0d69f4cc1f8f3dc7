/* Torques between the arms of a tree of more than eight arms, order by order: springs, friction and
 * drives as forces across the arms; the pivot's acceleration; the forces along the arms; and the
 * power of all.
 * Leaves to others: the orders themselves (chain_template, blocks_template), the derivation
 * (small_loads_template).
 * Invariant: one pass over the arms per order, the same for every decomposition. Ideal trees pay
 * nothing: `couples` is a compile-time constant. */
#pragma once

#include <assert.h>

#include "core/simd/vec8_template.h"
#include "core/taylor/loads_template.h"
#include "core/tree/turns.h"

enum { COUPLES_ARMS = 8 };

/* ---- once a step */

/* the series of the drives' torques */
static void couples_motors(const struct jets_system *s, const struct bodies_moment *now,
                           int order) {
    const struct jets_loads *loads = s->loads;
    double square = now->unit * now->unit;
    for (int a = 0; a < loads->padded; a += COUPLES_ARMS)
        memset(loads->motor + jets_row(s, a), 0, (size_t)order * COUPLES_ARMS * sizeof(double));
    for (int i = 0; i < loads->terms->harmonics; i++) {
        const struct pend_harmonic *harmonic = &loads->terms->harmonic[i];
        double torque[LOADS_ORDERS] = {0};
        if (harmonic->drives < 0) continue;
        bodies_harmonic(loads->value + harmonic->at, s->share, now, 0, order, torque, 1);
        double *to = loads->motor + jets_row(s, harmonic->drives);
        for (int k = 0; k < order; k++) to[k * COUPLES_ARMS] += square * torque[k];
    }
}

/* one term's values for the WIDE arms from k on; 0 if the pendulum does not have the term */
VEC_INLINE wide couples_row(const struct jets_loads *loads, enum pend_term_row row, int k) {
    int at = loads->terms->row[row], n = loads->terms->n;
    if (at < 0) return wide_of(0);
    if (k + WIDE <= n) return wide_load(loads->value + at + k);
    wide x = wide_of(0);
    for (int i = 0; k + i < n; i++) x[i] = loads->value[at + k + i];
    return x;
}

/* computes the values known before the first order; requires the rates of order 0 */
static void couples_begin(const struct jets_system *s, const struct bodies_moment *now, int order) {
    const struct jets_loads *loads = s->loads;
    double unit = now->unit, square = unit * unit;
    for (int k = 0; k < s->n; k += WIDE) {
        wide high = wide_get(s->angle + k), low = wide_get(s->angle_low + k);
        if (!k) high[0] += M_PI_2, low[0] += PEND_QUARTER_LOW;
        wide stiff = square * couples_row(loads, PEND_TERM_STIFFNESS, k);
        wide bent = (high + low) - couples_row(loads, PEND_TERM_REST, k);
        wide fixed = square * couples_row(loads, PEND_TERM_TORQUE, k) - stiff * bent;
        wide_put(loads->hold + k, unit * couples_row(loads, PEND_TERM_DAMPING, k));
        wide_put(loads->stiff + k, stiff);
        wide_put(loads->fixed + k, fixed);
    }
    for (int a = 0; a < loads->padded; a += WIDE)
        wide_put(loads->spin + a, wide_get(s->rate + jets_row(s, a)));
    if (loads->drives) couples_motors(s, now, order);
}

/* ---- once an order */

/* The torques of order k between the arms from a on, whose series are at `row`, and their parents.
 * The factor `less` is negative; it turns rates of order k - 1 into minus the angles of order k. */
VEC_INLINE wide couples_torque(const struct jets_loads *loads, int a, size_t row, int k, wide less,
                               wide up) {
    wide slip = wide_get(loads->spin + a) - up;
    wide torque = wide_get(k ? loads->slips + row - COUPLES_ARMS : loads->fixed + a);
    if (k) torque *= less * wide_get(loads->stiff + a);
    if (loads->drives) torque += wide_get(loads->motor + row);
    wide_put(loads->slips + row, slip);
    return torque - wide_get(loads->hold + a) * slip;
}

VEC_INLINE void couples_torques(const struct jets_loads *loads, int tile, size_t row, int k,
                                wide less) {
    const double *spin = loads->spin, *near = spin + loads->near[tile].parent;
    const int *parent = loads->near[tile].parent == LOADS_APART ? loads->parent : NULL;
    for (int h = 0; h < COUPLES_ARMS; h += WIDE) {
        int a = tile * COUPLES_ARMS + h;
        wide up = parent ? wide_gather(spin, parent + a) : wide_load(near + h);
        wide_put(loads->torque + a, couples_torque(loads, a, row + (size_t)h, k, less, up));
    }
}

/* computes the forces across an arm from its own torque minus that of its first child */
VEC_INLINE void couples_cross(const struct jets_loads *loads, int tile, size_t row) {
    const double *torque = loads->torque, *near = torque + loads->near[tile].child;
    const int *child = loads->near[tile].child == LOADS_APART ? loads->child : NULL;
    for (int h = 0; h < COUPLES_ARMS; h += WIDE) {
        int a = tile * COUPLES_ARMS + h;
        wide below = child ? wide_gather(torque, child + a) : wide_load(near + h);
        wide_put(loads->cross + row + h,
                 (wide_get(torque + a) - below) * wide_get(loads->part + a));
    }
}

/* adds to `cross` the forces across the arms of order k due to torques */
VEC_INLINE void couples_order(const struct jets_system *s, int k) {
    const struct jets_loads loads = *s->loads;
    size_t order = (size_t)k * COUPLES_ARMS;
    wide less = wide_of(k ? -s->share[k - 1] : 0);
    for (int tile = 0; tile < s->tiles; tile++)
        couples_torques(&loads, tile, (size_t)tile * s->tile + order, k, less);
    for (int tile = 0; tile < s->tiles; tile++)
        couples_cross(&loads, tile, (size_t)tile * s->tile + order);
    double *cross = loads.cross + order;
    for (const struct loads_kid *kid = loads.kid; kid < loads.kid + loads.kids; kid++)
        cross[kid->row] -= loads.torque[kid->child] * kid->part;
}

/* couples_order for a chain, in which the neighbours are the arms before and after */
VEC_INLINE void couples_chain_order(const struct jets_system *s, int k) {
    const struct jets_loads loads = *s->loads;
    wide less = wide_of(k ? -s->share[k - 1] : 0), after = wide_of(0);
    for (int tile = s->tiles - 1; tile >= 0; tile--) {
        size_t row = (size_t)tile * s->tile + (size_t)k * COUPLES_ARMS;
        for (int h = COUPLES_ARMS - WIDE; h >= 0; h -= WIDE) {
            int a = tile * COUPLES_ARMS + h;
            wide up = wide_unshift(wide_get(loads.spin + a - WIDE), wide_get(loads.spin + a));
            wide torque = couples_torque(&loads, a, row + (size_t)h, k, less, up);
            wide_put(loads.cross + row + h,
                     (torque - wide_shift(torque, after)) * wide_get(loads.part + a));
            after = torque;
        }
    }
}

/* The known forces across the arms, divided by the order, from the result of the convolutions
 * (`ci`, minus their real parts); stores its series. `row` is the index of order k of the arms. */
VEC_INLINE wide couples_across(const struct jets_system *s, size_t row, int k, wide ci) {
    double *at = s->loads->cross + row;
    wide cross = wide_get(at) + ci;
    wide_put(at, cross);
    return cross * wide_of(s->share[k]);
}

/* the pivot's acceleration with gravity, order k, divided by the order */
struct couples_lift {
    double x, y;
};

VEC_INLINE struct couples_lift couples_lift(const struct jets_system *s, double gravity, int k) {
    const struct jets_loads *loads = s->loads;
    if (!loads || !loads->moves) return (struct couples_lift){0, k ? 0 : gravity};
    return (struct couples_lift){loads->lift_x[k] * s->share[k], loads->lift_y[k] * s->share[k]};
}

/* ---- after the orders */

/* in place, from the highest order down: lambda = Re (conj(u) F) */
static void couples_along(const struct jets_system *s, int order) {
    for (int a = 0; a < s->loads->padded; a += WIDE) {
        size_t row = jets_row(s, a);
        const double *re = s->turn_re + row, *im = s->turn_im + row, *cross = s->loads->cross + row;
        double *force = s->force + row;
        wide first = wide_get(s->rate + row);
        for (int k = order - 1; k > 0; k--) {
            wide sum = wide_get(force + k * COUPLES_ARMS), less = wide_of(0);
            sum = wide_fma(first, wide_get(cross + (k - 1) * COUPLES_ARMS), sum);
            for (int j = 2; j <= k; j++) {
                size_t back = (size_t)(k - j) * COUPLES_ARMS;
                sum = wide_fma(wide_get(im + j * COUPLES_ARMS), wide_get(cross + back), sum);
                less = wide_fma(wide_get(re + j * COUPLES_ARMS), wide_get(force + back), less);
            }
            wide_put(force + k * COUPLES_ARMS, sum + less);
        }
    }
}

/* the force that the pivot exerts, along the first arm's axes: F = lambda u for point masses */
static void couples_haul(const struct jets_system *s, int order) {
    const struct jets_loads *loads = s->loads;
    size_t row = jets_row(s, 0);
    double force[LOADS_ORDERS], turn[2][LOADS_MARGIN + LOADS_ORDERS] = {{0}};
    for (int k = 0; k < order; k++) {
        size_t at = row + (size_t)k * COUPLES_ARMS;
        force[k] = s->force[at];
        loads->pivot_force_x[k] = loads->couples ? force[k] : 0;
        loads->pivot_force_y[k] = loads->couples ? loads->cross[at] : 0;
        turn[0][LOADS_MARGIN + k] = k ? s->turn_re[at] : 1;
        turn[1][LOADS_MARGIN + k] = k ? s->turn_im[at] : 0;
    }
    assert(order <= LOADS_ORDERS);
    if (loads->couples) return;
    for (int k = order; k % WIDE; k++) loads->pivot_force_x[k] = loads->pivot_force_y[k] = 0;
    loads_product(force, turn[0] + LOADS_MARGIN, order, loads->pivot_force_x);
    loads_product(force, turn[1] + LOADS_MARGIN, order, loads->pivot_force_y);
}

/* the sums of one order, one for each lane */
struct couples_sums {
    wide order[LOADS_ORDERS][COUPLES_ARMS / WIDE];
};

static void couples_total(const struct couples_sums *all, int order, double *sum) {
    for (int k = 0; k < order; k++)
        for (int i = 0; i < COUPLES_ARMS; i++) sum[k] += all->order[k][i / WIDE][i % WIDE];
}

/* adds the power of drives of orders below `order`: torque times rate relative to the parent,
 * summed over the arms */
static void couples_effort(const struct jets_system *s, int order, double *sum) {
    struct couples_sums all;
    memset(&all, 0, sizeof all);
    for (int a = 0; a < s->loads->padded; a += WIDE) {
        size_t row = jets_row(s, a);
        const double *slip = s->loads->slips + row, *motor = s->loads->motor + row;
        for (int k = 0; k < order; k++) {
            wide part = wide_of(0);
            for (int j = 0; j <= k; j++)
                part = wide_fma(wide_get(motor + j * COUPLES_ARMS),
                                wide_get(slip + (k - j) * COUPLES_ARMS), part);
            all.order[k][a % COUPLES_ARMS / WIDE] += part;
        }
    }
    couples_total(&all, order, sum);
}

/* adds the heat of friction of orders below `order`: a factor times the square of the rate relative
 * to the parent, summed over the arms; products of two orders are symmetric */
static void couples_waste(const struct jets_system *s, int order, double *sum) {
    struct couples_sums all;
    memset(&all, 0, sizeof all);
    for (int a = 0; a < s->loads->padded; a += WIDE) {
        const double *slip = s->loads->slips + jets_row(s, a);
        wide size = wide_get(s->loads->hold + a), none = wide_of(0);
        for (int k = 0; k < order; k++) {
            const double *front = slip, *back = slip + k * COUPLES_ARMS;
            wide even = none, odd = none;
            for (; front + COUPLES_ARMS < back - COUPLES_ARMS;
                 front += 2 * COUPLES_ARMS, back -= 2 * COUPLES_ARMS) {
                even = wide_fma(wide_get(front), wide_get(back), even);
                odd = wide_fma(wide_get(front + COUPLES_ARMS), wide_get(back - COUPLES_ARMS), odd);
            }
            if (front < back) {
                even = wide_fma(wide_get(front), wide_get(back), even);
                front += COUPLES_ARMS, back -= COUPLES_ARMS;
            }
            even = wide_of(2) * (even + odd);
            if (front == back) even = wide_fma(wide_get(front), wide_get(front), even);
            wide *to = &all.order[k][a % COUPLES_ARMS / WIDE];
            *to = wide_fma(size, even, *to);
        }
    }
    couples_total(&all, order, sum);
}

/* adds the power of constant torques */
static void couples_constant(const struct jets_system *s, int order, double *sum) {
    const struct jets_loads *loads = s->loads;
    double square = loads->unit * loads->unit;
    for (int a = 0; a < s->n; a++) {
        size_t row = jets_row(s, a);
        double torque = square * pend_terms_get(loads->terms, loads->value, PEND_TERM_TORQUE, a);
        for (int k = 0; k < order; k++)
            sum[k] += torque * loads->slips[row + (size_t)k * COUPLES_ARMS];
    }
}

static void couples_power(const struct jets_system *s, int order, double *work, double *heat) {
    const struct jets_loads *loads = s->loads;
    if (loads->losses) couples_waste(s, order, heat);
    if (loads->drives) couples_effort(s, order, work);
    if (loads->terms->row[PEND_TERM_TORQUE] >= 0) couples_constant(s, order, work);
    if (loads->moves) loads_pivot_force(s, order, work);
}
