/* The orders of one large tree, in blocks of eight arms: within a block both sweeps are a product with a small inverse.
 * Leaves to others: the factorization (jets_kernel), the cutting (blocks).
 * Invariant: an order waits once for each block, not for each arm; nothing is subtracted that jets_kernel does not. */
#ifndef PEND_BLOCKS_KERNEL_H
#define PEND_BLOCKS_KERNEL_H

#include "core/blocks.h"
#include "core/jets_system.h"
#include "core/lanes.h"

LANES_INLINE double *blocks_at(const struct blocks *b, int block) { return b->numbers + (size_t)block * BLOCK_NUMBERS; }

LANES_INLINE lanes8 block_get(const double *at, int row) { return lanes8_get(at + row * BLOCK_ARMS); }

LANES_INLINE void block_put(double *at, int row, lanes8 x) { lanes8_put(at + row * BLOCK_ARMS, x); }

/* the arms' successors, their predecessors */
LANES_INLINE lanes8 block_next(lanes8 x, lanes8 after) {
    return __builtin_shufflevector(x, after, 1, 2, 3, 4, 5, 6, 7, 8);
}

LANES_INLINE lanes8 block_last(lanes8 x, lanes8 before) {
    return __builtin_shufflevector(before, x, 7, 8, 9, 10, 11, 12, 13, 14);
}

/* a row's values at the arms' parents */
LANES_INLINE lanes8 block_parents(const struct blocks *b, const struct block_shape *shape, const double *at, int row) {
    if (shape->straight) return block_last(block_get(at, row), block_get(at - BLOCK_NUMBERS, row));
    return lanes8_gather(b->numbers + row * BLOCK_ARMS, shape->parent);
}

/* ---- once a step */

/* answers of a block's arms to a unit at arm i, on the way up and on the way down */
LANES_INLINE void block_invert(const struct jets_system *s, const struct block_shape *shape, double *at, int start) {
    lanes8 up[BLOCK_ARMS], down[BLOCK_ARMS];
    for (int i = 0; i < BLOCK_ARMS; i++) {
        up[i] = down[i] = lanes8_of(0);
        up[i][i] = down[i][i] = 1;
        int p = shape->inside[i];
        if (p >= 0) up[i] = lanes8_fma(lanes8_of(s->kappa[start + i]), up[p], up[i]);
    }
    for (int i = BLOCK_ARMS - 1; i >= 0; i--) {
        int p = shape->inside[i];
        if (p >= 0) down[p] = lanes8_fma(lanes8_of(s->kappa[start + i]), down[i], down[p]);
    }
    for (int i = 0; i < BLOCK_ARMS; i++) {
        block_put(at, BLOCK_UP + i, up[i]);
        block_put(at, BLOCK_DOWN + i, down[i]);
    }
}

LANES_INLINE void block_coefficients(const struct jets_system *s, const struct block_shape *shape, double *at, int a) {
    lanes8 eff = lanes8_get(s->eff + a), kappa = lanes8_get(s->kappa + a), part = lanes8_get(s->inv_len + a);
    lanes8 cosine = lanes8_get(s->cosine + a), sine = lanes8_get(s->sine + a);
    block_put(at, BLOCK_LEAN, lanes8_get(s->lean + a));
    block_put(at, BLOCK_NU, lanes8_get(s->nu + a));
    block_put(at, BLOCK_TAU, lanes8_get(s->tau + a));
    block_put(at, BLOCK_INV, lanes8_get(s->inv + a));
    block_put(at, BLOCK_INV_EFF, lanes8_get(s->inv_eff + a));
    block_put(at, BLOCK_STIFF, eff * kappa);
    block_put(at, BLOCK_WEIGHT, eff * lanes8_get(s->len + a));
    block_put(at, BLOCK_PART, part);
    block_put(at, BLOCK_ACROSS, cosine * part);
    block_put(at, BLOCK_ALONG, sine * part);
    block_put(at, BLOCK_LEAD_DOWN, shape->lead ? kappa[0] * block_get(at, BLOCK_DOWN) : lanes8_of(0));
    for (int i = 0; i < BLOCK_ARMS && a + i < s->n; i++) {
        int k = a + i, only = k + 1 < s->end[k] && s->end[k + 1] == s->end[k];
        at[BLOCK_C_ONLY * BLOCK_ARMS + i] = only ? s->cosine[k + 1] : 0;
        at[BLOCK_Z_ONLY * BLOCK_ARMS + i] = only ? s->sine[k + 1] : 0;
    }
}

