/* The computation of an ensemble in independent ranges of members.
 * Leaves to others: scheduling ranges (op_ensembles; a job's workers), the request (ensemble).
 * Invariant: raw rows have the same bits for every division of the ensemble into ranges, on any
 * thread. */
#pragma once

#include "api/op/ensemble/ensemble.h"

struct api_member_range;

/**
 * Starts the members first .. first + count - 1.
 *
 * range  out; NULL on failure; released by api_member_range_free.
 * raw    out, count x rows x numbers doubles, row after row; the caller's, complete once the range
 *        is done. An event that never happened has the time NaN, as have values that a failed
 *        member did not reach. Rows of passages follow each other without gaps.
 *
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status api_member_range_new(struct api_member_range **range,
                                                      const struct api_ensemble *ensemble,
                                                      long first, long count, double raw[],
                                                      struct pend_error *error);
void api_member_range_free(struct api_member_range **range);

/** Continues the computation for about half a millisecond and sets `done` once it is complete. The
 * result does not depend on the number of calls. */
PEND_MUST_CHECK enum pend_status api_member_range_go(struct api_member_range *range, int *done,
                                                     struct pend_error *error);

/* Counts so far: finished members, failed ones among these, and integration steps. */
struct api_member_range_stats {
    long finished, failed, steps;
    long lost; /* number of finished members whose horizon is before their end */
    long rows; /* number of rows of a complete range; for passages the number found */
};

/** Returns the counts so far. O(1). */
struct api_member_range_stats api_member_range_stats(const struct api_member_range *range);
