/* The orders of one large tree, in blocks of eight arms: within a block both sweeps are products
 * with a small inverse.
 * Leaves to others: the factorization (jets_factor), the division into blocks (blocks).
 * Invariant: an order has one sequential dependency per block, not per arm; its subtractions are
 * those of jets_template. */
#pragma once

#include "core/taylor/large/blocks.h"
#include "core/taylor/large/convolve_template.h"
#include "core/taylor/large/couples_template.h"
#include "core/simd/vec8_template.h"
#include "core/taylor/jets_factor.h"

VEC_INLINE double *blocks_at(const struct blocks *b, int block) {
    return b->numbers + (size_t)block * BLOCK_NUMBERS;
}

VEC_INLINE wide block_get(const double *at, int row) { return wide_get(at + row * BLOCK_ARMS); }

VEC_INLINE void block_put(double *at, int row, wide x) { wide_put(at + row * BLOCK_ARMS, x); }

/* ---- once a step */

/* the lane of arm i's parent, negative if the parent is in another block; for an arm that does not
 * exist, kappa is 0 */
VEC_INLINE int block_parent(const struct block_shape *shape, int start, int i) {
    return shape->parents[i] - pend_blocks_place(start);
}

/* responses of the WIDE arms from lane h on to a unit at each arm i: in the sweep up, and in the
 * sweep down */
VEC_INLINE void block_invert(const struct jets_system *s, const struct block_shape *shape,
                             double *at, int start, int h) {
    wide up[BLOCK_ARMS], down[BLOCK_ARMS];
    for (int i = 0; i < BLOCK_ARMS; i++) {
        up[i] = down[i] = wide_only(1, i, h);
        int p = block_parent(shape, start, i);
        if (p >= 0) up[i] = wide_fma(wide_of(s->kappa[start + i]), up[p], up[i]);
    }
    for (int i = BLOCK_ARMS - 1; i >= 0; i--) {
        int p = block_parent(shape, start, i);
        if (p >= 0) down[p] = wide_fma(wide_of(s->kappa[start + i]), down[i], down[p]);
    }
    for (int i = 0; i < BLOCK_ARMS; i++) {
        block_put(at + h, BLOCK_UP + i, up[i]);
        block_put(at + h, BLOCK_DOWN + i, down[i]);
    }
}

/* fills the coefficients of arms a .. a + WIDE - 1, whose rows are at `at` */
VEC_INLINE void block_coefficients(const struct jets_system *s, double *at, int a) {
    wide eff = wide_get(s->eff + a), kappa = wide_get(s->kappa + a),
         part = wide_get(s->inv_len + a);
    wide cosine = wide_get(s->cosine + a), sine = wide_get(s->sine + a);
    block_put(at, BLOCK_LEAN, wide_get(s->lean + a));
    block_put(at, BLOCK_NU, wide_get(s->nu + a));
    block_put(at, BLOCK_TAU, wide_get(s->tau + a));
    block_put(at, BLOCK_INV, wide_get(s->inv + a));
    block_put(at, BLOCK_INV_EFF, wide_get(s->inv_eff + a));
    block_put(at, BLOCK_STIFF, eff * kappa);
    block_put(at, BLOCK_WEIGHT, eff * wide_get(s->len + a));
    block_put(at, BLOCK_PART, part);
    block_put(at, BLOCK_ACROSS, cosine * part);
    block_put(at, BLOCK_ALONG, sine * part);
    block_put(at, BLOCK_SINE, sine);
    for (int i = 0; i < WIDE && a + i < s->n; i++) {
        int k = a + i, carries = k + 1 < s->end[k];
        at[BLOCK_C_FIRST * BLOCK_ARMS + i] = carries ? -s->cosine[k + 1] : 0;
        at[BLOCK_Z_FIRST * BLOCK_ARMS + i] = carries ? -s->sine[k + 1] : 0;
    }
}

/* sets, in both directions, the coupling between a block's last arm and the next block's first arm,
 * if that is its child */
