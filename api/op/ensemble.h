/* A checked request for an ensemble, and its computation in ranges of members that need not know of
 * each other.
 * Leaves to others: when and where a range of members runs (op_ensembles; a job's workers), the
 * bytes of the answer (encode).
 * Invariant: raw rows of members a .. b - 1 are the same bits however the ensemble is cut into
 * ranges of members, on any thread.
 */
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
 * PEND_INVALID   every fault was added to the problem.
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status api_ensemble_new(struct api_ensemble **ensemble,
                                                  const struct api_reading *reading);

void api_ensemble_free(struct api_ensemble **ensemble);

/**
 * What is computed once, before the first range: states that were given as modes. Afterwards the
 * ensemble is not changed any more, and ranges of members may run on any number of threads.
 */
PEND_MUST_CHECK enum pend_status api_ensemble_prepare(struct api_ensemble *ensemble,
                                                      struct pend_error *error);

/** Members. */
long api_ensemble_count(const struct api_ensemble *ensemble);

/** The table that the answer is; its rows are in the order of the members, `api_ensemble_rows`
 * for each. */
const struct api_table *api_ensemble_table(const struct api_ensemble *ensemble);

/** Rows a member: 1, or the instants of a trajectory. */
long api_ensemble_rows(const struct api_ensemble *ensemble);

/** Doubles a raw row. */
long api_ensemble_numbers(const struct api_ensemble *ensemble);

/** An estimate of the computation of so many members, s. */
double api_ensemble_cost(const struct api_ensemble *ensemble, long members);

/** Bytes of memory that the ensemble and a range of members's computation take, without the raw
 * rows. O(1). */
double api_ensemble_bytes(const struct api_ensemble *ensemble);

/**
 * Begins the members first .. first + count - 1.
 *
 * raw  out, count x rows x numbers doubles, row after row; the caller's, filled once the range is
 *      done. Every number in it is finite: what never happened is -1, what a failed member did not
 *      come to is 0.
 *
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status api_member_range_new(struct api_member_range **range,
                                                      const struct api_ensemble *ensemble,
                                                      long first, long count, double raw[],
                                                      struct pend_error *error);

void api_member_range_free(struct api_member_range **range);

/** Computes on for about half a millisecond. How often it is called changes no bit of the result.
 */
PEND_MUST_CHECK enum pend_status api_member_range_go(struct api_member_range *range, int *done);

/** Members that are finished, members of these that failed, and integration steps so far. */
struct api_member_range_stats {
    long finished, failed, steps;
    long lost; /* members that are good and did not keep the accuracy to their end */
};

struct api_member_range_stats api_member_range_stats(const struct api_member_range *range);

/**
 * Writes raw rows to an answer, column by column; call it with pieces of a few hundred rows.
 *
 * Fails as api_writer_block does.
 */
PEND_MUST_CHECK enum pend_status api_ensemble_write(const struct api_ensemble *ensemble,
                                                    struct api_writer *writer, long rows,
                                                    const double raw[], struct api_buffer *out,
                                                    struct pend_error *error);

#endif
