/* An RFC 9457 problem in the making: a status, a sentence, and every fault with its JSON pointer.
 * Leaves to others: finding the faults; sending the answer.
 * Invariant: at most API_PROBLEM_FAULTS faults are kept, the rest is counted. */
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
    struct api_fault *faults; /* room for API_PROBLEM_FAULTS, allocated at the first fault */
};

/** Starts with no problem. */
void api_problem_init(struct api_problem *problem);

/** Frees the faults and starts again with no problem. */
void api_problem_clear(struct api_problem *problem);

/**
 * States the problem: the first call wins, later ones are ignored.
 *
 * status  an HTTP status from 400 to 599; its title comes from the table of RFC 9110's reason
 *         phrases.
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
 * True when further faults will only be counted: then nobody need find words for them. Counts one
 * more fault when it is.
 */
int api_problem_full(struct api_problem *problem);

/**
 * Appends the problem as JSON (type, title, status, detail, errors) to the buffer. Text from the
 * client is escaped and, where it is not UTF-8, replaced. Fails as api_buffer_room does.
 */
PEND_MUST_CHECK enum pend_status api_problem_write(const struct api_problem *problem,
                                                   struct api_buffer *out);

#endif
