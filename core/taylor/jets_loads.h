/* The loads of a real pendulum that the fast kernels support: torques between arms, the
 * acceleration of its pivot, and, for few arms, bodies instead of point masses.
 * Leaves to others: the arithmetic (loads_template, small_loads_template, couples_template),
 * pendulums with other terms (jets_bodies).
 * Invariant: the choice depends on which terms are present, not on their values, so that all
 * members of an ensemble use one kernel. */
#pragma once

#include <stddef.h>

#include "core/tree/terms.h"
#include "core/tree/tree.h"

enum {
    LOADS_STRIDE = 16, /* numbers in a row: up to 8 rates, then up to 8 forces across */
    LOADS_MARGIN = 8   /* number of zeros before and after the series of the pivot */
};

/*
 * A row has one order of all arms, laid out as the kernel reads it: first rates, then forces.
 * Forces are multiplied by unit^2.
 *
 * across  row k + 1: the rates of order k + 1 next to the forces across the arms of order k
 * given   row k: minus the pivot's acceleration along the first arm over its length, and the known
 *         forces across the arms, torques over lengths
 * drop    row k: minus the pivot's acceleration across the first arm over its length
 * loss    row k: the contribution of friction to the forces across the arms
 * twist   row a: the forces across for a torque of 1 on arm a and its opposite on the parent */
#define LOADS_ROWS(X) X(across) X(given) X(drop) X(loss) X(twist)
/* Series with one number per order, with LOADS_MARGIN zeros on either side.
 *
 * lift_x, lift_y    acceleration of the pivot minus that of gravity
 * slide_x, slide_y  velocity of the pivot
 * pivot_force_x, pivot_force_y    the force that the pivot exerts, along the first arm's axes */
#define LOADS_SERIES(X) X(lift_x) X(lift_y) X(slide_x) X(slide_y) X(pivot_force_x) X(pivot_force_y)

/*
 * For trees of more than eight arms with torques between them: one number per arm, with
 * LOADS_MARGIN zeros on either side. Rates and torques are in the units of the series.
 *
 * hold, stiff   torque per unit of rate and per unit of angle, relative to the parent
 * fixed         torque of order 0: the given one, and that of the springs at the start
 * part          1 / length; 0 in the padding
 * spin          rates of the current order
 * torque        of the current order on the arm; the opposite acts on the parent */
#define LOADS_ARMS(X) X(hold) X(stiff) X(fixed) X(part) X(spin) X(torque)
/*
 * Series of trees of more than eight arms, laid out as the rates are, after eight zeros.
 *
 * cross   imaginary parts of the forces in fixed axes, whose real parts are in `force`; while an
 *         order is computed, at first only the contribution of torques
 * motor   torques of drives
 * slips   rates minus those of the parents */
#define LOADS_TILES(X) X(cross) X(motor) X(slips)

/* A child other than its parent's first: its index, the start of the parent's series, and 1 over
 * the parent's length. */
struct loads_kid {
    size_t row;
    double part;
    int child;
};

/* For eight consecutive arms: the indices at which their parents and their first children begin, if
 * these are consecutive too; otherwise LOADS_APART. */
enum { LOADS_APART = -1000000000 };
struct loads_tile {
    int parent, child;
};

struct bodies_system;

struct jets_loads {
    const struct pend_terms *terms;
    const double *value;  /* values of the terms, for the current expansion */
    double unit;          /* unit of time in the current expansion */
    int couples;          /* there are torques between arms */
    int shaped;           /* not all masses are points at the tips */
    int springs, losses;  /* springs act in joints; friction acts in joints */
    int drives, moves;    /* harmonics drive torques; the pivot moves */
    double drag_per_mass; /* 2 gamma in units, for the current expansion */
    int orders;           /* the number of orders in which `force` has real parts in fixed axes
                           * instead of lambda; for bodies, G over the arms' lengths, except in
                           * order 0 */
    struct bodies_system *bodies; /* values and factorization if there are masses other than points
                                   * at tips, arms attached elsewhere, or drag per mass; otherwise
                                   * NULL */
    double *bend;                 /* angles to the parents; of the first arm to the vertical */
    int padded;                   /* number of arms of a tree of more than eight, with padding;
                                   * otherwise 0 */
    int *parent, *child;          /* an arm's parent and its first child; -1 = none */
    struct loads_tile *near;
    struct loads_kid *kid;
    int kids;
#define X(name) double *name;
    LOADS_ROWS(X) LOADS_SERIES(X) LOADS_ARMS(X) LOADS_TILES(X)
#undef X
};

