/* The orders of a tree of bodies in tiles of eight arms: an order is a product with a tile's table,
 * and a few numbers go from tile to tile. For one pendulum in doubles.
 * Leaves to others: the tables (tiles_template), the derivation and other kinds of number
 * (bodies_template), what acts on the arms (drives_template).
 * Invariant: an order has one dependency for each tile, not for each arm; Im G follows from the
 * balance of moments, so that no sum over children is formed but that of a port. */
#ifndef PEND_TILES_ORDERS_TEMPLATE_H
#define PEND_TILES_ORDERS_TEMPLATE_H

#include "core/bodies/tiles_template.h"

enum { TILES_STRIDE = 8 };

/* what is known of an order of WIDE arms: T, and the parts of Im (conj u G) with Re u and Im u */
struct tiles_sums {
    wide Tr, Ti, known, less;
};

/* adds the products of a turn with a rate and with G */
VEC_INLINE void tiles_meet(wide ur, wide ui, wide w, wide x, wide y, struct tiles_sums *sum) {
    sum->Tr = wide_fma(ur, w, sum->Tr);
    sum->Ti = wide_fma(ui, w, sum->Ti);
    sum->known = wide_fma(ur, y, sum->known);
    sum->less = wide_fma(ui, x, sum->less);
}

/* the sums of order k, which is even and not 0, and those of the order after without the terms that
 * need order k: what is loaded serves both */
VEC_INLINE struct tiles_sums tiles_convolve(const struct bodies_system *s, size_t row, int k,
                                            struct tiles_sums *next_) {
    enum { STRIDE = TILES_STRIDE };
    const double *re = s->turn_re + row + 2 * STRIDE, *im = s->turn_im + row + 2 * STRIDE;
    const double *rate = s->rate + row + (size_t)k * STRIDE;
    const double *push_x = s->push_x + row + (size_t)(k - 1) * STRIDE;
    const double *push_y = s->push_y + row + (size_t)(k - 1) * STRIDE;
    wide w = wide_get(rate), x = wide_get(push_x), y = wide_get(push_y), zero = wide_of(0);
    wide first = wide_get(im - STRIDE), ur, ui;
    struct tiles_sums now = {zero, first * w, zero, first * x}, next = {zero, zero, zero, zero};
    for (int j = 2; j <= k; j++, re += STRIDE, im += STRIDE) {
        ur = wide_get(re), ui = wide_get(im);
        VEC_PIN(ur);
        VEC_PIN(ui);
        tiles_meet(ur, ui, w, x, y, &next);
        rate -= STRIDE, push_x -= STRIDE, push_y -= STRIDE;
        w = wide_get(rate), x = wide_get(push_x), y = wide_get(push_y);
        VEC_PIN(w);
        VEC_PIN(x);
        VEC_PIN(y);
        tiles_meet(ur, ui, w, x, y, &now);
    }
    ur = wide_get(re), ui = wide_get(im);
    tiles_meet(ur, ui, w, x, y, &next);
    w = wide_get(rate - STRIDE);
    now.Tr = wide_fma(ur, w, now.Tr);
    now.Ti = wide_fma(ui, w, now.Ti);
    *next_ = next;
    return now;
}

/* the sums of order k, the second of two, with the terms that were missing */
VEC_INLINE struct tiles_sums tiles_complete(const struct bodies_system *s, int a, size_t row,
                                            int k) {
    size_t now = row + (size_t)k * TILES_STRIDE;
    wide first = wide_get(s->turn_im + row + TILES_STRIDE), w = wide_get(s->rate + row);
    struct tiles_sums sum = {wide_get(s->next_x + a), wide_get(s->next_y + a),
                             wide_get(s->next_known + a), wide_of(0)};
    sum.Tr = wide_fma(wide_get(s->turn_re + now + TILES_STRIDE), w, sum.Tr);
    sum.Ti = wide_fma(wide_get(s->turn_im + now + TILES_STRIDE), w, sum.Ti);
    sum.Ti = wide_fma(first, wide_get(s->rate + now), sum.Ti);
    sum.less = first * wide_get(s->push_x + now - TILES_STRIDE);
    return sum;
}

/* the inputs of the arms from arm a on, lanes from h on, order k: mu and kr, and the air's forces
 */
