/* The orders of one bushy tree, layer by layer: no arm of a layer waits for another of it.
 * Leaves to others: the factorization (layers_factor), the cutting (layers).
 * Invariant: one pass a sweep, which reads a block's numbers once; nothing is subtracted that jets_kernel does not. */
#ifndef PEND_LAYERS_KERNEL_H
#define PEND_LAYERS_KERNEL_H

#include "core/layers_factor.h"

#if defined(__AVX512F__)
#define LAYER_PIN LANES_PIN
#else
#define LAYER_PIN(x) ((void)0)
#endif

/* ---- once an order, from the leaves to the root */

struct layer_known {
    lanes8 Tr, Ti, cr, ci;
};

/* where a block's series of order k will be, which until then hold T and c, or what is known of them */
struct layer_rows {
    double *rate, *turn_re, *turn_im, *force;
};

LANES_INLINE struct layer_rows layer_rows(const struct jets_system *s, int block, int k) {
    size_t row = (size_t)block * s->tile + (size_t)k * LAYER_ARMS;
    return (struct layer_rows){s->rate + row + LAYER_ARMS, s->turn_re + row + (size_t)2 * LAYER_ARMS,
                               s->turn_im + row + (size_t)2 * LAYER_ARMS, s->force + row};
}

/*
 * T and c of order k, and of order k + 1 but for the terms that order k is needed for, in one pass: what is loaded
 * serves both. Row -1 of the forces is zero.
 */
LANES_INLINE struct layer_known layer_known(const struct jets_system *s, int block, int k) {
    struct layer_rows first = layer_rows(s, block, 0), last = layer_rows(s, block, k),
                      after = layer_rows(s, block, k + 1);
    const double *re = first.turn_re, *im = first.turn_im, *rate = last.rate - LAYER_ARMS,
                 *force = last.force - LAYER_ARMS;
    lanes8 w = lanes8_get(rate), f = lanes8_get(force), turn = lanes8_get(first.rate - LAYER_ARMS), zero = lanes8_of(0);
    // u_1 is imaginary
    struct layer_known now = {zero, turn * w, zero, turn * f}, next = {zero, zero, zero, zero};
    for (int j = 2; j <= k + 1; j++, re += LAYER_ARMS, im += LAYER_ARMS) {
        lanes8 ur = lanes8_get(re), ui = lanes8_get(im);
        LAYER_PIN(ur);
        LAYER_PIN(ui);
        next.Tr = lanes8_fma(ur, w, next.Tr);
        next.Ti = lanes8_fma(ui, w, next.Ti);
        next.cr = lanes8_fma(ur, f, next.cr);
        next.ci = lanes8_fma(ui, f, next.ci);
        rate -= LAYER_ARMS, force -= LAYER_ARMS;
        w = lanes8_get(rate), f = lanes8_get(force);
        LAYER_PIN(w);
        LAYER_PIN(f);
        now.Tr = lanes8_fma(ur, w, now.Tr);
        now.Ti = lanes8_fma(ui, w, now.Ti);
        now.cr = lanes8_fma(ur, f, now.cr);
        now.ci = lanes8_fma(ui, f, now.ci);
    }
    lanes8_put(after.rate, next.Tr);
    lanes8_put(after.turn_re, next.Ti);
    lanes8_put(after.force, next.cr);
    lanes8_put(after.turn_im, next.ci);
    lanes8_put(last.force, now.cr);
    return now;
}

/* T and c of order k, the second of two: the terms that were missing, of which Re c has none */
LANES_INLINE struct layer_known layer_complete(const struct jets_system *s, int block, int k) {
    struct layer_rows first = layer_rows(s, block, 0), last = layer_rows(s, block, k - 1),
                      now = layer_rows(s, block, k);
    lanes8 turn = lanes8_get(first.rate - LAYER_ARMS);
    struct layer_known known = {.ci = lanes8_fma(turn, lanes8_get(last.force), lanes8_get(now.turn_im))};
    known.Tr = lanes8_fma(lanes8_get(last.turn_re), turn, lanes8_get(now.rate));
    known.Ti = lanes8_fma(lanes8_get(last.turn_im), turn, lanes8_get(now.turn_re));
    known.Ti = lanes8_fma(turn, lanes8_get(last.rate), known.Ti);
    return known;
}

