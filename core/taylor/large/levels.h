/* A bushy tree by height: leaves first, level after level, each in blocks of eight independent
 * arms.
 * Leaves to others: the arithmetic (levels_template), memory (jets), deep or crowded trees
 * (blocks).
 * Invariant: depends on the tree's shape alone; an arm's first child, one of its highest, has
 * the arm's own lane. */
#ifndef PEND_LEVELS_H
#define PEND_LEVELS_H

#include <stddef.h>

#include "core/tree/tree.h"

/*
 * Rows of a block, eight numbers each; forces of an order are divided by k + 1.
 *
 * WEIGHT .. STIFF     as in jets_system; GRIP: Z, and C times the parent's lean; PART: 1 / length
 * KNOWN               known force across each arm
 * BIAS, PUSH          f, h
 * ASKED, GIVEN        the arm's contributions to the parent's h and known force
 * FIRST               force across the first child: the known force minus the contributions of the
 *                     other children. Before the orders FIRST holds m and sums of S Z^2,
 *                     FIRST_LEAN sums of S C Z, of the other children
 * RADIAL, TANGENTIAL  acceleration of the tip; before it is known, the known part of TANGENTIAL
 * MASS, LENGTH, EFF   for the factorization
 */
// clang-format off
#define LEVEL_ROWS(X) \
    X(WEIGHT) X(KAPPA) X(GRIP) X(COSINE) X(SINE) X(LEAN) X(INV) X(NU) X(TAU) X(INV_EFF) \
    X(PART) X(STIFF) \
    X(KNOWN) X(BIAS) X(PUSH) X(ASKED) X(GIVEN) X(FIRST) X(FIRST_LEAN) \
    X(RADIAL) X(TANGENTIAL) X(MASS) X(LENGTH) X(EFF)
// clang-format on

enum {
    LEVEL_ARMS = 8,
    LEVELS_MAX = 64,      /* levels; deeper trees use blocks */
    LEVELS_CHILDREN = 16, /* children of one arm; trees with more use blocks */
    LEVELS_CHANGES = 4,
#define X(name) LEVEL_##name,
    LEVEL_ROWS(X)
#undef X
        LEVEL_ROW_COUNT,
    LEVEL_NUMBERS = LEVEL_ROW_COUNT * LEVEL_ARMS,
    LEVEL_TABLE = 2 * LEVEL_ARMS
};

/* A place is an index from `numbers`: for lane i of block b it is b LEVEL_NUMBERS + i. */
struct level_block {
    int leaves;       /* all of its arms are leaves */
    int below, above; /* the blocks of its arms' first children, and of the parents of its first
                       * children */
    int first, end;   /* its joints' further children, by rank */
    int aligned;      /* all of its arms are first children, and no lane is empty */
    int parents[LEVEL_ARMS]; /* places; the pivot's for an empty lane */
    int shares[LEVEL_ARMS];  /* places of the forces across the arms */
};

/* Children of one rank, eight joints in lanes: their places; the pivot's if there is none. */
struct level_rank {
    int children[LEVEL_ARMS];
};

/* The last block is the cap: the topmost arms, parents before children, which may be connected. One
 * more block, after the last, is the pivot's. */
struct levels {
    int count, ranks;
    double *numbers;   /* count + 1 blocks of LEVEL_NUMBERS, and two rows per rank */
    double *up, *down; /* responses of the cap's arms to a unit at each of them */
    struct level_block *block;
    struct level_rank *rank;
    int *seat; /* of arm k: 8 times its block, and its lane; padded to whole vectors, with seats in
                * the row of zeros */
    int *arm;  /* of a seat; -1 if it is empty */
    double *change[LEVELS_CHANGES]; /* of a seat: space for the changes of a state, and a row of
                                     * zeros */
};

/** Returns the number of blocks of a tree in levels; 0 if the tree has too many levels, crowded
 * joints, or too narrow levels. O(n). */
int pend_levels_count(const struct pend_tree *tree);

/** Returns the bytes that the levels of a tree need, a multiple of 64. O(n). */
size_t pend_levels_bytes(const struct pend_tree *tree);

/**
 * Divides a tree for which pend_levels_count(tree) is not 0.
 *
 * memory  pend_levels_bytes(tree) bytes, all zero, aligned to 64; not owned.
 * O(n).
 */
void pend_levels_init(struct levels *levels, const struct pend_tree *tree, void *memory);

/** Returns the start of the rows of the ranks, two per rank, which replace FIRST and FIRST_LEAN. */
static inline int pend_levels_table(int count) { return (count + 1) * LEVEL_NUMBERS; }

/** Returns the place of a seat. */
static inline int pend_levels_place(int seat) {
    return seat / LEVEL_ARMS * LEVEL_NUMBERS + seat % LEVEL_ARMS;
}

#endif
