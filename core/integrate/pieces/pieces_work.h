/* The workspace of a motion in pieces.
 * Leaves to others: the loop (pieces), rows (pieces_rows).
 * Invariant: one block of memory, the stepper and what is left while joints hold beside it. */
#ifndef PEND_PIECES_WORK_H
#define PEND_PIECES_WORK_H

#include "core/integrate/pieces/joint_events.h"
#include "core/integrate/pieces/rule.h"
#include "core/tree/turns.h"

/* kinds of rules */
enum { PIECES_RULES = 2 };
/* rows of instants that a stuck pendulum's states are spread by at a time */
enum { PIECES_ROWS = 16 };
/* pieces without a length that may follow each other */
enum { PIECES_STALLED = 1000 };
/* how a piece has ended: at an instant known beforehand, or at an event */
enum { PIECES_KNOWN = 1, PIECES_EVENT };

struct pieces {
    const struct pend_method *inner;
    struct pend_problem problem; /* with the piece's numbers */
    struct pend_piece piece;
    void *stepper;   /* of the whole pendulum, or of `stuck` */
    double begun;    /* s, relative: when the piece began */
    double next;     /* s, in the time of the drives: its end as known beforehand */
    double reached;  /* s, relative */
    double *low[2];  /* what the doubles of angles and rates leave out where it began */
    int ended;       /* how the last step has ended the piece; 0 = it has not */
    int fresh;       /* no step of the piece was taken */
    int stalled;     /* pieces without a length, the last ones */
    double way_most; /* s, of a step while joints hold: drives of these are not in its series */
    void *own[PIECES_RULES];         /* what rules keep; NULL = the pendulum has no such rule */
    struct pend_joints *joints;      /* NULL = no joint has dry friction or stops */
    struct pend_stuck *stuck;        /* while joints hold */
    double *room;                    /* of pend_joint_events and of rows */
    struct pend_sum work, heat;      /* J, by steppers that were closed */
    struct pend_stepper_counts done; /* by them */
};

#endif
