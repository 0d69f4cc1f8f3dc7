/* The computation of an ensemble in independent ranges of members.
 * Leaves to others: when and where a range is computed (op_ensembles; a job's workers), the request
 * (ensemble).
 * Invariant: raw rows of members a .. b - 1 are the same bits however the ensemble is divided into
 * ranges, on any thread. */
#ifndef API_MEMBER_RANGE_H
#define API_MEMBER_RANGE_H

#include "api/op/ensemble/ensemble.h"

struct api_member_range;

/**
 * Begins the members first .. first + count - 1.
 *
 * range  out; NULL on failure; ends with api_member_range_free.
 * raw    out, count x rows x numbers doubles, row after row; the caller's, complete once the range
 *        is done. Every number in it is finite: -1 for an event that never happened, 0 for values
 *        that a failed member did not reach. Of passages the rows of the
 *        members follow each other without gaps.
 *
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status api_member_range_new(struct api_member_range **range,
                                                      const struct api_ensemble *ensemble,
                                                      long first, long count, double raw[],
                                                      struct pend_error *error);

/** True if its counts are within the ensemble; for assertions. O(1). */
int api_member_range_valid(const struct api_member_range *range);

/** Frees a range, complete or not; nothing happens if it is NULL. */
void api_member_range_free(struct api_member_range **range);

/** Continues the computation for about half a millisecond and sets `done` once it is complete. How
 * often it is called changes no bit of the result. */
PEND_MUST_CHECK enum pend_status api_member_range_go(struct api_member_range *range, int *done,
                                                     struct pend_error *error);

/* Members that are finished, members of these that failed, and integration steps so far. */
struct api_member_range_stats {
    long finished, failed, steps;
    long lost; /* good members whose horizon is before their end */
    long rows; /* of a complete range; where they are passages they are as many as were found */
};

/** Returns the counts so far. O(1). */
struct api_member_range_stats api_member_range_stats(const struct api_member_range *range);

#endif
