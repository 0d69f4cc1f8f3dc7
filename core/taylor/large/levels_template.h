/* The orders of one bushy tree, level by level: no arm depends on another arm of its level. Without
 * levels, in blocks, the request of a trajectory by the method taylor takes the same processor time
 * with 32 arms, 10 % more with 64, 31 % with 200 and 44 % with 1000.
 * Leaves to others: the factorization (levels_factor), the decomposition (levels).
 * Invariant: one pass per sweep, which reads a block's numbers once; its subtractions are those of
 * jets_template. */
#ifndef PEND_LEVELS_TEMPLATE_H
#define PEND_LEVELS_TEMPLATE_H

#include "core/taylor/large/convolve_template.h"
#include "core/taylor/large/couples_template.h"
#include "core/taylor/large/levels_factor.h"

/* ---- once an order, from the leaves to the root */

/* the place of the series of order k of a block's arms from lane h on, which until then stores T
 * and c, or their known parts */
struct level_rows {
    double *rate, *turn_re, *turn_im, *force;
};

VEC_INLINE struct level_rows level_rows(const struct jets_system *s, int block, int h, int k) {
    size_t row = (size_t)block * s->tile + (size_t)k * LEVEL_ARMS + (size_t)h;
    return (struct level_rows){s->rate + row + LEVEL_ARMS,
                               s->turn_re + row + (size_t)2 * LEVEL_ARMS,
                               s->turn_im + row + (size_t)2 * LEVEL_ARMS, s->force + row};
}

/* T and c of order k; the known part of order k + 1 is stored at the place of that order */
VEC_INLINE struct convolved level_known(const struct jets_system *s, int block, int h, int k,
                                        int couples) {
    struct level_rows last = level_rows(s, block, h, k), after = level_rows(s, block, h, k + 1);
    struct convolved next,
        now = convolve(s, (size_t)block * s->tile + (size_t)h, k, couples, &next);
    wide_put(after.rate, next.Tr);
    wide_put(after.turn_re, next.Ti);
    wide_put(after.turn_im, next.ci);
    if (couples) return now;
    wide_put(after.force, next.cr);
    wide_put(last.force, now.cr);
    return now;
}

/* level_known for the second of two orders, except Re c, which is in its place already */
VEC_INLINE struct convolved level_complete(const struct jets_system *s, int block, int h, int k) {
    struct level_rows now = level_rows(s, block, h, k);
    struct convolved known = {wide_get(now.rate), wide_get(now.turn_re), wide_of(0),
                              wide_get(now.turn_im)};
    return convolve_rest(s, (size_t)block * s->tile + (size_t)h, k, known);
}

/* T and c of order k, stored in place; returns Ti and s */
VEC_INLINE struct convolved level_begin(const struct jets_system *s, const struct levels *l,
                                        int block, int h, int k, int couples) {
    struct convolved known =
        k % 2 ? level_complete(s, block, h, k) : level_known(s, block, h, k, couples);
    struct level_rows now = level_rows(s, block, h, k);
    wide_put(now.rate, known.Tr);
    wide_put(now.turn_re, -known.Ti * wide_of(s->share[k + 1]));
    size_t row = (size_t)block * s->tile + (size_t)k * LEVEL_ARMS + (size_t)h;
    known.ci = couples ? couples_across(s, row, k, known.ci) : known.ci * wide_of(s->share[k]);
    level_put(levels_at(l, block) + h, LEVEL_KNOWN, known.ci);
    return known;
}

/* the force on the parent, and its reaction */
VEC_INLINE void level_ask(double *at, wide known, wide bias) {
    level_put(at, LEVEL_BIAS, bias);
    level_put(at, LEVEL_ASKED,
              level_get(at, LEVEL_KAPPA) * bias - level_get(at, LEVEL_GRIP) * known);
    level_put(at, LEVEL_GIVEN,
              wide_fma(level_get(at, LEVEL_SINE), bias, level_get(at, LEVEL_COSINE) * known));
}

/* sums over children of forces on the parent, and of reactions */
struct level_sums {
    wide asked, given;
};

