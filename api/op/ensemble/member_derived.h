/* The derivatives of an ensemble's members, one member after another: of the final state, or at the
 * instants of a trajectory.
 * Leaves to others: the columns (observables), the motions (core/ensemble), the order of members
 * (member_range).
 * Invariant: a member's derivatives depend only on the request and the member's number. */
#pragma once

#include "api/op/derived.h"
#include "api/op/ensemble/members_fill.h"
#include "api/read/times_json.h"

/* The input of the computation, which must outlive it. */
struct api_member_derived_of {
    const struct api_derived *derived; /* parameters and columns */
    const struct api_tree *tree;
    const struct api_members *members;
    const struct pend_times *times; /* instants of trajectories; NULL = the end of the duration */
    double origin, duration;        /* s, start and duration of members */
    double rtol, atol;
    long step_cap;
};

struct api_member_derived;

/**
 * Allocates the memory of one member.
 *
 * made  out; NULL on failure; released by api_member_derived_free.
 *
 * PEND_NO_MEMORY  O(n + terms).
 */
PEND_MUST_CHECK enum pend_status api_member_derived_new(struct api_member_derived **made,
                                                        const struct api_member_derived_of *of);
void api_member_derived_free(struct api_member_derived **derived);

/** Returns the bytes of a computation for members with a number of instants, including the first
 * one. O(harmonics). */
double api_member_derived_bytes(const struct api_derived *derived, const struct api_tree *tree,
                                long instants);

/**
 * Starts a member that did not fail; cancels an earlier one.
 *
 * rows  number of instants of the trajectory, >= 1; without a trajectory 1, for the end.
 *
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status api_member_derived_begin(struct api_member_derived *derived,
                                                          long member, long rows,
                                                          struct pend_error *error);

/**
 * Continues the member for about half a millisecond.
 *
 * raw     out: the derivatives of its first row, finite numbers in the order of the columns.
 * stride  numbers from one row to the next.
 * made    in and out: number of complete rows, 0 at the first call; finished once it is `rows`.
 *
 * PEND_NOT_FINITE, PEND_STEP_TOO_SMALL, PEND_TOO_MANY_STEPS  for this member only.
 */
PEND_MUST_CHECK enum pend_status api_member_derived_next(struct api_member_derived *derived,
                                                         double raw[], long stride, long *made);