VEC_INLINE void tiles_inputs(const struct bodies_system *s, double *to, int a, int k, num gamma) {
    size_t row = bodies_row(s, a), now = row + (size_t)k * TILES_STRIDE, next = now + TILES_STRIDE;
    struct tiles_sums sum, after;
    if (k % 2) {
        sum = tiles_complete(s, a, row, k);
    } else {
        sum = tiles_convolve(s, row, k, &after);
        wide_put(s->next_x + a, after.Tr);
        wide_put(s->next_y + a, after.Ti);
        wide_put(s->next_known + a, after.known - after.less);
    }
    wide more = wide_of(k + 1), spun = more * sum.Tr, turned = spun, pulled = -sum.Ti;
    if (s->need & BODIES_MIST) {
        wide twice = wide_of(2 * gamma);
        spun = wide_fma(twice, wide_get(s->wind_x + a), spun);
        turned = wide_fma(twice, wide_get(s->rate + now), spun);
        pulled = wide_fma(twice, wide_get(s->turn_re + next), pulled);
    }
    pulled *= more;
    wide mu = wide_fma(wide_get(s->spread + a), spun, sum.less - sum.known);
    if (s->need & BODIES_JOINTS) mu += wide_get(s->couple + a);
    wide_put(s->wind_x + a, sum.Tr);
    wide_put(s->wind_y + a, sum.Ti);
    wide_put(s->turned + a, turned);
    wide_put(s->pulled + a, pulled);
    wide_put(to, mu);
    wide_put(to + TILE_ARMS, pulled);
}

/* the product of the tile's columns with its inputs: three rows of eight numbers */
VEC_INLINE void tiles_product(const double *columns, const double *input, int count, double *to) {
    enum { ROWS = 3, STRIDE = ROWS * TILE_ARMS };
    wide sum[ROWS][VEC8_PARTS], other[ROWS][VEC8_PARTS];
    assert(count >= 1 && count <= TILE_ARMS);
    for (int r = 0; r < ROWS; r++)
        for (int p = 0; p < VEC8_PARTS; p++) sum[r][p] = other[r][p] = wide_of(0);
    for (int i = 0; i < count; i++, columns += STRIDE) {
        const double *beside = columns + TILE_ARMS * STRIDE;
        wide one = wide_of(input[i]), second = wide_of(input[TILE_ARMS + i]);
        for (int r = 0; r < ROWS; r++)
            for (int p = 0; p < VEC8_PARTS; p++) {
                int at = r * TILE_ARMS + p * WIDE;
                sum[r][p] = wide_fma(one, wide_get(columns + at), sum[r][p]);
                other[r][p] = wide_fma(second, wide_get(beside + at), other[r][p]);
            }
    }
    for (int r = 0; r < ROWS; r++)
        for (int p = 0; p < VEC8_PARTS; p++)
            wide_put(to + r * TILE_ARMS + p * WIDE, sum[r][p] + other[r][p]);
}

/* what the kids ask goes to the roots' forces and to the kids' outputs */
VEC_INLINE void tiles_join(const struct bodies_system *s, const struct tiles *t,
                           const struct tile *tile, double *outputs) {
    int asks = TILE_OUT * tile->kids;
    const double *mutual = tiles_mutual(t, tile);
    assert(TILE_OUT * tile->roots + asks <= TILE_ARMS);
    for (int r = 0; r < tile->roots; r++) {
        int a = t->root[tile->root + r];
        s->asked_x[a] = outputs[TILE_OUT * r], s->asked_y[a] = outputs[TILE_OUT * r + 1];
    }
    outputs += TILE_OUT * tile->roots;
    for (int j = 0; j < tile->kids; j++) {
        const double *gain = tiles_gain(t, tile, j);
        int c = t->kid[tile->kid + j], a = t->kid_root[tile->kid + j];
        double x = s->asked_x[c], y = s->asked_y[c];
        s->asked_x[a] = num_fma(gain[0], x, num_fma(gain[2], y, s->asked_x[a]));
        s->asked_y[a] = num_fma(gain[1], x, num_fma(gain[3], y, s->asked_y[a]));
        for (int k = 0; k < asks; k++, mutual++)
            outputs[k] = num_fma(mutual[0], x, num_fma(mutual[asks], y, outputs[k]));
        mutual += asks;
    }
}

