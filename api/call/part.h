/* Computing a request as a job, in parts, each of which is stored in raw form. Parts are
 * independent of each other, or chained: then each begins where the one before it ended. Leaves to
 * others: when and where a part is computed and stored (server), the answer (results). Invariant: a
 * part's bytes are the same whenever and wherever it is computed, except compute_seconds. */
#ifndef API_PART_H
#define API_PART_H

#include "api/call/call.h"

/* What is known about a job before it runs. */
struct api_plan {
    long parts;   /* >= 1 */
    int chained;  /* non-zero: a part needs the checkpoint of the one before it */
    double cost;  /* s, estimated, of all parts */
    double bytes; /* memory that a part holds while it is computed, as api_part_bytes says */
    double kept;  /* bytes of results that the largest part has at least; 0 = unknown */
    char digest[API_DIGEST_BYTES]; /* of the request, without the representation and the engine */
};

/**
 * Reads and checks a request as a whole.
 *
 * plan     out.
 * request  its Accept is ignored.
 * seconds  about how long a part should take; one whose results would be large takes less.
 * body     the request's body is appended here in the form in which it is stored: without blanks,
 *          its keys in order; NULL = not wanted. Its digest is the same.
 * out      a problem is appended here.
 *
 * Returns 0 if the request is good, else the problem's HTTP status. O(body).
 */
int api_plan_read(struct api_plan *plan, const struct api_request *request,
                  const struct api_limits *limits, double seconds, struct api_buffer *body,
                  struct api_buffer *out);

struct api_part;

/**
 * Reads the request of a part, so that it is ready to run.
 *
 * part     out; NULL on failure; ends with api_part_free.
 * request  one that api_plan_read found good; its body is read here, once, and must outlive the
 * part. number   of the part, 0 .. parts - 1. error    on failure says why, for the job's message.
 *
 * PEND_INVALID, PEND_LIMIT  the request is refused, since the limits have changed.
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status api_part_new(struct api_part **part,
                                              const struct api_request *request,
                                              const struct api_limits *limits, long number,
                                              long parts, struct pend_error *error);

/** True if the part's number, operation and state fit each other; for assertions. O(1). */
int api_part_valid(const struct api_part *part);

/** Frees a part, complete or not; nothing happens if it is NULL. */
void api_part_free(struct api_part **part);

/**
 * Continues from the checkpoint of the part before this one; to be called before the first run of
 * every part of a chain but the first.
 *
 * PEND_INVALID    the checkpoint is damaged, belongs to another request or part, or was written by
 * a version with other contents. PEND_NO_MEMORY, and the failures of the operation's start.
 */
PEND_MUST_CHECK enum pend_status api_part_resume(struct api_part *part, const void *carried,
                                                 size_t bytes, struct pend_error *error);

/**
 * Appends the checkpoint that the next part begins with; to be called once, when this part is
 * complete. Appends nothing if the parts are independent, and after the last part.
 *
 * PEND_NO_MEMORY, PEND_LIMIT
 */
PEND_MUST_CHECK enum pend_status api_part_carry(struct api_part *part, struct api_buffer *carried);

/** Returns the bytes of memory that the part holds or will hold until its next run ends, as
 * api_call_bytes does. */
double api_part_bytes(const struct api_part *part);

/** Gives the part a clock, as api_call_clock does. */
void api_part_clock(struct api_part *part, double (*now)(void *context), void *context);

/** Gives the part a way to ask whether other work is urgent, as api_call_hurry does. */
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

#endif
