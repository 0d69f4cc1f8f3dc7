/* Conditions on a motion and their passages, as they are asked for and told.
 * Leaves to others: finding passages (event_search).
 * Invariant: arms are counted in stored order. */
#pragma once

#include "core/integrate/events/section.h"

/* What a condition is about. */
enum pend_quantity {
    PEND_QUANTITY_PHI,       /* rad, of an arm; m, of a cart */
    PEND_QUANTITY_THETA,     /* rad, from hanging, with the digits of a small swing */
    PEND_QUANTITY_RATE,      /* rad/s, of an arm */
    PEND_QUANTITY_FORCE,     /* N, lambda of an arm */
    PEND_QUANTITY_X,         /* m, of a tip */
    PEND_QUANTITY_Y,         /* m, of a tip */
    PEND_QUANTITY_DISTANCE,  /* m, of two tips */
    PEND_QUANTITY_KINETIC,   /* J, of the whole */
    PEND_QUANTITY_POTENTIAL, /* J, of gravity and springs */
    PEND_QUANTITY_ENERGY,    /* J, of both */
    PEND_QUANTITIES
};

struct pend_event {
    enum pend_quantity quantity;
    int arm, other; /* stored numbers; other: of a distance */
    double level;   /* the value that is passed */
    int bound;      /* non-zero: the size of the quantity is meant, level >= 0; up is outwards */
    unsigned ways;  /* of enum pend_way; up: the value grows, in the order of the run */
    long most;      /* passages that are told, >= 1; later ones are left out */
    long stop;      /* the motion ends at this one; 0 = at none */
};

/* A passage. */
struct pend_hit {
    double time;       /* s, after the start */
    int event;         /* its number */
    enum pend_way way; /* PEND_WAY_UP or PEND_WAY_DOWN */
};