/* from the last tile to the first */
VEC_INLINE void tiles_up(const struct bodies_system *s, int k, num gamma) {
    const struct tiles *t = s->tiles;
    assert(k >= 1);
    for (int i = t->count - 1; i >= 0; i--) {
        const struct tile *tile = &t->tile[i];
        double *input = t->numbers + tile->state, *answers = input + TILE_INPUTS * TILE_ARMS;
        for (int h = 0; h < TILE_ARMS; h += WIDE)
            tiles_inputs(s, input + h, tile->first + h, k, gamma);
        tiles_product(t->numbers + tile->columns, input, tile->arms, answers);
        tiles_join(s, t, tile, answers + TILE_ANSWERS);
    }
}

/* what the outputs make of the answers of the arms from h on */
struct tiles_answers {
    wide chi, push;
};

VEC_INLINE void tiles_sway(struct tiles_answers *answers, const double *sway, double x, double y) {
    const double *across = sway + TILE_ANSWERS;
    answers->chi = wide_fma(wide_of(x), wide_get(sway), answers->chi);
    answers->push = wide_fma(wide_of(x), wide_get(sway + TILE_ARMS), answers->push);
    answers->chi = wide_fma(wide_of(y), wide_get(across), answers->chi);
    answers->push = wide_fma(wide_of(y), wide_get(across + TILE_ARMS), answers->push);
}

VEC_INLINE struct tiles_answers tiles_answer(const struct bodies_system *s, const struct tile *tile,
                                             const double *to, int h) {
    const struct tiles *t = s->tiles;
    const double *sway = t->numbers + tile->sway + h;
    struct tiles_answers answers = {wide_get(to + h), wide_get(to + TILE_ARMS + h)};
    struct tiles_answers other = {wide_of(0), wide_of(0)};
    for (int r = 0; r < tile->roots; r++, sway += TILE_OUT * TILE_ANSWERS) {
        int a = t->root[tile->root + r];
        tiles_sway(&answers, sway, s->base_x[a], s->base_y[a]);
    }
    for (int j = 0; j < tile->kids; j++, sway += TILE_OUT * TILE_ANSWERS) {
        int c = t->kid[tile->kid + j];
        tiles_sway(&other, sway, s->asked_x[c], s->asked_y[c]);
    }
    return (struct tiles_answers){answers.chi + other.chi, answers.push + other.push};
}

/* the coefficients of order k of G, and of order k + 1 of rates and turns, of arms from arm a on,
 * whose inputs are at `input` */
VEC_INLINE void tiles_close(const struct bodies_system *s, int a, int k, const double *input,
                            struct tiles_answers answers) {
    size_t now = bodies_row(s, a) + (size_t)k * TILES_STRIDE, next = now + TILES_STRIDE;
    wide share = wide_of(s->share[k]), turn_share = wide_of(s->share[k + 1]);
    wide chi = answers.chi, Tr = wide_get(s->wind_x + a);
    wide rate = (chi - wide_get(s->turned + a)) * share;
    wide_put(s->rate + next, rate);
    wide_put(s->turn_re + next + TILES_STRIDE, -(wide_get(s->wind_y + a) * turn_share));
    wide_put(s->turn_im + next + TILES_STRIDE, (rate + Tr) * turn_share);
    wide_put(s->push_x + now, answers.push);
    wide_put(s->push_y + now, wide_get(input) - wide_get(s->spread + a) * chi);
}