/* what arms of other blocks do to a block: the edges' own kappa times the answer of the block */
static void blocks_join(const struct jets_system *s, const struct blocks *b) {
    for (int i = 0; i < b->count; i++) {
        double *at = blocks_at(b, i);
        const struct block_shape *shape = &b->shape[i];
        int next = (i + 1) * BLOCK_ARMS;
        double lead = i + 1 < b->count && b->shape[i + 1].lead ? s->kappa[next] : 0;
        block_put(at, BLOCK_LEAD_UP, lead * block_get(at, BLOCK_UP + BLOCK_ARMS - 1));
        for (int e = shape->up_first; e < shape->up_end; e++) {
            int k = b->up_arm[e], lane = s->parent[k] % BLOCK_ARMS;
            lanes8_put(b->edge_up + e * BLOCK_ARMS, s->kappa[k] * block_get(at, BLOCK_UP + lane));
        }
        for (int e = shape->down_first; e < shape->down_end; e++) {
            int k = b->down_arm[e], lane = k % BLOCK_ARMS;
            lanes8_put(b->edge_down + e * BLOCK_ARMS, s->kappa[k] * block_get(at, BLOCK_DOWN + lane));
        }
    }
}

static void blocks_prepare(const struct jets_system *s, const struct blocks *b) {
    for (int i = 0; i < b->count; i++) {
        double *at = blocks_at(b, i);
        block_invert(s, &b->shape[i], at, i * BLOCK_ARMS);
        block_coefficients(s, &b->shape[i], at, i * BLOCK_ARMS);
    }
    blocks_join(s, b);
}

/* ---- once an order */

/*
 * T and c of order k, and of order k + 1 but for the terms that order k is needed for, in one pass: what is loaded
 * serves both. Row -1 of the forces is zero.
 */
static void blocks_known(const struct jets_system *s, const struct blocks *b, int k) {
    enum { STRIDE = BLOCK_ARMS };
    lanes8 share = lanes8_of(s->share[k]);
    for (int i = b->count - 1; i >= 0; i--) {
        double *at = blocks_at(b, i);
        size_t row = (size_t)i * s->tile;
        const double *re = s->turn_re + row + 2 * STRIDE, *im = s->turn_im + row + 2 * STRIDE;
        const double *rate = s->rate + row + k * STRIDE, *force = s->force + row + (k - 1) * STRIDE;
        lanes8 w = lanes8_get(rate), f = lanes8_get(force), first = lanes8_get(s->rate + row), zero = lanes8_of(0);
        // u_1 is imaginary
        lanes8 Tr = zero, Ti = first * w, cr = zero, ci = first * f;
        lanes8 next_Tr = zero, next_Ti = zero, next_cr = zero, next_ci = zero;
        for (int j = 2; j <= k + 1; j++, re += STRIDE, im += STRIDE) {
            lanes8 ur = lanes8_get(re), ui = lanes8_get(im);
            next_Tr = lanes8_fma(ur, w, next_Tr);
            next_Ti = lanes8_fma(ui, w, next_Ti);
            next_cr = lanes8_fma(ur, f, next_cr);
            next_ci = lanes8_fma(ui, f, next_ci);
            rate -= STRIDE, force -= STRIDE;
            w = lanes8_get(rate), f = lanes8_get(force);
            Tr = lanes8_fma(ur, w, Tr);
            Ti = lanes8_fma(ui, w, Ti);
            cr = lanes8_fma(ur, f, cr);
            ci = lanes8_fma(ui, f, ci);
        }
        block_put(at, BLOCK_TR, Tr);
        block_put(at, BLOCK_TI, Ti);
        block_put(at, BLOCK_CR, cr);
        block_put(at, BLOCK_S, ci * share);
        block_put(at, BLOCK_NEXT_TR, next_Tr);
        block_put(at, BLOCK_NEXT_TI, next_Ti);
        block_put(at, BLOCK_NEXT_CR, next_cr);
        block_put(at, BLOCK_NEXT_CI, next_ci);
    }
}

