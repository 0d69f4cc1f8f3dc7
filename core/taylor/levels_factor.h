/* The order-0 system of a tree in layers, factorized: eight joints at once.
 * Leaves to others: the cutting (layers), the orders (layers_kernel), the formulas (jets_factor).
 * Invariant: what jets_factor's factors are, to rounding; a leaf's are set once for all. */
#ifndef PEND_LEVELS_FACTOR_H
#define PEND_LEVELS_FACTOR_H

#include "core/simd/vec8_template.h"
#include "core/taylor/jets_system.h"
#include "core/taylor/levels.h"

LANES_INLINE double *layers_at(const struct layers *l, int block) { return l->numbers + (size_t)block * LAYER_NUMBERS; }

LANES_INLINE wide layer_get(const double *at, int row) { return wide_get(at + row * LAYER_ARMS); }

LANES_INLINE void layer_put(double *at, int row, wide x) { wide_put(at + row * LAYER_ARMS, x); }

/* a row's numbers at places */
LANES_INLINE wide layer_gather(const struct layers *l, int row, const int places[WIDE]) {
    return wide_gather(l->numbers + row * LAYER_ARMS, places);
}

/* a row's numbers at the parents of a block's arms from lane h on: first children have their parents' lanes */
LANES_INLINE wide layer_parents(const struct layers *l, const struct layer_block *block, int row,
                                const int places[LAYER_ARMS], int h) {
    if (block->aligned) return layer_get(layers_at(l, block->above) + h, row);
    return layer_gather(l, row, places + h);
}

/* answers of the cap's arms from lane h on to a unit at one of them, on the way up and on the way down */
LANES_INLINE void layer_invert(const struct layers *l, int h) {
    int root = (l->count - 1) * LAYER_ARMS;
    const int *parents = l->block[l->count - 1].parents;
    const double *kappa = layers_at(l, l->count - 1) + LAYER_KAPPA * LAYER_ARMS;
    wide up[LAYER_ARMS], down[LAYER_ARMS];
    for (int i = 0; i < LAYER_ARMS; i++) {
        up[i] = down[i] = wide_only(1, i, h);
        int p = parents[i] - pend_layers_place(root);
        if (p < LAYER_ARMS) up[i] = wide_fma(wide_of(kappa[i]), up[p], up[i]);
    }
    for (int i = LAYER_ARMS - 1; i >= 0; i--) {
        int p = parents[i] - pend_layers_place(root);
        if (p < LAYER_ARMS) down[p] = wide_fma(wide_of(kappa[i]), down[i], down[p]);
    }
    for (int i = 0; i < LAYER_ARMS; i++) {
        layer_put(l->up + h, i, up[i]);
        layer_put(l->down + h, i, down[i]);
    }
}

/* what hangs on each joint of a block: sums over the children met so far */
struct layer_load {
    wide p, r, q, d;
};

/* the child of one rank joins; what the others do to it so far is kept */
LANES_INLINE void layer_join(struct layer_load *load, double *share, wide C, wide Z, wide S) {
    wide SC = S * C, SZ = S * Z;
    wide_put(share, load->q);
    wide_put(share + LAYER_ARMS, load->r);
    // p Z^2 - 2 r Z C + q C^2 = Z (p Z - r C) + C (q C - r Z)
    wide turned = Z * (load->p * Z - load->r * C) + C * (load->q * C - load->r * Z);
    load->d = wide_fma(S, turned, load->d);
    load->p = wide_fma(SC, C, load->p);
    load->r = wide_fma(SC, Z, load->r);
    load->q = wide_fma(SZ, Z, load->q);
}

/* the same from the last child to the first: the others are those before and those after, never all less the child */
LANES_INLINE void layer_part(struct layer_load *late, double *share, wide mass, wide C, wide Z, wide S) {
    wide SZ = S * Z;
    wide_put(share, mass + (wide_get(share) + late->q));
    wide_put(share + LAYER_ARMS, wide_get(share + LAYER_ARMS) + late->r);
    late->q = wide_fma(SZ, Z, late->q);
    late->r = wide_fma(SZ, C, late->r);
}

/* the factors of a block's own arms from lane h on, from their children's */
LANES_INLINE void layer_factor(const struct layers *l, int which, int h) {
    const struct layer_block *block = &l->block[which];
    double *at = layers_at(l, which) + h;
    const double *below = layers_at(l, block->below) + h;
    double *table = l->numbers + pend_layers_table(l->count) + h, *own = at + LAYER_FIRST * LAYER_ARMS;
    wide mass = layer_get(at, LAYER_MASS), zero = wide_of(0);
    struct layer_load load = {zero, zero, zero, zero}, late = load;
    layer_join(&load, own, layer_get(below, LAYER_COSINE), layer_get(below, LAYER_SINE), layer_get(below, LAYER_EFF));
    for (int i = block->first; i < block->end; i++) {
        const int *children = l->rank[i].children + h;
        layer_join(&load, table + i * LAYER_TABLE, layer_gather(l, LAYER_COSINE, children),
                   layer_gather(l, LAYER_SINE, children), layer_gather(l, LAYER_EFF, children));
    }
    for (int i = block->end - 1; i >= block->first; i--) {
        const int *children = l->rank[i].children + h;
        layer_part(&late, table + i * LAYER_TABLE, mass, layer_gather(l, LAYER_COSINE, children),
                   layer_gather(l, LAYER_SINE, children), layer_gather(l, LAYER_EFF, children));
    }
    layer_part(&late, own, mass, zero, zero, zero);
    wide inv = 1 / (mass + load.q);
    wide S = wide_fma(mass, mass + (load.p + load.q), load.d) * inv;
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

/* what a block's arms from lane h on pass on to their parents */
LANES_INLINE void layer_share(const struct layers *l, int i, int h) {
    const struct layer_block *block = &l->block[i];
    double *at = layers_at(l, i) + h;
    wide C = layer_get(at, LAYER_COSINE), Z = layer_get(at, LAYER_SINE), S = layer_get(at, LAYER_EFF);
    wide others = layer_parents(l, block, LAYER_FIRST, block->shares, h);
    wide lean = layer_parents(l, block, LAYER_FIRST_LEAN, block->shares, h);
    wide inv = layer_parents(l, block, LAYER_INV, block->parents, h);
    wide kappa = inv * (C * others - Z * lean);
    layer_put(at, LAYER_KAPPA, kappa);
    layer_put(at, LAYER_STIFF, S * kappa);
    layer_put(at, LAYER_NU, inv * others);
    layer_put(at, LAYER_TAU, inv * (S * Z));
    layer_put(at, LAYER_GRIP, wide_fma(layer_parents(l, block, LAYER_LEAN, block->parents, h), C, Z));
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
        for (int h = 0; h < LAYER_ARMS && !l->block[i].leaves; h += WIDE) layer_factor(l, i, h);
    }
    for (int lane = LAYER_ARMS - 1; lane >= 0; lane--) {
        if (l->arm[cap * LAYER_ARMS + lane] >= 0) layer_factor_one(l, lane);
    }
    for (int a = 0; a < l->count * LAYER_ARMS; a += WIDE) layer_share(l, a / LAYER_ARMS, a % LAYER_ARMS);
    layers_at(l, cap)[LAYER_NU * LAYER_ARMS] = 1;
    for (int h = 0; h < LAYER_ARMS; h += WIDE) layer_invert(l, h);
}

#endif
