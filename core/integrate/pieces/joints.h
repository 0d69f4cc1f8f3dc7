/* Joints that slide, hold, hit their stops and lean on them: what each does in a piece, and how
 * that changes between two. Leaves to others: the instants at which it changes (joint_events), the
 * motion in a piece (pieces). Invariant: a joint that holds has its parent's rate to the last bit.
 */
#ifndef PEND_JOINTS_H
#define PEND_JOINTS_H

#include "core/integrate/pieces/rule.h"
#include "core/integrate/pieces/stuck.h"

enum { PEND_JOINT_FREE = 2, PEND_JOINT_HOLDS = 0 }; /* +1, -1: it slides that way */

struct pend_joints {
    struct pend_piece *piece;
    const struct pend_tree *tree;
    int n;
    signed char *mode;   /* n: what each joint does */
    signed char *touch;  /* n: +1, -1: it leans on its upper or its lower stop */
    signed char *forced; /* n: its holding torque has come to its bound: the way that it goes */
    signed char *struck; /* n: it has come to its upper or lower stop */
    signed char *was_forced, *was_struck; /* n: the same where the piece began */
    unsigned char *stopped;               /* n: its rate has come to that of its parent */
    unsigned char *holds;                 /* n flags of the modes */
    signed char *try;                     /* n: modes that are looked at */
    double *acc, *torque;                 /* n each, of the modes that were looked at last */
    double *zero, *blow, *list;           /* n zeros and 2 n numbers; n; the numbers of an impact */
    void *work, *room;                    /* of pend_bodies_at, pend_balance */
    double heat;                          /* J, of impacts */
};

/** Bytes that joints of a pendulum take, a multiple of 64. */
size_t pend_joints_bytes(const struct pend_tree *tree, const struct pend_terms *terms);

/** Places joints in memory of zeros of pend_joints_bytes, aligned to 64. */
void pend_joints_init(struct pend_joints *joints, struct pend_piece *piece, void *memory);

/**
 * Checks the angles of a start.
 *
 * PEND_INVALID  a joint is beyond its stop; the message says which angle may be meant.
 */
PEND_MUST_CHECK enum pend_status pend_joints_start(struct pend_joints *joints,
                                                   struct pend_error *error);

/**
 * Impacts of all joints that have come to a stop, one after the other in the caller's order, until
 * none moves into its stop.
 *
 * The impulse is J = -(1 + e) r / (s^T M^-1 s) at the joint, s = e_child - e_parent, on the tree
 * with all joints loose. The last bounce of a geometric series has e = 0 (a flight of less than
 * 1e-6 s).
 *
 * PEND_STEP_TOO_SMALL  it does not end.
 */
PEND_MUST_CHECK enum pend_status pend_joints_impacts(struct pend_joints *joints,
                                                     struct pend_error *error);

/**
 * What every joint does from now on: all that are at rest are sorted anew. Writes PEND_TERM_SLIDE.
 *
 * All are assumed to hold. As long as something is inconsistent, a released joint that accelerates
 * against its way holds again, the one first that is most so; else the one that is most over its
 * bound is released. With holding above sliding torques several answers may be consistent; that of
 * the sliding torques alone is one of them, and the way out.
 */
PEND_MUST_CHECK enum pend_status pend_joints_sort(struct pend_joints *joints,
                                                  struct pend_error *error);

/** Accelerations of a state in which joints do what they do in the piece. stuck: the pendulum that
 * is left, or NULL. O(n). */
void pend_joints_accelerations(struct pend_joints *joints, const struct pend_stuck *stuck,
                               double time, const double phi[], const double rate[], double acc[]);

/** The pendulum that is left while joints hold; NULL where none does. */
PEND_MUST_CHECK enum pend_status pend_joints_contract(const struct pend_joints *joints,
                                                      const double phi_low[],
                                                      struct pend_stuck **stuck);

/** The rate of joint k, rad/s. O(1). */
static inline double pend_joints_rate(const struct pend_joints *joints, const double rate[],
                                      int k) {
    int p = pend_terms_holder(joints->piece->problem->loads.terms, joints->tree->parent, k);
    return rate[k] - (p < 0 ? 0 : rate[p]);
}

/** The angle of joint k, rad, that of a root from hanging; the place of a cart. O(1). */
double pend_joints_angle(const struct pend_joints *joints, const double phi[], int k);

#endif
