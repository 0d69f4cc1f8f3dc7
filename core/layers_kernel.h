/* The orders of one bushy tree, layer by layer: no arm of a layer waits for another of it.
 * Leaves to others: the factorization (jets_kernel), the cutting (layers).
 * Invariant: one pass a sweep, which reads a block's numbers once; nothing is subtracted that jets_kernel does not. */
#ifndef PEND_LAYERS_KERNEL_H
#define PEND_LAYERS_KERNEL_H

#include "core/jets_factor.h"
#include "core/lanes.h"
#include "core/layers.h"

#if defined(__AVX512F__)
#define LAYER_PIN LANES_PIN
#else
#define LAYER_PIN(x) ((void)0)
#endif

LANES_INLINE double *layers_at(const struct layers *l, int block) { return l->numbers + (size_t)block * LAYER_NUMBERS; }

LANES_INLINE lanes8 layer_get(const double *at, int row) { return lanes8_get(at + row * LAYER_ARMS); }

LANES_INLINE void layer_put(double *at, int row, lanes8 x) { lanes8_put(at + row * LAYER_ARMS, x); }

/* a row's numbers at eight places */
LANES_INLINE lanes8 layer_gather(const struct layers *l, int row, const int places[LAYER_ARMS]) {
#if defined(__AVX512F__) && !defined(NOGATHER)
    __m256i index = _mm256_loadu_si256((const __m256i *)(const void *)places);
    return (lanes8)_mm512_i32gather_pd(index, l->numbers + row * LAYER_ARMS, 8);
#else
    return lanes8_gather(l->numbers + row * LAYER_ARMS, places);
#endif
}

/* a row's numbers at the arms' parents: first children have their parents' lanes */
LANES_INLINE lanes8 layer_parents(const struct layers *l, const struct layer_block *block, int row,
                                  const int places[LAYER_ARMS]) {
#if defined(__AVX512F__) && !defined(NOGATHER)
    int all = (1 << LAYER_ARMS) - 1;
    if (block->light == all) return layer_gather(l, row, places);
    lanes8 near = layer_get(layers_at(l, block->above), row);
    if (!block->light) return near;
    __m256i index = _mm256_loadu_si256((const __m256i *)(const void *)places);
    return (lanes8)_mm512_mask_i32gather_pd((__m512d)near, (__mmask8)block->light, index,
                                            l->numbers + row * LAYER_ARMS, 8);
#else
    if (!block->light) return layer_get(layers_at(l, block->above), row);
    return layer_gather(l, row, places);
#endif
}

/* ---- once a step */

/* answers of the cap's arms to a unit at one of them, on the way up and on the way down */
static void layers_invert(const struct jets_system *s, const struct layers *l) {
    const int *arm = l->arm + (l->count - 1) * LAYER_ARMS;
    lanes8 up[LAYER_ARMS], down[LAYER_ARMS];
    for (int i = 0; i < LAYER_ARMS; i++) {
        int p = i && arm[i] >= 0 ? l->seat[s->parent[arm[i]]] % LAYER_ARMS : -1;
        up[i] = down[i] = lanes8_of(0);
        up[i][i] = down[i][i] = 1;
        if (p >= 0) up[i] = lanes8_fma(lanes8_of(s->kappa[arm[i]]), up[p], up[i]);
    }
    for (int i = LAYER_ARMS - 1; i >= 0; i--) {
        int p = i && arm[i] >= 0 ? l->seat[s->parent[arm[i]]] % LAYER_ARMS : -1;
        if (p >= 0) down[p] = lanes8_fma(lanes8_of(s->kappa[arm[i]]), down[i], down[p]);
    }
    for (int i = 0; i < LAYER_ARMS; i++) {
        layer_put(l->up, i, up[i]);
        layer_put(l->down, i, down[i]);
    }
}

static void layers_prepare(const struct jets_system *s, const struct layers *l) {
    for (int k = 0; k < s->n; k++) {
        double *at = l->numbers + pend_layers_place(l->seat[k]);
        int p = s->parent[k];
        at[LAYER_WEIGHT * LAYER_ARMS] = s->eff[k] * s->len[k];
        at[LAYER_KAPPA * LAYER_ARMS] = s->kappa[k];
        at[LAYER_GRIP * LAYER_ARMS] = p < 0 ? 0 : lanes1_fma(s->lean[p], s->cosine[k], s->sine[k]);
        at[LAYER_COSINE * LAYER_ARMS] = s->cosine[k];
        at[LAYER_SINE * LAYER_ARMS] = s->sine[k];
        at[LAYER_LEAN * LAYER_ARMS] = s->lean[k];
        at[LAYER_INV * LAYER_ARMS] = s->inv[k];
        at[LAYER_NU * LAYER_ARMS] = s->nu[k];
        at[LAYER_TAU * LAYER_ARMS] = s->tau[k];
        at[LAYER_INV_EFF * LAYER_ARMS] = s->inv_eff[k];
        at[LAYER_PART * LAYER_ARMS] = s->inv_len[k];
        at[LAYER_STIFF * LAYER_ARMS] = s->eff[k] * s->kappa[k];
    }
    layers_invert(s, l);
}

