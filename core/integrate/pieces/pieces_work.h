/* The workspace of a motion in pieces.
 * Leaves to others: the loop (pieces), rows (pieces_rows).
 * Invariant: one block of memory, without the stepper and the contracted pendulum. */
#ifndef PEND_PIECES_WORK_H
#define PEND_PIECES_WORK_H

#include "core/integrate/pieces/joints.h"
#include "core/integrate/pieces/rule.h"
#include "core/tree/turns.h"

/* kinds of rules */
enum { PIECES_RULES = 2 };
/* instants per block when the states of a contracted pendulum are expanded to all arms */
enum { PIECES_ROWS = 16 };
/* most consecutive pieces of zero length */
enum { PIECES_STALLED = 1000 };
/* how a piece ended: at an instant known in advance, or at an event */
enum { PIECES_KNOWN = 1, PIECES_EVENT };

struct pieces {
    const struct pend_method *inner;
    struct pend_problem problem; /* with the piece's numbers */
    struct pend_piece piece;
    void *stepper;   /* of the whole pendulum, or of `stuck` */
    double begun;    /* start of the piece, s after the first instant */
    double next;     /* end of the piece if no event comes before, s, in the time of the drives */
    double reached;  /* s, relative */
    double *low[2];  /* low-order parts of angles and rates at the start of the piece */
    int ended;       /* how the last step ended the piece; 0 = it did not */
    int fresh;       /* non-zero: no step of the piece was taken */
    int stalled;     /* number of the last pieces of zero length */
    double way_most; /* longest step while joints hold, s: the series lacks their drives */
    void *own[PIECES_RULES];         /* states of the rules; NULL = the pendulum has no such rule */
    struct pend_joints *joints;      /* NULL = no joint has dry friction or stops */
    struct pend_stuck *stuck;        /* while joints hold */
    double *room;                    /* memory of pend_joint_events and of rows */
    struct pend_sum work, heat;      /* J, of closed steppers */
    struct pend_stepper_counts done; /* counts of closed steppers */
};

#endif
