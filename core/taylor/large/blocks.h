/* A tree divided into blocks of eight arms: the edges within each block and between blocks.
 * Leaves to others: the arithmetic (blocks_template), memory (jets).
 * Invariant: depends on the tree's shape alone; a block's arms are consecutive in the tree's stored
 * order. */
#pragma once

#include <stddef.h>

#include "core/tree/tree.h"

/*
 * Rows of a block, eight numbers each; forces of an order are divided by k + 1.
 *
 * C_FIRST, Z_FIRST           cosine and sine of each arm's first child, which is the next arm; 0
 *                            if there is none
 * LEAN, NU, TAU, INV, INV_EFF, STIFF, WEIGHT   as in jets_system
 * PART, ACROSS, ALONG, SINE  1, cosine and sine over the length; sine
 * LEAD_UP, LEAD_DOWN         effect on this block of the next block's first arm, and of the last
 *                            block's last arm
 * TR, TI, CR, NEXT_*         T and c of the current order; their known parts of the next order
 * S, SIDE                    known force across each arm; the same with its children's
 * BIAS, PUSH, SWAY           f, h, Z f
 * OTHERS                     sum of Z f over the siblings at crowded joints; else 0
 * REST, TENSION              as in jets_system
 * RADIAL, TANGENTIAL         acceleration of the tip
 * UP, DOWN                   eight rows each: responses of the block's arms to a unit at one of
 * them */
// clang-format off
#define BLOCK_ROWS(X) \
    X(C_FIRST) X(Z_FIRST) X(LEAN) X(NU) X(TAU) X(INV) X(INV_EFF) X(STIFF) X(WEIGHT) X(PART) \
    X(ACROSS) X(ALONG) X(SINE) \
    X(LEAD_UP) X(LEAD_DOWN) X(TR) X(TI) X(CR) X(NEXT_TR) X(NEXT_TI) X(NEXT_CR) X(NEXT_CI) X(S) \
    X(SIDE) X(BIAS) X(PUSH) \
    X(SWAY) X(OTHERS) X(REST) X(TENSION) X(RADIAL) X(TANGENTIAL) X(UP)
// clang-format on

enum {
    BLOCK_ARMS = 8,
    BLOCK_SIBLINGS = 3, /* joints with more children are crowded */
#define X(name) BLOCK_##name,
    BLOCK_ROWS(X)
#undef X
        BLOCK_DOWN = BLOCK_UP + BLOCK_ARMS,
    BLOCK_ROW_COUNT = BLOCK_DOWN + BLOCK_ARMS,
    BLOCK_NUMBERS = BLOCK_ROW_COUNT * BLOCK_ARMS
};

/* A range of a list: index of its first entry, and one past its last. */
struct block_run {
    int first, end;
};

/* The structure of one block; a lane is one of its arms. */
struct block_shape {
    int straight; /* every arm is a child of the one before it, also across the start of the
                   * block */
    int lead;     /* the first arm is a child of the last arm of the block before */
    int rounds;   /* the most siblings of an arm at any joint that is not crowded */
    int parents[BLOCK_ARMS], siblings[BLOCK_SIBLINGS][BLOCK_ARMS]; /* places of the parents and of
                                                                    * all siblings; the pivot's
                                                                    * place fills unused entries */
    struct block_run up;     /* edges from later blocks except the lead */
    struct block_run down;   /* edges to earlier blocks, the lead first */
    struct block_run kids;   /* children of the block's arms that are not first */
    struct block_run joints; /* crowded joints */
};

/* A place is an index into `numbers`: lane i of row 0 of block b has the place b BLOCK_NUMBERS + i.
 * One more block precedes block 0: its last lane is the pivot, its other rows are zero. */
struct blocks {
    int count;       /* number of blocks */
    double *numbers; /* `count` blocks of BLOCK_NUMBERS */
    struct block_shape *shape;
    /* edges between blocks: `up` ordered by their parents' blocks, `down` by their children's */
    int *up_place, *up_arm;     /* of the edge's child */
    int *down_place, *down_arm; /* of the edge's parent and child */
    int *kid_place, *kid_arm;
    unsigned char *up_lane, *kid_lane; /* lane of the parent */
    /* crowded joint i has the children crowd_first[i] .. [i + 1] - 1 */
    int *crowd_first, *crowd_place;
};

/** Returns the bytes that the blocks of a tree need, a multiple of 64. O(n). */
size_t pend_blocks_bytes(const struct pend_tree *tree);

/**
 * Divides a tree into blocks.
 *
 * memory  pend_blocks_bytes(tree) bytes, all zero, aligned to 64; not owned.
 *
 * O(n).
 */
void pend_blocks_init(struct blocks *blocks, const struct pend_tree *tree, void *memory);

/** Returns the index of arm k's first number; -1 is the pivot. */
static inline int pend_blocks_place(int k) {
    return k < 0 ? -BLOCK_NUMBERS + BLOCK_ARMS - 1
                 : k / BLOCK_ARMS * BLOCK_NUMBERS + k % BLOCK_ARMS;
}
