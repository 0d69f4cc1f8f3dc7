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
    TILE_INPUTS = 2, /* rows of eight inputs: moments, and kr */
    TILE_ROOT = 2,
    TILE_PORT = 3,                /* outputs of a root and of a port */
    TILE_ANSWERS = 2 * TILE_ARMS, /* chi of its arms, and Re G */
    TILE_LEAN = 4 /* what a port's kids add to its Re G for a unit of a, kr, m / D */
};

/*
 * A root is an arm that hangs on no arm of its tile, a port one that carries arms of other tiles,
 * its kids. What a tile tells others, its outputs, are the forces that its roots ask of their
 * bases, two numbers each, and of its ports the acceleration of the base, two numbers, and m / D.
 */
struct tile {
    int first, arms, root, roots, port, ports; /* the first of each, and how many there are */
    int outs;                                  /* outputs, padded to a row of eight */
    size_t columns, sway, gain, state;         /* where its numbers begin */
};

/*
 * The numbers of a tile:
 *
 * columns  of each input: the answers of the arms, and the outputs
 * sway     of each output: the answers of the arms to the acceleration of a root's base, and to
 *          what kids ask of a port: a force, and its moment
 * gain     of each port the matrix from the acceleration of its root's base to that of its own, and
 *          TILE_LEAN; then of each of the ports' outputs what each of these makes of it
 * state    of the order at hand: the inputs, the answers, the outputs
 */
struct tiles {
    int count; /* tiles */
    struct tile *tile;
    int *root, *port; /* arms */
    int *port_root;   /* which of its tile's roots a port hangs on */
    int *kid_first,
        *kid; /* the kids of port i are kid[kid_first[i]] .. kid[kid_first[i + 1] - 1] */
    double *numbers;
};

/** Returns non-zero if tiles gain: 9 to 40 arms, and no tile has more outputs than a row
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
