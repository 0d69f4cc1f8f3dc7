/* A tree cut into blocks of eight arms: which arms of a block hang on each other, and what joins one block to another.
 * Leaves to others: the arithmetic (blocks_kernel), memory (jets).
 * Invariant: depends on the tree's shape alone; a block's arms follow each other in the tree's stored order. */
#ifndef PEND_BLOCKS_H
#define PEND_BLOCKS_H

#include <stddef.h>

#include "core/tree.h"

/*
 * Rows of a block, eight numbers each.
 *
 * C_ONLY, Z_ONLY             cosine and sine of the next arm where it is the only child, else 0
 * LEAN, NU, TAU, INV, INV_EFF, STIFF, WEIGHT   as in jets_system
 * PART, ACROSS, ALONG        1, cosine and sine over the length
 * LEAD_UP, LEAD_DOWN         what the next block's first arm does to this block, what the last block's last arm does
 * TR, TI, CR, S              T and c of the order at hand, Im c over the order
 * NEXT_*                     the same of the order after, as far as known
 * SUM_COS, SUM_SIN, SUM_SIDE sums over the children of joints with several: of C s, Z s and Z f; else 0
 * OTHERS                     sum of Z f over the siblings
 * SIDE, PULL, BIAS           known force across, its share along less the heave, f
 * HEAVE, TENSION, SHIFT, REST, RADIAL, TANGENTIAL   as in jets_system
 * UP, DOWN                   eight rows each: answers of the block's arms to a unit at one of them
 */
// clang-format off
#define BLOCK_ROWS(X) \
    X(C_ONLY) X(Z_ONLY) X(LEAN) X(NU) X(TAU) X(INV) X(INV_EFF) X(STIFF) X(WEIGHT) X(PART) X(ACROSS) X(ALONG) X(LEAD_UP) \
    X(LEAD_DOWN) X(TR) X(TI) X(CR) X(S) X(NEXT_TR) X(NEXT_TI) X(NEXT_CR) X(NEXT_CI) X(SUM_COS) X(SUM_SIN) X(SUM_SIDE) \
    X(OTHERS) X(SIDE) X(PULL) X(BIAS) X(HEAVE) X(TENSION) X(SHIFT) X(REST) X(RADIAL) X(TANGENTIAL) X(UP)
// clang-format on

enum {
    BLOCK_ARMS = 8,
#define X(name) BLOCK_##name,
    BLOCK_ROWS(X)
#undef X
        BLOCK_DOWN = BLOCK_UP + BLOCK_ARMS,
    BLOCK_ROW_COUNT = BLOCK_DOWN + BLOCK_ARMS,
    BLOCK_NUMBERS = BLOCK_ROW_COUNT * BLOCK_ARMS
};

/* The structure of one block; lanes count its arms. */
struct block_shape {
    int straight;                     /* every arm hangs on the one before it, the first on the last block's last */
    int lead;                         /* the first arm does so */
    signed char inside[BLOCK_ARMS];   /* lane of the parent, -1 = in another block */
    int parent[BLOCK_ARMS];           /* place of the parent */
    int up_first, up_end;             /* edges that end here, of later blocks */
    int down_first, down_end;         /* edges that begin here, to earlier blocks */
};

/* A place is an index from `numbers` in steps of one number, of lane i of block b in its row 0: b BLOCK_NUMBERS + i.
 * Before block 0 is one more, whose last lane is the pivot. */
struct blocks {
    int count;                /* blocks */
    int edges;                /* between blocks, without those of lead */
    int joints;               /* with several children */
    double *numbers;          /* count blocks of BLOCK_NUMBERS */
    double *edge_up, *edge_down; /* rows, one an edge */
    struct block_shape *shape;
    int *up_place, *down_place; /* of the child, of the parent: where an edge's number comes from */
    int *up_arm, *down_arm;     /* the child's number, both in the edge's order */
    int *joint, *first; /* place of joint i; its kids are first[i] .. first[i + 1] - 1 */
    int *kid, *kid_arm; /* their places, and their numbers */
};

/** Bytes that the blocks of a tree need, a multiple of 64. O(n). */
size_t pend_blocks_bytes(const struct pend_tree *tree);

/**
 * Cuts a tree.
 *
 * memory  pend_blocks_bytes(tree) bytes, all zero, aligned to 64; not owned.
 * O(n).
 */
void pend_blocks_init(struct blocks *blocks, const struct pend_tree *tree, void *memory);

/** The place of arm k. */
static inline int pend_blocks_place(int k) { return k < 0 ? -BLOCK_NUMBERS + BLOCK_ARMS - 1 : k / BLOCK_ARMS * BLOCK_NUMBERS + k % BLOCK_ARMS; }

#endif
