/* The orders of one bushy tree, layer by layer: no arm of a layer waits for another of it.
 * Leaves to others: the factorization (layers_factor), the cutting (layers).
 * Invariant: one pass a sweep, which reads a block's numbers once; nothing is subtracted that jets_kernel does not. */
#ifndef PEND_LEVELS_TEMPLATE_H
#define PEND_LEVELS_TEMPLATE_H

#include "core/taylor/convolve_template.h"
#include "core/taylor/levels_factor.h"

/* ---- once an order, from the leaves to the root */

/* where the series of order k of a block's arms from lane h on will be, which until then hold T and c, or what is known
 * of them */
struct layer_rows {
    double *rate, *turn_re, *turn_im, *force;
};

LANES_INLINE struct layer_rows layer_rows(const struct jets_system *s, int block, int h, int k) {
    size_t row = (size_t)block * s->tile + (size_t)k * LAYER_ARMS + (size_t)h;
    return (struct layer_rows){s->rate + row + LAYER_ARMS, s->turn_re + row + (size_t)2 * LAYER_ARMS,
                               s->turn_im + row + (size_t)2 * LAYER_ARMS, s->force + row};
}

/* T and c of order k; what is known of order k + 1 waits where that order will be */
LANES_INLINE struct convolved layer_known(const struct jets_system *s, int block, int h, int k) {
    struct layer_rows last = layer_rows(s, block, h, k), after = layer_rows(s, block, h, k + 1);
    struct convolved next, now = convolve(s, (size_t)block * s->tile + (size_t)h, k, &next);
    wide_put(after.rate, next.Tr);
    wide_put(after.turn_re, next.Ti);
    wide_put(after.force, next.cr);
    wide_put(after.turn_im, next.ci);
    wide_put(last.force, now.cr);
    return now;
}

/* the same of the second of two orders, but for Re c, which is where it will be needed */
LANES_INLINE struct convolved layer_complete(const struct jets_system *s, int block, int h, int k) {
    struct layer_rows now = layer_rows(s, block, h, k);
    struct convolved known = {wide_get(now.rate), wide_get(now.turn_re), wide_of(0), wide_get(now.turn_im)};
    return convolve_rest(s, (size_t)block * s->tile + (size_t)h, k, known);
}

/* T and c of order k, put where what they are part of will be; Ti and s go on */
LANES_INLINE struct convolved layer_begin(const struct jets_system *s, const struct layers *l, int block, int h,
                                          int k) {
    struct convolved known = k % 2 ? layer_complete(s, block, h, k) : layer_known(s, block, h, k);
    struct layer_rows now = layer_rows(s, block, h, k);
    wide_put(now.rate, known.Tr);
    wide_put(now.turn_re, -known.Ti * wide_of(s->share[k + 1]));
    known.ci *= wide_of(s->share[k]);
    layer_put(layers_at(l, block) + h, LAYER_KNOWN, known.ci);
    return known;
}

/* what is asked of the parent, and what it takes */
LANES_INLINE void layer_ask(double *at, wide known, wide bias) {
    layer_put(at, LAYER_BIAS, bias);
    layer_put(at, LAYER_ASKED, layer_get(at, LAYER_KAPPA) * bias - layer_get(at, LAYER_GRIP) * known);
    layer_put(at, LAYER_GIVEN, wide_fma(layer_get(at, LAYER_SINE), bias, layer_get(at, LAYER_COSINE) * known));
}

/* what children ask for, and what they take */
struct layer_sums {
    wide asked, given;
};

/*
 * What all children of a block's joints ask for and take, from what the first do. What each of them feels across leaves
 * the child itself out: it is the joint's known force less what the children before take, and those after.
 */
LANES_INLINE struct layer_sums layer_children(const struct layers *l, int which, int h, wide known,
                                              struct layer_sums sums) {
    const struct layer_block *block = &l->block[which];
    double *at = layers_at(l, which) + h;
    double *table = l->numbers + pend_layers_table(l->count) + block->first * LAYER_TABLE + h;
    wide given[LAYERS_CHILDREN], late = wide_of(0);
    int ranks = block->end - block->first;
    for (int i = 0; i < ranks; i++) {
        const int *children = l->rank[block->first + i].children + h;
        given[i] = layer_gather(l, LAYER_GIVEN, children);
        sums.asked += layer_gather(l, LAYER_ASKED, children);
        wide_put(table + i * LAYER_TABLE, sums.given);
        sums.given += given[i];
    }
    for (int i = ranks - 1; i >= 0; i--) {
        wide_put(table + i * LAYER_TABLE, known - (wide_get(table + i * LAYER_TABLE) + late));
        late += given[i];
    }
    layer_put(at, LAYER_FIRST, known - late);
    return sums;
}

