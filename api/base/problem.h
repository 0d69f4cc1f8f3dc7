/* An RFC 9457 problem: a status, a sentence, and every fault of a request with its JSON pointer.
 * Leaves to others: finding the faults (read, op); sending the response (server).
 * Invariant: at most API_PROBLEM_FAULTS faults are kept; further ones are counted. */
#ifndef API_PROBLEM_H
#define API_PROBLEM_H

#include "api/base/buffer.h"

enum { API_PROBLEM_FAULTS = 100, API_POINTER_BYTES = 160, API_DETAIL_BYTES = 400 };

struct api_fault {
    char pointer[API_POINTER_BYTES]; /* "/pendulum/arms/3/mass", "" for the whole document; RFC 6901
                                        escapes done */
    char detail[API_DETAIL_BYTES]; /* a sentence fragment: "must be a finite number greater than 0,
                                      got -1" */
};

struct api_problem {
    int status; /* HTTP status, 0 = no problem yet */
    char title[80];
    char detail[API_DETAIL_BYTES];
    int count;                /* faults kept */
    long beyond;              /* faults seen but not kept */
    struct api_fault *faults; /* API_PROBLEM_FAULTS of them, allocated at the first fault */
};

/** True if the counts fit the faults and the status; for assertions. */
int api_problem_valid(const struct api_problem *problem);

/** Initializes a problem that has not occurred: status 0, no faults. */
void api_problem_init(struct api_problem *problem);

/** Frees the faults and initializes the problem again. */
void api_problem_clear(struct api_problem *problem);

/**
 * States the problem. If one was stated already, the call is ignored.
 *
 * status  an HTTP status from 400 to 599; its title is the reason phrase of RFC 9110.
 * format  printf format of the detail sentence.
 */
void api_problem_set(struct api_problem *problem, int status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/**
 * Adds a fault; the problem becomes a 422 if none was stated yet.
 *
 * pointer  JSON pointer, already escaped.
 */
void api_problem_fault(struct api_problem *problem, const char *pointer, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/**
 * Returns true, and counts one more fault, if no further faults are kept: then the caller need not
 * write the text of its fault.
 */
int api_problem_full(struct api_problem *problem);

/**
 * Appends the problem as JSON (type, title, status, detail, errors) to the buffer. Text from the
 * client is escaped; bytes that are not UTF-8 become U+FFFD. Fails as api_buffer_room does; then
 * nothing was appended.
 */
PEND_MUST_CHECK enum pend_status api_problem_write(const struct api_problem *problem,
                                                   struct api_buffer *out);

#endif
