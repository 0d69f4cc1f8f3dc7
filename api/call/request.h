/* A request as it came over the wire, and the way of its body to the operation.
 * Leaves to others: representations (negotiate), running the operation (call, part, results).
 * Invariant: a request that was refused has a stated problem. */
#ifndef API_REQUEST_H
#define API_REQUEST_H

#include "api/call/digest.h"
#include "api/op/op.h"

/* What came over the wire; nothing is copied. */
struct api_request {
    enum api_op_id op;
    const char *argument;     /* the variable part of the path ("paper-four-arms"), or NULL */
    const char *query;        /* what follows '?', or NULL */
    const char *content_type; /* header values as they came, or NULL */
    const char *accept;
    const char *body; /* NULL for GET */
    size_t body_bytes;
};

/** Checks what can be said of a request before its body is looked at; faults are stated in
 * problem. */
void api_request_check(const struct api_request *request, const struct api_limits *limits,
                       struct api_problem *problem);

/**
 * Reads the body and has the operation read it.
 *
 * format  the representation of the answer.
 * limits  outlives the state.
 * state   out, the operation's; NULL on failure; ends with the operation's free.
 * digest  out; of the request in canonical form, see api_call_etag; of the raw form without the
 *         engine.
 * canonical  the body is appended here without blanks, keys in order, where that is shorter; else
 *            as it is; NULL = not wanted.
 *
 * PEND_INVALID  the faults are in problem.
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status
api_request_read(const struct api_request *request, const struct api_format *format,
                 const struct api_limits *limits, struct api_problem *problem, void **state,
                 char digest[API_DIGEST_BYTES], struct api_buffer *canonical);

#endif