/* T and c of order k, put where what they are part of will be; Ti and s go on */
LANES_INLINE struct layer_known layer_begin(const struct jets_system *s, const struct layers *l, int block, int k) {
    struct layer_known known = k % 2 ? layer_complete(s, block, k) : layer_known(s, block, k);
    struct layer_rows now = layer_rows(s, block, k);
    lanes8_put(now.rate, known.Tr);
    lanes8_put(now.turn_re, -known.Ti * lanes8_of(s->share[k + 1]));
    known.ci *= lanes8_of(s->share[k]);
    layer_put(layers_at(l, block), LAYER_KNOWN, known.ci);
    return known;
}

/* what is asked of the parent, and what it takes */
LANES_INLINE void layer_ask(double *at, lanes8 known, lanes8 bias) {
    layer_put(at, LAYER_BIAS, bias);
    layer_put(at, LAYER_ASKED, layer_get(at, LAYER_KAPPA) * bias - layer_get(at, LAYER_GRIP) * known);
    layer_put(at, LAYER_GIVEN, lanes8_fma(layer_get(at, LAYER_SINE), bias, layer_get(at, LAYER_COSINE) * known));
}

/* what children ask for, and what they take */
struct layer_sums {
    lanes8 asked, given;
};

/*
 * What all children of a block's joints ask for and take, from what the first do. What each of them feels across leaves
 * the child itself out: it is the joint's known force less what the children before take, and those after.
 */
LANES_INLINE struct layer_sums layer_children(const struct layers *l, const struct layer_block *block, double *at,
                                              lanes8 known, struct layer_sums sums) {
    double *table = l->numbers + pend_layers_table(l->count) + block->first * LAYER_TABLE;
    lanes8 given[LAYERS_CHILDREN], late = lanes8_of(0);
    int ranks = block->end - block->first;
    for (int i = 0; i < ranks; i++) {
        const int *children = l->rank[block->first + i].children;
        given[i] = layer_gather(l, LAYER_GIVEN, children);
        sums.asked += layer_gather(l, LAYER_ASKED, children);
        lanes8_put(table + i * LAYER_TABLE, sums.given);
        sums.given += given[i];
    }
    for (int i = ranks - 1; i >= 0; i--) {
        lanes8_put(table + i * LAYER_TABLE, known - (lanes8_get(table + i * LAYER_TABLE) + late));
        late += given[i];
    }
    layer_put(at, LAYER_FIRST, known - late);
    return sums;
}

/* leaves have nothing to add up */
LANES_INLINE void layer_up_leaves(const struct jets_system *s, const struct layers *l, int i, int k) {
    double *at = layers_at(l, i);
    struct layer_known known = layer_begin(s, l, i, k);
    layer_ask(at, known.ci, -(layer_get(at, LAYER_WEIGHT) * known.Ti));
}

LANES_INLINE void layer_up(const struct jets_system *s, const struct layers *l, int i, int k) {
    const struct layer_block *block = &l->block[i];
    const double *below = layers_at(l, block->below);
    double *at = layers_at(l, i);
    struct layer_known known = layer_begin(s, l, i, k);
    struct layer_sums sums = {layer_get(below, LAYER_ASKED), layer_get(below, LAYER_GIVEN)};
    sums = layer_children(l, block, at, known.ci, sums);
    lanes8 push = lanes8_fma(layer_get(at, LAYER_LEAN), known.ci, sums.asked);
    layer_put(at, LAYER_PUSH, push);
    layer_ask(at, known.ci, push - layer_get(at, LAYER_WEIGHT) * known.Ti);
    layer_put(at, LAYER_TANGENTIAL, layer_get(at, LAYER_INV) * (known.ci - sums.given));
}

