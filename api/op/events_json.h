/* The conditions of the field `events`: reading them, the search for their passages in a
 * trajectory, and these passages as JSON or as the rows of a table.
 * Leaves to others: the search itself (core/integrate/events), the rest of a trajectory
 * (op_trajectories).
 * Invariant: passages are in the order of time, arms in the caller's order. */
#pragma once

#include "api/encode/encode.h"
#include "api/op/op.h"
#include "api/read/method_json.h"
#include "api/read/state_json.h"
#include "core/integrate/events/events.h"

enum { API_EVENTS_MOST = 64, API_EVENTS_COLUMNS = 7 };

struct api_events {
    int count;       /* number of conditions; 0 = none */
    int rows;        /* whether the answer's rows are passages instead of instants */
    int stops;       /* whether a condition may end the motion */
    double followed; /* number of arms whose positions are computed in each step, for all
                      * conditions */
    struct pend_event event[API_EVENTS_MOST];
    const struct api_tree *tree;
    double step_cap;
    const char *step_name; /* name of the limit on steps */
    long usual;            /* default number of passages that are reported per condition */

    /* set while the search runs */
    struct pend_events *search;
    int searched;
    long found, room;
    double *column[API_EVENTS_COLUMNS]; /* t, event, direction, phi, phid, and a cart's position and
                                         * speed */
    double *state;                      /* angles and rates of all stored arms */
    char warning[API_WARNING_TEXT];
};

/**
 * Reads only the conditions of the field `events`. `events` must have its tree and `usual` set, and
 * be zero otherwise.
 *
 * Every error is added to the problem.
 */
void api_events_read_list(struct api_events *events, const struct api_value *field,
                          const struct api_limits *limits, struct api_problem *problem);

/**
 * Reads the fields `events` and `rows`; released by api_events_clear.
 *
 * tree    the trajectory's, which must outlive the events.
 * start   its initial state; NULL if that is invalid.
 * times   its instants; count 0 if they are invalid.
 *
 * Every error is added to the problem.
 */
void api_events_read(struct api_events *events, const struct api_reading *reading,
                     const struct api_tree *tree, const struct api_states *start,
                     const struct api_method *method, const struct pend_times *times);
void api_events_clear(struct api_events *events);

/**
 * Continues the search until the turn is over or `searched` is set.
 *
 * times  instants of the trajectory; the search goes from the first to the last. If a condition
 *        ends the motion, later instants are removed.
 *
 * PEND_NO_MEMORY, PEND_TOO_MANY_STEPS; also fails as pend_events_next does.
 */
PEND_MUST_CHECK enum pend_status
api_events_look(struct api_events *events, const struct api_states *start,
                const struct api_method *method, struct pend_times *times,
                const struct api_turn *turn, struct pend_error *error);

/** Writes the passages as the rows of an answer, then the statistics, until the turn is over. */
PEND_MUST_CHECK enum pend_status
api_events_write(struct api_events *events, const struct pend_times *times,
                 struct api_writer *writer, struct api_stats *stats, const struct api_turn *turn,
                 int *done, struct pend_error *error);

/** If passages are the rows, sets the table's columns and the largest number of rows, which is
 * known exactly only at the end. */
void api_events_columns(const struct api_events *events, struct api_table *table);

/**
 * Adds the number of passages, and the time, s, at which a condition ended the motion. If passages
 * are the rows, adds the number of the search's steps and the horizon.
 */
void api_events_tell(struct api_events *events, const struct pend_times *times,
                     struct api_stats *stats);

/** Writes the passages as the member `events`, replacing the closing brace at the end of `out`; no
 * effect without conditions. */
PEND_MUST_CHECK enum pend_status api_events_append(const struct api_events *events, int digits,
                                                   struct api_buffer *out);

/** Returns the time of the search relative to that of the motion's steps; 0 without a search.
 * O(1). */
double api_events_times(const struct api_events *events);

/** Returns the bytes of memory of the passages until the next turn ends. O(1). */
double api_events_bytes(const struct api_events *events);
