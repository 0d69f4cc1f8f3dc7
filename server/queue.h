/* Tasks that wait for a worker: bounded, first in, first out.
 * Leaves to others: what a task is, who runs it (workers).
 * Invariant: a task is in at most one place at a time: here, with a worker, or with its owner. */
#ifndef SRV_QUEUE_H
#define SRV_QUEUE_H

#include "core/status.h"

/* Something to run; lives inside its owner's structure, so that queueing allocates nothing. */
struct srv_task {
    void (*run)(struct srv_task *task); /* on a worker's thread; may end the task's life */
    struct srv_task *next, *previous;   /* the queue's */
    int queued;                         /* the queue's */
};

struct srv_queue;

/**
 * An empty queue.
 *
 * cap  most tasks that wait, >= 1.
 *
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status srv_queue_new(struct srv_queue **queue, int cap);

/** Frees a queue that is empty and has no one waiting in it. */
void srv_queue_free(struct srv_queue **queue);

/**
 * Adds a task at the end.
 *
 * PEND_LIMIT  there is no room, or the queue is closed; the task stays its owner's.
 */
PEND_MUST_CHECK enum pend_status srv_queue_push(struct srv_queue *queue, struct srv_task *task);

/** Takes the first task, waiting for one; NULL once the queue is closed and empty. */
struct srv_task *srv_queue_pop(struct srv_queue *queue);

/** Takes a task out of the middle. Returns 0 when it is not there any more: a worker has it or had it. O(1). */
int srv_queue_remove(struct srv_queue *queue, struct srv_task *task);

/** Tasks that wait. */
int srv_queue_count(struct srv_queue *queue);

/** Refuses further tasks and wakes who waits once it is empty. */
void srv_queue_close(struct srv_queue *queue);

/** Checks the links and the count; for tests and assertions. */
int srv_queue_valid(struct srv_queue *queue);

#endif
