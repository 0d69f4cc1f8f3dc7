/* Handles one request, from its bytes to the bytes of its answer, without a socket.
 * Leaves to others: receiving and sending the bytes, threads and clocks (server).
 * Invariant: one thread at a time uses a call; the same request and limits give the same answer,
 * except compute_seconds. */
#pragma once

#include "api/base/buffer.h"
#include "api/base/limits.h"
#include "api/call/request.h"
#include "api/call/results.h"

/* The result of a step of a call. */
enum api_progress {
    API_MORE,   /* call again; bytes may have been appended */
    API_DONE,   /* the answer is complete: the operation's answer, or a problem */
    API_BROKEN, /* the call failed after api_call_promise: the bytes in `out` may be sent, but the
                 * client must notice that the message is incomplete */
    API_WAITS   /* only after api_call_results: call again once the source has more; bytes may have
                 * been appended */
};

struct api_call;

/**
 * Allocates a call.
 *
 * call    out; NULL on failure; released by api_call_free.
 * limits  must outlive the call.
 *
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status api_call_new(struct api_call **call,
                                              const struct api_limits *limits);
void api_call_free(struct api_call **call);
int api_call_valid(const struct api_call *call);

/**
 * Sets the clock of a call; before api_call_open, or never.
 *
 * now  returns the seconds since any fixed instant, monotonic; called a few times a run on the
 *      thread that runs the call.
 *
 * With a clock api_call_run returns after about a millisecond, and the answer's stats contain
 * compute_seconds; without one it returns after a fixed amount of work, and compute_seconds is
 * omitted. In both cases it returns once it has appended about 256 KiB, plus at most one block of
 * samples.
 */
void api_call_clock(struct api_call *call, double (*now)(void *context), void *context);

/**
 * Sets a function that returns whether other work is urgent. Requires a clock; before
 * api_call_open, or never.
 *
 * hurry  called between two pieces of work once a run has lasted a quarter of a millisecond, on the
 *        thread that runs the call; if it returns non-zero, the run returns.
 */
void api_call_hurry(struct api_call *call, int (*hurry)(void *company), void *company);

/**
 * Parses and checks the whole request.
 *
 * API_MORE  the request is valid: api_call_run computes.
 * API_DONE  it is refused; the problem is appended to `out`.
 *
 * O(body). Stays within the limits for arbitrary bytes.
 */
PEND_MUST_CHECK enum api_progress
api_call_open(struct api_call *call, const struct api_request *request, struct api_buffer *out);

/**
 * As api_call_open, but api_call_run encodes the answer from the stored parts of a job.
 *
 * request  the job's request, with the Accept of the client that fetches the results.
 * source   copied; its context must outlive the call.
 */
PEND_MUST_CHECK enum api_progress api_call_results(struct api_call *call,
                                                   const struct api_request *request,
                                                   const struct api_source *source,
                                                   struct api_buffer *out);

/* A range of an answer's bytes, numbered from 0. */
struct api_range {
    long long first; /* -1: the last `last` bytes */
    long long last;  /* -1: up to the end */
};

/**
 * Sets the total length of the answer, if it is known from an earlier answer with the same ETag.
 * Called before api_call_range, it saves writing the answer twice.
 *
 * bytes  0 or less: unknown.
 */
void api_call_length(struct api_call *call, long long bytes);

/**
 * Restricts the answer to a range of its bytes, status 206, for a call opened by api_call_results,
 * before its first run. If the total length is unknown, the answer is written twice; the first pass
 * only counts its bytes.
 *
 * API_DONE  as after api_call_open; status 416 if the range is empty, which api_call_run may also
 *           discover later.
 */
PEND_MUST_CHECK enum api_progress api_call_range(struct api_call *call, struct api_range range,
                                                 struct api_buffer *out);

/**
 * Returns the identity of the answer as 64 hexadecimal digits: a SHA-256 of the operation, the body
 * in canonical form (independent of key order, blanks, number formats and most explicit defaults),
 * the representation, and the engine. NULL for a refused request. Equal digests mean equal answers,
 * except compute_seconds.
 *
 * Valid after api_call_open, for the lifetime of the call.
 */
const char *api_call_etag(const struct api_call *call);

/** Returns an estimate of the computation time, s, from the request alone: within a factor of about
 * three for most requests, on the machine that it was fitted on. 0 for a refused request. */
double api_call_cost(const struct api_call *call);

/** Returns an upper bound of the memory, in bytes, that the call holds or will hold until the next
 * api_call_run ends: the operation's arrays, kept rows, the request's values; not the caller's
 * buffer. Within a factor of about two if it is large. Known after api_call_open, before the first
 * run allocates that memory; it may grow between runs if an operation cannot predict its results. 0
 * after the end. */
double api_call_bytes(const struct api_call *call);

/** Returns true if api_call_run forecasts: after some hundredths of a second it refuses a
 * computation that cannot end within max-steps and max-compute-seconds. */
int api_call_foresees(const struct api_call *call);

/** Returns an upper bound of the bytes of the answer's whole body, even if only a range is
 * requested. */
double api_call_answer_bytes(const struct api_call *call);

/** Returns true if the answer can be streamed while it is computed; valid after api_call_open. */
int api_call_streams(const struct api_call *call);

/** The least limit, in bytes, of the buffer of a streamed answer. Such an answer is never held as a
 * whole and is not bounded by max-answer-bytes. */
enum { API_CALL_STREAM = 1 << 24 };

/**
 * Declares that the head of api_call_answer is sent. From now on the caller may remove bytes from
 * `out` between runs, and a failure breaks the answer instead of replacing it.
 *
 * Call between api_call_open and API_DONE, only if api_call_streams is true; further calls have no
 * effect.
 */
void api_call_promise(struct api_call *call);

/**
 * Continues the computation and appends to the answer, for about a millisecond or 256 KiB at a
 * time, so that the caller can check its clock and its client.
 *
 * API_DONE    also after a failure without api_call_promise: the answer is removed from `out` and
 *             becomes a problem.
 * API_BROKEN  a failure after api_call_promise. The appended bytes stay; application/x-ndjson gets
 *             a last line {"problem": {...}}.
 */
PEND_MUST_CHECK enum api_progress api_call_run(struct api_call *call, struct api_buffer *out);

/**
 * Ends a call early with a problem of this status (deadline, cancellation), like a failure in
 * api_call_run.
 *
 * Returns API_DONE or API_BROKEN.
 */
enum api_progress api_call_stop(struct api_call *call, int status, const char *detail,
                                struct api_buffer *out);

/** Returns the head of the answer: after API_DONE the final head, before that the expected one. */
struct api_answer api_call_answer(const struct api_call *call);

/** Returns why the call failed, in words, also after API_BROKEN; valid until api_call_free. */
const char *api_call_reason(const struct api_call *call);

/** Returns the integration steps so far, for the log; 0 for operations that do not integrate. */
long api_call_steps(const struct api_call *call);
