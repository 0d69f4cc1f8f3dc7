/* Computes a request as a job in parts, each stored in raw form. Parts are either independent, or
 * chained: then each continues from the end of the previous one.
 * Leaves to others: when and where a part is computed and stored (server), the answer (results).
 * Invariant: a part's bytes do not depend on when and where it is computed, except
 * compute_seconds. */
#pragma once

#include "api/call/call.h"

/* The plan of a job. */
struct api_plan {
    long parts;   /* >= 1 */
    int chained;  /* non-zero: a part needs the checkpoint of the previous part */
    double cost;  /* s, estimated time of all parts */
    double bytes; /* bytes of memory that a part needs while it is computed, as api_part_bytes */
    double kept;  /* lower bound of the largest part's results in bytes; 0 = unknown */
    char digest[API_DIGEST_BYTES]; /* of the request, without the representation and the engine */
};

/**
 * Reads and checks a request as a whole.
 *
 * plan     out.
 * request  its Accept is ignored.
 * seconds  s, approximate time of a part; parts with large results are shorter.
 * body     the request's body is appended in its stored form: without blanks, keys in order; NULL
 *          if not needed. Its digest is the same.
 * out      a problem is appended.
 *
 * Returns 0 if the request is valid, else the problem's HTTP status. O(body).
 */
int api_plan_read(struct api_plan *plan, const struct api_request *request,
                  const struct api_limits *limits, double seconds, struct api_buffer *body,
                  struct api_buffer *out);

struct api_part;

/**
 * Reads the request of a part, so that it is ready to run.
 *
 * part     out; NULL on failure; released by api_part_free.
 * request  accepted by api_plan_read; must outlive the part.
 * number   index of the part, 0 .. parts - 1.
 * error    out on failure: the reason, for the job's message.
 *
 * PEND_INVALID, PEND_LIMIT  the request is refused because the limits have changed.
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status api_part_new(struct api_part **part,
                                              const struct api_request *request,
                                              const struct api_limits *limits, long number,
                                              long parts, struct pend_error *error);
void api_part_free(struct api_part **part);

/**
 * Loads the checkpoint of the previous part. Call it before the first run of every chained part
 * except part 0.
 *
 * PEND_INVALID    the checkpoint is damaged, belongs to another request or part, or was written by
 *                 an incompatible version.
 * PEND_NO_MEMORY  and the failures of the operation's start.
 */
PEND_MUST_CHECK enum pend_status api_part_resume(struct api_part *part, const void *carried,
                                                 size_t bytes, struct pend_error *error);

/**
 * Appends the checkpoint for the next part. Call it once, when this part is complete. Appends
 * nothing for independent parts and for the last part.
 *
 * PEND_NO_MEMORY, PEND_LIMIT
 */
PEND_MUST_CHECK enum pend_status api_part_carry(struct api_part *part, struct api_buffer *carried);

/** Returns an upper bound of the memory, in bytes, that the part needs until its next run ends, as
 * api_call_bytes does. */
double api_part_bytes(const struct api_part *part);

/** Sets the clock, as api_call_clock does. */
void api_part_clock(struct api_part *part, double (*now)(void *context), void *context);

/** Sets the function that returns whether other work is urgent, as api_call_hurry does. */
void api_part_hurry(struct api_part *part, int (*hurry)(void *company), void *company);

/**
 * Continues the computation for about a millisecond and appends the results to be stored to out.
 *
 * done  set non-zero once the part is complete.
 *
 * Fails as the operation does; then the bytes in out are useless.
 */
PEND_MUST_CHECK enum pend_status api_part_run(struct api_part *part, struct api_buffer *out,
                                              int *done, struct pend_error *error);

/** Moves the rows of a complete part from `out`, where an API_RAW_FILE record takes their place,
 * into a Parquet file of doubles. Its bytes depend on the request, the part and the engine alone.
 * O(bytes). PEND_NO_MEMORY, PEND_LIMIT */
PEND_MUST_CHECK enum pend_status api_part_file(const struct api_part *part, struct api_buffer *out,
                                               struct api_buffer *file);
