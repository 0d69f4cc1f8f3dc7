/* A checked request for an ensemble, and its computation in independent ranges of members.
 * Leaves to others: when and where a range is computed (op_ensembles; a job's workers), the bytes
 * of the answer (encode).
 * Invariant: raw rows of members a .. b - 1 are the same bits however the ensemble is divided into
 * ranges, on any thread. */
#ifndef API_ENSEMBLE_H
#define API_ENSEMBLE_H

#include "api/op/members_json.h"
#include "api/op/observables.h"
#include "api/op/op.h"
#include "api/read/times_json.h"

struct api_ensemble;
struct api_member_range;

/**
 * Reads and checks a request.
 *
 * ensemble  out; NULL on failure; ends with api_ensemble_free.
 *
 * PEND_INVALID   every fault was added to the problem.
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status api_ensemble_new(struct api_ensemble **ensemble,
                                                  const struct api_reading *reading);

/** Frees an ensemble; nothing happens if it is NULL. No range of it may be in use. */
void api_ensemble_free(struct api_ensemble **ensemble);

/**
 * Computes the states that were given as modes; to be called once, before the first range.
 * Afterwards the ensemble does not change, and ranges may be computed on any number of threads.
 *
 * Fails as api_states_settle does.
 */
PEND_MUST_CHECK enum pend_status api_ensemble_prepare(struct api_ensemble *ensemble,
                                                      struct pend_error *error);

/** Returns the number of members. */
long api_ensemble_count(const struct api_ensemble *ensemble);

/** Returns the table of the answer; its rows are in the order of the members, api_ensemble_rows for
 * each. */
const struct api_table *api_ensemble_table(const struct api_ensemble *ensemble);

/** Returns the rows of a member: 1, or the instants of a trajectory. */
long api_ensemble_rows(const struct api_ensemble *ensemble);

/** Returns the doubles of a raw row. */
long api_ensemble_numbers(const struct api_ensemble *ensemble);

/** Estimates the computation of so many members, s. */
double api_ensemble_cost(const struct api_ensemble *ensemble, long members);

/** Returns the bytes of memory of the ensemble and the computation of a range, without the raw
 * rows. O(1). */
double api_ensemble_bytes(const struct api_ensemble *ensemble);

/**
 * Begins the members first .. first + count - 1.
 *
 * range  out; NULL on failure; ends with api_member_range_free.
 * raw    out, count x rows x numbers doubles, row after row; the caller's, complete once the range
 *        is done. Every number in it is finite: -1 for an event that never happened, 0 for values
 *        that a failed member did not reach.
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
PEND_MUST_CHECK enum pend_status api_member_range_go(struct api_member_range *range, int *done);

/* Members that are finished, members of these that failed, and integration steps so far. */
struct api_member_range_stats {
    long finished, failed, steps;
    long lost; /* good members whose horizon is before their end */
};

/** Returns the counts so far. O(1). */
struct api_member_range_stats api_member_range_stats(const struct api_member_range *range);

/**
 * Writes raw rows to an answer, column by column; to be called with pieces of a few hundred rows.
 *
 * Fails as api_writer_block does.
 */
PEND_MUST_CHECK enum pend_status api_ensemble_write(const struct api_ensemble *ensemble,
                                                    struct api_writer *writer, long rows,
                                                    const double raw[], struct api_buffer *out,
                                                    struct pend_error *error);

#endif
