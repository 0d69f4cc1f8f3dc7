/* A chain in pieces of eight arms: the coefficients from which its tensions are computed.
 * Leaves to others: the arithmetic (chain_template), memory (jets), other trees and unequal masses
 * (blocks).
 * Invariant: masses differ so little that differences of tensions keep their digits. */
#pragma once

#include <stddef.h>

#include "core/tree/tree.h"

/*
 * Rows of a piece, eight numbers each. "Next" and "last" are the arm after and the arm before; m is
 * the mass of the arm's own tip; forces of an order are divided by k + 1.
 *
 * MASS, ABOVE                mass of the parent's tip and its inverse; 1 and 0 at the pivot
 * BELOW, PULL, PART          1 / m, -len, 1 / len
 * SPREAD, N, N_LAST          of the effective mass: Z^2 / m_last, N, and N of the last arm
 * KAPPA, MORE, GAIN          factor from one tension to the next; an arm's contribution to the
 *                            diagonal of the inverse; the diagonal
 * LEAN_NEXT, LEAN_LAST       along the arm, the effect of known forces across the neighbours
 * SIDE, SIDE_NEXT, SIDE_LAST on phi'', the effect of known forces across the arm and its neighbours
 * TURN_NEXT, TURN_LAST       on phi'', the effect of the neighbours' tensions
 * BEFORE, AFTER              responses to a unit from the pieces before and from those after
 * ENDS                       four numbers of the piece, below
 * TR, TI, CR, NEXT_*, OLD_*, OLDER_*   T and c of the current order; their known parts of the next
 *                            three orders
 * S                          known force across each arm
 * ASK, KNOWN, MU             right-hand side, known part of phi'', force along the arm
 * GREEN                      eight rows: forces in the piece due to a unit at each of its arms */
// clang-format off
#define CHAIN_ROWS(X) \
    X(MASS) X(ABOVE) X(BELOW) X(PULL) X(PART) X(SPREAD) X(N) X(N_LAST) X(KAPPA) X(MORE) \
    X(GAIN) X(LEAN_NEXT) \
    X(LEAN_LAST) X(SIDE) X(SIDE_NEXT) X(SIDE_LAST) X(TURN_NEXT) X(TURN_LAST) X(BEFORE) \
    X(AFTER) X(ENDS) X(TR) X(TI) \
    X(CR) X(NEXT_TR) X(NEXT_TI) X(NEXT_CR) X(NEXT_CI) X(OLD_TR) X(OLD_TI) X(OLD_CR) X(OLD_CI) \
    X(OLDER_TR) \
    X(OLDER_TI) X(OLDER_CR) X(OLDER_CI) X(S) X(ASK) X(KNOWN) X(MU) X(GREEN)
// clang-format on

enum {
    CHAIN_ARMS = 8,
#define X(name) CHAIN_##name,
    CHAIN_ROWS(X)
#undef X
        CHAIN_ROW_COUNT = CHAIN_GREEN + CHAIN_ARMS,
    CHAIN_NUMBERS = CHAIN_ROW_COUNT * CHAIN_ARMS
};

/* Numbers in row ENDS: how a piece transmits values from before or after it; the effect of its
 * first arm's force on the piece before; and the values from before and from after. */
enum { CHAIN_THROUGH, CHAIN_BACK, CHAIN_FROM_BEFORE, CHAIN_FROM_AFTER };

struct chain {
    int count;       /* number of pieces */
    double *numbers; /* count pieces of CHAIN_NUMBERS, between two pieces of zeros */
};

/** Returns non-zero if the tree is a chain of more than 8 arms with similar masses. O(n). */
int pend_chain_suits(const struct pend_tree *tree);

/** Returns the bytes, a multiple of 64, for the numbers of a chain, whatever its masses. */
size_t pend_chain_bytes(const struct pend_tree *tree);

/** Lays out a chain, whatever its masses, and stores its lengths, which the sums of its orders
 * need; arguments as for pend_chain_init. */
void pend_chain_lay(struct chain *chain, const struct pend_tree *tree, void *memory);

/**
 * Sets the values that do not change from step to step.
 *
 * memory  pend_chain_bytes(tree) bytes, all zero, aligned to 64; not owned.
 */
void pend_chain_init(struct chain *chain, const struct pend_tree *tree, void *memory);
