/* Waiting for another thread until an instant of the clock that never goes back.
 * Leaves to others: the mutex, what is waited for, waking (pthread_cond_signal).
 * Invariant: a change of the wall clock makes no wait shorter or longer. */
#ifndef SRV_CONDITION_H
#define SRV_CONDITION_H

#include <pthread.h>
#include <stdint.h>

/* An instant that never comes. */
#define SRV_CONDITION_NEVER INT64_MAX

/** Makes a condition variable for srv_condition_wait; ended by pthread_cond_destroy. */
void srv_condition_init(pthread_cond_t *condition);

/**
 * Waits with the mutex held, as pthread_cond_wait does: it may return without a reason.
 *
 * until  ns of srv_clock_now, or SRV_CONDITION_NEVER. An instant that is over lets go of the mutex
 *        for a moment and does not wait.
 *
 * Returns false once that instant is over.
 */
int srv_condition_wait(pthread_cond_t *condition, pthread_mutex_t *mutex, int64_t until);

#endif