static void blocks_join(const struct jets_system *s, const struct blocks *b) {
    for (int a = 0; a < b->count * BLOCK_ARMS; a += WIDE) {
        int i = a / BLOCK_ARMS, here = i * BLOCK_ARMS, next = here + BLOCK_ARMS;
        double *at = blocks_at(b, i) + a % BLOCK_ARMS;
        double up = i + 1 < b->count && b->shape[i + 1].lead ? s->kappa[next] : 0;
        double down = b->shape[i].lead ? s->kappa[here] : 0;
        block_put(at, BLOCK_LEAD_UP, up * block_get(at, BLOCK_UP + BLOCK_ARMS - 1));
        block_put(at, BLOCK_LEAD_DOWN, down * block_get(at, BLOCK_DOWN));
    }
}

static void blocks_prepare(const struct jets_system *s, const struct blocks *b) {
    for (int a = 0; a < b->count * BLOCK_ARMS; a += WIDE) {
        int i = a / BLOCK_ARMS, h = a % BLOCK_ARMS;
        block_invert(s, &b->shape[i], blocks_at(b, i), i * BLOCK_ARMS, h);
        block_coefficients(s, blocks_at(b, i) + h, a);
    }
    blocks_join(s, b);
}

/* ---- once an order, from the last block to the first */

/* returns T and c of order k, and stores the known part of order k + 1 in the block's rows */
VEC_INLINE struct convolved block_known(const struct jets_system *s, double *at, size_t row, int k,
                                        int couples) {
    struct convolved next, now = convolve(s, row, k, couples, &next);
    block_put(at, BLOCK_NEXT_TR, next.Tr);
    block_put(at, BLOCK_NEXT_TI, next.Ti);
    block_put(at, BLOCK_NEXT_CR, next.cr);
    block_put(at, BLOCK_NEXT_CI, next.ci);
    return now;
}

/* returns T and c of the second of two orders, whose known part block_known stored */
VEC_INLINE struct convolved block_complete(const struct jets_system *s, const double *at,
                                           size_t row, int k) {
    struct convolved known = {block_get(at, BLOCK_NEXT_TR), block_get(at, BLOCK_NEXT_TI),
                              block_get(at, BLOCK_NEXT_CR), block_get(at, BLOCK_NEXT_CI)};
    return convolve_rest(s, row, k, known);
}

VEC_INLINE double blocks_one(const struct blocks *b, int place, int row) {
    return b->numbers[place + row * BLOCK_ARMS];
}

/* subtracts y from a lane of x */
VEC_INLINE void block_less(struct vec8 *x, int lane, double y) {
    for (int p = 0; p < VEC8_PARTS; p++) x->part[p] -= wide_only(y, lane, p * WIDE);
}

/* adds y times a row */
VEC_INLINE void block_add(struct vec8 *x, const double *at, int row, wide y) {
    for (int p = 0; p < VEC8_PARTS; p++)
        x->part[p] = wide_fma(block_get(at + p * WIDE, row), y, x->part[p]);
}

/* f, the constant part of the force on an arm's base; lane 0 of `after` is that of the next block's
 * first arm */
VEC_INLINE struct vec8 block_bias(const struct jets_system *s, const struct blocks *b,
                                  const struct block_shape *shape, const double *at,
                                  const struct vec8 *pull, wide after) {
    struct vec8 bias = vec8_product(at + BLOCK_UP * BLOCK_ARMS, pull);
    for (int e = shape->up.first; e < shape->up.end; e++) {
        double child = s->kappa[b->up_arm[e]] * blocks_one(b, b->up_place[e], BLOCK_BIAS);
        block_add(&bias, at, BLOCK_UP + b->up_lane[e], wide_of(child));
    }
    block_add(&bias, at, BLOCK_LEAD_UP, wide_of(after[0]));
    return bias;
}

/* at crowded joints: adds up Z f of each arm's earlier and later siblings */
VEC_INLINE void block_crowd(const struct blocks *b, int joint) {
    enum { SWAY = BLOCK_SWAY * BLOCK_ARMS, OTHERS = BLOCK_OTHERS * BLOCK_ARMS };
    double early = 0, late = 0;
    for (int c = b->crowd_first[joint]; c < b->crowd_first[joint + 1]; c++) {
        double *kid = b->numbers + b->crowd_place[c];
        kid[OTHERS] = early;
        early += kid[SWAY];
    }
    for (int c = b->crowd_first[joint + 1] - 1; c >= b->crowd_first[joint]; c--) {
        double *kid = b->numbers + b->crowd_place[c];
        kid[OTHERS] += late;
        late += kid[SWAY];
    }
}

