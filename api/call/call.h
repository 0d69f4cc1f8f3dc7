/* One request from its bytes to its answer's bytes, with no socket in sight.
 * Leaves to others: moving the bytes, threads and clocks (server).
 * Invariant: a call is used by one thread at a time; same request and limits, same answer (but
 * for compute_seconds). */
#ifndef API_CALL_H
#define API_CALL_H

#include "api/base/buffer.h"
#include "api/base/limits.h"
#include "api/call/request.h"
#include "api/encode/remarks.h"

/* What is known of an answer before its first byte is sent; the texts live as long as the call. */
struct api_answer {
    int status;             /* HTTP status */
    const char *media_type; /* a static string */
    const char *columns; /* of X-Columns, "t,phi[4],phid[4]", or NULL: the representation does not
                            tell them itself */
    const struct api_remarks *told; /* fields of the figures, once the answer is complete; NULL
                                       before, or where none are */
    int tells; /* there are going to be such fields: of a stream they come behind it, as trailers */
    const char *file_name; /* under which a browser would save it, or NULL: to be looked at */
    const char *etag;      /* as api_call_etag; NULL for a problem */
    long long length;      /* bytes of the answer's body where that is known, else -1 */
    long long first;       /* status 206: the number of its first byte in the whole, from 0 */
    long long total;       /* status 206 and 416: bytes of the whole */
};

enum api_progress {
    API_MORE,   /* call again; bytes may have been appended */
    API_DONE,   /* the answer is complete: an answer of the operation, or a problem */
    API_BROKEN, /* it failed after api_call_promise: what is in out may be sent, then the client is
                   to see a message that is not complete */
    API_WAITS   /* call again once the source has more; bytes may have been appended. Only after
                   api_call_results */
};

struct api_call;

/**
 * An empty call.
 *
 * limits  must outlive the call.
 *
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status api_call_new(struct api_call **call,
                                              const struct api_limits *limits);

void api_call_free(struct api_call **call);

/**
 * Lends the call a clock; to be set before api_call_open, or never.
 *
 * now  seconds since any fixed instant, monotonic; called a few times a run on the thread that runs
 *      the call.
 *
 * With a clock a run comes back after about a millisecond and the answer's stats say
 * compute_seconds; without one a run comes back after a fixed amount of work and compute_seconds is
 * left out. Either way it comes back once it has appended about 256 KiB: with one block of samples
 * more at most.
 */
void api_call_clock(struct api_call *call, double (*now)(void *context), void *context);

/**
 * Lends a look at who else waits; with a clock, to be set before api_call_open, or never.
 *
 * hurry  asked between two pieces of work once a run has lasted a quarter of a millisecond; where
 *        it returns non-zero the run comes back. Called on the thread that runs the call.
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

/* Where the parts of a job lie (api/call/part). */
struct api_source {
    /**
     * Fetches the next bytes of the parts, in their order.
     *
     * data   out, room for `cap` bytes.
     * bytes  out; 0 = that was all.
     *
     * Anything but PEND_OK ends the answer; error->text says why.
     */
    enum pend_status (*fetch)(void *context, void *data, size_t cap, size_t *bytes,
                              struct pend_error *error);
    /** Begins with the first part again. */
    void (*again)(void *context);
    void *context;
    /** Non-zero where fetch has what it fetches, an end or an error included; NULL = fetch may
     * wait for it. */
    int (*ready)(void *context);
};

/**
 * As api_call_open, but api_call_run takes the answer from the kept parts of a job instead of
 * computing it.
 *
 * request  what the job was made of, with the Accept of the client who wants the results.
 * source   copied; its context must outlive the call.
 */
PEND_MUST_CHECK enum api_progress api_call_results(struct api_call *call,
                                                   const struct api_request *request,
                                                   const struct api_source *source,
                                                   struct api_buffer *out);

/* A range of an answer's bytes, numbered from 0. */
struct api_range {
    long long first; /* -1: the last `last` bytes are wanted */
    long long last;  /* -1: all to the end */
};

/**
 * Tells how many bytes the whole answer has, for one whose length is not known before it is
 * written: from an answer of the same ETag that was written before. Before api_call_range, which
 * then need not write it twice.
 *
 * bytes  0 or less: it is not known.
 */
void api_call_length(struct api_call *call, long long bytes);

/**
 * Asks for a part of the answer only, status 206, of a call that api_call_results has opened;
 * before its first run. Where the length of the whole is not known before it is written, that is
 * done twice, the first time for nobody.
 *
 * API_DONE  as after api_call_open; status 416 where no byte of the answer is in the range: that
 *           may also come later.
 */
PEND_MUST_CHECK enum api_progress api_call_range(struct api_call *call, struct api_range range,
                                                 struct api_buffer *out);

/**
 * What tells a request from every other, as 64 hexadecimal digits: a SHA-256 of the operation, what
 * it was asked in a canonical form (the order of keys, blanks, the spelling of numbers and most
 * defaults written out do not matter), the representation, and the engine. NULL for a request that
 * was refused. Equal digests: the same answer but for compute_seconds.
 *
 * Valid once api_call_open came back; lives as long as the call.
 */
const char *api_call_etag(const struct api_call *call);

/**
 * An estimate of the computation, s, from the request alone: within a factor of three or so for
 * most, on the machine that it was adjusted on. 0 for a request that was refused.
 */
double api_call_cost(const struct api_call *call);

/**
 * Bytes of memory that the call holds and will hold until the next api_call_run is over: its
 * operation's arrays, the rows that a representation keeps, what was read of the request; not the
 * caller's buffer. An upper bound, within a factor of about two for what is large. Known once
 * api_call_open came back and before the first run takes that memory; may grow between two runs,
 * for operations that cannot know how much they will find. 0 after the end.
 */
double api_call_bytes(const struct api_call *call);

/**
 * True where api_call_run itself refuses, after some hundredths of a second, what cannot come to
 * its end within max-steps and max-compute-seconds, as far as the first part of a motion can tell.
 */
int api_call_foresees(const struct api_call *call);

/** Bytes that the answer's body will not pass, as far as that is known before it is written; of a
 * range the whole. */
double api_call_answer_bytes(const struct api_call *call);

/**
 * True when the answer may be sent in pieces while it is computed; valid once api_call_open came
 * back.
 */
int api_call_streams(const struct api_call *call);

/**
 * Takes the answer of api_call_answer for promised: its head is on its way to the client. From now
 * on the caller may take bytes out of `out` between two runs, and a failure breaks the answer
 * instead of replacing it.
 *
 * To be called between api_call_open and API_DONE, where api_call_streams says so; once is enough.
 */
void api_call_promise(struct api_call *call);

/**
 * Computes on and appends to the answer, for about a millisecond or 256 KiB at a time, so that the
 * caller can look after its clock and its client.
 *
 * API_DONE    also after a failure where nothing was promised: the bytes written so far are taken
 *             back (out->bytes returns to what it was before the first run) and the answer becomes
 *             a problem.
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
 * The head of the answer. After api_call_open returned API_MORE: what it will be if nothing fails;
 * after API_DONE:
 * what it is.
 */
struct api_answer api_call_answer(const struct api_call *call);

/** Computation steps so far, for the log: integration steps of a trajectory, 0 for others. */
long api_call_steps(const struct api_call *call);

#endif
