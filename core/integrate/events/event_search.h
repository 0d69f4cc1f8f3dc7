/* Conditions on a motion, watched step by step: where in a step a quantity comes to its level.
 * Leaves to others: the quantities' series (event_series), the steps (events for one motion,
 * ensemble_watch for the members of an ensemble).
 * Invariant: the side of its level that a quantity is on passes from step to step, so that a
 * crossing is found once, however near it is to another one or to the end of a step. */
#pragma once

#include "core/integrate/events/event.h"
#include "core/integrate/events/event_series.h"

/* the most hits of a condition and its two bounds in a step */
enum { EVENT_HITS = 2 * (PEND_ROOTS_DEGREE + 1) };

/* What is known of a condition between the steps of a motion. */
struct event_watch {
    /* Of the upper and the lower bound: the quantity is at its level or above; negative while it
     * has been at the level since the start. */
    int above[2];
    long told;
};

/* The conditions and the passages of a step. One search serves any number of motions in turn, each
 * with watches of its own. */
struct event_search {
    int count;
    const struct pend_event *event;
    int queued, next;         /* the hits of the step, and the next of them to be told */
    double *room;             /* memory for the energies' series, or NULL */
    struct event_truth truth; /* memory for forces of states; phi NULL where none is asked for */
    double kinetic[EVENT_TERMS], potential[EVENT_TERMS]; /* of the step, if there is room */
    struct pend_hit *queue;                              /* count EVENT_HITS */
};

/**
 * Checks conditions.
 *
 * n  stored arms.
 *
 * PEND_INVALID  no such arm, a level that is not finite, none to be told.
 */
PEND_MUST_CHECK enum pend_status pend_event_search_check(int count, const struct pend_event event[],
                                                         int n, struct pend_error *error);

/** Returns the bytes of memory that a search of these conditions needs beside itself, for a tree
 * and its terms. O(count). */
size_t pend_event_search_bytes(int count, const struct pend_event event[],
                               const struct pend_tree *tree, const struct pend_loads *loads);

/** Prepares a search in the caller's memory of pend_event_search_bytes, aligned to 8; the
 * conditions must outlive it. */
void pend_event_search_init(struct event_search *search, int count, const struct pend_event event[],
                            const struct pend_tree *tree, void *memory);

/**
 * Finds the passages of a step, and puts them into the queue in the order of time; of simultaneous
 * ones that of the first condition first.
 *
 * step   without degree and room where no energy is asked for; without truth.
 * watch  of the motion, count of them; zeros before its first step.
 * from   s, the step's beginning, after the motion's start.
 * first  non-zero in the motion's first step: a start at the wanted value is no passage.
 *
 * No allocation. O(order) for each condition that the step stays away from, else O(order^2), times
 * the arms on the way to the pivot for a place; and once that of all arms, if there is an energy.
 */
void pend_event_search_step(struct event_search *search, struct event_step *step,
                            struct event_watch watch[], double from, int first);

/**
 * Takes the next passage of the queue that is to be told, and counts it.
 *
 * stops  out: non-zero if it ends the motion.
 *
 * Returns NULL if there is none.
 */
const struct pend_hit *pend_event_search_take(struct event_search *search,
                                              struct event_watch watch[], int *stops);

/** True if no condition has anything more to tell of a motion. O(count). */
int pend_event_search_told(const struct event_search *search, const struct event_watch watch[]);
