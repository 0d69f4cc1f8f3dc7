/* The instants at which something about a motion comes to a wanted value: an angle, a rate, a
 * force, a place, a distance, an energy.
 * Leaves to others: where in a step they are (event_search), the steps (method_taylor), samples
 * (run), how long the digits hold (horizon).
 * Invariant: instants are roots of power series of each step, in order of time; a crossing that the
 * computed motion makes is found once, however near it is to another one or to the end of a step.
 */
#pragma once

#include "core/integrate/events/event_search.h"

struct pend_events_problem {
    const struct pend_tree *tree; /* must outlive the search */
    struct pend_loads loads;
    const double *phi, *rate;         /* start, n values each, stored order; copied */
    const double *phi_low, *rate_low; /* their rounding errors; NULL = 0 */
    double start;                     /* s, in the time of the drives */
    double duration;                  /* s, not 0; below 0 backwards in time */
    double rtol, atol;                /* as of the taylor method; 0 = its default */
    double accuracy;                  /* as of horizon.h; 0 = how long it holds is not asked */
    int count;                        /* >= 1 */
    const struct pend_event *event;   /* count of them; must outlive the search */
};

struct pend_events;

/**
 * Prepares a search; a start at the wanted value is no passage.
 *
 * events  out; NULL on failure; released by pend_events_free.
 *
 * PEND_INVALID    no duration, no such arm, a level that is not finite.
 * PEND_NO_MEMORY, and what the method's open returns.
 */
PEND_MUST_CHECK enum pend_status pend_events_new(struct pend_events **events,
                                                 const struct pend_events_problem *problem,
                                                 struct pend_error *error);

/** Frees a search and clears the pointer; NULL is accepted. */
void pend_events_free(struct pend_events **events);

/**
 * Looks for the next passage in time; of simultaneous ones that of the first condition.
 *
 * steps      the largest number of integration steps of this call, >= 1.
 * found      out: nothing yet, a passage, or the end: of the duration, of the motion by a condition
 *            that stops it, or of all that is to be told.
 * hit        out, if one was found.
 * phi, rate  out, n values each: the state then.
 *
 * PEND_NOT_FINITE, PEND_STEP_TOO_SMALL  error says the time.
 * No allocation. A step costs what the method's does, and O(order^2) for each condition, times the
 * arms on the way to the pivot for a place; and once that of all arms, if there is an energy.
 */
PEND_MUST_CHECK enum pend_status pend_events_next(struct pend_events *events, long steps,
                                                  enum pend_found *found, struct pend_hit *hit,
                                                  double phi[], double rate[],
                                                  struct pend_error *error);

/** Returns the time, s after the start, at which a condition stopped the motion; NaN if none did.
 */
double pend_events_stopped(const struct pend_events *events);

/**
 * Returns the time, s after the start, up to which the motion keeps the problem's accuracy, as far
 * as it was searched, and no further than where a condition stopped it; NaN without an accuracy.
 */
double pend_events_held(const struct pend_events *events);

/** Returns the number of integration steps so far. */
long pend_events_steps(const struct pend_events *events);

/** Returns the part of the duration that was searched, 0 .. 1. */
double pend_events_progress(const struct pend_events *events);
