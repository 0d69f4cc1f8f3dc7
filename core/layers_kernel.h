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
    return lanes8_gather(l->numbers + row * LAYER_ARMS, places);
}

/* a row's numbers at the arms' parents: first children have their parents' lanes */
LANES_INLINE lanes8 layer_parents(const struct layers *l, const struct layer_block *block, int row,
                                  const int places[LAYER_ARMS]) {
    if (block->aligned) return layer_get(layers_at(l, block->above), row);
    return layer_gather(l, row, places);
}

/* ---- once a step */

/* answers of the cap's arms to a unit at one of them, on the way up and on the way down */
static void layers_invert(const struct layers *l) {
    int root = (l->count - 1) * LAYER_ARMS;
    const int *parents = l->block[l->count - 1].parents;
    const double *kappa = layers_at(l, l->count - 1) + LAYER_KAPPA * LAYER_ARMS;
    lanes8 up[LAYER_ARMS], down[LAYER_ARMS];
    for (int i = 0; i < LAYER_ARMS; i++) {
        up[i] = down[i] = lanes8_of(0);
        up[i][i] = down[i][i] = 1;
        int p = parents[i] - pend_layers_place(root);
        if (p < LAYER_ARMS) up[i] = lanes8_fma(lanes8_of(kappa[i]), up[p], up[i]);
    }
    for (int i = LAYER_ARMS - 1; i >= 0; i--) {
        int p = parents[i] - pend_layers_place(root);
        if (p < LAYER_ARMS) down[p] = lanes8_fma(lanes8_of(kappa[i]), down[i], down[p]);
    }
    for (int i = 0; i < LAYER_ARMS; i++) {
        layer_put(l->up, i, up[i]);
        layer_put(l->down, i, down[i]);
    }
}

/* what hangs on each joint of a block: sums over the children met so far */
struct layer_load {
    lanes8 p, r, q, d;
};

/* the child of one rank joins; what the others do to it so far is kept */
LANES_INLINE void layer_join(struct layer_load *load, double *share, lanes8 C, lanes8 Z, lanes8 S) {
    lanes8 SC = S * C, SZ = S * Z;
    lanes8_put(share, load->q);
    lanes8_put(share + LAYER_ARMS, load->r);
    // p Z^2 - 2 r Z C + q C^2 = Z (p Z - r C) + C (q C - r Z)
    lanes8 turned = Z * (load->p * Z - load->r * C) + C * (load->q * C - load->r * Z);
    load->d = lanes8_fma(S, turned, load->d);
    load->p = lanes8_fma(SC, C, load->p);
    load->r = lanes8_fma(SC, Z, load->r);
    load->q = lanes8_fma(SZ, Z, load->q);
}

/* the same from the last child to the first: the others are those before and those after, never all less the child */
LANES_INLINE void layer_part(struct layer_load *late, double *share, lanes8 mass, lanes8 C, lanes8 Z, lanes8 S) {
    lanes8 SZ = S * Z;
    lanes8_put(share, mass + (lanes8_get(share) + late->q));
    lanes8_put(share + LAYER_ARMS, lanes8_get(share + LAYER_ARMS) + late->r);
    late->q = lanes8_fma(SZ, Z, late->q);
    late->r = lanes8_fma(SZ, C, late->r);
}

/* the factors of a block's own arms, from its children's */
LANES_INLINE void layer_factor(const struct layers *l, const struct layer_block *block, double *at) {
    const double *below = layers_at(l, block->below);
    double *table = l->numbers + pend_layers_table(l->count), *own = at + LAYER_FIRST * LAYER_ARMS;
    lanes8 mass = layer_get(at, LAYER_MASS), zero = lanes8_of(0);
    struct layer_load load = {zero, zero, zero, zero}, late = load;
    layer_join(&load, own, layer_get(below, LAYER_COSINE), layer_get(below, LAYER_SINE), layer_get(below, LAYER_EFF));
    for (int i = block->first; i < block->end; i++) {
        const int *children = l->rank[i].children;
        layer_join(&load, table + i * LAYER_TABLE, layer_gather(l, LAYER_COSINE, children),
                   layer_gather(l, LAYER_SINE, children), layer_gather(l, LAYER_EFF, children));
    }
    for (int i = block->end - 1; i >= block->first; i--) {
        const int *children = l->rank[i].children;
        layer_part(&late, table + i * LAYER_TABLE, mass, layer_gather(l, LAYER_COSINE, children),
                   layer_gather(l, LAYER_SINE, children), layer_gather(l, LAYER_EFF, children));
    }
    layer_part(&late, own, mass, zero, zero, zero);
    lanes8 inv = 1 / (mass + load.q);
    lanes8 S = lanes8_fma(mass, mass + (load.p + load.q), load.d) * inv;
    layer_put(at, LAYER_INV, inv);
    layer_put(at, LAYER_LEAN, load.r * inv);
    layer_put(at, LAYER_EFF, S);
    layer_put(at, LAYER_INV_EFF, 1 / S);
    layer_put(at, LAYER_WEIGHT, S * layer_get(at, LAYER_LENGTH));
}

