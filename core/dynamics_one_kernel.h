/* Phi'' and lambda of one state of any tree.
 * Leaves to others: long chains (dynamics_chain_kernel), several states (dynamics_lanes_kernel), memory (dynamics).
 * Invariant: the operations of dynamics_lanes_kernel, hence its bits. */
#ifndef PEND_DYNAMICS_ONE_KERNEL_H
#define PEND_DYNAMICS_ONE_KERNEL_H

#include "core/dynamics_kernel.h"

/* Scratch of a block of arms; the letters are those of core/README.md. */
struct block {
    double cosine[DYNAMICS_BLOCK], sine[DYNAMICS_BLOCK]; /* C, Z: of the angle to the parent */
    double spin[DYNAMICS_BLOCK];                         /* w = l phi'^2 */
    double eff[DYNAMICS_BLOCK], held[DYNAMICS_BLOCK];    /* S, h */
    double lean[DYNAMICS_BLOCK], side[DYNAMICS_BLOCK];   /* r / (m + q), t / (m + q) */
};

/* Sums over the children of a joint that were met so far: S C^2, S Z^2, S C Z, f C, f Z, D and H. */
struct sums {
    double p, q, r, b, t, area, lift;
};

/* What a joint hands to its children: its acceleration along its arm and, with its sign turned, across, and how it
 * yields. */
struct tip {
    double radial, yield, lean, side;
};

/* the first `count` numbers of a vector; the others are 1 */
LANES_INLINE wide wide_load_some(const double *from, int count) {
#if defined(__AVX512F__)
    return (wide)_mm512_mask_loadu_pd(_mm512_set1_pd(1), (__mmask8)((1u << count) - 1), from);
#else
    wide x = WIDE_(of)(1);
    for (int i = 0; i < WIDE; i++)
        if (i < count) x[i] = from[i];
    return x;
#endif
}

LANES_INLINE void wide_store_some(double *to, wide x, int count) {
#if defined(__AVX512F__)
    _mm512_mask_storeu_pd(to, (__mmask8)((1u << count) - 1), (__m512d)x);
#else
    for (int i = 0; i < WIDE; i++)
        if (i < count) to[i] = x[i];
#endif
}

/* angles to the parents and what follows from an arm alone, arms i to i + WIDE of a block */
LANES_INLINE void block_angles(struct block *block, int i, wide x, wide base, wide rate, wide len) {
    wide sine, cosine;
    WIDE_(between)(x, base, &sine, &cosine);
    WIDE_(put)(block->cosine + i, cosine);
    WIDE_(put)(block->sine + i, sine);
    WIDE_(put)(block->spin + i, len * rate * rate);
}

static void block_prepare(struct block *block, const struct pend_tree *tree, const double phi[], const double rate[],
                          int begin, int count) {
    double base[DYNAMICS_BLOCK] __attribute__((aligned(64)));
    const int *parent = tree->parent + begin;
    int i = 0;
    if (!begin) base[i++] = 0;
    for (; i < count; i++) base[i] = phi[parent[i]];
    phi += begin, rate += begin;
    const double *len = tree->len + begin;
    for (i = 0; i + WIDE <= count; i += WIDE)
        block_angles(block, i, wide_load(phi + i), WIDE_(get)(base + i), wide_load(rate + i), wide_load(len + i));
    if (i == count) return;
    count -= i;
    block_angles(block, i, wide_load_some(phi + i, count), wide_load_some(base + i, count),
                 wide_load_some(rate + i, count), wide_load_some(len + i, count));
    // what the places behind the last arm add to the largest of all
    for (int j = i; j < i + WIDE; j++) block->eff[j] = block->held[j] = block->lean[j] = block->side[j] = 0;
}

/* the sweep from the leaves to the root */
struct climb {
    struct sums now;                  /* of the joint to which the arm before belongs */
    struct sums stack[WAITING], *top; /* joints that wait for more children */
    double unit, eff;                 /* eff: the largest S */
};

LANES_INLINE struct sums sums_first(double S, double f, double C, double Z) {
    return (struct sums){S * (C * C), S * (Z * Z), S * (C * Z), f * C, f * Z, 0, 0};
}

LANES_INLINE struct sums sums_join(const struct sums *j, double S, double f, double C, double Z) {
    double x = fma1(j->q, C, -(j->r * Z)), y = fma1(j->p, Z, -(j->r * C)), z = fma1(j->b, Z, -(j->t * C));
    return (struct sums){fma1(S, C * C, j->p),
                         fma1(S, Z * Z, j->q),
                         fma1(S, C * Z, j->r),
                         fma1(f, C, j->b),
                         fma1(f, Z, j->t),
                         fma1(S, fma1(Z, y, C * x), j->area),
                         fma1(S, Z * z, fma1(f, x, j->lift))};
}

