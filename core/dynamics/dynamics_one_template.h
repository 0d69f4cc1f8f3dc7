/* Computes phi'' and lambda of one state of any tree.
 * Leaves to others: angles (dynamics_angles_template), several states (dynamics_vec_template),
 * memory (dynamics).
 * Invariant: the operations are those of dynamics_vec_template, so the bits are the same. */
#pragma once

#include "core/dynamics/dynamics_angles_template.h"

/* Values of an arm with children for the second sweep: S, h, r / (m + q), t / (m + q). Entries are
 * in the order of the first sweep. */
struct joint {
    double eff, held, lean, side;
};

/* Sums over the children of a joint visited so far: S C^2, S Z^2, S C Z, f C, f Z, D and H. */
struct sums {
    double p, q, r, b, t, area, lift;
};

/* Values passed from a joint to its children: its acceleration along its arm, minus its
 * acceleration across, and its compliance. */
struct tip {
    double radial, yield, lean, side;
};

struct climb {
    struct sums now;                      /* sums at the current joint, that of the previous arm */
    struct sums stack[WAITING + 1], *top; /* joints whose children are not all added yet */
    struct joint *joint;
    double unit, eff; /* unit: scale of the masses; eff: the largest S */
};

VEC_INLINE struct sums sums_first(double S, double f, double C, double Z) {
    return (struct sums){S * (C * C), S * (Z * Z), S * (C * Z), f * C, f * Z, 0, 0};
}

VEC_INLINE struct sums sums_join(const struct sums *j, double S, double f, double C, double Z) {
    double x = fma1(j->q, C, -(j->r * Z)), y = fma1(j->p, Z, -(j->r * C)),
           z = fma1(j->b, Z, -(j->t * C));
    return (struct sums){fma1(S, C * C, j->p),
                         fma1(S, Z * Z, j->q),
                         fma1(S, C * Z, j->r),
                         fma1(f, C, j->b),
                         fma1(f, Z, j->t),
                         fma1(S, fma1(Z, y, C * x), j->area),
                         fma1(S, Z * z, fma1(f, x, j->lift))};
}

/* the arms of a block from the last to the first */
VEC_INLINE void block_up(const struct turns *turns, const struct pend_tree *tree,
                         struct climb *climb, int begin, int count) {
    const unsigned char *kin = tree->kin + begin;
    const double *mass = tree->mass + begin;
    struct sums now = climb->now, *top = climb->top;
    struct joint *joint = climb->joint;
    double unit = climb->unit, largest = climb->eff;
    for (int i = count - 1; i >= 0; i--) {
        unsigned how = kin[i];
        double m = unit * mass[i], C = turns->cosine[i], Z = turns->sine[i], S = m, h = 0;
        if (!(how & PEND_KIN_LEAF)) {
            double inv = 1 / (m + now.q);
            S = fma1(fma1(m, now.p, now.area), inv, m);
            h = fma1(m, now.b, now.lift) * inv;
            *joint++ = (struct joint){S, h, now.r * inv, now.t * inv};
        }
        double f = fma1(-S, turns->spin[i], h);
        largest = S > largest ? S : largest;
        if (how & PEND_KIN_LAST)
            now = sums_first(S, f, C, Z);
        else if (how & PEND_KIN_LEAF)
            now = sums_join(&now, S, f, C, Z);
        else
            now = sums_join(top--, S, f, C, Z);
        // the previous arm is neither parent nor sibling
        if (!(how & PEND_KIN_FIRST) && kin[i - 1] & PEND_KIN_LAST) *++top = now;
    }
    climb->now = now, climb->top = top, climb->joint = joint, climb->eff = largest;
}

struct descent {
    struct tip now, stack[WAITING + 2], *top;
    const struct joint *joint; /* points one past the next joint to visit */
    double unit, inverse_unit, yield;
    wide force, radial, spin, poison; /* maxima, as in struct lanes_peaks */
};

/* the acceleration of a tip along its arm, from that of the arm's base */
VEC_INLINE double tip_radial(const struct tip *base, double C, double Z, double w) {
    return fma1(fma1(-Z, base->lean, C), base->radial, -fma1(Z, base->side, w));
}