/* T and c of order k, the second of two: the terms that were missing */
static void blocks_complete(const struct jets_system *s, const struct blocks *b, int k) {
    enum { STRIDE = BLOCK_ARMS };
    lanes8 share = lanes8_of(s->share[k]);
    for (int i = b->count - 1; i >= 0; i--) {
        double *at = blocks_at(b, i);
        size_t row = (size_t)i * s->tile, now = row + (size_t)k * STRIDE;
        lanes8 first = lanes8_get(s->rate + row);
        lanes8 Tr = lanes8_fma(lanes8_get(s->turn_re + now + STRIDE), first, block_get(at, BLOCK_NEXT_TR));
        lanes8 Ti = lanes8_fma(lanes8_get(s->turn_im + now + STRIDE), first, block_get(at, BLOCK_NEXT_TI));
        Ti = lanes8_fma(first, lanes8_get(s->rate + now), Ti);
        lanes8 ci = lanes8_fma(first, lanes8_get(s->force + now - STRIDE), block_get(at, BLOCK_NEXT_CI));
        block_put(at, BLOCK_TR, Tr);
        block_put(at, BLOCK_TI, Ti);
        block_put(at, BLOCK_CR, block_get(at, BLOCK_NEXT_CR));
        block_put(at, BLOCK_S, ci * share);
    }
}

/* sums of C s and Z s over the children of joints with several */
static void blocks_sum_known(const struct jets_system *s, const struct blocks *b) {
    enum { S = BLOCK_S * BLOCK_ARMS };
    for (int i = 0; i < b->joints; i++) {
        double along = 0, across = 0;
        for (int c = b->first[i]; c < b->first[i + 1]; c++) {
            double side = b->numbers[b->kid[c] + S];
            along = lanes1_fma(s->cosine[b->kid_arm[c]], side, along);
            across = lanes1_fma(s->sine[b->kid_arm[c]], side, across);
        }
        b->numbers[b->joint[i] + BLOCK_SUM_COS * BLOCK_ARMS] = along;
        b->numbers[b->joint[i] + BLOCK_SUM_SIN * BLOCK_ARMS] = across;
    }
}

/* the known forces, and what they ask of each arm */
static void blocks_pull(const struct blocks *b) {
    lanes8 after = lanes8_of(0);
    for (int i = b->count - 1; i >= 0; i--) {
        double *at = blocks_at(b, i);
        lanes8 here = block_get(at, BLOCK_S), next = block_next(here, after);
        lanes8 side = here - lanes8_fma(block_get(at, BLOCK_C_ONLY), next, block_get(at, BLOCK_SUM_COS));
        lanes8 sum_sin = lanes8_fma(block_get(at, BLOCK_Z_ONLY), next, block_get(at, BLOCK_SUM_SIN));
        lanes8 heave = block_get(at, BLOCK_WEIGHT) * block_get(at, BLOCK_TI);
        block_put(at, BLOCK_SIDE, side);
        block_put(at, BLOCK_HEAVE, heave);
        block_put(at, BLOCK_PULL, (block_get(at, BLOCK_LEAN) * side - sum_sin) - heave);
        after = here;
    }
}

/* the product of eight rows with eight numbers of another row */
LANES_INLINE lanes8 block_product(const double *at, int rows, int factors, lanes8 sum) {
    const double *x = at + factors * BLOCK_ARMS;
    lanes8 part = block_get(at, rows) * x[0];
    for (int i = 1; i < BLOCK_ARMS; i += 2) part = lanes8_fma(block_get(at, rows + i), lanes8_of(x[i]), part);
    for (int i = 2; i < BLOCK_ARMS; i += 2) sum = lanes8_fma(block_get(at, rows + i), lanes8_of(x[i]), sum);
    return part + sum;
}