/* ---- once an order, from the leaves to the root */

struct layer_known {
    lanes8 Tr, Ti, cr, ci;
};

/*
 * T and c of order k, and of order k + 1 but for the terms that order k is needed for, in one pass: what is loaded
 * serves both. Row -1 of the forces is zero.
 */
LANES_INLINE struct layer_known layer_known(const struct jets_system *s, double *at, size_t row, int k) {
    enum { STRIDE = LAYER_ARMS };
    const double *re = s->turn_re + row + 2 * STRIDE, *im = s->turn_im + row + 2 * STRIDE;
    const double *rate = s->rate + row + (size_t)k * STRIDE, *force = s->force + row + (size_t)k * STRIDE - STRIDE;
    lanes8 w = lanes8_get(rate), f = lanes8_get(force), first = lanes8_get(s->rate + row), zero = lanes8_of(0);
    // u_1 is imaginary
    struct layer_known now = {zero, first * w, zero, first * f}, next = {zero, zero, zero, zero};
    for (int j = 2; j <= k + 1; j++, re += STRIDE, im += STRIDE) {
        lanes8 ur = lanes8_get(re), ui = lanes8_get(im);
        LAYER_PIN(ur);
        LAYER_PIN(ui);
        next.Tr = lanes8_fma(ur, w, next.Tr);
        next.Ti = lanes8_fma(ui, w, next.Ti);
        next.cr = lanes8_fma(ur, f, next.cr);
        next.ci = lanes8_fma(ui, f, next.ci);
        rate -= STRIDE, force -= STRIDE;
        w = lanes8_get(rate), f = lanes8_get(force);
        LAYER_PIN(w);
        LAYER_PIN(f);
        now.Tr = lanes8_fma(ur, w, now.Tr);
        now.Ti = lanes8_fma(ui, w, now.Ti);
        now.cr = lanes8_fma(ur, f, now.cr);
        now.ci = lanes8_fma(ui, f, now.ci);
    }
    layer_put(at, LAYER_NEXT_TR, next.Tr);
    layer_put(at, LAYER_NEXT_TI, next.Ti);
    layer_put(at, LAYER_NEXT_CR, next.cr);
    layer_put(at, LAYER_NEXT_CI, next.ci);
    return now;
}

/* T and c of order k, the second of two: the terms that were missing */
LANES_INLINE struct layer_known layer_complete(const struct jets_system *s, const double *at, size_t row, int k) {
    enum { STRIDE = LAYER_ARMS };
    size_t now = row + (size_t)k * STRIDE;
    lanes8 first = lanes8_get(s->rate + row);
    struct layer_known known = {layer_get(at, LAYER_NEXT_TR), layer_get(at, LAYER_NEXT_TI),
                                layer_get(at, LAYER_NEXT_CR), layer_get(at, LAYER_NEXT_CI)};
    known.Tr = lanes8_fma(lanes8_get(s->turn_re + now + STRIDE), first, known.Tr);
    known.Ti = lanes8_fma(lanes8_get(s->turn_im + now + STRIDE), first, known.Ti);
    known.Ti = lanes8_fma(first, lanes8_get(s->rate + now), known.Ti);
    known.ci = lanes8_fma(first, lanes8_get(s->force + now - STRIDE), known.ci);
    return known;
}

/* T and c of order k, put where what they are part of will be; Ti and s go on */
LANES_INLINE struct layer_known layer_begin(const struct jets_system *s, double *at, size_t row, int k) {
    struct layer_known known = k % 2 ? layer_complete(s, at, row, k) : layer_known(s, at, row, k);
    double *force = s->force + row + (size_t)k * LAYER_ARMS, *rate = s->rate + row + (size_t)(k + 1) * LAYER_ARMS;
    lanes8_put(force, known.cr);
    lanes8_put(rate, known.Tr);
    lanes8_put(s->turn_re + row + (size_t)(k + 2) * LAYER_ARMS, -known.Ti * lanes8_of(s->share[k + 1]));
    known.ci *= lanes8_of(s->share[k]);
    layer_put(at, LAYER_KNOWN, known.ci);
    return known;
}