/* the factors of one arm of the cap */
static void layer_factor_one(const struct layers *l, int lane) {
    const struct layer_block *block = &l->block[l->count - 1];
    const struct layer_rank *rank = l->rank + block->first;
    double *at = layers_at(l, l->count - 1) + lane, *row = l->numbers + pend_layers_table(l->count) + block->first * LAYER_TABLE + lane;
    double mass = at[LAYER_MASS * LAYER_ARMS], p = 0, r = 0, q = 0, d = 0, late_q = 0, late_r = 0;
    int pivot = pend_layers_place(l->count * LAYER_ARMS), count = 0;
    for (; count < block->end - block->first && rank[count].children[lane] != pivot; count++) {
        const double *c = l->numbers + rank[count].children[lane];
        double C = c[LAYER_COSINE * LAYER_ARMS], Z = c[LAYER_SINE * LAYER_ARMS], S = c[LAYER_EFF * LAYER_ARMS];
        row[count * LAYER_TABLE] = q;
        row[count * LAYER_TABLE + LAYER_ARMS] = r;
        d = lanes1_fma(S, Z * (p * Z - r * C) + C * (q * C - r * Z), d);
        p = lanes1_fma(S * C, C, p);
        r = lanes1_fma(S * C, Z, r);
        q = lanes1_fma(S * Z, Z, q);
    }
    while (count--) {
        const double *c = l->numbers + rank[count].children[lane];
        double C = c[LAYER_COSINE * LAYER_ARMS], SZ = c[LAYER_EFF * LAYER_ARMS] * c[LAYER_SINE * LAYER_ARMS];
        row[count * LAYER_TABLE] = mass + (row[count * LAYER_TABLE] + late_q);
        row[count * LAYER_TABLE + LAYER_ARMS] += late_r;
        late_q = lanes1_fma(SZ, c[LAYER_SINE * LAYER_ARMS], late_q);
        late_r = lanes1_fma(SZ, C, late_r);
    }
    double inv = 1 / (mass + q), S = lanes1_fma(mass, mass + (p + q), d) * inv;
    at[LAYER_INV * LAYER_ARMS] = inv;
    at[LAYER_LEAN * LAYER_ARMS] = r * inv;
    at[LAYER_EFF * LAYER_ARMS] = S;
    at[LAYER_INV_EFF * LAYER_ARMS] = 1 / S;
    at[LAYER_WEIGHT * LAYER_ARMS] = S * at[LAYER_LENGTH * LAYER_ARMS];
}

/* what a block's arms pass on to their parents */
LANES_INLINE void layer_share(const struct layers *l, const struct layer_block *block, double *at) {
    lanes8 C = layer_get(at, LAYER_COSINE), Z = layer_get(at, LAYER_SINE), S = layer_get(at, LAYER_EFF);
    lanes8 others = layer_parents(l, block, LAYER_FIRST, block->shares);
    lanes8 lean = layer_parents(l, block, LAYER_FIRST_LEAN, block->shares);
    lanes8 inv = layer_parents(l, block, LAYER_INV, block->parents);
    lanes8 kappa = inv * (C * others - Z * lean);
    layer_put(at, LAYER_KAPPA, kappa);
    layer_put(at, LAYER_STIFF, S * kappa);
    layer_put(at, LAYER_NU, inv * others);
    layer_put(at, LAYER_TAU, inv * (S * Z));
    layer_put(at, LAYER_GRIP, lanes8_fma(layer_parents(l, block, LAYER_LEAN, block->parents), C, Z));
}

/* the order-0 tree system, as jets_factor has it */
static void layers_factor(const struct jets_system *s, const struct layers *l) {
    int cap = l->count - 1;
    for (int k = 0; k < s->n; k++) {
        double *at = l->numbers + pend_layers_place(l->seat[k]);
        at[LAYER_COSINE * LAYER_ARMS] = s->cosine[k];
        at[LAYER_SINE * LAYER_ARMS] = s->sine[k];
    }
    for (int i = 0; i < cap; i++) {
        if (!l->block[i].leaves) layer_factor(l, &l->block[i], layers_at(l, i));
    }
    for (int lane = LAYER_ARMS - 1; lane >= 0; lane--) {
        if (l->arm[cap * LAYER_ARMS + lane] >= 0) layer_factor_one(l, lane);
    }
    for (int i = 0; i <= cap; i++) layer_share(l, &l->block[i], layers_at(l, i));
    layers_at(l, cap)[LAYER_NU * LAYER_ARMS] = 1;
    layers_invert(l);
}

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
    struct layer_rows first = layer_rows(s, block, 0), last = layer_rows(s, block, k), after = layer_rows(s, block, k + 1);
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
    struct layer_rows first = layer_rows(s, block, 0), last = layer_rows(s, block, k - 1), now = layer_rows(s, block, k);
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