/* the arms of a block from the last to the first */
LANES_INLINE void block_up(struct block *block, const struct pend_tree *tree, struct climb *climb, int begin,
                           int count) {
    const unsigned char *kin = tree->kin + begin;
    const double *mass = tree->mass + begin;
    struct sums now = climb->now, *top = climb->top;
    double unit = climb->unit, largest = climb->eff;
    for (int i = count - 1; i >= 0; i--) {
        unsigned how = kin[i];
        double m = unit * mass[i], C = block->cosine[i], Z = block->sine[i], S, h, lean = 0, side = 0;
        if (how & PEND_KIN_LEAF) {
            S = m;
            h = 0;
        } else {
            double inv = 1 / (m + now.q);
            S = fma1(fma1(m, now.p, now.area), inv, m);
            h = fma1(m, now.b, now.lift) * inv;
            lean = now.r * inv;
            side = now.t * inv;
        }
        double f = fma1(-S, block->spin[i], h);
        block->lean[i] = lean;
        block->side[i] = side;
        block->eff[i] = S;
        block->held[i] = h;
        largest = S > largest ? S : largest;
        if (how & PEND_KIN_LAST)
            now = sums_first(S, f, C, Z);
        else if (how & PEND_KIN_LEAF)
            now = sums_join(&now, S, f, C, Z);
        else
            now = sums_join(top--, S, f, C, Z);
        // the arm before is neither parent nor sibling
        if (!(how & PEND_KIN_FIRST) && kin[i - 1] & PEND_KIN_LAST) *++top = now;
    }
    climb->now = now, climb->top = top, climb->eff = largest;
}

/* the sweep from the root to the leaves */
struct descent {
    struct tip now, stack[WAITING], *top;
    double inverse_unit;
    wide force, radial, yield, spin, poison; /* as struct lanes_peaks */
};

/* the acceleration of a tip along its arm, from that of the arm's base */
LANES_INLINE double tip_radial(const struct tip *base, double C, double Z, double w) {
    return fma1(fma1(-Z, base->lean, C), base->radial, -fma1(Z, base->side, w));
}

/* the arms of a block from the first to the last: accelerations along them, and l phi'' */
LANES_INLINE void block_down(struct block *block, const unsigned char kin[], struct descent *descent, int count,
                             double along[], double bend[]) {
    struct tip now = descent->now, *top = descent->top;
    for (int i = 0; i < count; i++) {
        unsigned how = kin[i];
        if (!(how & PEND_KIN_FIRST)) {
            now = *top;
            if (how & PEND_KIN_LAST) top--;
        }
        double C = block->cosine[i], Z = block->sine[i], lean = block->lean[i], side = block->side[i];
        double radial = tip_radial(&now, C, Z, block->spin[i]), yield = fma1(lean, radial, side);
        along[i] = radial;
        bend[i] = fma1(C, now.yield, Z * now.radial) - yield;
        if (!(how & PEND_KIN_LEAF)) {
            now = (struct tip){radial, yield, lean, side};
            if (how & PEND_KIN_FORK) *++top = now;
        }
    }
    descent->now = now, descent->top = top;
}

/* phi'' and lambda of some arms of a block */
LANES_INLINE void block_values(const struct block *block, int i, wide radial, wide bend, wide len,
                               struct descent *descent, wide *acc, wide *force) {
    wide tension = WIDE_(fma)(WIDE_(get)(block->eff + i), radial, WIDE_(get)(block->held + i));
    wide yield = WIDE_(fma)(WIDE_(get)(block->lean + i), radial, WIDE_(get)(block->side + i));
    *acc = bend * (1.0 / len);
    *force = tension * descent->inverse_unit;
    descent->force = WIDE_(peak)(tension, descent->force);
    descent->radial = WIDE_(peak)(radial, descent->radial);
    descent->yield = WIDE_(peak)(yield, descent->yield);
    descent->spin = WIDE_(max)(WIDE_(get)(block->spin + i), descent->spin);
    descent->poison = WIDE_(fma)(*acc, WIDE_(of)(0), descent->poison);
}

