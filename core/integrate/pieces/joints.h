/* Joints with dry friction and stops: during a piece each slides, holds or rests on a stop; it may
 * change its mode between two pieces.
 * Leaves to others: the instants of change (joint_events), the motion in a piece (pieces).
 * Invariant: a joint that holds has exactly its parent's rate. */
#pragma once

#include "core/integrate/methods/method.h"
#include "core/integrate/pieces/stuck.h"
#include "core/tree/rules.h"

/* A motion in pieces, at the boundary of two pieces. */
struct pend_piece {
    const struct pend_problem *problem; /* the list of its numbers is `value` */
    const struct pend_rules *rules;
    double *value; /* the numbers of the current piece */
    int way;       /* +1 or -1: the direction of time */
    double start;  /* start of the run, s, in the time of the drives */
    double now;    /* start of the piece, s, in the same time; exact, not a sum, at an instant known
                      in advance */
    double *phi, *rate; /* the state at `now`, n values each, stored order; impacts change rates */
};

enum { PEND_JOINT_FREE = 2, PEND_JOINT_HOLDS = 0 }; /* +1, -1: it slides in that direction */

struct pend_joints {
    struct pend_piece *piece;
    const struct pend_tree *tree;
    int n;
    signed char *mode;   /* one value per joint: its mode */
    signed char *touch;  /* +1 or -1: the joint rests on its upper or lower stop */
    signed char *forced; /* +1 or -1: direction in which the holding torque reached its limit */
    signed char *struck; /* +1 or -1: the joint reached its upper or lower stop */
    signed char *was_forced, *was_struck; /* the same at the start of the piece */
    signed char *side;                    /* +1 or -1: the stop of the last impact */
    double *hit;                          /* time of the last impact, s */
    unsigned char *stopped;               /* flags: the joint's rate reached its parent's */
    unsigned char *holds;                 /* flags: the joint is to hold */
    signed char *try;                     /* candidate modes */
    double *acc, *torque;                 /* n each, for the candidate modes computed last */
    double *zero, *blow, *list; /* scratch: n zeros, then 2 n numbers; n changes of rates; the list
                                 * of an impact */
    void *work, *room;          /* scratch of pend_bodies_at and of pend_balance */
    double heat;                /* J, heat of impacts so far */
};

/** Returns the bytes of memory for the joints of a pendulum, a multiple of 64. */
size_t pend_joints_bytes(const struct pend_tree *tree, const struct pend_terms *terms);

/** Lays out joints in zeroed memory of pend_joints_bytes, aligned to 64. */
void pend_joints_init(struct pend_joints *joints, struct pend_piece *piece, void *memory);

/**
 * Checks the initial angles.
 *
 * PEND_INVALID  a joint is beyond its stop; the message suggests the intended angle.
 */
PEND_MUST_CHECK enum pend_status pend_joints_start(struct pend_joints *joints,
                                                   struct pend_error *error);

/**
 * Applies the impacts of all joints at a stop, one after the other in the caller's order, until
 * none moves into its stop.
 *
 * The impulse is J = -(1 + e) r / (s^T M^-1 s) at the joint, s = e_child - e_parent, on the tree
 * with all joints free. If the next flight would last less than 1e-6 s, or the flight from the same
 * stop did, e is 0: the series of bounces ends. Two joints that shake each other may bounce so.
 *
 * PEND_STEP_TOO_SMALL  the impacts do not end.
 */
PEND_MUST_CHECK enum pend_status pend_joints_impacts(struct pend_joints *joints,
                                                     struct pend_error *error);

/**
 * Determines the mode of every joint at rest for the next piece. Writes PEND_TERM_SLIDE.
 *
 * At first all joints at rest are assumed to hold, except those that an event has just released.
 * While a mode is inconsistent, one is changed: if released joints accelerate against their
 * direction, the worst holds again; otherwise the holding joint that exceeds its limit most is
 * released. If static friction exceeds sliding friction, several answers may be consistent. The
 * static limits are tried first, then the sliding limits.
 */
PEND_MUST_CHECK enum pend_status pend_joints_sort(struct pend_joints *joints,
                                                  struct pend_error *error);

/** Computes accelerations in the modes that the joints have during the piece. stuck: the contracted
 * pendulum, or NULL. O(n). */
void pend_joints_accelerations(struct pend_joints *joints, const struct pend_stuck *stuck,
                               double time, const double phi[], const double rate[], double acc[]);

/** Creates the contracted pendulum, in which holding joints are rigid; NULL if none holds. */
PEND_MUST_CHECK enum pend_status pend_joints_contract(const struct pend_joints *joints,
                                                      const double phi_low[],
                                                      struct pend_stuck **stuck);

/** Returns the rate of joint k, rad/s. O(1). */
static inline double pend_joints_rate(const struct pend_joints *joints, const double rate[],
                                      int k) {
    int p = pend_terms_holder(joints->piece->problem->loads.terms, joints->tree->parent, k);
    return rate[k] - (p < 0 ? 0 : rate[p]);
}

/** Returns the angle of joint k, rad; for a root measured from the vertical; for a cart its
 * position, m. O(1). */
double pend_joints_angle(const struct pend_joints *joints, const double phi[], int k);

/* number of nodes in a step at which torques are computed */
enum { PEND_JOINT_NODES = 13 };

/* rad, the largest phase of a drive in a step: up to it the polynomial through the nodes is
 * accurate to 1e-10 */
#define PEND_JOINT_TURN 4.0

/* A step of a piece. */
struct pend_joint_step {
    const struct pend_method *method;
    void *stepper;
    const struct pend_stuck
        *stuck;   /* the contracted pendulum of the step; NULL = the whole pendulum */
    int fresh;    /* whether this is the first step of the piece */
    double to;    /* s after the first instant: end of the search */
    double start; /* s: the first instant */
    double *room; /* scratch of (5 + PEND_JOINT_NODES) n numbers */
};

/**
 * Returns the first instant of a step at which a joint ends the piece, s after the motion's first
 * instant; infinity if none does. Marks the joints in `forced`, `struck` and `stopped`.
 *
 * Events of rates and angles are roots of their power series. Events of torques are roots of a
 * polynomial through nodes, refined with the torques themselves. O(n order), plus O(n order) for
 * each holding joint.
 */
double pend_joint_events(struct pend_joints *joints, const struct pend_joint_step *step);
