/* A chain of rods, joined at tips, in pieces of eight arms: the coefficients from which its forces
 * are computed.
 * Leaves to others: the arithmetic (rods_table_template, rods_template), the sums of an order
 * (chain), other trees and unequal masses (core/bodies).
 * Invariant: masses differ so little that differences of forces keep their digits. */
#pragma once

#include <stddef.h>

#include "core/taylor/large/chain.h"
#include "core/tree/loads.h"
#include "core/tree/tree.h"

/*
 * Rows of a piece, eight numbers each. An arm of mass M, first moment h and inertia J about its
 * joint is equivalent to a mass h / l at its tip, M - h / l at its joint and an inertia J' = J -
 * h l, which is negative for a uniform bar. J', J and the other inertias are divided by l^2 here,
 * and masses are in units of 1 / `scale`, except those of the orders.
 *
 * TIP, JOINT, WHOLE      h / l, M - h / l, M
 * NEAR, FAR, TWIST       inertias about the joint and about the tip, J'
 * SPREAD                 M times the inertia about the center
 * NODE                   mass at the joint: the arm's own JOINT and TIP of the arm before it
 * VOID                   1 in a lane without an arm
 * SHARE                  the part of the mass at the tip that the force at the tip does not include
 * RESIST, WIND           for the orders: J' / l^2, J' / l
 * SQUARE_C, SQUARE_Z, MIXED, TWICE  C^2, Z^2, C Z, C^2 - Z^2
 * HUNG_*                 the form of the chain below the tip, five numbers (rods_form)
 * HELD_*                 the form of the chain above the joint
 * LINE_LINE, LINE_SIDE   force along the arm per unit of acceleration along it and of known force
 * SIDE_SIDE              acceleration across it per unit of known force
 * BACK_*                 of the piece's first arm: effect of its force on the piece before
 * ON_*                   force along, and acceleration across, per unit of the force along and
 *                        across the arm before it
 * BEFORE_*, AFTER_*      the same of all arms of the piece, for values from the pieces before and
 *                        after it, in the order of ON
 * ENDS                   numbers of the piece, below
 * ASK, KNOWN             of the current order: required acceleration along the arm, known force
 *                        across it
 * MU, WAY                force along the arm, acceleration across it
 * GREEN                  four times eight rows: MU, then WAY, per unit of each arm's ASK and KNOWN
 */
// clang-format off
#define RODS_ROWS(X) \
    X(TIP) X(JOINT) X(WHOLE) X(NEAR) X(FAR) X(TWIST) X(SPREAD) X(NODE) X(VOID) X(SHARE) X(RESIST) \
    X(WIND) X(SQUARE_C) X(SQUARE_Z) X(MIXED) X(TWICE) \
    X(HUNG_D) X(HUNG_XX) X(HUNG_XY) X(HUNG_YY) X(HUNG_N) \
    X(HELD_D) X(HELD_XX) X(HELD_XY) X(HELD_YY) X(HELD_N) \
    X(LINE_LINE) X(LINE_SIDE) X(SIDE_SIDE) X(BACK_XX) X(BACK_XY) X(BACK_YY) \
    X(ON_XX) X(ON_XY) X(ON_YX) X(ON_YY) \
    X(BEFORE_XX) X(BEFORE_XY) X(BEFORE_YX) X(BEFORE_YY) \
    X(AFTER_XX) X(AFTER_XY) X(AFTER_YX) X(AFTER_YY) \
    X(ENDS) X(ENDS_MORE) X(ASK) X(KNOWN) X(MU) X(WAY) X(GREEN)
// clang-format on

enum {
#define X(name) RODS_##name,
    RODS_ROWS(X)
#undef X
        RODS_ROW_COUNT = RODS_GREEN + 4 * CHAIN_ARMS,
    RODS_NUMBERS = RODS_ROW_COUNT * CHAIN_ARMS
};

/* Offsets in row ENDS and the next. THROUGH: 2 x 2 matrix for values from the piece before; its
 * transpose is for values from the piece after. BACK: effect of the first arm's force on the piece
 * before. FROM_BEFORE, FROM_AFTER: the values, two each. */
enum { RODS_THROUGH = 0, RODS_BACK = 4, RODS_FROM_BEFORE = 8, RODS_FROM_AFTER = 10 };

struct rods {
    int count; /* number of pieces */
    double scale;
    double *numbers; /* count pieces of RODS_NUMBERS, between two pieces of zeros */
};

/** Returns non-zero if the terms permit the form for rods: a chain of more than 8 arms joined at
 * tips, with rods or bodies and otherwise only terms that the fast kernels support. O(n). */
int pend_rods_known(const struct pend_tree *tree, const struct pend_terms *terms);

/** Returns non-zero if the values are suitable too: centers of mass on the arms, between joint and
 * tip, similar masses at the joints, and no arm close to a single point mass. O(n). */
int pend_rods_suit(const struct pend_tree *tree, const struct pend_loads *loads);

/** Returns the bytes for the numbers of a chain of rods and of its chain, a multiple of 64. */
size_t pend_rods_bytes(const struct pend_tree *tree);

/**
 * Sets the values that do not change from step to step.
 *
 * chain   out: of the tree, used only for the sums of the orders.
 * memory  pend_rods_bytes(tree) bytes, all zero, aligned to 64; not owned.
 */
void pend_rods_init(struct rods *rods, struct chain *chain, const struct pend_tree *tree,
                    const struct pend_loads *loads, void *memory);
