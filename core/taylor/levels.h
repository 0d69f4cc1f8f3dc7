/* A bushy tree by height: leaves first, layer after layer, each in blocks of eight arms that do not touch each other.
 * Leaves to others: the arithmetic (layers_kernel), memory (jets), trees that are deep or crowded (blocks).
 * Invariant: depends on the tree's shape alone; an arm's first child, one of its highest, has the arm's own lane. */
#ifndef PEND_LEVELS_H
#define PEND_LEVELS_H

#include <stddef.h>

#include "core/tree/tree.h"

/*
 * Rows of a block, eight numbers each.
 *
 * WEIGHT .. STIFF     as in jets_system; GRIP: Z, and C times the parent's lean; PART: 1 over the length
 * KNOWN               known force across each arm, over the order
 * BIAS, PUSH          f, h
 * ASKED, GIVEN        what the parent adds to its h for the arm, and takes from its known force for it
 * FIRST               known force less what the children but the first take: what the first feels across; before the
 *                     orders it holds m and sums of S Z^2, FIRST_LEAN sums of S C Z, of the same children
 * RADIAL, TANGENTIAL  acceleration of the tip; before it is known TANGENTIAL holds what stays of it
 * MASS, LENGTH, EFF   for the factorization
 */
// clang-format off
#define LAYER_ROWS(X) \
    X(WEIGHT) X(KAPPA) X(GRIP) X(COSINE) X(SINE) X(LEAN) X(INV) X(NU) X(TAU) X(INV_EFF) X(PART) X(STIFF) \
    X(KNOWN) X(BIAS) X(PUSH) X(ASKED) X(GIVEN) X(FIRST) X(FIRST_LEAN) \
    X(RADIAL) X(TANGENTIAL) X(MASS) X(LENGTH) X(EFF)
// clang-format on

enum {
    LAYER_ARMS = 8,
    LAYERS_MAX = 64,      /* layers: trees with more are left to blocks */
    LAYERS_CHILDREN = 16, /* of one arm: the same */
    LAYERS_CHANGES = 4,
#define X(name) LAYER_##name,
    LAYER_ROWS(X)
#undef X
        LAYER_ROW_COUNT,
    LAYER_NUMBERS = LAYER_ROW_COUNT * LAYER_ARMS,
    LAYER_TABLE = 2 * LAYER_ARMS
};

/* A place is an index from `numbers`: of lane i of block b it is b LAYER_NUMBERS + i. */
struct layer_block {
    int leaves;              /* nothing hangs on any of its arms */
    int below, above;        /* the blocks of its arms' first children, and of the parents of its first children */
    int first, end;          /* its joints' further children, by rank */
    int aligned;             /* all of its arms are first children, and no lane is empty */
    int parents[LAYER_ARMS]; /* places; the pivot's for an empty lane */
    int shares[LAYER_ARMS];  /* places of what the arms feel across */
};

/* Children of one rank, eight joints in lanes: their places, the pivot's where there is none. */
struct layer_rank {
    int children[LAYER_ARMS];
};

/* The last block is the cap: the topmost arms, parents before children, which may hang on each other. One more block,
 * after the last, is the pivot's. */
struct layers {
    int count, ranks;
    double *numbers;   /* count + 1 blocks of LAYER_NUMBERS, and two rows a rank */
    double *up, *down; /* answers of the cap's arms to a unit at each of them */
    struct layer_block *block;
    struct layer_rank *rank;
    int *seat; /* of arm k: 8 times its block, and its lane; padded to whole vectors, with seats in the row of zeros */
    int *arm;  /* of a seat; -1 where it is empty */
    double *change[LAYERS_CHANGES]; /* of a seat: room for what a state changes by, and a row of zeros */
};

/** Blocks that a tree has in layers; 0 where it has too many layers, crowded joints, or layers too narrow. O(n). */
int pend_layers_count(const struct pend_tree *tree);

/** Bytes that the layers of a tree need, a multiple of 64. O(n). */
size_t pend_layers_bytes(const struct pend_tree *tree);

/**
 * Cuts a tree for which pend_layers_count(tree) is not 0.
 *
 * memory  pend_layers_bytes(tree) bytes, all zero, aligned to 64; not owned.
 * O(n).
 */
void pend_layers_init(struct layers *layers, const struct pend_tree *tree, void *memory);

/** Where the rows of the ranks begin, two a rank, to be found in place of FIRST and FIRST_LEAN. */
static inline int pend_layers_table(int count) { return (count + 1) * LAYER_NUMBERS; }

/** The place of a seat. */
static inline int pend_layers_place(int seat) { return seat / LAYER_ARMS * LAYER_NUMBERS + seat % LAYER_ARMS; }

#endif
