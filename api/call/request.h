/* A received request, and the parsing of its body for the operation.
 * Leaves to others: representations (negotiate), running the operation (call, part, results).
 * Invariant: a refused request has a problem. */
#pragma once

#include "api/call/digest.h"
#include "api/op/op.h"

/* The received request; nothing is copied. */
struct api_request {
    enum api_op_id op;
    const char *argument;     /* the variable part of the path ("paper-four-arms"), or NULL */
    const char *query;        /* the text after '?', or NULL */
    const char *content_type; /* field values as received, or NULL */
    const char *accept;
    const char *body; /* NULL for GET */
    size_t body_bytes;
    long part, parts; /* parts > 0: only the rows of this part, 1 .. parts */
};

/** Checks a request without its body; sets the problem if it is refused. */
void api_request_check(const struct api_request *request, const struct api_limits *limits,
                       struct api_problem *problem);

/**
 * Parses the body and lets the operation read it.
 *
 * format     the representation of the answer.
 * limits     must outlive the state.
 * state      out: the operation's state; NULL on failure; released by the operation's free.
 * digest     out; see api_call_etag. For the raw format it does not include the engine.
 * canonical  the body is appended, without blanks and with keys in order if that is shorter,
 *            otherwise unchanged; NULL if not needed.
 *
 * PEND_INVALID  the errors are in problem.
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status
api_request_read(const struct api_request *request, const struct api_format *format,
                 const struct api_limits *limits, struct api_problem *problem, void **state,
                 char digest[API_DIGEST_BYTES], struct api_buffer *canonical);
