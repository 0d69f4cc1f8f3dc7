/* The table of a job's answer, from its parts as they were kept.
 * Leaves to others: the request and the head of the answer (call), fetching the parts in their
 * order (server).
 * Invariant: the bytes do not depend on how the parts are cut into pieces when they are fed. */
#ifndef API_RESULTS_H
#define API_RESULTS_H

#include "api/encode/encode.h"

struct api_results;

/**
 * Begins an answer.
 *
 * results  out; NULL on failure.
 * table    outlives the results.
 * apart    non-zero: JSON is kept as such, since it says more than the table.
 * later    non-zero: the table's rows are the most that there can be, and a record of figures says
 *          that all are there.
 * out      what comes before the rows is appended.
 *
 * PEND_NO_MEMORY, PEND_LIMIT
 */
PEND_MUST_CHECK enum pend_status api_results_new(struct api_results **results,
                                                 const struct api_format *format,
                                                 const struct api_table *table, int apart,
                                                 int later, struct api_buffer *out);

/** The figures of all parts, once the answer is complete; NULL where there are none. */
const struct api_stats *api_results_stats(const struct api_results *results);

void api_results_free(struct api_results **results);

/**
 * Takes the next bytes of the parts, and appends what follows from them.
 *
 * PEND_BUG        they are damaged, or not of this table.
 * PEND_NO_MEMORY, PEND_LIMIT
 */
PEND_MUST_CHECK enum pend_status api_results_feed(struct api_results *results, const void *data,
                                                  size_t bytes, struct api_buffer *out);

/**
 * Says that the parts were fed to their end, and appends the next piece of what is left, about
 * API_PIECE_BYTES.
 *
 * done  set non-zero once the answer is complete.
 *
 * Fails as api_results_feed does, also when rows are missing.
 */
PEND_MUST_CHECK enum pend_status api_results_end(struct api_results *results,
                                                 struct api_buffer *out, int *done);

#endif