/* what the children of a block ask for and take, all together */
struct layer_sums {
    lanes8 asked, given;
};

/* sums over the children; what each of them feels across leaves the child itself out: the ranks before, and those after */
LANES_INLINE struct layer_sums layer_children(const struct layers *l, const struct layer_block *block, double *at,
                                              lanes8 known) {
    const double *below = layers_at(l, block->below);
    double *table = l->numbers + pend_layers_table(l->count) + block->first * LAYER_TABLE;
    struct layer_sums sums = {layer_get(below, LAYER_ASKED), layer_get(below, LAYER_GIVEN)};
    lanes8 given[LAYERS_CHILDREN], late = lanes8_of(0);
    int ranks = block->end - block->first;
    for (int i = 0; i < ranks; i++) {
        const int *children = l->rank[block->first + i].children;
        lanes8_put(table + i * LAYER_TABLE, sums.given);
        sums.asked += layer_gather(l, LAYER_ASKED, children);
        given[i] = layer_gather(l, LAYER_GIVEN, children);
        sums.given += given[i];
    }
    for (int i = ranks - 1; i >= 0; i--) {
        lanes8_put(table + i * LAYER_TABLE, known - (lanes8_get(table + i * LAYER_TABLE) + late));
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
    double *table = l->numbers + pend_layers_table(l->count) + block->first * LAYER_TABLE;
    struct layer_known known = layer_begin(s, l, i, k);
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
        lanes8_put(table + j * LAYER_TABLE, sum);
        sum += given[j];
    }
    for (int j = ranks - 1; j >= 0; j--) {
        lanes8_put(table + j * LAYER_TABLE, known.ci - (lanes8_get(table + j * LAYER_TABLE) + late));
        late += given[j];
    }
    layer_put(at, LAYER_TANGENTIAL, layer_get(at, LAYER_INV) * (known.ci - sum));
}

static void layers_up(const struct jets_system *s, const struct layers *l, int k) {
    int i = 0;
    for (; i < l->count && l->block[i].leaves; i++) {
        double *at = layers_at(l, i);
        struct layer_known known = layer_begin(s, l, i, k);
        layer_ask(at, known.ci, -(layer_get(at, LAYER_WEIGHT) * known.Ti));
    }
    for (; i < l->count - 1; i++) {
        double *at = layers_at(l, i);
        struct layer_known known = layer_begin(s, l, i, k);
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

/* the root hangs on the pivot, which has i gravity; it is alone in its block */
LANES_INLINE lanes8 layers_lift(const struct layers *l, double gravity) {
    layers_at(l, l->count)[LAYER_TANGENTIAL * LAYER_ARMS] = gravity;
    return (lanes8){layers_at(l, l->count - 1)[LAYER_SINE * LAYER_ARMS] * gravity};
}

static void layers_down_cap(const struct jets_system *s, const struct layers *l, double gravity, int k) {
    lanes8 lift = layers_lift(l, gravity);
    int i = l->count - 1;
    double *at = layers_at(l, i);
    const struct layer_block *block = &l->block[i];
    lanes8 tension = layer_tension(at, layer_gather(l, LAYER_FIRST, block->shares));
    lanes8 shift = (tension - layer_get(at, LAYER_PUSH)) * layer_get(at, LAYER_INV_EFF) + lift;
    tension = lanes8_fma(lift, layer_get(at, LAYER_EFF), tension);
    lanes8 radial = layer_product(l->down, shift);
    lanes8 tangential = layer_get(at, LAYER_TANGENTIAL) - layer_get(at, LAYER_LEAN) * radial;
    layer_put(at, LAYER_RADIAL, radial);
    layer_put(at, LAYER_TANGENTIAL, tangential);
    struct layer_felt felt = {radial, layer_gather(l, LAYER_RADIAL, block->parents),
                              layer_gather(l, LAYER_TANGENTIAL, block->parents)};
    layer_learn(s, l, i, k, &felt, tension, tangential);
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
        layer_learn(s, l, i, k, &felt, tension, tangential);
    }
    for (; i >= 0; i--) {
        const double *at = layers_at(l, i);
        struct layer_felt felt = layer_feel(l, &l->block[i]);
        lanes8 tension = layer_tension(at, felt.across);
        lanes8 tangential = layer_get(at, LAYER_INV) * layer_get(at, LAYER_KNOWN);
        layer_learn(s, l, i, k, &felt, tension, tangential);
    }
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