/* The sums over all children of a block's joints, starting with the first. The sum for each child
 * excludes the child itself: the joint's known force minus the sums over the earlier and over the
 * later siblings. */
VEC_INLINE struct level_sums level_children(const struct levels *l, int which, int h, wide known,
                                            struct level_sums sums) {
    const struct level_block *block = &l->block[which];
    double *at = levels_at(l, which) + h;
    double *table = l->numbers + pend_levels_table(l->count) + block->first * LEVEL_TABLE + h;
    wide given[LEVELS_CHILDREN], late = wide_of(0);
    int ranks = block->end - block->first;
    for (int i = 0; i < ranks; i++) {
        const int *children = l->rank[block->first + i].children + h;
        given[i] = level_gather(l, LEVEL_GIVEN, children);
        sums.asked += level_gather(l, LEVEL_ASKED, children);
        wide_put(table + i * LEVEL_TABLE, sums.given);
        sums.given += given[i];
    }
    for (int i = ranks - 1; i >= 0; i--) {
        wide_put(table + i * LEVEL_TABLE, known - (wide_get(table + i * LEVEL_TABLE) + late));
        late += given[i];
    }
    level_put(at, LEVEL_FIRST, known - late);
    return sums;
}

/* leaves have no children to sum over */
VEC_INLINE void level_up_leaves(const struct jets_system *s, const struct levels *l, int i, int h,
                                int k, int couples) {
    double *at = levels_at(l, i) + h;
    struct convolved known = level_begin(s, l, i, h, k, couples);
    level_ask(at, known.ci, -(level_get(at, LEVEL_WEIGHT) * known.Ti));
}

VEC_INLINE void level_up(const struct jets_system *s, const struct levels *l, int i, int h, int k,
                         int couples) {
    const double *below = levels_at(l, l->block[i].below) + h;
    double *at = levels_at(l, i) + h;
    struct convolved known = level_begin(s, l, i, h, k, couples);
    struct level_sums sums = {level_get(below, LEVEL_ASKED), level_get(below, LEVEL_GIVEN)};
    sums = level_children(l, i, h, known.ci, sums);
    wide push = wide_fma(level_get(at, LEVEL_LEAN), known.ci, sums.asked);
    level_put(at, LEVEL_PUSH, push);
    level_ask(at, known.ci, push - level_get(at, LEVEL_WEIGHT) * known.Ti);
    level_put(at, LEVEL_TANGENTIAL, level_get(at, LEVEL_INV) * (known.ci - sums.given));
}

/* The cap's arms may be connected: their forces are computed first without the effect of other arms
 * of the cap, and again with it. */
VEC_INLINE void level_up_cap(const struct jets_system *s, const struct levels *l, int i, int k,
                             int couples) {
    const struct level_block *block = &l->block[i];
    struct vec8 known, heave, pull;
    for (int p = 0; p < VEC8_PARTS; p++) {
        double *at = levels_at(l, i) + p * WIDE;
        struct convolved x = level_begin(s, l, i, p * WIDE, k, couples);
        known.part[p] = x.ci;
        heave.part[p] = level_get(at, LEVEL_WEIGHT) * x.Ti;
        level_ask(at, x.ci, wide_of(0));
    }
    for (int p = 0; p < VEC8_PARTS; p++) {
        double *at = levels_at(l, i) + p * WIDE;
        pull.part[p] = wide_fma(level_get(at, LEVEL_LEAN), known.part[p], -heave.part[p]);
        for (int j = block->first; j < block->end; j++)
            pull.part[p] += level_gather(l, LEVEL_ASKED, l->rank[j].children + p * WIDE);
    }
    struct vec8 bias = vec8_product(l->up, &pull);
    for (int p = 0; p < VEC8_PARTS; p++) {
        double *at = levels_at(l, i) + p * WIDE;
        level_put(at, LEVEL_PUSH, bias.part[p] + heave.part[p]);
        level_ask(at, known.part[p], bias.part[p]);
    }
    for (int p = 0; p < VEC8_PARTS; p++) {
        double *at = levels_at(l, i) + p * WIDE;
        struct level_sums sums = {wide_of(0), wide_of(0)};
        sums = level_children(l, i, p * WIDE, known.part[p], sums);
        level_put(at, LEVEL_TANGENTIAL, level_get(at, LEVEL_INV) * (known.part[p] - sums.given));
    }
}