/* the product of eight rows with the eight numbers of a vector */
LANES_INLINE lanes8 layer_product(const double *rows, lanes8 x) {
#define LAYER_TERM(i) layer_get(rows, i), __builtin_shufflevector(x, x, i, i, i, i, i, i, i, i)
    lanes8 part = lanes8_fma(LAYER_TERM(0), lanes8_of(0)), sum = lanes8_fma(LAYER_TERM(1), lanes8_of(0));
    part = lanes8_fma(LAYER_TERM(2), part);
    sum = lanes8_fma(LAYER_TERM(3), sum);
    part = lanes8_fma(LAYER_TERM(4), part);
    sum = lanes8_fma(LAYER_TERM(5), sum);
    part = lanes8_fma(LAYER_TERM(6), part);
    sum = lanes8_fma(LAYER_TERM(7), sum);
#undef LAYER_TERM
    return part + sum;
}

/* the cap's arms hang on each other: they ask first without what they are to find out, and again when they know it */
LANES_INLINE void layer_up_cap(const struct jets_system *s, const struct layers *l, int i, int k) {
    const struct layer_block *block = &l->block[i];
    double *at = layers_at(l, i);
    struct layer_known known = layer_begin(s, l, i, k);
    lanes8 heave = layer_get(at, LAYER_WEIGHT) * known.Ti;
    layer_ask(at, known.ci, lanes8_of(0));
    lanes8 pull = lanes8_fma(layer_get(at, LAYER_LEAN), known.ci, -heave);
    for (int j = block->first; j < block->end; j++) pull += layer_gather(l, LAYER_ASKED, l->rank[j].children);
    lanes8 bias = layer_product(l->up, pull);
    layer_put(at, LAYER_PUSH, bias + heave);
    layer_ask(at, known.ci, bias);
    struct layer_sums sums = layer_children(l, block, at, known.ci, (struct layer_sums){lanes8_of(0), lanes8_of(0)});
    layer_put(at, LAYER_TANGENTIAL, layer_get(at, LAYER_INV) * (known.ci - sums.given));
}

static void layers_up(const struct jets_system *s, const struct layers *l, int k) {
    int i = 0;
    for (; l->block[i].leaves; i++) layer_up_leaves(s, l, i, k);
    for (; i < l->count - 1; i++) layer_up(s, l, i, k);
    layer_up_cap(s, l, i, k);
}

/* ---- once an order, from the root to the leaves */

/* what a block's arms feel from their parents */
struct layer_felt {
    lanes8 across, radial, tangential;
};

LANES_INLINE struct layer_felt layer_feel(const struct layers *l, const struct layer_block *block) {
    return (struct layer_felt){layer_parents(l, block, LAYER_FIRST, block->shares),
                               layer_parents(l, block, LAYER_RADIAL, block->parents),
                               layer_parents(l, block, LAYER_TANGENTIAL, block->parents)};
}

/* the constant part of mu, tension first */
LANES_INLINE lanes8 layer_tension(const double *at, lanes8 share) {
    lanes8 across = share - layer_get(at, LAYER_COSINE) * layer_get(at, LAYER_KNOWN);
    return lanes8_fma(layer_get(at, LAYER_TAU), across, layer_get(at, LAYER_NU) * layer_get(at, LAYER_BIAS));
}

/* the coefficients of order k and what they make of u */
LANES_INLINE void layer_learn(const struct jets_system *s, const struct layers *l, int block, int k,
                              const struct layer_felt *felt, lanes8 tension, lanes8 tangential) {
    const double *at = layers_at(l, block);
    struct layer_rows now = layer_rows(s, block, k);
    lanes8 gap = lanes8_fma(layer_get(at, LAYER_SINE), felt->radial, tangential);
    lanes8 turned = (gap - layer_get(at, LAYER_COSINE) * felt->tangential) * layer_get(at, LAYER_PART);
    lanes8 mu = lanes8_fma(layer_get(at, LAYER_STIFF), felt->radial, tension);
    lanes8_put(now.rate, turned - lanes8_get(now.rate));
    lanes8_put(now.force, mu * lanes8_of(k + 1) - lanes8_get(now.force));
    lanes8_put(now.turn_im, turned * lanes8_of(s->share[k + 1]));
}