/* T and c of order k of all arms */
VEC_INLINE void blocks_known(const struct jets_system *s, const struct blocks *b, int k,
                             int couples) {
    wide share = wide_of(s->share[k]);
    for (int a = b->count * BLOCK_ARMS - WIDE; a >= 0; a -= WIDE) {
        double *at = blocks_at(b, a / BLOCK_ARMS) + a % BLOCK_ARMS;
        size_t row = jets_row(s, a);
        struct convolved known =
            k % 2 ? block_complete(s, at, row, k) : block_known(s, at, row, k, couples);
        block_put(at, BLOCK_TR, known.Tr);
        block_put(at, BLOCK_TI, known.Ti);
        if (!couples) block_put(at, BLOCK_CR, known.cr);
        block_put(at, BLOCK_S,
                  couples ? couples_across(s, row + (size_t)k * BLOCK_ARMS, k, known.ci)
                          : known.ci * share);
    }
}

/* the values of the arms that follow those of part p; after the last arm, lane 0 of `after` */
VEC_INLINE wide block_next(const struct vec8 *x, int p, wide after) {
    return wide_shift(x->part[p], p + 1 < VEC8_PARTS ? x->part[p + 1] : after);
}

/* computes the known forces of arms and their children, and the constant part of h in `pull` */
VEC_INLINE void block_gather(const struct jets_system *s, const struct blocks *b,
                             const struct block_shape *shape, double *at, wide after,
                             struct vec8 *side, struct vec8 *pull) {
    struct vec8 here = vec8_get(at + BLOCK_S * BLOCK_ARMS);
    for (int p = 0; p < VEC8_PARTS; p++) {
        wide next = block_next(&here, p, after);
        side->part[p] = wide_fma(block_get(at + p * WIDE, BLOCK_C_FIRST), next, here.part[p]);
        pull->part[p] = block_get(at + p * WIDE, BLOCK_Z_FIRST) * next;
    }
    for (int e = shape->kids.first; e < shape->kids.end; e++) {
        double child = blocks_one(b, b->kid_place[e], BLOCK_S);
        int arm = b->kid_arm[e];
        block_less(side, b->kid_lane[e], s->cosine[arm] * child);
        block_less(pull, b->kid_lane[e], s->sine[arm] * child);
    }
    for (int p = 0; p < VEC8_PARTS; p++) {
        block_put(at + p * WIDE, BLOCK_SIDE, side->part[p]);
        pull->part[p] =
            wide_fma(block_get(at + p * WIDE, BLOCK_LEAN), side->part[p], pull->part[p]);
    }
}

/* computes the part of the tangential acceleration without the radial part */
VEC_INLINE void block_rest(const struct jets_system *s, const struct blocks *b,
                           const struct block_shape *shape, double *at, const struct vec8 *bias,
                           wide after, const struct vec8 *side) {
    struct vec8 rest;
    for (int p = 0; p < VEC8_PARTS; p++) {
        rest.part[p] = wide_fma(block_get(at + p * WIDE, BLOCK_Z_FIRST), block_next(bias, p, after),
                                side->part[p]);
    }
    for (int e = shape->kids.first; e < shape->kids.end; e++) {
        double child = blocks_one(b, b->kid_place[e], BLOCK_BIAS);
        block_less(&rest, b->kid_lane[e], s->sine[b->kid_arm[e]] * child);
    }
    for (int p = 0; p < VEC8_PARTS; p++) {
        block_put(at + p * WIDE, BLOCK_REST, block_get(at + p * WIDE, BLOCK_INV) * rest.part[p]);
    }
}