/* leaves have nothing to add up */
LANES_INLINE void layer_up_leaves(const struct jets_system *s, const struct layers *l, int i, int h, int k) {
    double *at = layers_at(l, i) + h;
    struct convolved known = layer_begin(s, l, i, h, k);
    layer_ask(at, known.ci, -(layer_get(at, LAYER_WEIGHT) * known.Ti));
}

LANES_INLINE void layer_up(const struct jets_system *s, const struct layers *l, int i, int h, int k) {
    const double *below = layers_at(l, l->block[i].below) + h;
    double *at = layers_at(l, i) + h;
    struct convolved known = layer_begin(s, l, i, h, k);
    struct layer_sums sums = {layer_get(below, LAYER_ASKED), layer_get(below, LAYER_GIVEN)};
    sums = layer_children(l, i, h, known.ci, sums);
    wide push = wide_fma(layer_get(at, LAYER_LEAN), known.ci, sums.asked);
    layer_put(at, LAYER_PUSH, push);
    layer_ask(at, known.ci, push - layer_get(at, LAYER_WEIGHT) * known.Ti);
    layer_put(at, LAYER_TANGENTIAL, layer_get(at, LAYER_INV) * (known.ci - sums.given));
}

/* the cap's arms hang on each other: they ask first without what they are to find out, and again when they know it */
LANES_INLINE void layer_up_cap(const struct jets_system *s, const struct layers *l, int i, int k) {
    const struct layer_block *block = &l->block[i];
    struct eight known, heave, pull;
    for (int p = 0; p < EIGHT_PARTS; p++) {
        double *at = layers_at(l, i) + p * WIDE;
        struct convolved x = layer_begin(s, l, i, p * WIDE, k);
        known.part[p] = x.ci;
        heave.part[p] = layer_get(at, LAYER_WEIGHT) * x.Ti;
        layer_ask(at, x.ci, wide_of(0));
    }
    for (int p = 0; p < EIGHT_PARTS; p++) {
        double *at = layers_at(l, i) + p * WIDE;
        pull.part[p] = wide_fma(layer_get(at, LAYER_LEAN), known.part[p], -heave.part[p]);
        for (int j = block->first; j < block->end; j++)
            pull.part[p] += layer_gather(l, LAYER_ASKED, l->rank[j].children + p * WIDE);
    }
    struct eight bias = eight_product(l->up, &pull);
    for (int p = 0; p < EIGHT_PARTS; p++) {
        double *at = layers_at(l, i) + p * WIDE;
        layer_put(at, LAYER_PUSH, bias.part[p] + heave.part[p]);
        layer_ask(at, known.part[p], bias.part[p]);
    }
    for (int p = 0; p < EIGHT_PARTS; p++) {
        double *at = layers_at(l, i) + p * WIDE;
        struct layer_sums sums = {wide_of(0), wide_of(0)};
        sums = layer_children(l, i, p * WIDE, known.part[p], sums);
        layer_put(at, LAYER_TANGENTIAL, layer_get(at, LAYER_INV) * (known.part[p] - sums.given));
    }
}

static void layers_up(const struct jets_system *s, const struct layers *l, int k) {
    int i = 0;
    for (; l->block[i].leaves; i++)
        for (int h = 0; h < LAYER_ARMS; h += WIDE) layer_up_leaves(s, l, i, h, k);
    for (; i < l->count - 1; i++)
        for (int h = 0; h < LAYER_ARMS; h += WIDE) layer_up(s, l, i, h, k);
    layer_up_cap(s, l, i, k);
}

/* ---- once an order, from the root to the leaves */

/* what a block's arms feel from their parents */
struct layer_felt {
    wide across, radial, tangential;
};

LANES_INLINE struct layer_felt layer_feel(const struct layers *l, const struct layer_block *block, int h) {
    return (struct layer_felt){layer_parents(l, block, LAYER_FIRST, block->shares, h),
                               layer_parents(l, block, LAYER_RADIAL, block->parents, h),
                               layer_parents(l, block, LAYER_TANGENTIAL, block->parents, h)};
}

/* the constant part of mu, tension first */
LANES_INLINE wide layer_tension(const double *at, wide share) {
    wide across = share - layer_get(at, LAYER_COSINE) * layer_get(at, LAYER_KNOWN);
    return wide_fma(layer_get(at, LAYER_TAU), across, layer_get(at, LAYER_NU) * layer_get(at, LAYER_BIAS));
}

/* the coefficients of order k and what they make of u */
LANES_INLINE void layer_learn(const struct jets_system *s, const struct layers *l, int block, int h, int k,
                              const struct layer_felt *felt, wide tension, wide tangential) {
    const double *at = layers_at(l, block) + h;
    struct layer_rows now = layer_rows(s, block, h, k);
    wide gap = wide_fma(layer_get(at, LAYER_SINE), felt->radial, tangential);
    wide turned = (gap - layer_get(at, LAYER_COSINE) * felt->tangential) * layer_get(at, LAYER_PART);
    wide mu = wide_fma(layer_get(at, LAYER_STIFF), felt->radial, tension);
    wide_put(now.rate, turned - wide_get(now.rate));
    wide_put(now.force, mu * wide_of(k + 1) - wide_get(now.force));
    wide_put(now.turn_im, turned * wide_of(s->share[k + 1]));
}

