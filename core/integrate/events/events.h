/* The instants at which a quantity of a motion reaches a given value: an angle, a rate, a force, a
 * position, a distance, an energy.
 * Leaves to others: finding them in a step (event_search), the steps (method_taylor), samples
 * (run), the horizon of the accuracy (horizon).
 * Invariant: instants are roots of the power series of the steps, in order of time; each crossing
 * of the computed motion is found once, even close to another crossing or to the end of a step. */
#pragma once

#include "core/integrate/events/event_search.h"

struct pend_events_problem {
    const struct pend_tree *tree; /* must outlive the search */
    struct pend_loads loads;
    const double *phi, *rate;         /* initial state, n values each, stored order; copied */
    const double *phi_low, *rate_low; /* low-order parts of the initial state; NULL = 0 */
    double start;                     /* s, time of the start in the time of the drives */
    double duration;                  /* s, not 0; < 0: backwards in time */
    double rtol, atol;                /* as for the taylor method; 0 = its default */
    double accuracy;                  /* requested accuracy, as in horizon.h; 0 = no horizon */
    int count;                        /* number of conditions, >= 1 */
    const struct pend_event *event;   /* `count` conditions; must outlive the search */
};

struct pend_events;

/**
 * Prepares a search; a start at the given value is not a passage.
 *
 * events  out; NULL on failure; released by pend_events_free.
 *
 * PEND_INVALID    no duration, no such arm, a level that is not finite.
 * PEND_NO_MEMORY, and the failures of the method's `open`.
 */
PEND_MUST_CHECK enum pend_status pend_events_new(struct pend_events **events,
                                                 const struct pend_events_problem *problem,
                                                 struct pend_error *error);
void pend_events_free(struct pend_events **events);

/**
 * Searches for the next passage in time; of simultaneous passages, that of the first condition.
 *
 * steps      the largest number of integration steps of this call, >= 1.
 * found      out: nothing yet; a passage; or the end of the search, because the duration is over, a
 *            condition stopped the motion, or all passages are reported.
 * hit        out, if a passage was found.
 * phi, rate  out, n values each: the state at the passage.
 *
 * PEND_NOT_FINITE, PEND_STEP_TOO_SMALL  error contains the time.
 * No allocation. Cost per step: the step of the method, plus O(order^2) for each condition; for a
 * position times the number of arms up to the pivot, for energies once times n.
 */
PEND_MUST_CHECK enum pend_status pend_events_next(struct pend_events *events, long steps,
                                                  enum pend_found *found, struct pend_hit *hit,
                                                  double phi[], double rate[],
                                                  struct pend_error *error);

/** Returns the time, s after the start, at which a condition stopped the motion; NaN if none did.
 */
double pend_events_stopped(const struct pend_events *events);

/** Returns the time, s after the start, up to which the searched motion keeps the problem's
 * accuracy. It is at most the time at which a condition stopped the motion; NaN if the problem has
 * no accuracy. */
double pend_events_held(const struct pend_events *events);

/** Returns the number of integration steps so far. */
long pend_events_steps(const struct pend_events *events);

/** Returns the fraction of the duration that was searched, 0 .. 1. */
double pend_events_progress(const struct pend_events *events);