/* leaves to root: the constant part of the force an arm asks for */
static void blocks_up(const struct blocks *b) {
    lanes8 after = lanes8_of(0);
    for (int i = b->count - 1; i >= 0; i--) {
        double *at = blocks_at(b, i);
        const struct block_shape *shape = &b->shape[i];
        lanes8 bias = block_product(at, BLOCK_UP, BLOCK_PULL, lanes8_of(0));
        for (int e = shape->up_first; e < shape->up_end; e++) {
            double child = b->numbers[b->up_place[e] + BLOCK_BIAS * BLOCK_ARMS];
            bias = lanes8_fma(lanes8_get(b->edge_up + e * BLOCK_ARMS), lanes8_of(child), bias);
        }
        lanes8 first = __builtin_shufflevector(after, after, 0, 0, 0, 0, 0, 0, 0, 0);
        bias = lanes8_fma(block_get(at, BLOCK_LEAD_UP), first, bias);
        block_put(at, BLOCK_BIAS, bias);
        after = bias;
    }
}

/* sums of Z f over the siblings of each arm and over all children of a joint, where there are several */
static void blocks_sum_bias(const struct jets_system *s, const struct blocks *b) {
    enum { BIAS = BLOCK_BIAS * BLOCK_ARMS, OTHERS = BLOCK_OTHERS * BLOCK_ARMS };
    for (int i = 0; i < b->joints; i++) {
        double early = 0, late = 0;
        for (int c = b->first[i]; c < b->first[i + 1]; c++) {
            b->numbers[b->kid[c] + OTHERS] = early;
            early = lanes1_fma(s->sine[b->kid_arm[c]], b->numbers[b->kid[c] + BIAS], early);
        }
        for (int c = b->first[i + 1] - 1; c >= b->first[i]; c--) {
            b->numbers[b->kid[c] + OTHERS] += late;
            late = lanes1_fma(s->sine[b->kid_arm[c]], b->numbers[b->kid[c] + BIAS], late);
        }
        b->numbers[b->joint[i] + BLOCK_SUM_SIDE * BLOCK_ARMS] = late;
    }
}

/* the constant part of mu, tension first: the siblings' part leaves the arm itself out */
static void blocks_tension(const struct blocks *b) {
    lanes8 after = lanes8_of(0);
    for (int i = b->count - 1; i >= 0; i--) {
        double *at = blocks_at(b, i);
        lanes8 bias = block_get(at, BLOCK_BIAS), next = block_next(bias, after);
        lanes8 sum_side = lanes8_fma(block_get(at, BLOCK_Z_ONLY), next, block_get(at, BLOCK_SUM_SIDE));
        lanes8 across = block_parents(b, &b->shape[i], at, BLOCK_SIDE) - block_get(at, BLOCK_OTHERS);
        lanes8 tension = lanes8_fma(block_get(at, BLOCK_TAU), across, block_get(at, BLOCK_NU) * bias);
        lanes8 push = bias + block_get(at, BLOCK_HEAVE);
        block_put(at, BLOCK_TENSION, tension);
        block_put(at, BLOCK_SHIFT, (tension - push) * block_get(at, BLOCK_INV_EFF));
        block_put(at, BLOCK_REST, block_get(at, BLOCK_INV) * (block_get(at, BLOCK_SIDE) - sum_side));
        after = bias;
    }
}

/* the root hangs on the pivot, which has i gravity */
static void blocks_hang(const struct jets_system *s, const struct blocks *b, double gravity) {
    double *root = blocks_at(b, 0), lift = s->sine[0] * gravity;
    root[pend_blocks_place(-1) + BLOCK_TANGENTIAL * BLOCK_ARMS] = gravity;
    if (gravity == 0) return;
    root[BLOCK_TENSION * BLOCK_ARMS] = lanes1_fma(s->eff[0], lift, root[BLOCK_TENSION * BLOCK_ARMS]);
    root[BLOCK_SHIFT * BLOCK_ARMS] += lift;
}