VEC_INLINE void levels_up(const struct jets_system *s, const struct levels *l, int k, int couples) {
    int i = 0;
    for (; l->block[i].leaves; i++)
        for (int h = 0; h < LEVEL_ARMS; h += WIDE) level_up_leaves(s, l, i, h, k, couples);
    for (; i < l->count - 1; i++)
        for (int h = 0; h < LEVEL_ARMS; h += WIDE) level_up(s, l, i, h, k, couples);
    level_up_cap(s, l, i, k, couples);
}

/* ---- once an order, from the root to the leaves */

/* the forces of the parents on a block's arms */
struct level_felt {
    wide across, radial, tangential;
};

VEC_INLINE struct level_felt level_feel(const struct levels *l, const struct level_block *block,
                                        int h) {
    return (struct level_felt){level_parents(l, block, LEVEL_FIRST, block->shares, h),
                               level_parents(l, block, LEVEL_RADIAL, block->parents, h),
                               level_parents(l, block, LEVEL_TANGENTIAL, block->parents, h)};
}

/* the constant part of mu, tension first */
VEC_INLINE wide level_tension(const double *at, wide share) {
    wide across = share - level_get(at, LEVEL_COSINE) * level_get(at, LEVEL_KNOWN);
    return wide_fma(level_get(at, LEVEL_TAU), across,
                    level_get(at, LEVEL_NU) * level_get(at, LEVEL_BIAS));
}

/* stores the coefficients of order k and computes the next ones of u */
VEC_INLINE void level_learn(const struct jets_system *s, const struct levels *l, int block, int h,
                            int k, const struct level_felt *felt, wide tension, wide tangential,
                            int couples) {
    const double *at = levels_at(l, block) + h;
    struct level_rows now = level_rows(s, block, h, k);
    wide gap = wide_fma(level_get(at, LEVEL_SINE), felt->radial, tangential);
    wide turned =
        (gap - level_get(at, LEVEL_COSINE) * felt->tangential) * level_get(at, LEVEL_PART);
    wide mu = wide_fma(level_get(at, LEVEL_STIFF), felt->radial, tension);
    wide rate = turned - wide_get(now.rate), pull = mu * wide_of(k + 1);
    wide_put(now.rate, rate);
    if (couples) wide_put(s->loads->spin + block * LEVEL_ARMS + h, rate);
    wide_put(now.force, couples ? pull : pull - wide_get(now.force));
    wide_put(now.turn_im, turned * wide_of(s->share[k + 1]));
}

/* stores the acceleration of the tips, and returns the part across */
VEC_INLINE wide level_tip(double *at, wide radial) {
    wide tangential = level_get(at, LEVEL_TANGENTIAL) - level_get(at, LEVEL_LEAN) * radial;
    level_put(at, LEVEL_RADIAL, radial);
    level_put(at, LEVEL_TANGENTIAL, tangential);
    return tangential;
}

/* the pivot's force along the root, which is the cap's first arm */
VEC_INLINE double levels_lift(const struct levels *l, struct couples_lift lift) {
    const double *root = levels_at(l, l->count - 1);
    double *pivot = levels_at(l, l->count), along = root[LEVEL_SINE * LEVEL_ARMS] * lift.y;
    if (lift.x != 0) along = lanes1_fma(root[LEVEL_COSINE * LEVEL_ARMS], lift.x, along);
    pivot[LEVEL_RADIAL * LEVEL_ARMS] = lift.x;
    pivot[LEVEL_TANGENTIAL * LEVEL_ARMS] = lift.y;
    return along;
}