/* keeps the acceleration of the tips, and tells the part across */
LANES_INLINE wide layer_tip(double *at, wide radial) {
    wide tangential = layer_get(at, LAYER_TANGENTIAL) - layer_get(at, LAYER_LEAN) * radial;
    layer_put(at, LAYER_RADIAL, radial);
    layer_put(at, LAYER_TANGENTIAL, tangential);
    return tangential;
}

/* the root hangs on the pivot, which has i gravity; it is the cap's first arm */
LANES_INLINE double layers_lift(const struct layers *l, double gravity) {
    layers_at(l, l->count)[LAYER_TANGENTIAL * LAYER_ARMS] = gravity;
    return layers_at(l, l->count - 1)[LAYER_SINE * LAYER_ARMS] * gravity;
}

/* the cap's tips answer to all its shifts at once */
LANES_INLINE void layer_down_cap(const struct jets_system *s, const struct layers *l, double lift, int i, int k) {
    const struct layer_block *block = &l->block[i];
    struct eight tension, shift;
    for (int p = 0; p < EIGHT_PARTS; p++) {
        double *at = layers_at(l, i) + p * WIDE;
        wide root = p ? wide_of(0) : (wide){lift};
        wide here = layer_tension(at, layer_gather(l, LAYER_FIRST, block->shares + p * WIDE));
        shift.part[p] = (here - layer_get(at, LAYER_PUSH)) * layer_get(at, LAYER_INV_EFF) + root;
        tension.part[p] = wide_fma(root, layer_get(at, LAYER_EFF), here);
    }
    struct eight radial = eight_product(l->down, &shift);
    struct eight tangential;
    for (int p = 0; p < EIGHT_PARTS; p++) {
        tangential.part[p] = layer_tip(layers_at(l, i) + p * WIDE, radial.part[p]);
    }
    for (int p = 0; p < EIGHT_PARTS; p++) {
        struct layer_felt felt = layer_feel(l, block, p * WIDE);
        layer_learn(s, l, i, p * WIDE, k, &felt, tension.part[p], tangential.part[p]);
    }
}

LANES_INLINE void layer_down(const struct jets_system *s, const struct layers *l, int i, int h, int k) {
    double *at = layers_at(l, i) + h;
    struct layer_felt felt = layer_feel(l, &l->block[i], h);
    wide tension = layer_tension(at, felt.across);
    wide shift = (tension - layer_get(at, LAYER_PUSH)) * layer_get(at, LAYER_INV_EFF);
    wide radial = wide_fma(layer_get(at, LAYER_KAPPA), felt.radial, shift);
    layer_learn(s, l, i, h, k, &felt, tension, layer_tip(at, radial));
}

/* nobody asks how a leaf's tip moves */
LANES_INLINE void layer_down_leaves(const struct jets_system *s, const struct layers *l, int i, int h, int k) {
    const double *at = layers_at(l, i) + h;
    struct layer_felt felt = layer_feel(l, &l->block[i], h);
    wide tangential = layer_get(at, LAYER_INV) * layer_get(at, LAYER_KNOWN);
    layer_learn(s, l, i, h, k, &felt, layer_tension(at, felt.across), tangential);
}

static void layers_down(const struct jets_system *s, const struct layers *l, double gravity, int k) {
    int i = l->count - 1;
    layer_down_cap(s, l, layers_lift(l, gravity), i--, k);
    for (; !l->block[i].leaves; i--)
        for (int h = 0; h < LAYER_ARMS; h += WIDE) layer_down(s, l, i, h, k);
    for (; i >= 0; i--)
        for (int h = 0; h < LAYER_ARMS; h += WIDE) layer_down_leaves(s, l, i, h, k);
}

/* all orders: rate_1 .. rate_order and force_0 .. force_{order - 1} from rate_0 and the factorization */
static void layers_orders(const struct jets_system *s, double gravity, int order) {
    const struct layers *l = s->layers;
    layers_factor(s, l);
    for (int a = 0; a < jets_seats(s); a += WIDE) {
        size_t row = jets_row(s, a);
        wide_put(s->turn_re + row + LAYER_ARMS, wide_of(0));
        wide_put(s->turn_im + row + LAYER_ARMS, wide_get(s->rate + row));
    }
    for (int k = 0; k < order; k++) {
        layers_up(s, l, k);
        layers_down(s, l, k ? 0 : gravity, k);
    }
}

#endif
