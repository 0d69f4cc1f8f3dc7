/* The order-0 system of a tree in levels, factorized: eight joints at once.
 * Leaves to others: the decomposition (levels), the orders (levels_template), the formulas
 * (jets_factor).
 * Invariant: the factors are those of jets_factor up to rounding; a leaf's are set once. */
#ifndef PEND_LEVELS_FACTOR_H
#define PEND_LEVELS_FACTOR_H

#include "core/simd/vec8_template.h"
#include "core/taylor/jets_system.h"
#include "core/taylor/large/levels.h"

VEC_INLINE double *levels_at(const struct levels *l, int block) {
    return l->numbers + (size_t)block * LEVEL_NUMBERS;
}

VEC_INLINE wide level_get(const double *at, int row) { return wide_get(at + row * LEVEL_ARMS); }

VEC_INLINE void level_put(double *at, int row, wide x) { wide_put(at + row * LEVEL_ARMS, x); }

/* a row's numbers at places */
VEC_INLINE wide level_gather(const struct levels *l, int row, const int places[WIDE]) {
    return wide_gather(l->numbers + row * LEVEL_ARMS, places);
}

/* a row's numbers at the parents of a block's arms from lane h on: first children have their
 * parents' lanes */
VEC_INLINE wide level_parents(const struct levels *l, const struct level_block *block, int row,
                              const int places[LEVEL_ARMS], int h) {
    if (block->aligned) return level_get(levels_at(l, block->above) + h, row);
    return level_gather(l, row, places + h);
}

/* responses of the cap's arms from lane h on to a unit at one of them, in the sweep up and in the
 * sweep down */
VEC_INLINE void level_invert(const struct levels *l, int h) {
    int root = (l->count - 1) * LEVEL_ARMS;
    const int *parents = l->block[l->count - 1].parents;
    const double *kappa = levels_at(l, l->count - 1) + LEVEL_KAPPA * LEVEL_ARMS;
    wide up[LEVEL_ARMS], down[LEVEL_ARMS];
    for (int i = 0; i < LEVEL_ARMS; i++) {
        up[i] = down[i] = wide_only(1, i, h);
        int p = parents[i] - pend_levels_place(root);
        if (p < LEVEL_ARMS) up[i] = wide_fma(wide_of(kappa[i]), up[p], up[i]);
    }
    for (int i = LEVEL_ARMS - 1; i >= 0; i--) {
        int p = parents[i] - pend_levels_place(root);
        if (p < LEVEL_ARMS) down[p] = wide_fma(wide_of(kappa[i]), down[i], down[p]);
    }
    for (int i = 0; i < LEVEL_ARMS; i++) {
        level_put(l->up + h, i, up[i]);
        level_put(l->down + h, i, down[i]);
    }
}

/* sums over the children of each joint of a block that have joined so far */
struct level_load {
    wide p, r, q, d;
};

/* adds the child of one rank; stores the sums over its earlier siblings */
VEC_INLINE void level_join(struct level_load *load, double *share, wide C, wide Z, wide S) {
    wide SC = S * C, SZ = S * Z;
    wide_put(share, load->q);
    wide_put(share + LEVEL_ARMS, load->r);
    // p Z^2 - 2 r Z C + q C^2 = Z (p Z - r C) + C (q C - r Z)
    wide turned = Z * (load->p * Z - load->r * C) + C * (load->q * C - load->r * Z);
    load->d = wide_fma(S, turned, load->d);
    load->p = wide_fma(SC, C, load->p);
    load->r = wide_fma(SC, Z, load->r);
    load->q = wide_fma(SZ, Z, load->q);
}

/* the same from the last child to the first: the sum over the siblings is that of the earlier plus
 * that of the later ones, never the total minus the child */
VEC_INLINE void level_part(struct level_load *late, double *share, wide mass, wide C, wide Z,
                           wide S) {
    wide SZ = S * Z;
    wide_put(share, mass + (wide_get(share) + late->q));
    wide_put(share + LEVEL_ARMS, wide_get(share + LEVEL_ARMS) + late->r);
    late->q = wide_fma(SZ, Z, late->q);
    late->r = wide_fma(SZ, C, late->r);
}

/* the factors of a block's own arms from lane h on, from their children's */
VEC_INLINE void level_factor(const struct levels *l, int which, int h) {
    const struct level_block *block = &l->block[which];
    double *at = levels_at(l, which) + h;
    const double *below = levels_at(l, block->below) + h;
    double *table = l->numbers + pend_levels_table(l->count) + h,
           *own = at + LEVEL_FIRST * LEVEL_ARMS;
    wide mass = level_get(at, LEVEL_MASS), zero = wide_of(0);
    struct level_load load = {zero, zero, zero, zero}, late = load;
    level_join(&load, own, level_get(below, LEVEL_COSINE), level_get(below, LEVEL_SINE),
               level_get(below, LEVEL_EFF));
    for (int i = block->first; i < block->end; i++) {
        const int *children = l->rank[i].children + h;
        level_join(&load, table + i * LEVEL_TABLE, level_gather(l, LEVEL_COSINE, children),
                   level_gather(l, LEVEL_SINE, children), level_gather(l, LEVEL_EFF, children));
    }
    for (int i = block->end - 1; i >= block->first; i--) {
        const int *children = l->rank[i].children + h;
        level_part(&late, table + i * LEVEL_TABLE, mass, level_gather(l, LEVEL_COSINE, children),
                   level_gather(l, LEVEL_SINE, children), level_gather(l, LEVEL_EFF, children));
    }
    level_part(&late, own, mass, zero, zero, zero);
    wide inv = 1 / (mass + load.q);
    wide S = wide_fma(mass, mass + (load.p + load.q), load.d) * inv;
    level_put(at, LEVEL_INV, inv);
    level_put(at, LEVEL_LEAN, load.r * inv);
    level_put(at, LEVEL_EFF, S);
    level_put(at, LEVEL_INV_EFF, 1 / S);
    level_put(at, LEVEL_WEIGHT, S * level_get(at, LEVEL_LENGTH));
}

