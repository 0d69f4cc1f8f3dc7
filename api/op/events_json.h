/* The conditions of the field `events`: reading them, and of a trajectory the search for their
 * passages, and these as JSON or as the rows of a table. Leaves to others: the search itself
 * (events/events), the rest of a trajectory (op_trajectories). Invariant: passages are kept
 * in the order of time, arms in the caller's. */
#ifndef API_EVENTS_JSON_H
#define API_EVENTS_JSON_H

#include "api/encode/encode.h"
#include "api/op/op.h"
#include "api/read/method_json.h"
#include "api/read/state_json.h"
#include "core/integrate/events/events.h"

enum { API_EVENTS_MOST = 64, API_EVENTS_COLUMNS = 7 };

struct api_events {
    int count;       /* of conditions; 0 = there are none */
    int rows;        /* the answer's rows are the passages, not the instants */
    int stops;       /* a condition may end the motion */
    double followed; /* arms whose places are followed in each step, all conditions together */
    struct pend_event event[API_EVENTS_MOST];
    const struct api_tree *tree;
    double step_cap;
    const char *step_name; /* of the limit */
    long usual;            /* passages of a condition that are told, if it does not say */

    /* once it runs */
    struct pend_events *search;
    int searched;
    long found, room;
    double *column[API_EVENTS_COLUMNS]; /* t, event, direction, phi, phid, and of a cart its
                                         * place and speed */
    double *state;                      /* of all stored arms, angles and rates */
    char warning[API_WARNING_TEXT];
};

/**
 * Reads the conditions of the field `events`, where `events` has its tree and `usual` and else
 * zeros; nothing of the rest of the request is looked at.
 *
 * Every fault is added to the problem.
 */
void api_events_read_list(struct api_events *events, const struct api_value *field,
                          const struct api_limits *limits, struct api_problem *problem);

/**
 * Reads the fields `events` and `rows`; must be cleared by api_events_clear.
 *
 * tree    the trajectory's, which must outlive the events.
 * start   its state; NULL if that is faulty.
 * times   its instants; none of them if they are faulty.
 *
 * Every fault is added to the problem.
 */
void api_events_read(struct api_events *events, const struct api_reading *reading,
                     const struct api_tree *tree, const struct api_states *start,
                     const struct api_method *method, const struct pend_times *times);

/** Frees the passages and the search. */
void api_events_clear(struct api_events *events);

/**
 * Continues the search until the turn is over or `searched` is set.
 *
 * times  the trajectory's; the search goes from the first to the last of them. Once it is over and
 *        a condition has ended the motion, there are fewer of them: those up to that instant.
 *
 * PEND_NO_MEMORY, PEND_TOO_MANY_STEPS, and what pend_events_next returns.
 */
PEND_MUST_CHECK enum pend_status
api_events_look(struct api_events *events, const struct api_states *start,
                const struct api_method *method, struct pend_times *times,
                const struct api_turn *turn, struct pend_error *error);

/** Writes the passages as the rows of an answer, and the figures behind them, until the turn is
 * over. */
PEND_MUST_CHECK enum pend_status
api_events_write(struct api_events *events, const struct pend_times *times,
                 struct api_writer *writer, struct api_stats *stats, const struct api_turn *turn,
                 int *done, struct pend_error *error);

/** Sets the columns of a table of passages and the most rows that it can have, where these are the
 * rows; says where rows are known only later. */
void api_events_columns(const struct api_events *events, struct api_table *table);

/** Adds the number of passages, and where these are the rows that of the search's steps, and up to
 * when the digits hold; and the time at which the motion was ended, s, if it was. */
void api_events_tell(struct api_events *events, const struct pend_times *times,
                     struct api_stats *stats);

/**
 * Writes the passages as the member `events`, in the place of the closing brace that `out` ends
 * with; nothing without conditions.
 */
PEND_MUST_CHECK enum pend_status api_events_append(const struct api_events *events, int digits,
                                                   struct api_buffer *out);

/** Returns how many times as long as the motion's steps the search takes; 0 without one. O(1). */
double api_events_times(const struct api_events *events);

/** Bytes that the passages take until the next turn ends. O(1). */
double api_events_bytes(const struct api_events *events);

#endif