/* the cap's tips respond to all its shifts at once */
VEC_INLINE void level_down_cap(const struct jets_system *s, const struct levels *l, double lift,
                               int i, int k, int couples) {
    const struct level_block *block = &l->block[i];
    struct vec8 tension, shift;
    for (int p = 0; p < VEC8_PARTS; p++) {
        double *at = levels_at(l, i) + p * WIDE;
        wide root = p ? wide_of(0) : (wide){lift};
        wide here = level_tension(at, level_gather(l, LEVEL_FIRST, block->shares + p * WIDE));
        shift.part[p] = (here - level_get(at, LEVEL_PUSH)) * level_get(at, LEVEL_INV_EFF) + root;
        tension.part[p] = wide_fma(root, level_get(at, LEVEL_EFF), here);
    }
    struct vec8 radial = vec8_product(l->down, &shift);
    struct vec8 tangential;
    for (int p = 0; p < VEC8_PARTS; p++) {
        tangential.part[p] = level_tip(levels_at(l, i) + p * WIDE, radial.part[p]);
    }
    for (int p = 0; p < VEC8_PARTS; p++) {
        struct level_felt felt = level_feel(l, block, p * WIDE);
        level_learn(s, l, i, p * WIDE, k, &felt, tension.part[p], tangential.part[p], couples);
    }
}

VEC_INLINE void level_down(const struct jets_system *s, const struct levels *l, int i, int h, int k,
                           int couples) {
    double *at = levels_at(l, i) + h;
    struct level_felt felt = level_feel(l, &l->block[i], h);
    wide tension = level_tension(at, felt.across);
    wide shift = (tension - level_get(at, LEVEL_PUSH)) * level_get(at, LEVEL_INV_EFF);
    wide radial = wide_fma(level_get(at, LEVEL_KAPPA), felt.radial, shift);
    level_learn(s, l, i, h, k, &felt, tension, level_tip(at, radial), couples);
}

/* the accelerations of a leaf's tip are not needed */
VEC_INLINE void level_down_leaves(const struct jets_system *s, const struct levels *l, int i, int h,
                                  int k, int couples) {
    const double *at = levels_at(l, i) + h;
    struct level_felt felt = level_feel(l, &l->block[i], h);
    wide tangential = level_get(at, LEVEL_INV) * level_get(at, LEVEL_KNOWN);
    level_learn(s, l, i, h, k, &felt, level_tension(at, felt.across), tangential, couples);
}

VEC_INLINE void levels_down(const struct jets_system *s, const struct levels *l,
                            struct couples_lift lift, int k, int couples) {
    int i = l->count - 1;
    level_down_cap(s, l, levels_lift(l, lift), i--, k, couples);
    for (; !l->block[i].leaves; i--)
        for (int h = 0; h < LEVEL_ARMS; h += WIDE) level_down(s, l, i, h, k, couples);
    for (; i >= 0; i--)
        for (int h = 0; h < LEVEL_ARMS; h += WIDE) level_down_leaves(s, l, i, h, k, couples);
}

/* all orders: rate_1 .. rate_order and force_0 .. force_{order - 1} from rate_0 and the
 * factorization */
VEC_INLINE void levels_all(const struct jets_system *s, double gravity, int order, int couples) {
    const struct levels *l = s->levels;
    levels_factor(s, l);
    for (int a = 0; a < jets_seats(s); a += WIDE) {
        size_t row = jets_row(s, a);
        wide_put(s->turn_re + row + LEVEL_ARMS, wide_of(0));
        wide_put(s->turn_im + row + LEVEL_ARMS, wide_get(s->rate + row));
    }
    for (int k = 0; k < order; k++) {
        if (couples) couples_order(s, k);
        levels_up(s, l, k, couples);
        levels_down(s, l, couples_lift(s, gravity, k), k, couples);
    }
}

static void levels_orders(const struct jets_system *s, double gravity, int order) {
    levels_all(s, gravity, order, 0);
}

/* with torques between the arms */
static void levels_coupled_orders(const struct jets_system *s, double gravity, int order) {
    levels_all(s, gravity, order, 1);
}

#endif
