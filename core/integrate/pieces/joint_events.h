/* Finds the instant at which a joint ends a piece: a sliding joint comes to rest, a joint reaches
 * its stop, or the torque of a holding joint reaches its bound. Leaves to others: what happens then
 * (joints). Invariant: a root at the beginning of a piece is divided out, so that no event is found
 * twice. */
#ifndef PEND_JOINT_EVENTS_H
#define PEND_JOINT_EVENTS_H

#include "core/integrate/pieces/joints.h"

/* the nodes of a step at which torques are computed */
enum { PEND_JOINT_NODES = 13 };

/* most phase of a drive per step, rad: the polynomial through the nodes then follows it to 1e-10 */
#define PEND_JOINT_TURN 4.0

/* A step of a piece. */
struct pend_joint_step {
    const struct pend_method *method;
    void *stepper;
    const struct pend_stuck
        *stuck;   /* the contracted pendulum of the step; NULL = the whole pendulum */
    int fresh;    /* the first step of the piece */
    double to;    /* end of the search, s after the first instant */
    double start; /* the first instant, s */
    double *room; /* (5 + PEND_JOINT_NODES) n numbers */
};

/**
 * Returns the first instant of a step at which a joint ends the piece, s after the motion's first
 * instant; infinity if none does. Marks the joints in `forced`, `struck` and `stopped`.
 *
 * Rates and angles: roots of their power series. Torques: roots of a polynomial through nodes,
 * refined with the torques themselves. O(n order), plus O(n order) for each holding joint.
 */
double pend_joint_events(struct pend_joints *joints, const struct pend_joint_step *step);

#endif