/* what is asked of the parent, and what it takes */
LANES_INLINE void layer_ask(double *at, lanes8 known, lanes8 bias) {
    layer_put(at, LAYER_BIAS, bias);
    layer_put(at, LAYER_ASKED, layer_get(at, LAYER_KAPPA) * bias - layer_get(at, LAYER_GRIP) * known);
    layer_put(at, LAYER_GIVEN, lanes8_fma(layer_get(at, LAYER_SINE), bias, layer_get(at, LAYER_COSINE) * known));
}

/* what the children of a block ask for and take, all together */
struct layer_sums {
    lanes8 asked, given;
};

/* sums over the children; what each of them feels across leaves the child itself out: the ranks before, and those after */
LANES_INLINE struct layer_sums layer_children(const struct layers *l, const struct layer_block *block, double *at,
                                              lanes8 known) {
    const double *below = layers_at(l, block->below);
    double *table = layers_at(l, l->count + 1) + (size_t)block->first * LAYER_ARMS;
    struct layer_sums sums = {layer_get(below, LAYER_ASKED), layer_get(below, LAYER_GIVEN)};
    lanes8 given[LAYERS_CHILDREN], late = lanes8_of(0);
    int ranks = block->end - block->first;
    for (int i = 0; i < ranks; i++) {
        const int *children = l->rank[block->first + i].children;
        layer_put(table, i, sums.given);
        sums.asked += layer_gather(l, LAYER_ASKED, children);
        given[i] = layer_gather(l, LAYER_GIVEN, children);
        sums.given += given[i];
    }
    for (int i = ranks - 1; i >= 0; i--) {
        layer_put(table, i, known - (layer_get(table, i) + late));
        late += given[i];
    }
    layer_put(at, LAYER_FIRST, known - late);
    return sums;
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

/* the cap, whose arms hang on each other */
static void layers_up_cap(const struct jets_system *s, const struct layers *l, int k) {
    int i = l->count - 1;
    double *at = layers_at(l, i);
    const struct layer_block *block = &l->block[i];
    double *table = layers_at(l, l->count + 1) + (size_t)block->first * LAYER_ARMS;
    struct layer_known known = layer_begin(s, at, (size_t)i * s->tile, k);
    layer_ask(at, known.ci, lanes8_of(0));
    lanes8 pull = layer_get(at, LAYER_LEAN) * known.ci, heave = layer_get(at, LAYER_WEIGHT) * known.Ti;
    int ranks = block->end - block->first;
    for (int j = 0; j < ranks; j++) pull += layer_gather(l, LAYER_ASKED, l->rank[block->first + j].children);
    lanes8 bias = layer_product(l->up, pull - heave);
    layer_put(at, LAYER_PUSH, bias + heave);
    layer_ask(at, known.ci, bias);
    lanes8 given[LAYERS_CHILDREN], sum = lanes8_of(0), late = sum;
    for (int j = 0; j < ranks; j++) {
        given[j] = layer_gather(l, LAYER_GIVEN, l->rank[block->first + j].children);
        layer_put(table, j, sum);
        sum += given[j];
    }
    for (int j = ranks - 1; j >= 0; j--) {
        layer_put(table, j, known.ci - (layer_get(table, j) + late));
        late += given[j];
    }
    layer_put(at, LAYER_TANGENTIAL, layer_get(at, LAYER_INV) * (known.ci - sum));
}

static void layers_up(const struct jets_system *s, const struct layers *l, int k) {
    int i = 0;
    for (; i < l->count && l->block[i].leaves; i++) {
        double *at = layers_at(l, i);
        struct layer_known known = layer_begin(s, at, (size_t)i * s->tile, k);
        layer_ask(at, known.ci, -(layer_get(at, LAYER_WEIGHT) * known.Ti));
    }
    for (; i < l->count - 1; i++) {
        double *at = layers_at(l, i);
        struct layer_known known = layer_begin(s, at, (size_t)i * s->tile, k);
        struct layer_sums sums = layer_children(l, &l->block[i], at, known.ci);
        lanes8 push = lanes8_fma(layer_get(at, LAYER_LEAN), known.ci, sums.asked);
        layer_put(at, LAYER_PUSH, push);
        layer_put(at, LAYER_TANGENTIAL, layer_get(at, LAYER_INV) * (known.ci - sums.given));
        layer_ask(at, known.ci, push - layer_get(at, LAYER_WEIGHT) * known.Ti);
    }
    layers_up_cap(s, l, k);
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
LANES_INLINE void layer_learn(const struct jets_system *s, const double *at, size_t row, int k,
                              const struct layer_felt *felt, lanes8 tension, lanes8 tangential) {
    size_t now = row + (size_t)k * LAYER_ARMS, next = now + LAYER_ARMS, after = next + LAYER_ARMS;
    lanes8 gap = lanes8_fma(layer_get(at, LAYER_SINE), felt->radial, tangential);
    lanes8 turned = (gap - layer_get(at, LAYER_COSINE) * felt->tangential) * layer_get(at, LAYER_PART);
    lanes8 mu = lanes8_fma(layer_get(at, LAYER_STIFF), felt->radial, tension);
    lanes8_put(s->rate + next, turned - lanes8_get(s->rate + next));
    lanes8_put(s->force + now, mu * lanes8_of(k + 1) - lanes8_get(s->force + now));
    lanes8_put(s->turn_im + after, turned * lanes8_of(s->share[k + 1]));
}

/* the root hangs on the pivot, which has i gravity; it is alone in its block */
LANES_INLINE lanes8 layers_lift(const struct jets_system *s, const struct layers *l, double gravity) {
    layers_at(l, l->count)[LAYER_TANGENTIAL * LAYER_ARMS] = gravity;
    return (lanes8){s->sine[0] * gravity};
}

static void layers_down_cap(const struct jets_system *s, const struct layers *l, double gravity, int k) {
    lanes8 lift = layers_lift(s, l, gravity);
    int i = l->count - 1;
    double *at = layers_at(l, i);
    const struct layer_block *block = &l->block[i];
    lanes8 tension = layer_tension(at, layer_gather(l, LAYER_FIRST, block->shares));
    lanes8 shift = (tension - layer_get(at, LAYER_PUSH)) * layer_get(at, LAYER_INV_EFF) + lift;
    tension += lift * lanes8_of(s->eff[0]);
    lanes8 radial = layer_product(l->down, shift);
    lanes8 tangential = layer_get(at, LAYER_TANGENTIAL) - layer_get(at, LAYER_LEAN) * radial;
    layer_put(at, LAYER_RADIAL, radial);
    layer_put(at, LAYER_TANGENTIAL, tangential);
    struct layer_felt felt = {radial, layer_gather(l, LAYER_RADIAL, block->parents),
                              layer_gather(l, LAYER_TANGENTIAL, block->parents)};
    layer_learn(s, at, (size_t)i * s->tile, k, &felt, tension, tangential);
}

static void layers_down(const struct jets_system *s, const struct layers *l, double gravity, int k) {
    layers_down_cap(s, l, gravity, k);
    int i = l->count - 2;
    for (; i >= 0 && !l->block[i].leaves; i--) {
        double *at = layers_at(l, i);
        struct layer_felt felt = layer_feel(l, &l->block[i]);
        lanes8 tension = layer_tension(at, felt.across);
        lanes8 shift = (tension - layer_get(at, LAYER_PUSH)) * layer_get(at, LAYER_INV_EFF);
        lanes8 radial = lanes8_fma(layer_get(at, LAYER_KAPPA), felt.radial, shift);
        lanes8 tangential = layer_get(at, LAYER_TANGENTIAL) - layer_get(at, LAYER_LEAN) * radial;
        layer_put(at, LAYER_RADIAL, radial);
        layer_put(at, LAYER_TANGENTIAL, tangential);
        layer_learn(s, at, (size_t)i * s->tile, k, &felt, tension, tangential);
    }
    for (; i >= 0; i--) {
        const double *at = layers_at(l, i);
        struct layer_felt felt = layer_feel(l, &l->block[i]);
        lanes8 tension = layer_tension(at, felt.across);
        lanes8 tangential = layer_get(at, LAYER_INV) * layer_get(at, LAYER_KNOWN);
        layer_learn(s, at, (size_t)i * s->tile, k, &felt, tension, tangential);
    }
}

/* all orders: rate_1 .. rate_order and force_0 .. force_{order - 1} from rate_0 and the factorization */
static void layers_orders(const struct jets_system *s, double gravity, int order) {
    const struct layers *l = s->layers;
    jets_factor(s);
    layers_prepare(s, l);
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
