/* The instant at which joints end a piece: one that slides comes to rest, one comes to its stop,
 * the torque of one that holds comes to its bound. Leaves to others: what happens then (joints).
 * Invariant: a function that is 0 where a piece begins is divided by its root there, so that the
 * same event is not found twice. */
#ifndef PEND_JOINT_EVENTS_H
#define PEND_JOINT_EVENTS_H

#include "core/integrate/pieces/joints.h"

/* the nodes of a step at which torques are computed */
enum { PEND_JOINT_NODES = 13 };

/* rad: how far a drive may go on in a step, so that the polynomial through the nodes has it to
 * 1e-10 */
#define PEND_JOINT_TURN 4.0

/* A step of a piece. */
struct pend_joint_step {
    const struct pend_method *method;
    void *stepper;
    const struct pend_stuck *stuck; /* of which the step is; NULL = of the whole pendulum */
    int fresh;                      /* the piece begins with it */
    double to;                      /* s, relative to the first instant: how far it counts */
    double start;                   /* s, of the first instant */
    double *room;                   /* (5 + PEND_JOINT_NODES) n numbers */
};

/**
 * Returns the first instant in a step, s, relative to the first one, at which a joint ends the
 * piece; an infinity where none does. Marks the joints in `forced`, `struck` and `stopped`.
 *
 * Roots of the power series of rates and angles; of torques, of a polynomial through nodes, and
 * then of the torques themselves. O(n order), and O(n order) a joint that holds.
 */
double pend_joint_events(struct pend_joints *joints, const struct pend_joint_step *step);

#endif