/* For the arms of a block: accelerations along them, l phi'', scaled lambda. */
struct values {
    double radial[DYNAMICS_BLOCK], bend[DYNAMICS_BLOCK], tension[DYNAMICS_BLOCK];
};

/* the arms of a block from the first to the last */
VEC_INLINE void block_down(const struct turns *turns, const struct pend_tree *tree,
                           struct descent *descent, int begin, int count, struct values *values) {
    const unsigned char *kin = tree->kin + begin;
    const double *mass = tree->mass + begin;
    struct tip now = descent->now, *top = descent->top;
    const struct joint *joint = descent->joint;
    double unit = descent->unit, largest = descent->yield;
    for (int i = 0; i < count; i++) {
        unsigned how = kin[i];
        if (!(how & PEND_KIN_FIRST)) {
            now = *top;
            if (how & PEND_KIN_LAST) top--;
        }
        double C = turns->cosine[i], Z = turns->sine[i],
               radial = tip_radial(&now, C, Z, turns->spin[i]);
        double bend = fma1(C, now.yield, Z * now.radial), tension;
        if (how & PEND_KIN_LEAF) {
            tension = unit * mass[i] * radial;
        } else {
            joint--;
            double yield = fma1(joint->lean, radial, joint->side);
            tension = fma1(joint->eff, radial, joint->held);
            bend -= yield;
            largest = fabs(yield) > largest ? fabs(yield) : largest;
            now = (struct tip){radial, yield, joint->lean, joint->side};
            if (how & PEND_KIN_FORK) *++top = now;
        }
        values->radial[i] = radial;
        values->bend[i] = bend;
        values->tension[i] = tension;
    }
    descent->now = now, descent->top = top, descent->joint = joint, descent->yield = largest;
}

/* phi'' and lambda of some arms of a block */
VEC_INLINE void block_values(struct descent *descent, wide radial, wide bend, wide tension,
                             wide spin, wide len, wide *acc, wide *force) {
    *acc = bend * (1.0 / len);
    *force = tension * descent->inverse_unit;
    descent->force = WIDE_(peak)(tension, descent->force);
    descent->radial = WIDE_(peak)(radial, descent->radial);
    descent->spin = WIDE_(max)(spin, descent->spin);
    descent->poison = WIDE_(fma)(*acc, WIDE_(of)(0), descent->poison);
}

VEC_INLINE void block_finish(const struct turns *turns, const struct pend_tree *tree,
                             struct descent *descent, int begin, int count, double acc[],
                             double force[]) {
    struct values values __attribute__((aligned(64)));
    block_down(turns, tree, descent, begin, count, &values);
    const double *len = tree->len + begin;
    wide a, f;
    int i = 0;
    acc += begin, force += begin;
    for (; i + WIDE <= count; i += WIDE) {
        block_values(descent, WIDE_(get)(values.radial + i), WIDE_(get)(values.bend + i),
                     WIDE_(get)(values.tension + i), WIDE_(get)(turns->spin + i),
                     wide_load(len + i), &a, &f);
        memcpy(acc + i, &a, sizeof a);
        memcpy(force + i, &f, sizeof f);
    }
    if (i == count) return;
    count -= i;
    block_values(descent, wide_load_some(values.radial + i, count, 0),
                 wide_load_some(values.bend + i, count, 0),
                 wide_load_some(values.tension + i, count, 0), WIDE_(get)(turns->spin + i),
                 wide_load_some(len + i, count, 1), &a, &f);
    wide_store_some(acc + i, a, count);
    wide_store_some(force + i, f, count);
}

struct one {
    const struct pend_tree *tree;
    double gravity;
    const double *phi, *rate;
    double *acc, *force;
    struct turns *turns; /* one entry per block */
    struct joint *joint;
};

VEC_INLINE int one_blocks(const struct pend_tree *tree) {
    return (tree->n + DYNAMICS_BLOCK - 1) / DYNAMICS_BLOCK;
}

VEC_INLINE int block_count(int n, int b) {
    int left = n - b * DYNAMICS_BLOCK;
    return left < DYNAMICS_BLOCK ? left : DYNAMICS_BLOCK;
}

