/* What a real pendulum has beside the series of an ideal one: torques between arms, the
 * acceleration of its pivot, and, of few arms, bodies in place of point masses. The quick kernels
 * take these.
 * Leaves to others: the arithmetic (loads_template, small_loads_template, couples_template),
 * pendulums with anything else (jets_bodies).
 * Invariant: which terms there are decides, not their numbers, so that all members of an ensemble
 * go one way. */
#ifndef PEND_JETS_LOADS_H
#define PEND_JETS_LOADS_H

#include <stddef.h>

#include "core/tree/terms.h"
#include "core/tree/tree.h"

enum {
    LOADS_STRIDE = 16, /* numbers of a row: one of each arm for rates, one for forces across */
    LOADS_MARGIN = 8   /* zeros before and behind the series of the pivot */
};

/*
 * Rows of an order have the numbers of arms where the kernel has them: first as rates, then as
 * forces. Forces are times unit^2.
 *
 * across  row k + 1: the rates of order k + 1 beside the forces across the arms of order k
 * given   row k: less the pivot's acceleration along the first arm over its length, and the known
 *         forces across the arms, torques over lengths
 * drop    row k: less the pivot's acceleration across the first arm over its length
 * loss    row k: what friction adds to the forces across the arms
 * twist   row a: the forces across for a torque of 1 on arm a and its opposite on the parent
 */
#define LOADS_ROWS(X) X(across) X(given) X(drop) X(loss) X(twist)
/*
 * Series of a number an order, with LOADS_MARGIN zeros on either side.
 *
 * lift_x, lift_y    acceleration of the pivot and gravity
 * slide_x, slide_y  velocity of the pivot
 * pivot_force_x, pivot_force_y    the force that the pivot exerts, along the first arm's axes
 */
#define LOADS_SERIES(X) X(lift_x) X(lift_y) X(slide_x) X(slide_y) X(pivot_force_x) X(pivot_force_y)

/*
 * Of trees of more than eight arms with torques between them: numbers a seat, with LOADS_MARGIN
 * zeros on either side. Rates and torques are in units as the series are.
 *
 * hold, stiff   torque for a unit of rate, of angle, to the parent
 * fixed         torque of order 0: the given one, and that of the springs at the start
 * part          1 / length; 0 of an empty seat
 * spin          rates of the order at hand
 * torque        on the arm, its opposite on the parent, order at hand
 */
#define LOADS_SEATS(X) X(hold) X(stiff) X(fixed) X(part) X(spin) X(torque)
/*
 * Series of the same trees, laid out as those of the rates are, behind eight zeros.
 *
 * cross   imaginary parts of the forces in axes that are fixed, whose real parts are in `force`;
 *         of an order that is under way, first what torques do
 * motor   torques of drives
 * slips   rates less those of the parents
 */
#define LOADS_TILES(X) X(cross) X(motor) X(slips)

/* A child that is not its parent's first: its seat, where the parent's series begin, and 1 over the
 * parent's length. */
struct loads_kid {
    size_t row;
    double part;
    int child;
};

/* Of eight seats that follow each other: where their parents and their first children begin, if
 * these follow each other too; else LOADS_APART. */
enum { LOADS_APART = -1000000000 };
struct loads_tile {
    int parent, child;
};

struct bodies_system;

struct jets_loads {
    const struct pend_terms *terms;
    const double *value;  /* of the terms, those of the expansion at hand */
    double unit;          /* of time, of that expansion */
    int couples;          /* torques act between arms */
    int shaped;           /* masses are not all points at tips */
    int springs, losses;  /* among them those of springs and of friction */
    int drives, moves;    /* harmonics among the torques; the pivot moves */
    double drag_per_mass; /* drag_per_mass: 2 gamma in units, of the expansion at hand */
    int orders;           /* of the forces, whose real parts in fixed axes stand where lambda will;
                           * of bodies those of G over the arms' lengths, but for order 0 */
    struct bodies_system *bodies; /* of masses that are not points at tips, of arms that hang
                                   * elsewhere, or with drag per mass: their numbers and
                                   * factorization; else NULL */
    double *bend;                 /* angles to the parents, of the first arm to the vertical */
    int seats;           /* of a tree of more than eight arms, empty ones included; else 0 */
    const int *seat;     /* of an arm; NULL = arms sit in stored order */
    int *parent, *child; /* seats of an arm's parent and of its first child; -1 = none */
    struct loads_tile *near;
    struct loads_kid *kid;
    int kids;
#define X(name) double *name;
    LOADS_ROWS(X) LOADS_SERIES(X) LOADS_SEATS(X) LOADS_TILES(X)
#undef X
};

/* Where the arms of a tree sit in its series. */
struct loads_seats {
    int count, rows; /* seats, a multiple of 8; rows of a tile of the series */
    const int *seat; /* of an arm; NULL = arms sit in stored order */
};

/**
 * Non-zero if the quick kernels know all terms of a pendulum of points: masses at the tips of
 * massless arms, at which the other arms hang, with springs, viscous friction and torques in the
 * joints and a pivot that moves as it is told, and nothing else. O(1).
 */
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

/** Non-zero if row r of the terms says where masses are, or where arms hang. O(1). */
static inline int jets_loads_shape(int r) {
    return r == PEND_TERM_ROD || r == PEND_TERM_BODY || r == PEND_TERM_CENTER_X ||
           r == PEND_TERM_CENTER_Y || r == PEND_TERM_INERTIA || r == PEND_TERM_AT_X ||
           r == PEND_TERM_AT_Y;
}

/** Non-zero if masses of a real pendulum are not all points at tips, arms hang elsewhere, or there
 * is drag per mass. O(1). */
static inline int jets_loads_bodies(const struct pend_terms *terms) {
    for (int r = 0; r < PEND_TERM_ROWS; r++)
        if (terms->row[r] >= 0 && jets_loads_shape(r)) return 1;
    return terms->one[PEND_TERM_DRAG_PER_MASS] >= 0;
}

/** Non-zero if the quick kernels of one tree take it: of more than eight arms those of points.
 * O(1).
 */
static inline int jets_loads_suit(const struct pend_tree *tree, const struct pend_terms *terms) {
    if (tree->n > 8) return jets_loads_known(terms);
    struct pend_terms points = *terms; // what would be left with points at the tips, in no air
    points.one[PEND_TERM_DRAG_PER_MASS] = -1;
    for (int r = 0; r < PEND_TERM_ROWS; r++)
        if (jets_loads_shape(r)) points.row[r] = -1;
    return jets_loads_known(&points);
}

/**
 * Returns the bytes of memory that the loads of a pendulum need, a multiple of 64. O(1).
 *
 * seats  their number and rows; `seat` is not read.
 */
size_t pend_jets_loads_bytes(const struct pend_tree *tree, const struct pend_terms *terms,
                             int order_cap, const struct loads_seats *seats);

/**
 * Lays out the loads of a pendulum.
 *
 * terms   known to the quick kernels; must outlive the loads, as `seats->seat` must.
 * memory  pend_jets_loads_bytes bytes, all zero, aligned to 64; not owned.
 *
 * O(n).
 */
void pend_jets_loads_init(struct jets_loads *loads, const struct pend_tree *tree,
                          const struct pend_terms *terms, int order_cap,
                          const struct loads_seats *seats, void *memory);

#endif
