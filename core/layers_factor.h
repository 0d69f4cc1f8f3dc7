/* The order-0 system of a tree in layers, factorized: eight joints at once.
 * Leaves to others: the cutting (layers), the orders (layers_kernel), the formulas (jets_factor).
 * Invariant: what jets_factor's factors are, to rounding; a leaf's are set once for all. */
#ifndef PEND_LAYERS_FACTOR_H
#define PEND_LAYERS_FACTOR_H

#include "core/jets_system.h"
#include "core/lanes.h"
#include "core/layers.h"

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
    double *at = layers_at(l, l->count - 1) + lane,
           *row = l->numbers + pend_layers_table(l->count) + block->first * LAYER_TABLE + lane;
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

#endif
