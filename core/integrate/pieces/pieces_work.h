/* The workspace of a motion in pieces.
 * Leaves to others: the loop (pieces), rows (pieces_rows).
 * Invariant: one block of memory, apart from the stepper and the contracted pendulum. */
#pragma once

#include "core/integrate/pieces/joints.h"
#include "core/tree/turns.h"

/* instants per block when the states of a contracted pendulum are expanded to all arms */
enum { PIECES_ROWS = 16 };
/* maximum number of consecutive pieces of zero length */
enum { PIECES_STALLED = 1000 };
/* maximum number of steps between two samples of controllers */
enum { PIECES_STEPS = 10000 };
/* how a piece ended: at an instant known in advance, or at an event */
enum { PIECES_KNOWN = 1, PIECES_EVENT };

struct pieces {
    const struct pend_method *inner;
    struct pend_problem problem; /* the problem, with the numbers of the current piece */
    struct pend_piece piece;
    void *stepper;   /* stepper of the whole pendulum, or of `stuck` */
    double begun;    /* s after the first instant: start of the piece */
    double next;     /* s, in the time of the drives: end of the piece if no event comes before */
    double reached;  /* s, relative: end of the last step */
    double *low[2];  /* low-order parts of angles and rates at the start of the piece */
    int ended;       /* how the last step ended the piece; 0 = it did not */
    int fresh;       /* whether no step of the piece was taken yet */
    int stalled;     /* number of consecutive pieces of zero length, up to now */
    int taken;       /* number of steps in this piece so far */
    double way_most; /* s, longest step while joints hold: the series do not contain their drives */
    double *control; /* the state of the controllers; NULL = there are none */
    struct pend_joints *joints;      /* NULL = no joint has dry friction or stops */
    struct pend_stuck *stuck;        /* the contracted pendulum, while joints hold */
    double *room;                    /* scratch of pend_joint_events and of rows */
    struct pend_sum work, heat;      /* J, sums over the closed steppers */
    struct pend_stepper_counts done; /* counts of the closed steppers */
};
