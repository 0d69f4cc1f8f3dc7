/* The answer of a job, in any representation, from its parts as they were kept.
 * Leaves to others: fetching the parts in their order (server).
 * Invariant: the bytes do not depend on how the parts are cut into pieces when they are fed. */
#ifndef API_RESULTS_H
#define API_RESULTS_H

#include "api/part.h"

struct api_results;

/**
 * Begins an answer.
 *
 * results  out; NULL after a failure.
 * request  what the job was made of, with the Accept of the client who wants the results; needed for this call only.
 * limits   the job's.
 * out      what comes first is appended; after a failure a problem.
 *
 * Returns 0, or the problem's HTTP status: 406, or 422 where the representation is too large to be held in memory.
 */
int api_results_new(struct api_results **results, const struct api_request *request, const struct api_limits *limits,
                    struct api_buffer *out);

void api_results_free(struct api_results **results);

/** The head of the answer; its texts live as long as the results. The etag is NULL. */
struct api_answer api_results_answer(const struct api_results *results);

/**
 * Takes the next bytes of the parts, and appends what follows from them.
 *
 * PEND_BUG        they are damaged, or not of this job.
 * PEND_NO_MEMORY, PEND_LIMIT
 */
PEND_MUST_CHECK enum pend_status api_results_feed(struct api_results *results, const void *data, size_t bytes,
                                                  struct api_buffer *out);

/**
 * Says that the parts were fed to their end, and appends the next piece of what is left, about API_PIECE_BYTES.
 *
 * done  set non-zero once the answer is complete.
 *
 * Fails as api_results_feed does, also when rows are missing.
 */
PEND_MUST_CHECK enum pend_status api_results_end(struct api_results *results, struct api_buffer *out, int *done);

#endif
