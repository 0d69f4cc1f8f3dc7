/* A request computed as a job, in parts, each kept in raw form: parts that need not know of each
 * other, or that are chained, each beginning where the one before it ended.
 * Leaves to others: when and where a part runs and where it is kept (server), the answer
 * (results).
 * Invariant: a part's bytes are the same whenever and wherever it is computed, but for
 * compute_seconds. */
#ifndef API_PART_H
#define API_PART_H

#include "api/call/call.h"

/* What is known of a job before it runs. */
struct api_plan {
    long parts;   /* >= 1 */
    int chained;  /* non-zero: a part begins with what the one before it carried over */
    double cost;  /* s, estimated, of all */
    double bytes; /* of memory that a part holds while it is computed, as api_part_bytes says */
    double kept;  /* bytes of results that the largest part has at least; 0 = not known before */
    char digest[API_DIGEST_BYTES]; /* of the request, whatever the representation and the engine */
};

/**
 * Reads and checks a request as a whole.
 *
 * request  its Accept is not looked at.
 * seconds  that a part should take, about.
 * plan     out.
 * body     the request's body is appended here as it is to be kept: without blanks, its keys in
 *          order; NULL = not wanted. It means the same: its digest is the same.
 * out      a problem is appended here.
 *
 * Returns 0 where the request is good, else the problem's HTTP status. O(body).
 */
int api_plan_read(struct api_plan *plan, const struct api_request *request,
                  const struct api_limits *limits, double seconds, struct api_buffer *body,
                  struct api_buffer *out);

struct api_part;

/**
 * A part that is ready to run.
 *
 * request  what api_plan_read found good; its body is read here, once.
 * number   of the part, 0 .. parts - 1.
 * error    why not, for the job's message.
 *
 * PEND_INVALID, PEND_LIMIT  the request is refused, by other limits than before.
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status api_part_new(struct api_part **part,
                                              const struct api_request *request,
                                              const struct api_limits *limits, long number,
                                              long parts, struct pend_error *error);

void api_part_free(struct api_part **part);

/**
 * Goes on from what the part before this one carried over; before the first run of every part of a
 * chain but the first.
 *
 * PEND_INVALID    it was altered by a bit, is not of this request and part, or was carried by a
 *                 version that keeps other things.
 * PEND_NO_MEMORY, and what the operation's start fails with.
 */
PEND_MUST_CHECK enum pend_status api_part_resume(struct api_part *part, const void *carried,
                                                 size_t bytes, struct pend_error *error);

/**
 * Appends what the next part begins with; once, when this one is complete. Nothing where parts need
 * not know of each other, and after the last.
 *
 * PEND_NO_MEMORY, PEND_LIMIT
 */
PEND_MUST_CHECK enum pend_status api_part_carry(struct api_part *part, struct api_buffer *carried);

/** Bytes of memory that the part holds and will hold until its next run is over, as
 * api_call_bytes says. */
double api_part_bytes(const struct api_part *part);

/** Lends a clock, as api_call_clock. */
void api_part_clock(struct api_part *part, double (*now)(void *context), void *context);

/** Lends a look at who else waits, as api_call_hurry. */
void api_part_hurry(struct api_part *part, int (*hurry)(void *company), void *company);

/**
 * Computes on for about a millisecond and appends to out what is to be kept.
 *
 * done  set non-zero once the part is complete.
 *
 * Fails as the operation does; what is in out is then worth nothing.
 */
PEND_MUST_CHECK enum pend_status api_part_run(struct api_part *part, struct api_buffer *out,
                                              int *done, struct pend_error *error);

#endif
