/* A bounded queue of tasks for the workers: short tasks are taken before long ones, addresses take
 * turns, and so do the clients of one address.
 * Leaves to others: tasks and their expected duration (compute), clients (clients), running tasks
 * (workers).
 * Invariant: at any time a task is in the queue, or with one worker, or with its owner. */
#pragma once

#include "core/base/status.h"
#include "server/base/turns.h"

enum {
    SRV_QUEUE_LEVELS = 4,              /* 0 = the shortest tasks */
    SRV_QUEUE_READ = SRV_QUEUE_LEVELS, /* reading a long body in one go, by the reader's thread */
    SRV_QUEUE_LINES,
    SRV_QUEUE_SHARE = 8 /* one in this many tasks is taken not from the shortest waiting ones but
                         * from the levels in turn */
};

/* Lanes of one origin, such as an address with many clients. Initialized as {0}; after its first
 * use only the queue changes it. */
struct srv_road {
    struct srv_turns_road at[SRV_QUEUE_LINES];
    int count; /* tasks of all its lanes */
};

/* The tasks of one client. Initialized as {0}; after its first use only the queue changes it, and
 * its memory may be freed when it is empty. */
struct srv_lane {
    struct srv_turns_lane at[SRV_QUEUE_LINES];
    int count;
    struct srv_road
        own; /* the road of this lane unless `road` is set, and of lanes whose `road` it is */
    struct srv_road *road; /* NULL = `own`; may be changed while the lane is empty */
};

/* A task; part of its owner's structure, so that queueing needs no allocation. */
struct srv_task {
    struct srv_list link; /* used by the queue */
    /* Runs on a worker's thread. Returns 1 if the task should be queued again at the end of its
     * lane; after 0 the task may have been freed. */
    int (*run)(struct srv_task *task);
    struct srv_lane *lane; /* the lane of the task's client */
    int level;             /* 0 = the shortest; SRV_QUEUE_READ; must not change while it waits */
    int queued;            /* used by the queue */
    int road_full; /* out of srv_queue_push: non-zero if the road was full, but the lane was not */
};

struct srv_queue;

/**
 * Creates an empty queue.
 *
 * cap       largest number of waiting tasks, >= 1.
 * lane_cap  largest number of waiting tasks of one lane, >= 1.
 *
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status srv_queue_new(struct srv_queue **queue, int cap, int lane_cap);

/** Replaces both bounds; waiting tasks stay. Any thread. */
void srv_queue_bound(struct srv_queue *queue, int cap, int lane_cap);

/** Frees an empty queue in which no worker waits. */
void srv_queue_free(struct srv_queue **queue);
int srv_queue_valid(struct srv_queue *queue);

/**
 * Adds a task at the end of its lane and level.
 *
 * PEND_LIMIT    the queue is full or closed; the caller keeps the task.
 * PEND_INVALID  the lane or its road is full; a road may have three quarters of the queue, or
 *               lane_cap if that is more.
 */
PEND_MUST_CHECK enum pend_status srv_queue_push(struct srv_queue *queue, struct srv_task *task);

/** Adds an unfinished task that was taken from the queue; the bounds do not apply to it. */
void srv_queue_again(struct srv_queue *queue, struct srv_task *task);

/**
 * Waits for a task and takes it. Returns NULL when the queue is closed and empty.
 *
 * The task is taken from the lowest level that has tasks, but every SRV_QUEUE_SHARE-th task from
 * the levels in turn, and within a level as srv_turns_next says.
 */
struct srv_task *srv_queue_pop(struct srv_queue *queue);

/** Like srv_queue_pop, for tasks at SRV_QUEUE_READ only, which srv_queue_pop does not take. */
struct srv_task *srv_queue_pop_read(struct srv_queue *queue);

/** Adds a task that was taken from the queue and takes the next one, which may be the same, under
 * one lock, so that no other thread sees the lane longer by this task. */
struct srv_task *srv_queue_swap(struct srv_queue *queue, struct srv_task *task);

/** Removes a task from anywhere in the queue. Returns 0 if the task is not in the queue. O(1). */
int srv_queue_remove(struct srv_queue *queue, struct srv_task *task);

/** Returns the number of waiting tasks; read without a lock, so the number may be out of date. */
int srv_queue_count(const struct srv_queue *queue);

/** Returns the number of waiting tasks of a level; read without a lock, so the number may be out of
 * date. */
int srv_queue_waiting(const struct srv_queue *queue, int level);

/** Returns true if a task of a level below this one, SRV_QUEUE_LEVELS at most, waits; read without
 * a lock, so it may be out of date. */
int srv_queue_shorter(const struct srv_queue *queue, int level);

/** Refuses new tasks from now on; srv_queue_pop returns NULL when the queue is empty. */
void srv_queue_close(struct srv_queue *queue);