/* the root hangs on the pivot, which has i gravity; it is the cap's first arm */
LANES_INLINE lanes8 layers_lift(const struct layers *l, double gravity) {
    layers_at(l, l->count)[LAYER_TANGENTIAL * LAYER_ARMS] = gravity;
    return (lanes8){layers_at(l, l->count - 1)[LAYER_SINE * LAYER_ARMS] * gravity};
}

/* the cap's tips answer to all its shifts at once */
LANES_INLINE void layer_down_cap(const struct jets_system *s, const struct layers *l, lanes8 lift, int i, int k) {
    const struct layer_block *block = &l->block[i];
    double *at = layers_at(l, i);
    lanes8 tension = layer_tension(at, layer_gather(l, LAYER_FIRST, block->shares));
    lanes8 shift = (tension - layer_get(at, LAYER_PUSH)) * layer_get(at, LAYER_INV_EFF) + lift;
    lanes8 radial = layer_product(l->down, shift);
    lanes8 tangential = layer_get(at, LAYER_TANGENTIAL) - layer_get(at, LAYER_LEAN) * radial;
    layer_put(at, LAYER_RADIAL, radial);
    layer_put(at, LAYER_TANGENTIAL, tangential);
    struct layer_felt felt = layer_feel(l, block);
    layer_learn(s, l, i, k, &felt, lanes8_fma(lift, layer_get(at, LAYER_EFF), tension), tangential);
}

LANES_INLINE void layer_down(const struct jets_system *s, const struct layers *l, int i, int k) {
    double *at = layers_at(l, i);
    struct layer_felt felt = layer_feel(l, &l->block[i]);
    lanes8 tension = layer_tension(at, felt.across);
    lanes8 shift = (tension - layer_get(at, LAYER_PUSH)) * layer_get(at, LAYER_INV_EFF);
    lanes8 radial = lanes8_fma(layer_get(at, LAYER_KAPPA), felt.radial, shift);
    lanes8 tangential = layer_get(at, LAYER_TANGENTIAL) - layer_get(at, LAYER_LEAN) * radial;
    layer_put(at, LAYER_RADIAL, radial);
    layer_put(at, LAYER_TANGENTIAL, tangential);
    layer_learn(s, l, i, k, &felt, tension, tangential);
}

/* nobody asks how a leaf's tip moves */
LANES_INLINE void layer_down_leaves(const struct jets_system *s, const struct layers *l, int i, int k) {
    const double *at = layers_at(l, i);
    struct layer_felt felt = layer_feel(l, &l->block[i]);
    lanes8 tangential = layer_get(at, LAYER_INV) * layer_get(at, LAYER_KNOWN);
    layer_learn(s, l, i, k, &felt, layer_tension(at, felt.across), tangential);
}

static void layers_down(const struct jets_system *s, const struct layers *l, double gravity, int k) {
    int i = l->count - 1;
    layer_down_cap(s, l, layers_lift(l, gravity), i--, k);
    for (; !l->block[i].leaves; i--) layer_down(s, l, i, k);
    for (; i >= 0; i--) layer_down_leaves(s, l, i, k);
}

/* all orders: rate_1 .. rate_order and force_0 .. force_{order - 1} from rate_0 and the factorization */
static void layers_orders(const struct jets_system *s, double gravity, int order) {
    const struct layers *l = s->layers;
    layers_factor(s, l);
    for (int i = 0; i < l->count; i++) {
        size_t row = (size_t)i * s->tile;
        lanes8_put(s->turn_re + row + LAYER_ARMS, lanes8_of(0));
        lanes8_put(s->turn_im + row + LAYER_ARMS, lanes8_get(s->rate + row));
    }
    for (int k = 0; k < order; k++) {
        layers_up(s, l, k);
        layers_down(s, l, k ? 0 : gravity, k);
    }
}

#endif
