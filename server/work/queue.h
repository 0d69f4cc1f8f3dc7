/* Tasks that wait for a worker: bounded, short ones before long ones, and fair among those who
 * brought them: first among addresses, then among the clients of each. Leaves to others: what a
 * task is and how long it will take (compute), who brought it (clients), who runs it (workers).
 * Invariant: a task is in at most one place at a time:
 * here, with a worker, or with its owner. */
#ifndef SRV_QUEUE_H
#define SRV_QUEUE_H

#include "core/base/status.h"
#include "server/base/list.h"

enum {
    SRV_QUEUE_LEVELS = 4, /* 0 = the shortest tasks */
    SRV_QUEUE_TURNS = 8,  /* most turns in a row of one road */
    SRV_QUEUE_SHARE =
        8 /* of so many tasks taken, one is not of the shortest waiting but of any level in turn */
};

/* Where many lanes come from, as an address with many clients; the queue's, once it was used.
 * Begins as {0}. */
struct srv_road {
    struct {
        struct srv_list link; /* in the level's ring of roads that have tasks; first of its level */
        struct srv_list lanes; /* the ring of its lanes that have tasks of the level */
        int busy, turns;       /* how many these are; turns since the road became the first */
    } at[SRV_QUEUE_LEVELS];
    int count; /* tasks of all its lanes */
};

/* Whoever brings tasks has a lane in the queue; the queue's, once it was used. Begins as {0},
 * ends when empty. */
struct srv_lane {
    struct {
        struct srv_list link;  /* in its road's ring of lanes that have tasks; first of its level */
        struct srv_list tasks; /* the ring of its tasks */
    } at[SRV_QUEUE_LEVELS];
    int count;
    struct srv_road
        own; /* of a lane that comes from nowhere else, and of those that come from there */
    struct srv_road *road; /* NULL = its own; to be changed by its owner while the lane is empty */
};

/* Something to run; lives inside its owner's structure, so that queueing allocates nothing. */
struct srv_task {
    struct srv_list link; /* the queue's */
    /* on a worker's thread. 1: it is not done and goes to the end of its lane; 0: its life may
     * have ended */
    int (*run)(struct srv_task *task);
    struct srv_lane *lane; /* who brought it */
    int level;             /* how long it may take; not to be changed while it waits */
    int queued;            /* the queue's */
};

struct srv_queue;

/**
 * An empty queue.
 *
 * cap       most tasks that wait, >= 1.
 * lane_cap  most tasks of one lane that wait, >= 1.
 *
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status srv_queue_new(struct srv_queue **queue, int cap, int lane_cap);

/** Sets both bounds anew; what waits already goes on waiting. Any thread. */
void srv_queue_bound(struct srv_queue *queue, int cap, int lane_cap);

/** Frees a queue that is empty and has no one waiting in it. */
void srv_queue_free(struct srv_queue **queue);

/**
 * Adds a task at the end of its lane and level.
 *
 * PEND_LIMIT    there is no room, or the queue is closed; the task stays its owner's.
 * PEND_INVALID  the lane has no room, or its road: three quarters of the queue, unless one lane may
 *               have more.
 */
PEND_MUST_CHECK enum pend_status srv_queue_push(struct srv_queue *queue, struct srv_task *task);

/** Adds a task that was taken from here before and is not done: there is always room for it. */
void srv_queue_again(struct srv_queue *queue, struct srv_task *task);

/**
 * Takes a task, waiting for one; NULL once the queue is closed and empty.
 *
 * Of the lowest level that has any, but for one in SRV_QUEUE_SHARE; of the roads there in turn,
 * each for as many turns in a row as it has lanes that wait, SRV_QUEUE_TURNS at most; of the road's
 * lanes in turn; of the lane the first.
 */
struct srv_task *srv_queue_pop(struct srv_queue *queue);

/**
 * Adds a task that was taken from here, and takes the next, which may be the same, at one instant:
 * nobody finds the lane fuller by the one that a worker has.
 */
struct srv_task *srv_queue_swap(struct srv_queue *queue, struct srv_task *task);

/** Takes a task out of the middle. Returns 0 when it is not there any more: a worker has it or
 * had it. O(1). */
int srv_queue_remove(struct srv_queue *queue, struct srv_task *task);

/** Tasks that wait; without a lock, so that it may be past. */
int srv_queue_count(const struct srv_queue *queue);

/** Tasks of a level that wait; without a lock, so that it may be past. */
int srv_queue_waiting(const struct srv_queue *queue, int level);

/** True when a task of a level below this one waits; without a lock, so that it may be past. */
int srv_queue_shorter(const struct srv_queue *queue, int level);

/** Refuses further new tasks and wakes who waits once it is empty. */
void srv_queue_close(struct srv_queue *queue);

/** Checks the links and the counts; for tests and assertions. */
int srv_queue_valid(struct srv_queue *queue);

#endif
