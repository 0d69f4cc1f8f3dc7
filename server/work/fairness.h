/* Sharing of processors between the sockets' thread and the workers if there are fewer processors
 * than threads.
 * Leaves to others: the work of the threads (http, workers).
 * Invariant: only the sockets' thread sleeps here, for 5 ms at most, and only while every worker
 * has a short task. */
#pragma once

#include <semaphore.h>
#include <stdatomic.h>

#include "server/work/queue.h"

struct srv_fairness {
    const struct srv_queue *queue;
    int workers;
    atomic_int computing; /* workers that have a task of the lowest level */
    atomic_int fd;        /* readable while the sockets' thread has work; -1 before it has begun */
    atomic_int napping;   /* the sockets' thread sleeps until `wake`, or for a short time */
    sem_t wake;
};

/** Initializes the sharing for a queue and a number of workers. Ends with srv_fairness_clear. */
void srv_fairness_init(struct srv_fairness *fairness, const struct srv_queue *queue, int workers);

/** Frees it; no thread may use it any more. */
void srv_fairness_clear(struct srv_fairness *fairness);

/**
 * Called by the sockets' thread before it waits for events. While every worker has a short task, it
 * sleeps until a worker calls srv_fairness_look or is idle, or for 5 ms. Otherwise each request and
 * each answer would interrupt a worker; this way several are handled after one context switch.
 *
 * fd  the epoll descriptor on which the thread will wait.
 */
void srv_fairness_nap(struct srv_fairness *fairness, int fd);

/** Called by a worker when it begins and when it ends a turn on a task of that level. */
void srv_fairness_begin(struct srv_fairness *fairness, int level);
void srv_fairness_end(struct srv_fairness *fairness, int level);

/** Called by a worker between two pieces of a task: yields its processor if the sockets' thread has
 * events. Checks at most every 0.4 ms. */
void srv_fairness_look(struct srv_fairness *fairness);
