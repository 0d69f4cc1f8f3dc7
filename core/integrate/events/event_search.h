/* Conditions on a motion, searched step by step: where in a step a quantity reaches its level.
 * Leaves to others: the quantities' series (event_series), the steps (events for one motion,
 * ensemble_watch for the members of an ensemble).
 * Invariant: the side of the level on which a quantity lies is kept from step to step, so that each
 * crossing is found once, even close to another crossing or to the end of a step. */
#pragma once

#include "core/integrate/events/event.h"
#include "core/integrate/events/event_series.h"

/* maximum number of hits of a condition with two bounds in a step */
enum { EVENT_HITS = 2 * (PEND_ROOTS_DEGREE + 1) };

/* The state of a condition between the steps of a motion. */
struct event_watch {
    /* For the upper and the lower bound: whether the quantity is at its level or above; negative
     * while it has stayed at the level since the start. */
    int above[2];
    long told;
};

/* The conditions and the passages of a step. One search serves any number of motions in turn; each
 * motion has its own watches. */
struct event_search {
    int count;
    const struct pend_event *event;
    int queued, next;         /* number of hits of the step; index of the next hit to report */
    double *room;             /* memory for the series of the energies, or NULL */
    struct event_truth truth; /* memory for forces computed from states; phi is NULL if no force is
                               * requested */
    double kinetic[EVENT_TERMS], potential[EVENT_TERMS]; /* series of the step, if there is memory
                                                          * for them */
    struct pend_hit *queue;                              /* EVENT_HITS entries per condition */
};

/**
 * Checks conditions.
 *
 * n  stored arms.
 *
 * PEND_INVALID  no such arm, a level that is not finite, no passage to report.
 */
PEND_MUST_CHECK enum pend_status pend_event_search_check(int count, const struct pend_event event[],
                                                         int n, struct pend_error *error);

/** Returns the bytes of memory that a search of these conditions needs in addition to its
 * structure, for a tree and its terms. O(count). */
size_t pend_event_search_bytes(int count, const struct pend_event event[],
                               const struct pend_tree *tree, const struct pend_loads *loads);

/** Prepares a search in the caller's memory of pend_event_search_bytes, aligned to 8; the
 * conditions must outlive it. */
void pend_event_search_init(struct event_search *search, int count, const struct pend_event event[],
                            const struct pend_tree *tree, void *memory);

/**
 * Finds the passages of a step and appends them to the queue in the order of time, simultaneous
 * passages in the order of conditions.
 *
 * step   degree and room may be unset if no energy is requested; truth is unset.
 * watch  `count` watches of the motion; zeros before its first step.
 * from   s, start of the step, relative to the motion's start.
 * first  non-zero in the motion's first step, where a start at the level is not a passage.
 *
 * No allocation. O(order) for each condition far from its level, otherwise O(order^2); for a
 * position times the number of arms up to the pivot, for energies once times n.
 */
void pend_event_search_step(struct event_search *search, struct event_step *step,
                            struct event_watch watch[], double from, int first);

/** Appends a passage to the queue of the step, in the order of time, unless its condition does not
 * concern that way. */
void pend_event_search_note(struct event_search *search, double time, int event, int up);

/**
 * Takes the next passage to report from the queue, and counts it.
 *
 * stops  out: non-zero if it ends the motion.
 *
 * Returns NULL if there is none.
 */
const struct pend_hit *pend_event_search_take(struct event_search *search,
                                              struct event_watch watch[], int *stops);

/** Returns true if no condition has further passages of a motion to report. O(count). */
int pend_event_search_told(const struct event_search *search, const struct event_watch watch[]);
