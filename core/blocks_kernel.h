/* The orders of one large tree, in blocks of eight arms: within a block both sweeps are a product with a small inverse.
 * Leaves to others: the factorization (jets_kernel), the cutting (blocks).
 * Invariant: an order waits once for each block, not for each arm; nothing is subtracted that jets_kernel does not. */
#ifndef PEND_BLOCKS_KERNEL_H
#define PEND_BLOCKS_KERNEL_H

#include "core/blocks.h"
#include "core/jets_factor.h"
#include "core/lanes.h"

#if defined(__AVX512F__)
#define BLOCK_PIN LANES_PIN
#else
#define BLOCK_PIN(x) ((void)0)
#endif

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

/* ---- once a step */

/* answers of a block's arms to a unit at arm i, on the way up and on the way down */
LANES_INLINE void block_invert(const struct jets_system *s, const struct block_shape *shape, double *at, int start) {
    lanes8 up[BLOCK_ARMS], down[BLOCK_ARMS];
    for (int i = 0; i < BLOCK_ARMS; i++) {
        up[i] = down[i] = lanes8_of(0);
        up[i][i] = down[i][i] = 1;
        int p = shape->parent.from[i];
        if (shape->parent.mask >> i & 1) up[i] = lanes8_fma(lanes8_of(s->kappa[start + i]), up[p], up[i]);
    }
    for (int i = BLOCK_ARMS - 1; i >= 0; i--) {
        int p = shape->parent.from[i];
        if (shape->parent.mask >> i & 1) down[p] = lanes8_fma(lanes8_of(s->kappa[start + i]), down[i], down[p]);
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
    block_put(at, BLOCK_SINE, sine);
    block_put(at, BLOCK_LEAD_DOWN, shape->lead ? kappa[0] * block_get(at, BLOCK_DOWN) : lanes8_of(0));
    for (int i = 0; i < BLOCK_ARMS && a + i < s->n; i++) {
        int k = a + i, carries = k + 1 < s->end[k];
        at[BLOCK_C_FIRST * BLOCK_ARMS + i] = carries ? -s->cosine[k + 1] : 0;
        at[BLOCK_Z_FIRST * BLOCK_ARMS + i] = carries ? -s->sine[k + 1] : 0;
    }
}

/* what the next block's first arm does to a block, where it hangs on the block's last */
static void blocks_join(const struct jets_system *s, const struct blocks *b) {
    for (int i = 0; i < b->count; i++) {
        double *at = blocks_at(b, i);
        int next = (i + 1) * BLOCK_ARMS;
        double lead = i + 1 < b->count && b->shape[i + 1].lead ? s->kappa[next] : 0;
        block_put(at, BLOCK_LEAD_UP, lead * block_get(at, BLOCK_UP + BLOCK_ARMS - 1));
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

/* ---- once an order, from the last block to the first */

struct block_known {
    lanes8 Tr, Ti, cr, ci;
};

/*
 * T and c of order k, and of order k + 1 but for the terms that order k is needed for, in one pass: what is loaded
 * serves both. Row -1 of the forces is zero.
 */
LANES_INLINE struct block_known block_known(const struct jets_system *s, double *at, size_t row, int k) {
    enum { STRIDE = BLOCK_ARMS };
    const double *re = s->turn_re + row + 2 * STRIDE, *im = s->turn_im + row + 2 * STRIDE;
    const double *rate = s->rate + row + (size_t)k * STRIDE, *force = s->force + row + (size_t)k * STRIDE - STRIDE;
    lanes8 w = lanes8_get(rate), f = lanes8_get(force), first = lanes8_get(s->rate + row), zero = lanes8_of(0);
    // u_1 is imaginary
    struct block_known now = {zero, first * w, zero, first * f}, next = {zero, zero, zero, zero};
    for (int j = 2; j <= k + 1; j++, re += STRIDE, im += STRIDE) {
        lanes8 ur = lanes8_get(re), ui = lanes8_get(im);
        BLOCK_PIN(ur);
        BLOCK_PIN(ui);
        next.Tr = lanes8_fma(ur, w, next.Tr);
        next.Ti = lanes8_fma(ui, w, next.Ti);
        next.cr = lanes8_fma(ur, f, next.cr);
        next.ci = lanes8_fma(ui, f, next.ci);
        rate -= STRIDE, force -= STRIDE;
        w = lanes8_get(rate), f = lanes8_get(force);
        BLOCK_PIN(w);
        BLOCK_PIN(f);
        now.Tr = lanes8_fma(ur, w, now.Tr);
        now.Ti = lanes8_fma(ui, w, now.Ti);
        now.cr = lanes8_fma(ur, f, now.cr);
        now.ci = lanes8_fma(ui, f, now.ci);
    }
    block_put(at, BLOCK_NEXT_TR, next.Tr);
    block_put(at, BLOCK_NEXT_TI, next.Ti);
    block_put(at, BLOCK_NEXT_CR, next.cr);
    block_put(at, BLOCK_NEXT_CI, next.ci);
    return now;
}

/* T and c of order k, the second of two: the terms that were missing */
LANES_INLINE struct block_known block_complete(const struct jets_system *s, const double *at, size_t row, int k) {
    enum { STRIDE = BLOCK_ARMS };
    size_t now = row + (size_t)k * STRIDE;
    lanes8 first = lanes8_get(s->rate + row);
    struct block_known known = {block_get(at, BLOCK_NEXT_TR), block_get(at, BLOCK_NEXT_TI),
                                block_get(at, BLOCK_NEXT_CR), block_get(at, BLOCK_NEXT_CI)};
    known.Tr = lanes8_fma(lanes8_get(s->turn_re + now + STRIDE), first, known.Tr);
    known.Ti = lanes8_fma(lanes8_get(s->turn_im + now + STRIDE), first, known.Ti);
    known.Ti = lanes8_fma(first, lanes8_get(s->rate + now), known.Ti);
    known.ci = lanes8_fma(first, lanes8_get(s->force + now - STRIDE), known.ci);
    return known;
}

/* a number of a row */
LANES_INLINE double blocks_one(const struct blocks *b, int place, int row) {
    return b->numbers[place + row * BLOCK_ARMS];
}

/* x less y in the lanes of a mask, of which one is set */
LANES_INLINE lanes8 block_less(lanes8 x, unsigned char mask, double y) {
#if defined(__AVX512F__)
    return (lanes8)_mm512_mask_sub_pd((__m512d)x, mask, (__m512d)x, (__m512d)lanes8_of(y));
#else
    x[__builtin_ctz(mask)] -= y;
    return x;
#endif
}

/* the product of eight rows with the eight numbers of a vector */
LANES_INLINE lanes8 block_product(const double *at, int rows, lanes8 x) {
#define BLOCK_TERM(i) block_get(at, rows + (i)), __builtin_shufflevector(x, x, i, i, i, i, i, i, i, i)
    lanes8 part = lanes8_fma(BLOCK_TERM(0), lanes8_of(0)), sum = lanes8_fma(BLOCK_TERM(1), lanes8_of(0));
    part = lanes8_fma(BLOCK_TERM(2), part);
    sum = lanes8_fma(BLOCK_TERM(3), sum);
    part = lanes8_fma(BLOCK_TERM(4), part);
    sum = lanes8_fma(BLOCK_TERM(5), sum);
    part = lanes8_fma(BLOCK_TERM(6), part);
    sum = lanes8_fma(BLOCK_TERM(7), sum);
#undef BLOCK_TERM
    return part + sum;
}

/* f, the constant part of the force that an arm asks for; `after` holds that of the next block */
LANES_INLINE lanes8 block_bias(const struct jets_system *s, const struct blocks *b, const struct block_shape *shape,
                               double *at, lanes8 pull, lanes8 after) {
    lanes8 bias = block_product(at, BLOCK_UP, pull);
    for (int e = shape->up.first; e < shape->up.end; e++) {
        double child = s->kappa[b->up_arm[e]] * blocks_one(b, b->up_place[e], BLOCK_BIAS);
        bias = lanes8_fma(block_get(at, BLOCK_UP + b->up_lane[e]), lanes8_of(child), bias);
    }
    lanes8 first = __builtin_shufflevector(after, after, 0, 0, 0, 0, 0, 0, 0, 0);
    return lanes8_fma(block_get(at, BLOCK_LEAD_UP), first, bias);
}

/* at crowded joints: the sum of Z f over the siblings before an arm and over those after it */
LANES_INLINE void block_crowd(const struct blocks *b, int joint) {
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
static void blocks_known(const struct jets_system *s, const struct blocks *b, int k) {
    lanes8 share = lanes8_of(s->share[k]);
    for (int i = b->count - 1; i >= 0; i--) {
        double *at = blocks_at(b, i);
        size_t row = (size_t)i * s->tile;
        struct block_known known = k % 2 ? block_complete(s, at, row, k) : block_known(s, at, row, k);
        block_put(at, BLOCK_TR, known.Tr);
        block_put(at, BLOCK_TI, known.Ti);
        block_put(at, BLOCK_CR, known.cr);
        block_put(at, BLOCK_S, known.ci * share);
    }
}

/* leaves to root */
static void blocks_up(const struct jets_system *s, const struct blocks *b) {
    lanes8 after_s = lanes8_of(0), after_bias = after_s;
    for (int i = b->count - 1; i >= 0; i--) {
        double *at = blocks_at(b, i);
        const struct block_shape *shape = &b->shape[i];
        // known forces of the arm and its children
        lanes8 here = block_get(at, BLOCK_S), next = block_next(here, after_s);
        lanes8 side = lanes8_fma(block_get(at, BLOCK_C_FIRST), next, here), push = block_get(at, BLOCK_Z_FIRST) * next;
        for (int e = shape->kids.first; e < shape->kids.end; e++) {
            double child = blocks_one(b, b->kid_place[e], BLOCK_S);
            int arm = b->kid_arm[e];
            side = block_less(side, b->kid_lane[e], s->cosine[arm] * child);
            push = block_less(push, b->kid_lane[e], s->sine[arm] * child);
        }
        lanes8 heave = block_get(at, BLOCK_WEIGHT) * block_get(at, BLOCK_TI);
        block_put(at, BLOCK_SIDE, side);
        lanes8 pull = lanes8_fma(block_get(at, BLOCK_LEAN), side, push) - heave;
        lanes8 bias = block_bias(s, b, shape, at, pull, after_bias);
        block_put(at, BLOCK_BIAS, bias);
        block_put(at, BLOCK_PUSH, bias + heave);
        block_put(at, BLOCK_SWAY, bias * block_get(at, BLOCK_SINE));
        // what stays of the tangential acceleration
        lanes8 rest = lanes8_fma(block_get(at, BLOCK_Z_FIRST), block_next(bias, after_bias), side);
        for (int e = shape->kids.first; e < shape->kids.end; e++) {
            double child = blocks_one(b, b->kid_place[e], BLOCK_BIAS);
            rest = block_less(rest, b->kid_lane[e], s->sine[b->kid_arm[e]] * child);
        }
        block_put(at, BLOCK_REST, block_get(at, BLOCK_INV) * rest);
        for (int j = shape->joints.first; j < shape->joints.end; j++) block_crowd(b, j);
        after_s = here, after_bias = bias;
    }
}

/* ---- once an order, from the first block to the last */

#if defined(__AVX512F__)
LANES_INLINE lanes8 block_lanes(const struct block_lanes *lanes, lanes8 x) {
    __m512i from = _mm512_cvtepi8_epi64(_mm_loadl_epi64((const __m128i *)(const void *)lanes->from));
    return (lanes8)_mm512_maskz_permutexvar_pd(lanes->mask, from, (__m512d)x);
}
#endif

/* a row's values at the arms' parents */
LANES_INLINE lanes8 block_parents(const struct blocks *b, const struct block_shape *shape, const double *at, int row) {
    if (shape->straight) return block_last(block_get(at, row), block_get(at - BLOCK_NUMBERS, row));
#if defined(__AVX512F__)
    lanes8 x = block_lanes(&shape->parent, block_get(at, row));
    for (int e = shape->down.first; e < shape->down.end; e++) {
        lanes8 other = lanes8_of(blocks_one(b, b->down_place[e], row));
        x = (lanes8)_mm512_mask_mov_pd((__m512d)x, b->down_lane[e], (__m512d)other);
    }
    return x;
#else
    return lanes8_gather(b->numbers + row * BLOCK_ARMS, shape->parents);
#endif
}

/* x less the sum of Z f over each arm's siblings, but for crowded joints */
LANES_INLINE lanes8 block_siblings(const struct blocks *b, const struct block_shape *shape, const double *at,
                                   lanes8 x) {
#if defined(__AVX512F__)
    lanes8 sway = block_get(at, BLOCK_SWAY);
    for (int i = 0; i < shape->rounds; i++) x -= block_lanes(&shape->sibling[i], sway);
    for (int e = shape->apart.first; e < shape->apart.end; e++) {
        x = block_less(x, b->apart_lane[e], blocks_one(b, b->apart_place[e], BLOCK_SWAY));
    }
#else
    (void)at;
    for (int i = 0; i < shape->rounds; i++) {
        x -= lanes8_gather(b->numbers + BLOCK_SWAY * BLOCK_ARMS, shape->siblings[i]);
    }
#endif
    return x;
}

/* the constant part of mu, tension first: the siblings' part leaves the arm itself out */
LANES_INLINE lanes8 block_tension(const struct blocks *b, const struct block_shape *shape, double *at) {
    lanes8 across = block_parents(b, shape, at, BLOCK_SIDE) - block_get(at, BLOCK_OTHERS);
    across = block_siblings(b, shape, at, across);
    lanes8 bias = block_get(at, BLOCK_BIAS), push = block_get(at, BLOCK_PUSH);
    lanes8 tension = lanes8_fma(block_get(at, BLOCK_TAU), across, block_get(at, BLOCK_NU) * bias);
    block_put(at, BLOCK_TENSION, tension);
    return (tension - push) * block_get(at, BLOCK_INV_EFF);
}

/* acceleration of the tips along their arms; `before` is that of the block before */
LANES_INLINE lanes8 block_radial(const struct jets_system *s, const struct blocks *b, const struct block_shape *shape,
                                 double *at, lanes8 shift, lanes8 before) {
    lanes8 radial = block_product(at, BLOCK_DOWN, shift);
    for (int e = shape->down.first + shape->lead; e < shape->down.end; e++) {
        int arm = b->down_arm[e];
        double parent = s->kappa[arm] * blocks_one(b, b->down_place[e], BLOCK_RADIAL);
        radial = lanes8_fma(block_get(at, BLOCK_DOWN + arm % BLOCK_ARMS), lanes8_of(parent), radial);
    }
    lanes8 last = __builtin_shufflevector(before, before, 7, 7, 7, 7, 7, 7, 7, 7);
    return lanes8_fma(block_get(at, BLOCK_LEAD_DOWN), last, radial);
}

/* the coefficients of order k and what they make of u */
LANES_INLINE void block_learn(const struct jets_system *s, const struct blocks *b, int i, int k) {
    enum { STRIDE = BLOCK_ARMS };
    double *at = blocks_at(b, i);
    size_t now = (size_t)i * s->tile + (size_t)k * STRIDE, next = now + STRIDE, after = next + STRIDE;
    lanes8 order = lanes8_of(k + 1), turn_share = lanes8_of(s->share[k + 1]);
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

/* the root hangs on the pivot, which has i gravity: what that adds to the shifts of the first block */
LANES_INLINE lanes8 blocks_hang(const struct jets_system *s, const struct blocks *b, double gravity) {
    double *root = blocks_at(b, 0) + BLOCK_TENSION * BLOCK_ARMS, lift = s->sine[0] * gravity;
    b->numbers[pend_blocks_place(-1) + BLOCK_TANGENTIAL * BLOCK_ARMS] = gravity;
    if (gravity != 0) *root = lanes1_fma(s->eff[0], lift, *root);
    return (lanes8){lift};
}

/* root to leaves */
static void blocks_down(const struct jets_system *s, const struct blocks *b, double gravity, int k) {
    lanes8 before = lanes8_of(0);
    for (int i = 0; i < b->count; i++) {
        double *at = blocks_at(b, i);
        const struct block_shape *shape = &b->shape[i];
        lanes8 shift = block_tension(b, shape, at);
        if (!i) shift += blocks_hang(s, b, gravity);
        lanes8 radial = block_radial(s, b, shape, at, shift, before);
        block_put(at, BLOCK_RADIAL, radial);
        block_put(at, BLOCK_TANGENTIAL, block_get(at, BLOCK_REST) - block_get(at, BLOCK_LEAN) * radial);
        block_learn(s, b, i, k);
        before = radial;
    }
}

/* all orders: rate_1 .. rate_order and force_0 .. force_{order - 1} from rate_0 and the factorization */
static void blocks_orders(const struct jets_system *s, double gravity, int order) {
    const struct blocks *b = s->blocks;
    jets_factor(s);
    blocks_prepare(s, b);
    for (int i = 0; i < b->count; i++) {
        size_t row = (size_t)i * s->tile;
        lanes8_put(s->turn_re + row + BLOCK_ARMS, lanes8_of(0));
        lanes8_put(s->turn_im + row + BLOCK_ARMS, lanes8_get(s->rate + row));
    }
    for (int k = 0; k < order; k++) {
        blocks_known(s, b, k);
        blocks_up(s, b);
        blocks_down(s, b, k ? 0 : gravity, k);
    }
}

#endif