/* leaves to root */
static void blocks_up(const struct jets_system *s, const struct blocks *b) {
    wide after_s = wide_of(0), after_bias = after_s;
    for (int i = b->count - 1; i >= 0; i--) {
        double *at = blocks_at(b, i);
        const struct block_shape *shape = &b->shape[i];
        struct vec8 side, pull, heave, bias;
        block_gather(s, b, shape, at, after_s, &side, &pull);
        for (int p = 0; p < VEC8_PARTS; p++) {
            heave.part[p] =
                block_get(at + p * WIDE, BLOCK_WEIGHT) * block_get(at + p * WIDE, BLOCK_TI);
            pull.part[p] -= heave.part[p];
        }
        bias = block_bias(s, b, shape, at, &pull, after_bias);
        for (int p = 0; p < VEC8_PARTS; p++) {
            block_put(at + p * WIDE, BLOCK_BIAS, bias.part[p]);
            block_put(at + p * WIDE, BLOCK_PUSH, bias.part[p] + heave.part[p]);
            block_put(at + p * WIDE, BLOCK_SWAY,
                      bias.part[p] * block_get(at + p * WIDE, BLOCK_SINE));
        }
        block_rest(s, b, shape, at, &bias, after_bias, &side);
        for (int j = shape->joints.first; j < shape->joints.end; j++) block_crowd(b, j);
        after_s = block_get(at, BLOCK_S), after_bias = bias.part[0];
    }
}

/* ---- once an order, from the first block to the last */

/* a row's values at the parents of the arms from lane h on */
VEC_INLINE wide block_parents(const struct blocks *b, const struct block_shape *shape,
                              const double *at, int row, int h) {
    const double *before = h ? at + h - WIDE : at - BLOCK_NUMBERS + BLOCK_ARMS - WIDE;
    if (shape->straight) return wide_unshift(block_get(before, row), block_get(at + h, row));
    return wide_gather(b->numbers + row * BLOCK_ARMS, shape->parents + h);
}

/* x minus the sum of Z f over each arm's siblings, except at crowded joints */
VEC_INLINE wide block_siblings(const struct blocks *b, const struct block_shape *shape, wide x,
                               int h) {
    for (int i = 0; i < shape->rounds; i++)
        x -= wide_gather(b->numbers + BLOCK_SWAY * BLOCK_ARMS, shape->siblings[i] + h);
    return x;
}

/* the constant part of mu, where tension is solved first, from the siblings' sums without the arm
 * itself */
VEC_INLINE wide block_tension(const struct blocks *b, const struct block_shape *shape, double *at,
                              int h) {
    wide across = block_parents(b, shape, at, BLOCK_SIDE, h) - block_get(at + h, BLOCK_OTHERS);
    across = block_siblings(b, shape, across, h);
    wide bias = block_get(at + h, BLOCK_BIAS), push = block_get(at + h, BLOCK_PUSH);
    wide tension =
        wide_fma(block_get(at + h, BLOCK_TAU), across, block_get(at + h, BLOCK_NU) * bias);
    block_put(at + h, BLOCK_TENSION, tension);
    return (tension - push) * block_get(at + h, BLOCK_INV_EFF);
}

/* the tips' accelerations along their arms; the last lane of `before` belongs to the block
 * before */
VEC_INLINE struct vec8 block_radial(const struct jets_system *s, const struct blocks *b,
                                    const struct block_shape *shape, const double *at,
                                    const struct vec8 *shift, wide before) {
    struct vec8 radial = vec8_product(at + BLOCK_DOWN * BLOCK_ARMS, shift);
    for (int e = shape->down.first + shape->lead; e < shape->down.end; e++) {
        int arm = b->down_arm[e];
        double parent = s->kappa[arm] * blocks_one(b, b->down_place[e], BLOCK_RADIAL);
        block_add(&radial, at, BLOCK_DOWN + arm % BLOCK_ARMS, wide_of(parent));
    }
    block_add(&radial, at, BLOCK_LEAD_DOWN, wide_end(before));
    return radial;
}

/* stores the order-k coefficients of a block's arms from lane h on, and computes the next ones of
 * u */