LANES_INLINE void block_finish(struct block *block, const struct pend_tree *tree, struct descent *descent, int begin,
                               int count, double acc[], double force[]) {
    double along[DYNAMICS_BLOCK] __attribute__((aligned(64))), bend[DYNAMICS_BLOCK] __attribute__((aligned(64)));
    block_down(block, tree->kin + begin, descent, count, along, bend);
    const double *len = tree->len + begin;
    wide a, f;
    int i = 0;
    acc += begin, force += begin;
    for (; i + WIDE <= count; i += WIDE) {
        block_values(block, i, WIDE_(get)(along + i), WIDE_(get)(bend + i), wide_load(len + i), descent, &a, &f);
        memcpy(acc + i, &a, sizeof a);
        memcpy(force + i, &f, sizeof f);
    }
    if (i == count) return;
    count -= i;
    block_values(block, i, wide_load_some(along + i, count), wide_load_some(bend + i, count),
                 wide_load_some(len + i, count), descent, &a, &f);
    wide_store_some(acc + i, a, count);
    wide_store_some(force + i, f, count);
}

/* the largest S |acceleration of the base|, where an acceleration counts as the largest on the way from the pivot */
static double one_load(const struct block *block, const struct pend_tree *tree, double gravity) {
    struct {
        struct tip tip;
        double far;
    } stack[WAITING], *top = stack, now = {{0, -gravity, 0, -gravity}, fabs(gravity)};
    double most = 0;
    for (int k = 0; k < tree->n; k++) {
        const struct block *b = &block[k / DYNAMICS_BLOCK];
        int i = k % DYNAMICS_BLOCK;
        unsigned how = tree->kin[k];
        if (!(how & PEND_KIN_FIRST)) {
            now = *top;
            if (how & PEND_KIN_LAST) top--;
        }
        double w = b->spin[i], load = b->eff[i] * (now.far + w);
        most = load > most ? load : most;
        if (how & PEND_KIN_LEAF) continue;
        double radial = tip_radial(&now.tip, b->cosine[i], b->sine[i], w);
        now.tip = (struct tip){radial, fma1(b->lean[i], radial, b->side[i]), b->lean[i], b->side[i]};
        double size = fabs(now.tip.radial) + fabs(now.tip.yield) + w;
        now.far = size > now.far ? size : now.far;
        if (how & PEND_KIN_FORK) *++top = now;
    }
    return most;
}

LANES_INLINE double wide_most(wide x) {
    double most = x[0];
    for (int i = 1; i < WIDE; i++) most = x[i] > most ? x[i] : most;
    return most;
}

LANES_INLINE int kernel_blocks(const struct pend_tree *tree, double gravity, const double phi[], const double rate[],
                               double work[], double acc[], double force[]) {
    struct block *block = (struct block *)work;
    int n = tree->n, blocks = (n + DYNAMICS_BLOCK - 1) / DYNAMICS_BLOCK;
    struct climb climb;
    climb.now = (struct sums){0};
    climb.top = climb.stack, climb.unit = kernel_unit(tree->subtree_mass[0]), climb.eff = 0;
    for (int b = blocks - 1; b >= 0; b--) {
        int begin = b * DYNAMICS_BLOCK, count = n - begin < DYNAMICS_BLOCK ? n - begin : DYNAMICS_BLOCK;
        block_prepare(block + b, tree, phi, rate, begin, count);
        block_up(block + b, tree, &climb, begin, count);
    }
    struct descent descent;
    // gravity is a pivot that accelerates with i g
    descent.now = (struct tip){0, -gravity, 0, -gravity};
    descent.top = descent.stack;
    descent.inverse_unit = 1 / climb.unit;
    descent.force = descent.yield = descent.spin = descent.poison = WIDE_(of)(0);
    descent.radial = WIDE_(of)(fabs(gravity));
    for (int b = 0; b < blocks; b++) {
        int begin = b * DYNAMICS_BLOCK, count = n - begin < DYNAMICS_BLOCK ? n - begin : DYNAMICS_BLOCK;
        block_finish(block + b, tree, &descent, begin, count, acc, force);
    }
    double poison = 0, most = LOAD_MOST * wide_most(descent.force), spin = wide_most(descent.spin);
    for (int i = 0; i < WIDE; i++) poison += descent.poison[i];
    if (!(poison == 0 && most < INFINITY)) return 0;
    // no load is above this bound, which is most often enough
    double far = wide_most(descent.radial) + wide_most(descent.yield) + spin;
    return climb.eff * (far + spin) <= most || one_load(block, tree, gravity) <= most;
}

#endif
