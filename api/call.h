/* One request from its bytes to its answer's bytes, with no socket in sight.
 * Leaves to others: moving the bytes, threads and clocks (server).
 * Invariant: a call is used by one thread at a time; same request and limits, same answer (but for compute_seconds). */
#ifndef API_CALL_H
#define API_CALL_H

#include "api/buffer.h"
#include "api/limits.h"
#include "api/op.h"

/* What came over the wire; nothing is copied, all must outlive api_call_open. */
struct api_request {
    enum api_op_id op;
    const char *argument;     /* the variable part of the path ("paper-four-arms"), or NULL */
    const char *query;        /* what follows '?', or NULL */
    const char *content_type; /* header values as they came, or NULL */
    const char *accept;
    const char *body; /* NULL for GET */
    size_t body_bytes;
};

/* What is known of an answer before its first byte is sent. */
struct api_answer {
    int status;             /* HTTP status */
    const char *media_type; /* a static string */
};

enum api_progress {
    API_MORE, /* call again; bytes may have been appended */
    API_DONE  /* the answer is complete: an answer of the operation, or a problem */
};

struct api_call;

/**
 * An empty call.
 *
 * limits  must outlive the call.
 *
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status api_call_new(struct api_call **call, const struct api_limits *limits);

void api_call_free(struct api_call **call);

/**
 * Lends the call a clock; to be set before api_call_open, or never.
 *
 * now  seconds since any fixed instant, monotonic; called a few times a run on the thread that runs the call.
 *
 * With a clock a run comes back after about 5 ms and the answer's stats say compute_seconds; without one a run comes
 * back after a fixed amount of work and compute_seconds is left out.
 */
void api_call_clock(struct api_call *call, double (*now)(void *context), void *context);

/**
 * Reads and checks the whole request. Afterwards the answer is known to be a problem, or the computation is ready to
 * run.
 *
 * API_MORE  the request is good: api_call_run computes.
 * API_DONE  it is refused: the problem was appended to out.
 * O(body). Never crashes, hangs or grows beyond the limits whatever the bytes are.
 */
PEND_MUST_CHECK enum api_progress api_call_open(struct api_call *call, const struct api_request *request,
                                                struct api_buffer *out);

/**
 * Computes on and appends to the answer, for about 5 ms at a time, so that the caller can look after its clock and its
 * client.
 *
 * On failure in mid-way the bytes written so far are taken back where nothing was promised to the client yet
 * (out->bytes returns to what it was before the first run), the answer becomes a problem, and API_DONE is returned.
 */
PEND_MUST_CHECK enum api_progress api_call_run(struct api_call *call, struct api_buffer *out);

/**
 * Ends a call early: what is in out is replaced by a problem of that status (a deadline, a cancellation).
 */
void api_call_stop(struct api_call *call, int status, const char *detail, struct api_buffer *out);

/** The status line and media type of the answer; valid once API_DONE was returned. */
struct api_answer api_call_answer(const struct api_call *call);

/** Computation steps so far, for the log: integration steps of a trajectory, 0 for others. */
long api_call_steps(const struct api_call *call);

#endif