VEC_INLINE void block_learn(const struct jets_system *s, const struct blocks *b, int i, int h,
                            int k, int couples) {
    enum { STRIDE = BLOCK_ARMS };
    double *block = blocks_at(b, i), *at = block + h;
    size_t now = (size_t)i * s->tile + (size_t)k * STRIDE + (size_t)h, next = now + STRIDE,
           after = next + STRIDE;
    wide order = wide_of(k + 1), turn_share = wide_of(s->share[k + 1]);
    wide radial = block_parents(b, &b->shape[i], block, BLOCK_RADIAL, h);
    wide tangential = block_parents(b, &b->shape[i], block, BLOCK_TANGENTIAL, h);
    wide turned = block_get(at, BLOCK_ALONG) * radial - block_get(at, BLOCK_ACROSS) * tangential;
    turned = wide_fma(block_get(at, BLOCK_PART), block_get(at, BLOCK_TANGENTIAL), turned);
    wide mu = wide_fma(block_get(at, BLOCK_STIFF), radial, block_get(at, BLOCK_TENSION));
    wide rate = turned - block_get(at, BLOCK_TR);
    wide_put(s->rate + next, rate);
    if (couples) wide_put(s->loads->spin + i * BLOCK_ARMS + h, rate);
    wide_put(s->force + now, couples ? mu * order : mu * order - block_get(at, BLOCK_CR));
    wide_put(s->turn_re + after, -block_get(at, BLOCK_TI) * turn_share);
    wide_put(s->turn_im + after, turned * turn_share);
}

/* the pivot's contribution to the root's `shift` */
VEC_INLINE double blocks_hang(const struct jets_system *s, const struct blocks *b,
                              struct couples_lift lift) {
    double *root = blocks_at(b, 0) + BLOCK_TENSION * BLOCK_ARMS, along = s->sine[0] * lift.y;
    double *pivot = b->numbers + pend_blocks_place(-1);
    if (lift.x != 0) along = lanes1_fma(s->cosine[0], lift.x, along);
    pivot[BLOCK_RADIAL * BLOCK_ARMS] = lift.x;
    pivot[BLOCK_TANGENTIAL * BLOCK_ARMS] = lift.y;
    if (along != 0) *root = lanes1_fma(s->eff[0], along, *root);
    return along;
}

/* root to leaves */
VEC_INLINE void blocks_down(const struct jets_system *s, const struct blocks *b,
                            struct couples_lift lift, int k, int couples) {
    wide before = wide_of(0);
    for (int i = 0; i < b->count; i++) {
        double *at = blocks_at(b, i);
        const struct block_shape *shape = &b->shape[i];
        struct vec8 shift, radial;
        for (int p = 0; p < VEC8_PARTS; p++) shift.part[p] = block_tension(b, shape, at, p * WIDE);
        if (!i) shift.part[0] += (wide){blocks_hang(s, b, lift)};
        radial = block_radial(s, b, shape, at, &shift, before);
        vec8_put(at + BLOCK_RADIAL * BLOCK_ARMS, &radial);
        for (int p = 0; p < VEC8_PARTS; p++) {
            double *own = at + p * WIDE;
            wide along = block_get(own, BLOCK_LEAN) * radial.part[p];
            block_put(own, BLOCK_TANGENTIAL, block_get(own, BLOCK_REST) - along);
        }
        for (int h = 0; h < BLOCK_ARMS; h += WIDE) block_learn(s, b, i, h, k, couples);
        before = radial.part[VEC8_PARTS - 1];
    }
}

/* all orders: rate_1 .. rate_order and force_0 .. force_{order - 1} from rate_0 and the
 * factorization */
VEC_INLINE void blocks_all(const struct jets_system *s, double gravity, int order, int couples) {
    const struct blocks *b = s->blocks;
    jets_factor(s);
    blocks_prepare(s, b);
    for (int a = 0; a < b->count * BLOCK_ARMS; a += WIDE) {
        size_t row = jets_row(s, a);
        wide_put(s->turn_re + row + BLOCK_ARMS, wide_of(0));
        wide_put(s->turn_im + row + BLOCK_ARMS, wide_get(s->rate + row));
    }
    for (int k = 0; k < order; k++) {
        if (couples) couples_order(s, k);
        blocks_known(s, b, k, couples);
        blocks_up(s, b);
        blocks_down(s, b, couples_lift(s, gravity, k), k, couples);
    }
}

static void blocks_orders(const struct jets_system *s, double gravity, int order) {
    blocks_all(s, gravity, order, 0);
}

/* all orders, with torques between the arms */
static void blocks_coupled_orders(const struct jets_system *s, double gravity, int order) {
    blocks_all(s, gravity, order, 1);
}