/* root to leaves: accelerations of the tips in their arms' frames */
static void blocks_down(const struct blocks *b) {
    lanes8 before = lanes8_of(0);
    for (int i = 0; i < b->count; i++) {
        double *at = blocks_at(b, i);
        const struct block_shape *shape = &b->shape[i];
        lanes8 radial = block_product(at, BLOCK_DOWN, BLOCK_SHIFT, lanes8_of(0));
        for (int e = shape->down_first; e < shape->down_end; e++) {
            double parent = b->numbers[b->down_place[e] + BLOCK_RADIAL * BLOCK_ARMS];
            radial = lanes8_fma(lanes8_get(b->edge_down + e * BLOCK_ARMS), lanes8_of(parent), radial);
        }
        lanes8 last = __builtin_shufflevector(before, before, 7, 7, 7, 7, 7, 7, 7, 7);
        radial = lanes8_fma(block_get(at, BLOCK_LEAD_DOWN), last, radial);
        block_put(at, BLOCK_RADIAL, radial);
        block_put(at, BLOCK_TANGENTIAL, block_get(at, BLOCK_REST) - block_get(at, BLOCK_LEAN) * radial);
        before = radial;
    }
}

/* the coefficients of order k and what they make of u */
static void blocks_learn(const struct jets_system *s, const struct blocks *b, int k) {
    enum { STRIDE = BLOCK_ARMS };
    lanes8 order = lanes8_of(k + 1), turn_share = lanes8_of(s->share[k + 1]);
    for (int i = 0; i < b->count; i++) {
        double *at = blocks_at(b, i);
        size_t now = (size_t)i * s->tile + (size_t)k * STRIDE, next = now + STRIDE, after = next + STRIDE;
        lanes8 radial = block_parents(b, &b->shape[i], at, BLOCK_RADIAL);
        lanes8 tangential = block_parents(b, &b->shape[i], at, BLOCK_TANGENTIAL);
        lanes8 turned = block_get(at, BLOCK_ALONG) * radial - block_get(at, BLOCK_ACROSS) * tangential;
        turned = lanes8_fma(block_get(at, BLOCK_PART), block_get(at, BLOCK_TANGENTIAL), turned);
        lanes8 mu = lanes8_fma(block_get(at, BLOCK_STIFF), radial, block_get(at, BLOCK_TENSION));
        lanes8_put(s->rate + next, turned - block_get(at, BLOCK_TR));
        lanes8_put(s->force + now, mu * order - block_get(at, BLOCK_CR));
        lanes8_put(s->turn_re + after, -block_get(at, BLOCK_TI) * turn_share);
        lanes8_put(s->turn_im + after, turned * turn_share);
    }
}

/* all orders: rate_1 .. rate_order and force_0 .. force_{order - 1} from rate_0 and the factorization */
static void blocks_orders(const struct jets_system *s, double gravity, int order) {
    const struct blocks *b = s->blocks;
    blocks_prepare(s, b);
    for (int i = 0; i < b->count; i++) {
        size_t row = (size_t)i * s->tile;
        lanes8_put(s->turn_re + row + BLOCK_ARMS, lanes8_of(0));
        lanes8_put(s->turn_im + row + BLOCK_ARMS, lanes8_get(s->rate + row));
    }
    for (int k = 0; k < order; k++) {
        if (k % 2)
            blocks_complete(s, b, k);
        else
            blocks_known(s, b, k);
        blocks_sum_known(s, b);
        blocks_pull(b);
        blocks_up(b);
        blocks_sum_bias(s, b);
        blocks_tension(b);
        blocks_hang(s, b, k ? 0 : gravity);
        blocks_down(b);
        blocks_learn(s, b, k);
    }
}

#endif