/* the factors of one arm of the cap */
static void level_factor_one(const struct levels *l, int lane) {
    const struct level_block *block = &l->block[l->count - 1];
    const struct level_rank *rank = l->rank + block->first;
    double *at = levels_at(l, l->count - 1) + lane,
           *row = l->numbers + pend_levels_table(l->count) + block->first * LEVEL_TABLE + lane;
    double mass = at[LEVEL_MASS * LEVEL_ARMS], p = 0, r = 0, q = 0, d = 0, late_q = 0, late_r = 0;
    int pivot = pend_levels_place(l->count * LEVEL_ARMS), count = 0;
    for (; count < block->end - block->first && rank[count].children[lane] != pivot; count++) {
        const double *c = l->numbers + rank[count].children[lane];
        double C = c[LEVEL_COSINE * LEVEL_ARMS], Z = c[LEVEL_SINE * LEVEL_ARMS],
               S = c[LEVEL_EFF * LEVEL_ARMS];
        row[count * LEVEL_TABLE] = q;
        row[count * LEVEL_TABLE + LEVEL_ARMS] = r;
        d = lanes1_fma(S, Z * (p * Z - r * C) + C * (q * C - r * Z), d);
        p = lanes1_fma(S * C, C, p);
        r = lanes1_fma(S * C, Z, r);
        q = lanes1_fma(S * Z, Z, q);
    }
    while (count--) {
        const double *c = l->numbers + rank[count].children[lane];
        double C = c[LEVEL_COSINE * LEVEL_ARMS],
               SZ = c[LEVEL_EFF * LEVEL_ARMS] * c[LEVEL_SINE * LEVEL_ARMS];
        row[count * LEVEL_TABLE] = mass + (row[count * LEVEL_TABLE] + late_q);
        row[count * LEVEL_TABLE + LEVEL_ARMS] += late_r;
        late_q = lanes1_fma(SZ, c[LEVEL_SINE * LEVEL_ARMS], late_q);
        late_r = lanes1_fma(SZ, C, late_r);
    }
    double inv = 1 / (mass + q), S = lanes1_fma(mass, mass + (p + q), d) * inv;
    at[LEVEL_INV * LEVEL_ARMS] = inv;
    at[LEVEL_LEAN * LEVEL_ARMS] = r * inv;
    at[LEVEL_EFF * LEVEL_ARMS] = S;
    at[LEVEL_INV_EFF * LEVEL_ARMS] = 1 / S;
    at[LEVEL_WEIGHT * LEVEL_ARMS] = S * at[LEVEL_LENGTH * LEVEL_ARMS];
}

/* the contributions of a block's arms from lane h on to their parents */
VEC_INLINE void level_share(const struct levels *l, int i, int h) {
    const struct level_block *block = &l->block[i];
    double *at = levels_at(l, i) + h;
    wide C = level_get(at, LEVEL_COSINE), Z = level_get(at, LEVEL_SINE),
         S = level_get(at, LEVEL_EFF);
    wide others = level_parents(l, block, LEVEL_FIRST, block->shares, h);
    wide lean = level_parents(l, block, LEVEL_FIRST_LEAN, block->shares, h);
    wide inv = level_parents(l, block, LEVEL_INV, block->parents, h);
    wide kappa = inv * (C * others - Z * lean);
    level_put(at, LEVEL_KAPPA, kappa);
    level_put(at, LEVEL_STIFF, S * kappa);
    level_put(at, LEVEL_NU, inv * others);
    level_put(at, LEVEL_TAU, inv * (S * Z));
    level_put(at, LEVEL_GRIP,
              wide_fma(level_parents(l, block, LEVEL_LEAN, block->parents, h), C, Z));
}

/* factorizes the order-0 tree system, as jets_factor does */
static void levels_factor(const struct jets_system *s, const struct levels *l) {
    int cap = l->count - 1;
    for (int k = 0; k < s->n; k++) {
        double *at = l->numbers + pend_levels_place(l->seat[k]);
        at[LEVEL_COSINE * LEVEL_ARMS] = s->cosine[k];
        at[LEVEL_SINE * LEVEL_ARMS] = s->sine[k];
    }
    for (int i = 0; i < cap; i++) {
        for (int h = 0; h < LEVEL_ARMS && !l->block[i].leaves; h += WIDE) level_factor(l, i, h);
    }
    for (int lane = LEVEL_ARMS - 1; lane >= 0; lane--) {
        if (l->arm[cap * LEVEL_ARMS + lane] >= 0) level_factor_one(l, lane);
    }
    for (int a = 0; a < l->count * LEVEL_ARMS; a += WIDE)
        level_share(l, a / LEVEL_ARMS, a % LEVEL_ARMS);
    levels_at(l, cap)[LEVEL_NU * LEVEL_ARMS] = 1;
    for (int h = 0; h < LEVEL_ARMS; h += WIDE) level_invert(l, h);
}

#endif
