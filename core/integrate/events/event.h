/* Conditions on a motion and their passages, as requested and as reported.
 * Leaves to others: finding passages (event_search).
 * Invariant: arms are counted in stored order. */
#pragma once

#include "core/integrate/events/section.h"

/* The quantity of a condition. */
enum pend_quantity {
    PEND_QUANTITY_PHI,       /* rad, of an arm; m, of a cart */
    PEND_QUANTITY_THETA,     /* rad, from the vertical, with the digits of a small swing */
    PEND_QUANTITY_RATE,      /* rad/s, of an arm */
    PEND_QUANTITY_FORCE,     /* N, lambda of an arm */
    PEND_QUANTITY_X,         /* m, of a tip */
    PEND_QUANTITY_Y,         /* m, of a tip */
    PEND_QUANTITY_DISTANCE,  /* m, between two tips */
    PEND_QUANTITY_KINETIC,   /* J, kinetic energy of the whole pendulum */
    PEND_QUANTITY_POTENTIAL, /* J, of gravity and springs */
    PEND_QUANTITY_ENERGY,    /* J, sum of the kinetic and the potential energy */
    PEND_QUANTITIES,
    PEND_QUANTITY_IMPACT = PEND_QUANTITIES /* impact of a joint on its stop, reported before and
                                            * after it; up: the upper stop */
};

/** Returns non-zero if a quantity belongs to the whole pendulum. */
static inline int pend_quantity_energy(enum pend_quantity quantity) {
    return quantity >= PEND_QUANTITY_KINETIC && quantity <= PEND_QUANTITY_ENERGY;
}

struct pend_event {
    enum pend_quantity quantity;
    int arm, other; /* stored numbers; other: for a distance */
    double level;   /* the value that the quantity crosses */
    int bound;      /* non-zero: the condition concerns the magnitude, level >= 0; up means away
                     * from 0 */
    unsigned ways;  /* flags of enum pend_way; up: the value grows as the integration proceeds */
    long most;      /* maximum number of passages that are reported, >= 1 */
    long stop;      /* number of the passage that ends the motion, from 1; 0 = none */
};

struct pend_hit {
    double time;       /* s, after the start */
    int event;         /* index of its condition */
    enum pend_way way; /* PEND_WAY_UP or PEND_WAY_DOWN */
};
