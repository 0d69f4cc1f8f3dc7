/* The passages of the conditions on an ensemble's members, as columns: the first of each condition
 * next to the member's observables, or all of them as rows.
 * Leaves to others: reading the conditions (events_json), the search (core/ensemble).
 * Invariant: a passage that did not occur has the time NaN and zeros. */
#pragma once

#include "api/op/events_json.h"

/**
 * Reads `events`, and `rows`: whether the answer's rows are the passages.
 *
 * tree        the ensemble's, which must outlive the events.
 * trajectory  non-zero: trajectories are requested, which excludes conditions.
 *
 * Every error is added to the problem.
 */
void api_member_events_read(struct api_events *events, const struct api_reading *reading,
                            const struct api_tree *tree, int trajectory);

/** Adds the columns of the first passages of a member, or of a row of passages. */
void api_member_events_columns(const struct api_events *events, struct api_table *table);

/** Returns the largest number of reported passages of a member. O(conditions). */
double api_member_events_most(const struct api_events *events);

/** Initializes the columns of passages to "none". at: the first of them in a member's row. */
void api_member_events_blank(const struct api_events *events, double unknown, double at[]);

/** Stores a passage in the columns of its member. phi, rate: the state, stored order. */
void api_member_events_note(const struct api_events *events, const struct pend_hit *hit,
                            const double phi[], const double rate[], double at[]);

/** Writes a passage of a member as a row; its status is 0. */
void api_member_events_row(const struct api_events *events, long member, const struct pend_hit *hit,
                           const double phi[], const double rate[], double row[]);

/** Returns the estimated time of the search in one step of one member, s. O(1). */
double api_member_events_cost(const struct api_events *events);

/** Returns the bytes of memory of the search in an ensemble. O(1). */
double api_member_events_bytes(const struct api_events *events);
