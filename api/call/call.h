/* One request from its bytes to its answer's bytes, without a socket.
 * Leaves to others: receiving and sending the bytes, threads and clocks (server).
 * Invariant: a call is used by one thread at a time; the same request and limits give the same
 * answer, except compute_seconds. */
#ifndef API_CALL_H
#define API_CALL_H

#include "api/base/buffer.h"
#include "api/base/limits.h"
#include "api/call/request.h"
#include "api/call/results.h"

/* How a call stands. */
enum api_progress {
    API_MORE,   /* call again; bytes may have been appended */
    API_DONE,   /* the answer is complete: an answer of the operation, or a problem */
    API_BROKEN, /* it failed after api_call_promise: the bytes in out may be sent, but the client
                   must see that the message is not complete */
    API_WAITS   /* call again once the source has more; bytes may have been appended. Only after
                   api_call_results */
};

struct api_call;

/**
 * Allocates a call.
 *
 * call    out; NULL on failure; ends with api_call_free.
 * limits  must outlive the call.
 *
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status api_call_new(struct api_call **call,
                                              const struct api_limits *limits);

/** True if its stage fits its operation, answer and problem; for assertions. O(1). */
int api_call_valid(const struct api_call *call);

/** Frees a call at any stage; nothing happens if it is NULL. */
void api_call_free(struct api_call **call);

/**
 * Gives the call a clock; before api_call_open, or never.
 *
 * now  returns the seconds since any fixed instant, monotonic; called a few times a run on the
 *      thread that runs the call.
 *
 * With a clock api_call_run returns after about a millisecond, and the answer's stats have
 * compute_seconds; without one it returns after a fixed amount of work, and compute_seconds is left
 * out. In both cases it returns once it has appended about 256 KiB and at most one block of samples
 * more.
 */
void api_call_clock(struct api_call *call, double (*now)(void *context), void *context);

/**
 * Gives the call a way to ask whether other work is urgent; with a clock, before api_call_open, or
 * never.
 *
 * hurry  called between two pieces of work once a run has lasted a quarter of a millisecond; if it
 *        returns non-zero, the run returns. Called on the thread that runs the call.
 */
void api_call_hurry(struct api_call *call, int (*hurry)(void *company), void *company);

/**
 * Reads and checks the whole request. Afterwards the answer is known to be a problem, or the
 * computation is ready to run.
 *
 * API_MORE  the request is good: api_call_run computes.
 * API_DONE  it is refused: the problem was appended to out.
 * O(body). Never crashes, hangs or grows beyond the limits whatever the bytes are.
 */
PEND_MUST_CHECK enum api_progress
api_call_open(struct api_call *call, const struct api_request *request, struct api_buffer *out);

/**
 * As api_call_open, but api_call_run makes the answer from the stored parts of a job instead of
 * computing it.
 *
 * request  the job's request, with the Accept of the client who wants the results.
 * source   copied; its context must outlive the call.
 */
PEND_MUST_CHECK enum api_progress api_call_results(struct api_call *call,
                                                   const struct api_request *request,
                                                   const struct api_source *source,
                                                   struct api_buffer *out);

/* A range of an answer's bytes, numbered from 0. */
struct api_range {
    long long first; /* -1: the last `last` bytes are wanted */
    long long last;  /* -1: up to the end */
};

/**
 * Sets the length of the whole answer, if it was learned from an earlier answer with the same ETag.
 * To be called before api_call_range, which then does not write the answer twice.
 *
 * bytes  0 or less: unknown.
 */
void api_call_length(struct api_call *call, long long bytes);

/**
 * Restricts the answer to a range of its bytes, status 206, for a call that api_call_results has
 * opened, before its first run. If the length of the whole is unknown before it is written, the
 * answer is written twice; the first time only counts its bytes.
 *
 * API_DONE  as after api_call_open; status 416 if no byte of the answer is in the range, which
 *           api_call_run may also find later.
 */
PEND_MUST_CHECK enum api_progress api_call_range(struct api_call *call, struct api_range range,
                                                 struct api_buffer *out);

/**
 * Returns the identity of the answer as 64 hexadecimal digits: a SHA-256 of the operation, the body
 * in a canonical form (the order of keys, blanks, the spelling of numbers and most defaults written
 * out do not matter), the representation, and the engine. NULL for a request that was refused.
 * Equal digests mean equal answers, except compute_seconds.
 *
 * Valid once api_call_open has returned; lives as long as the call.
 */
const char *api_call_etag(const struct api_call *call);

/**
 * Returns an estimate of the computation, s, from the request alone: within a factor of about three
 * for most requests, on the machine that it was fitted on. 0 for a request that was refused.
 */
double api_call_cost(const struct api_call *call);

/**
 * Returns the bytes of memory that the call holds or will hold until the next api_call_run ends:
 * its operation's arrays, the rows that a representation keeps, the request's values; not the
 * caller's buffer. An upper bound, within a factor of about two if it is large. Known once
 * api_call_open has returned and before the first run allocates that memory; it may grow between
 * two runs, for operations that cannot know how much they will find. 0 after the end.
 */
double api_call_bytes(const struct api_call *call);

/**
 * True if api_call_run refuses a computation after some hundredths of a second if, judged by its
 * first part, it cannot end within max-steps and max-compute-seconds.
 */
int api_call_foresees(const struct api_call *call);

/** Returns an upper bound of the bytes of the answer's body, of a range that of the whole. */
double api_call_answer_bytes(const struct api_call *call);

/**
 * True if the answer may be sent in pieces while it is computed; valid once api_call_open has
 * returned.
 */
int api_call_streams(const struct api_call *call);

/** The least room in bytes of the buffer of an answer that streams: what flows is never held as a
 * whole, so that the limit of answers does not bound it. */
enum { API_CALL_STREAM = 1 << 24 };

/**
 * Promises the answer of api_call_answer: its head is sent to the client. From now on the caller
 * may remove bytes from `out` between two runs, and a failure breaks the answer instead of
 * replacing it.
 *
 * To be called between api_call_open and API_DONE, only if api_call_streams is true; further calls
 * change nothing.
 */
void api_call_promise(struct api_call *call);

/**
 * Continues the computation and appends to the answer, for about a millisecond or 256 KiB at a
 * time, so that the caller can check its clock and its client.
 *
 * API_DONE    also after a failure if nothing was promised: the bytes written so far are removed
 *             (out->bytes is what it was before the first run) and the answer becomes a problem.
 * API_BROKEN  a failure after api_call_promise. What was appended stays; application/x-ndjson gets
 *             a last line {"problem": {...}}.
 */
PEND_MUST_CHECK enum api_progress api_call_run(struct api_call *call, struct api_buffer *out);

/**
 * Ends a call early, as a failure in api_call_run would: by a problem of that status (a deadline, a
 * cancellation).
 *
 * Returns API_DONE or API_BROKEN.
 */
enum api_progress api_call_stop(struct api_call *call, int status, const char *detail,
                                struct api_buffer *out);

/**
 * Returns the head of the answer: after API_DONE the final one, before that the one that it will be
 * if nothing fails.
 */
struct api_answer api_call_answer(const struct api_call *call);

/** Returns the integration steps so far, for the log; 0 for operations that do not integrate. */
long api_call_steps(const struct api_call *call);

#endif
