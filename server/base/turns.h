/* Fair scheduling on three levels: roads (addresses, rooms) take turns, the lanes (clients) of a
 * road take turns, and a lane is first in, first out. The queue, the storage and classrooms use
 * them.
 * Leaves to others: locks, the waiting objects, bounds.
 * Invariant: a road is linked while one of its lanes is, a lane while something waits in it. */
#pragma once

#include "server/base/list.h"

enum { SRV_TURNS_ROW = 8 /* maximum number of consecutive turns of a road */ };

/* The roads that wait. Initialized as {0}. */
struct srv_turns {
    struct srv_list roads; /* the ring of roads in which something waits; the next one first */
};

/* Initialized as {0}; its memory may be freed while nothing in it waits. */
struct srv_turns_road {
    struct srv_list link, lanes; /* link in the ring of roads; the ring of its lanes in which
                                  * something waits */
    int busy, turns;             /* number of linked lanes; consecutive turns used so far */
};

/* Initialized as {0}. It belongs to one road while something waits in it. */
struct srv_turns_lane {
    struct srv_list link, waiting; /* link among the lanes of its road; the waiting links */
};

/** Appends a link to its lane. */
void srv_turns_add(struct srv_turns *turns, struct srv_turns_road *road,
                   struct srv_turns_lane *lane, struct srv_list *link);

/** Removes a link that waits in the lane. */
void srv_turns_remove(struct srv_turns_road *road, struct srv_turns_lane *lane,
                      struct srv_list *link);

/**
 * Returns the link whose turn it is, or NULL if none waits. The caller removes the link.
 *
 * The roads take turns; a road has as many consecutive turns as it has waiting lanes, at most
 * SRV_TURNS_ROW. The lanes of a road take turns, and a lane is first in, first out. O(1).
 */
struct srv_list *srv_turns_next(struct srv_turns *turns);