/* from the first tile to the last */
VEC_INLINE void tiles_down(const struct bodies_system *s, int k) {
    const struct tiles *t = s->tiles;
    double lift_x = s->lift_x[k], lift_y = s->lift_y[k], cosine = s->cosine[0], sine = s->sine[0];
    s->base_x[0] = num_fma(cosine, lift_x, num_mul(sine, lift_y));
    s->base_y[0] = num_sub(num_mul(cosine, lift_y), num_mul(sine, lift_x));
    for (const struct tile *tile = t->tile; tile < t->tile + t->count; tile++) {
        double *input = t->numbers + tile->state, *answers = input + TILE_INPUTS * TILE_ARMS;
        const double *outputs = answers + TILE_ANSWERS + TILE_OUT * tile->roots;
        for (int j = 0; j < tile->kids; j++, outputs += TILE_OUT) {
            const double *gain = tiles_gain(t, tile, j);
            int c = t->kid[tile->kid + j], a = t->kid_root[tile->kid + j];
            num x = s->base_x[a], y = s->base_y[a];
            s->base_x[c] = num_fma(gain[0], x, num_fma(gain[1], y, outputs[0]));
            s->base_y[c] = num_fma(gain[2], x, num_fma(gain[3], y, outputs[1]));
        }
        for (int h = 0; h < TILE_ARMS; h += WIDE)
            tiles_close(s, tile->first + h, k, input + h, tiles_answer(s, tile, answers, h));
    }
    // the force of the first joint is what the pivot exerts
    num x = s->base_x[0], y = s->base_y[0];
    s->reach_x[0] = num_fma(s->form_xx[0], x, num_fma(s->form_xy[0], y, s->asked_x[0]));
    s->reach_y[0] = num_fma(s->form_xy[0], x, num_fma(s->form_yy[0], y, s->asked_y[0]));
    bodies_haul_first(s, k);
}

/* all orders: as bodies_orders, but that of the forces at the tips only order 0 is there */
static void tiles_orders(const struct bodies_system *s, const struct bodies_moment *now,
                         int order) {
    num gamma = num_mul(bodies_one(s, PEND_TERM_DRAG_PER_MASS), now->unit);
    assert(s->tiles && s->n > TILE_ARMS && s->stride == TILES_STRIDE);
    bodies_begin(s, now, order);
    tiles_prepare(s);
    bodies_load(s, now, 0);
    bodies_convolve(s, 0, gamma);
    bodies_up(s);
    bodies_down(s, 0);
    bodies_close(s, 0);
    for (int k = 1; k < order; k++) {
        bodies_load(s, now, k);
        tiles_up(s, k, gamma);
        tiles_down(s, k);
    }
    for (int a = 0; a < s->n; a += WIDE)
        wide_put(s->force + bodies_row(s, a), wide_get(s->tip_x + bodies_row(s, a)));
}

/* ---- behind the orders */

/* what is known of order k of the arms from arm a on, from the series */
VEC_INLINE void tiles_recall(const struct bodies_system *s, int a, int k, num gamma) {
    size_t row = bodies_row(s, a) + (size_t)k * TILES_STRIDE, turn = row + 2 * TILES_STRIDE;
    wide way = wide_of((k + 1) * (k + 2)), mist = wide_of(2 * (k + 1) * gamma);
    wide kr = way * wide_get(s->turn_re + turn), chi = way * wide_get(s->turn_im + turn);
    if (s->need & BODIES_MIST) {
        kr = wide_fma(mist, wide_get(s->turn_re + turn - TILES_STRIDE), kr);
        chi = wide_fma(mist, wide_get(s->turn_im + turn - TILES_STRIDE), chi);
    }
    wide mu = wide_fma(wide_get(s->spread + a), chi, wide_get(s->push_y + row));
    wide x = wide_fma(wide_get(s->lever_x + a), mu, wide_get(s->draw_x + a) * kr);
    wide y = wide_fma(wide_get(s->lever_y + a), mu, wide_get(s->draw_y + a) * kr);
    wide_put(s->pulled + a, kr);
    wide_put(s->asked_x + a, x);
    wide_put(s->asked_y + a, y);
    wide_put(s->answer + a, mu);
}

/** The forces at the tips, orders 1 .. order - 1, which the orders leave out. O(n order). */
static void tiles_tips(const struct bodies_system *s, num unit, int order) {
    num gamma = num_mul(bodies_one(s, PEND_TERM_DRAG_PER_MASS), unit);
    for (int k = 1; k < order; k++) {
        for (int a = 0; a < s->n; a += WIDE) tiles_recall(s, a, k, gamma);
        bodies_up(s);
        bodies_down(s, k);
        for (int a = 0; a < s->n; a += WIDE)
            bodies_tip(s, bodies_row(s, a) + (size_t)k * TILES_STRIDE, a);
        for (int a = 1; a < s->n && s->need & BODIES_SHAPE; a++) bodies_tip_child(s, a, k);
    }
}

#endif
