/* A tree of bodies cut into tiles of eight arms that follow each other in its stored order: which
 * arms join one tile to another, and the memory of the tiles' tables.
 * Leaves to others: the arithmetic (tiles_template, tiles_orders_template), other numbers than
 * doubles (bodies_template).
 * Invariant: depends on the tree's shape alone. */
#ifndef PEND_TILES_H
#define PEND_TILES_H

#include <stddef.h>

#include "core/tree/tree.h"

enum {
    TILE_ARMS = 8,
    TILE_INPUTS = 2,             /* rows of eight inputs: moments, and kr */
    TILE_OUT = 2,                /* numbers of an output */
    TILE_ANSWERS = 2 * TILE_ARMS /* chi of its arms, and Re G */
};

/*
 * A root is an arm that hangs on no arm of its tile, a kid one of another tile that hangs on an arm
 * of this one. What a tile tells others, its outputs, are the forces that its roots ask of their
 * bases and the accelerations of its kids' bases, two numbers each.
 */
struct tile {
    int first, arms, root, roots, kid, kids; /* the first of each, and how many there are */
    size_t columns, sway, gain, state;       /* where its numbers begin */
};

/*
 * The numbers of a tile:
 *
 * columns  of each input: the answers of the arms, and a row of outputs
 * sway     of each output's opposite: the answers of the arms to the acceleration of a root's base,
 *          and to the force that a kid asks
 * gain     of each kid the matrix from the acceleration of its tile's root's base to that of its
 *          own, TILE_OUT^2; then what the force that each kid asks makes of all kids' outputs
 * state    of the order at hand: the inputs, the answers, the outputs
 */
struct tiles {
    int count; /* tiles */
    struct tile *tile;
    int *root, *kid; /* arms */
    int *kid_root;   /* the root that the arm hangs on that carries a kid */
    double *numbers;
};

/** Returns non-zero if tiles gain: 9 to 256 arms, and no tile has more outputs than a row
 * holds, as those of chains and of trees of few long limbs. O(n). */
int pend_tiles_suit(const struct pend_tree *tree);

/** Bytes that the tiles of a tree need that suits, a multiple of 64. O(n). */
size_t pend_tiles_bytes(const struct pend_tree *tree);

/**
 * Cuts a tree.
 *
 * memory  pend_tiles_bytes bytes, all zero, aligned to 64; not owned.
 *
 * O(n).
 */
void pend_tiles_init(struct tiles *tiles, const struct pend_tree *tree, void *memory);

#endif