VEC_INLINE void one_up(const struct one *one, struct climb *climb) {
    const struct pend_tree *tree = one->tree;
    climb->now = (struct sums){0};
    climb->top = climb->stack, climb->joint = one->joint;
    climb->unit = kernel_unit(tree->subtree_mass[0]), climb->eff = 0;
    for (int b = one_blocks(tree) - 1; b >= 0; b--) {
        int begin = b * DYNAMICS_BLOCK, count = block_count(tree->n, b);
        block_turns(&one->turns[b], tree, one->phi, one->rate, begin, count);
        block_up(&one->turns[b], tree, climb, begin, count);
    }
}

VEC_INLINE void one_down(const struct one *one, const struct climb *climb,
                         struct descent *descent) {
    const struct pend_tree *tree = one->tree;
    double *acc = one->acc, *force = one->force;
    // gravity is equivalent to a pivot with the acceleration i g
    descent->now = (struct tip){0, -one->gravity, 0, -one->gravity};
    descent->top = descent->stack, descent->joint = climb->joint;
    descent->unit = climb->unit, descent->inverse_unit = 1 / climb->unit;
    descent->yield = 0;
    descent->force = descent->spin = descent->poison = WIDE_(of)(0);
    descent->radial = WIDE_(of)(fabs(one->gravity));
    for (int b = 0; b < one_blocks(tree); b++) {
        int begin = b * DYNAMICS_BLOCK, count = block_count(tree->n, b);
        block_finish(&one->turns[b], tree, descent, begin, count, acc, force);
    }
}

/* Returns the largest S |acceleration of the base|, where each base counts with the largest
 * acceleration on its path from the pivot. The array of joints ends at `joint`. */
static __attribute__((noinline)) double one_load(struct one one, const struct joint *joint,
                                                 double unit) {
    const struct pend_tree *tree = one.tree;
    double gravity = one.gravity;
    struct {
        struct tip tip;
        double far;
    } stack[WAITING], *top = stack, now = {{0, -gravity, 0, -gravity}, fabs(gravity)};
    double most = 0;
    for (int b = 0; b < one_blocks(tree); b++) {
        int begin = b * DYNAMICS_BLOCK, count = block_count(tree->n, b);
        const struct turns *turns = &one.turns[b];
        for (int i = 0; i < count; i++) {
            unsigned how = tree->kin[begin + i];
            if (!(how & PEND_KIN_FIRST)) {
                now = *top;
                if (how & PEND_KIN_LAST) top--;
            }
            double w = turns->spin[i],
                   S = how & PEND_KIN_LEAF ? unit * tree->mass[begin + i] : (--joint)->eff;
            double load = S * (now.far + w),
                   radial = tip_radial(&now.tip, turns->cosine[i], turns->sine[i], w);
            most = load > most ? load : most;
            if (how & PEND_KIN_LEAF) continue;
            now.tip = (struct tip){radial, fma1(joint->lean, radial, joint->side), joint->lean,
                                   joint->side};
            double size = fabs(radial) + fabs(now.tip.yield) + w;
            now.far = size > now.far ? size : now.far;
            if (how & PEND_KIN_FORK) *++top = now;
        }
    }
    return most;
}

VEC_INLINE double wide_most(wide x) {
    double most = x[0];
    for (int i = 1; i < WIDE; i++) most = x[i] > most ? x[i] : most;
    return most;
}

VEC_INLINE int one_sweeps(const struct one *one) {
    struct climb climb;
    struct descent descent;
    one_up(one, &climb);
    one_down(one, &climb, &descent);
    double poison = 0, most = LOAD_MOST * wide_most(descent.force), spin = wide_most(descent.spin);
    for (int i = 0; i < WIDE; i++) poison += descent.poison[i];
    if (!(poison == 0 && most < INFINITY)) return 0;
    // an upper bound of all loads, usually sufficient
    double far = wide_most(descent.radial) + descent.yield + spin;
    return climb.eff * (far + spin) <= most || one_load(*one, climb.joint, climb.unit) <= most;
}

static int kernel_blocks(const struct pend_tree *tree, const struct pend_loads *loads,
                         const double phi[], const double rate[], double work[], double acc[],
                         double force[]) {
    struct turns *turns = (struct turns *)work;
    struct joint *joint = (struct joint *)(turns + one_blocks(tree));
    const struct one one = {tree, loads->gravity, phi, rate, acc, force, turns, joint};
    return one_sweeps(&one);
}
