/* Whole requests for tests: a body in, the answer out, parsed; and access to it by JSON pointers.
 * Leaves to others: what is asked and expected (test_*). Invariant: every JSON answer was read
 * back by api's own reader, so that an answer which is no JSON fails its test. */
#pragma once

#include "api/call/call.h"
#include "api/json/json_in.h"

/* The reply. */
struct test_reply {
    int status;
    const char *media_type;
    struct api_buffer out; /* out.data ends with a NUL that out.bytes does not include */
    struct api_json *json; /* NULL if the answer is not JSON */
    long runs, steps;
};

/** Sends a request with a body as JSON, with the default limits. */
struct test_reply test_post(enum api_op_id op, const char *body);

/** The same, with an Accept header and limits; either may be NULL. */
struct test_reply test_post_as(enum api_op_id op, const char *body, const char *accept,
                               const struct api_limits *limits);

/** Sends any request with any limits. */
struct test_reply test_send(const struct api_request *request, const struct api_limits *limits);

void test_reply_free(struct test_reply *reply);

/** The number at a pointer ("/phi/3/0"), NAN if there is none. */
double test_reply_number(const struct test_reply *reply, const char *pointer);

/** The error of unknown j of a fit, in standard errors. */
double test_reply_off(const struct test_reply *reply, int j, double truth);

/** The text at a pointer, or NULL; valid as long as the reply. */
const char *test_reply_text(const struct test_reply *reply, const char *pointer);

/** Number of items or members at a pointer; -1 if there is none. */
int test_reply_count(const struct test_reply *reply, const char *pointer);

/** True if the reply is a problem with an error at exactly this pointer whose detail contains the
 * piece. */
int test_reply_has_fault(const struct test_reply *reply, const char *pointer, const char *piece);

/** Number of errors that the problem lists. */
int test_reply_faults(const struct test_reply *reply);

/**
 * Checks that a body is refused with a 422 whose single error is at the pointer and contains the
 * piece.
 */
void test_refused(enum api_op_id op, const char *body, const char *pointer, const char *piece,
                  const char *file, int line);

#define CHECK_REFUSED(op, body, pointer, piece)                                                    \
    test_refused((op), (body), (pointer), (piece), __FILE__, __LINE__)

/** Checks all rows of a table of refusals, as tests/api/read/refused.txt explains it. */
void test_refused_rows(const char *file);
