/* An RFC 9457 problem: a status, a sentence, and every error of a request with its JSON pointer.
 * Leaves to others: finding the errors (read, op); sending the response (server).
 * Invariant: at most API_PROBLEM_FAULTS errors are kept; further ones are counted. */
#pragma once

#include <stdarg.h>

#include "api/base/buffer.h"

/* Codes of errors and types of problems. A format string begins with its code, "\1" and a letter,
 * as in api_problem_fault(problem, pointer, API_CODE_MISSING "is missing"). api/call/openapi.yaml
 * lists the codes with their meanings; sentences may change, codes do not. Without a code an error
 * is "invalid", and a problem's type is "about:blank". */
#define API_CODE_UNKNOWN_FIELD "\1u"
#define API_CODE_MISSING "\1m"
#define API_CODE_WRONG_TYPE "\1t"
#define API_CODE_OUT_OF_RANGE "\1r"
#define API_CODE_WRONG_COUNT "\1n"
#define API_CODE_UNKNOWN_NAME "\1w"
#define API_CODE_DUPLICATE "\1d"
#define API_CODE_CONFLICT "\1c"
#define API_CODE_NOT_APPLICABLE "\1a"
#define API_CODE_ORDER "\1o"
#define API_CODE_NOT_A_TREE "\1g"
#define API_CODE_LIMIT "\1l"
#define API_CODE_UNSUPPORTED "\1s"

#define API_TYPE_INVALID "\1I"
#define API_TYPE_NOT_JSON "\1J"
#define API_TYPE_LIMIT "\1L"
#define API_TYPE_QUOTA "\1Q"
#define API_TYPE_RATE "\1R"
#define API_TYPE_CREDENTIALS "\1C"
#define API_TYPE_OWNER "\1O"
#define API_TYPE_ROLE "\1P"
#define API_TYPE_ORIGIN "\1W"
#define API_TYPE_KEY_REUSED "\1K"
#define API_TYPE_NOT_DONE "\1D"
#define API_TYPE_NO_RESULTS "\1E"
#define API_TYPE_NO_STORE "\1S"

enum { API_PROBLEM_FAULTS = 100, API_POINTER_BYTES = 160, API_DETAIL_BYTES = 400 };

struct api_fault {
    char pointer[API_POINTER_BYTES]; /* "/pendulum/arms/3/mass", "" for the whole document; escaped
                                      * by RFC 6901 */
    char detail[API_DETAIL_BYTES]; /* a sentence fragment: "must be a finite number greater than 0,
                                      got -1" */
    const char *code;              /* kind of error, a word of the table: "out_of_range" */
    const char *meant;             /* the sibling field that was probably intended, or NULL */
};

struct api_problem {
    int status;       /* HTTP status, 0 = no problem yet */
    const char *type; /* type of the problem, a word of the table; NULL = none besides its status */
    char title[80];
    char detail[API_DETAIL_BYTES];
    int deprecated;           /* whether the request uses a deprecated name; no problem */
    int count;                /* number of stored errors */
    long beyond;              /* number of further errors, which are only counted */
    struct api_fault *faults; /* API_PROBLEM_FAULTS errors, allocated when the first one occurs */
};

/** Initializes a problem that has not occurred: status 0, no errors. */
void api_problem_init(struct api_problem *problem);

/** Frees the errors and initializes the problem again. */
void api_problem_clear(struct api_problem *problem);
int api_problem_valid(const struct api_problem *problem);

/** Returns the HTTP status of a result of core: 200, 422, 500 or 503. */
int api_problem_http(enum pend_status status);

/**
 * Sets the problem. If one is already set, the call has no effect.
 *
 * status  an HTTP status from 400 to 599; its title is the reason phrase of RFC 9110.
 * format  printf format of the detail, optionally after an API_TYPE.
 */
void api_problem_set(struct api_problem *problem, int status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/** As api_problem_set, with the format's arguments as a list. */
void api_problem_set_list(struct api_problem *problem, int status, const char *format,
                          va_list arguments) __attribute__((format(printf, 3, 0)));

/**
 * Adds an error; the problem becomes a 422 if it has no status yet.
 *
 * pointer  JSON pointer, already escaped.
 * format   printf format of the error, optionally after an API_CODE.
 */
void api_problem_fault(struct api_problem *problem, const char *pointer, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/** As api_problem_fault, with the format's arguments as a list. */
void api_problem_fault_list(struct api_problem *problem, const char *pointer, const char *format,
                            va_list arguments) __attribute__((format(printf, 3, 0)));

/**
 * Records that the last error's member was a misspelling of `name`, so that `name` is not reported
 * as missing too.
 *
 * name  must outlive the problem.
 */
void api_problem_meant(struct api_problem *problem, const char *name);

/**
 * Returns true if an error at this pointer's object was a misspelling of `name` (NULL: of any
 * member). O(errors).
 */
int api_problem_is_meant(const struct api_problem *problem, const char *pointer, const char *name);

/** Returns true if no more errors can be stored, and counts one more: the caller need not format
 * it. */
int api_problem_full(struct api_problem *problem);

/** Appends the problem as JSON (type, title, status, detail, errors) to the buffer. Text from the
 * client is escaped; bytes that are not UTF-8 become U+FFFD. Fails as api_buffer_room does; then
 * nothing was appended. */
PEND_MUST_CHECK enum pend_status api_problem_write(const struct api_problem *problem,
                                                   struct api_buffer *out);

/**
 * Writes the problem of a failed call (with the default text of the status if it has none), and
 * clears it. PEND_NO_MEMORY replaces the errors, which may be incomplete.
 *
 * Returns 0 for PEND_OK, else the problem's HTTP status.
 */
int api_problem_end(struct api_problem *problem, enum pend_status status, struct api_buffer *out);
