/* A request computed as a job: in parts that need not know of each other, each kept in raw form.
 * Leaves to others: when and where a part runs and where it is kept (server), the answer (results).
 * Invariant: a part's bytes are the same whenever and wherever it is computed, but for compute_seconds. */
#ifndef API_PART_H
#define API_PART_H

#include "api/call.h"

/* What is known of a job before it runs. */
struct api_plan {
    long parts;                    /* >= 1 */
    double cost;                   /* s, estimated, of all */
    char digest[API_DIGEST_BYTES]; /* of the request, whatever the representation */
};

/**
 * Reads and checks a request as a whole.
 *
 * request  its Accept is not looked at.
 * seconds  that a part should take, about.
 * plan     out.
 * out      a problem is appended here.
 *
 * Returns 0 where the request is good, else the problem's HTTP status. O(body).
 */
int api_plan_read(struct api_plan *plan, const struct api_request *request, const struct api_limits *limits,
                  double seconds, struct api_buffer *out);

struct api_part;

/**
 * A part that is ready to run.
 *
 * request  what api_plan_read found good; its body outlives the part.
 * number   of the part, 0 .. parts - 1.
 * error    why not, for the job's message.
 *
 * PEND_INVALID, PEND_LIMIT  the request is refused, by other limits than before.
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status api_part_new(struct api_part **part, const struct api_request *request,
                                              const struct api_limits *limits, long number, long parts,
                                              struct pend_error *error);

void api_part_free(struct api_part **part);

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
PEND_MUST_CHECK enum pend_status api_part_run(struct api_part *part, struct api_buffer *out, int *done,
                                              struct pend_error *error);

#endif
