/* The sockets' thread and those that compute, where they share a processor: who lets whom go
 * first.
 * Leaves to others: what either does (http, workers). Invariant: the sockets' thread sleeps here
 * for a moment at most, and only while every worker has a short task; nobody else ever sleeps
 * here. */
#ifndef SRV_FAIRNESS_H
#define SRV_FAIRNESS_H

#include <semaphore.h>
#include <stdatomic.h>

#include "server/work/queue.h"

struct srv_fairness {
    const struct srv_queue *queue;
    int workers;
    atomic_int computing; /* workers that have a task of the lowest level */
    atomic_int fd;        /* readable while the sockets' thread has work; -1 before it has begun */
    atomic_int napping;   /* the sockets' thread sleeps until `wake`, or for a moment */
    sem_t wake;
};

void srv_fairness_init(struct srv_fairness *fairness, const struct srv_queue *queue, int workers);

void srv_fairness_clear(struct srv_fairness *fairness);

/**
 * For the sockets' thread, before it waits for what comes.
 *
 * While every worker has a short task, what comes may wait for its end. Each request and each
 * finished answer would push a worker aside; so the thread lets them gather until a worker looks,
 * or has nothing to do, or a moment is over.
 *
 * fd  what it will wait for: an epoll descriptor.
 */
void srv_fairness_nap(struct srv_fairness *fairness, int fd);

/** For a worker: it has a task of that level; it has it no more. */
void srv_fairness_begin(struct srv_fairness *fairness, int level);
void srv_fairness_end(struct srv_fairness *fairness, int level);

/**
 * For a worker in mid-task: where something has come it lets the sockets' thread go first. Looks a
 * few thousand times a second at most, however often it is called.
 */
void srv_fairness_look(struct srv_fairness *fairness);

#endif