/* The layout of the series of a tree: number of arms with padding, a multiple of 8; number of rows
 * in a tile. */
struct loads_layout {
    int padded, rows;
};

/** Returns non-zero if the fast kernels support all terms of a pendulum of point masses: masses at
 * the tips of massless arms, children at tips, springs, viscous friction and torques in the joints,
 * and a moving pivot, but nothing else. O(1). */
static inline int jets_loads_known(const struct pend_terms *terms) {
    for (int r = 0; r < PEND_TERM_ROWS; r++)
        if (terms->row[r] >= 0 && r != PEND_TERM_DAMPING && r != PEND_TERM_STIFFNESS &&
            r != PEND_TERM_REST && r != PEND_TERM_TORQUE)
            return 0;
    for (int i = 0; i < PEND_TERM_ONES; i++)
        if (terms->one[i] >= 0 && i != PEND_TERM_PIVOT_ACCELERATION_X &&
            i != PEND_TERM_PIVOT_ACCELERATION_Y)
            return 0;
    return 1;
}

/** Returns non-zero if row r of the terms sets the position of masses or of joints. O(1). */
static inline int jets_loads_shape(int r) {
    return r == PEND_TERM_ROD || r == PEND_TERM_BODY || r == PEND_TERM_CENTER_X ||
           r == PEND_TERM_CENTER_Y || r == PEND_TERM_INERTIA || r == PEND_TERM_AT_X ||
           r == PEND_TERM_AT_Y;
}

/** Returns non-zero if some masses of a real pendulum are not points at tips, some arms are
 * attached elsewhere, or there is drag per mass. O(1). */
static inline int jets_loads_bodies(const struct pend_terms *terms) {
    for (int r = 0; r < PEND_TERM_ROWS; r++)
        if (terms->row[r] >= 0 && jets_loads_shape(r)) return 1;
    return terms->one[PEND_TERM_DRAG_PER_MASS] >= 0;
}

/** Returns non-zero if the fast kernels for a single tree support it; with more than eight arms
 * they support only point masses. O(1). */
static inline int jets_loads_suit(const struct pend_tree *tree, const struct pend_terms *terms) {
    if (tree->n > 8) return jets_loads_known(terms);
    struct pend_terms points = *terms; // `terms` with masses at the tips and without drag
    points.one[PEND_TERM_DRAG_PER_MASS] = -1;
    // an input of a piece is a torque too; its work and heat are known if the pivot is at rest
    if (terms->one[PEND_TERM_DRAG_PER_MASS] < 0 && terms->one[PEND_TERM_PIVOT_ACCELERATION_X] < 0 &&
        !(terms->harmonics && terms->harmonic[0].drives < 0)) {
        points.row[PEND_TERM_INPUT] = points.row[PEND_TERM_INPUT_RATE] = -1;
        points.row[PEND_TERM_SLIDE] = points.one[PEND_TERM_PIECE] = -1;
    }
    for (int r = 0; r < PEND_TERM_ROWS; r++)
        if (jets_loads_shape(r)) points.row[r] = -1;
    return jets_loads_known(&points);
}

/** Returns the number of orders in which the given torques are not 0. O(1). */
static inline int jets_loads_torques(const struct jets_loads *loads, int order) {
    const int *row = loads->terms->row;
    if (loads->drives) return order;
    if (row[PEND_TERM_INPUT] >= 0) return 2;
    return row[PEND_TERM_TORQUE] >= 0 || row[PEND_TERM_SLIDE] >= 0;
}

/** Returns the bytes of memory for the loads of a pendulum, a multiple of 64. O(1). */
size_t pend_jets_loads_bytes(const struct pend_tree *tree, const struct pend_terms *terms,
                             int order_cap, const struct loads_layout *layout);

/**
 * Places the loads of a pendulum in memory.
 *
 * terms   supported by the fast kernels; must outlive the loads.
 * memory  pend_jets_loads_bytes bytes, all zero, aligned to 64; not owned.
 *
 * O(n).
 */
void pend_jets_loads_init(struct jets_loads *loads, const struct pend_tree *tree,
                          const struct pend_terms *terms, int order_cap,
                          const struct loads_layout *layout, void *memory);
