/* Waiting for another thread until an instant of the monotonic clock.
 * Leaves to others: the mutex, the awaited condition, waking (pthread_cond_signal).
 * Invariant: a change of the wall clock makes no wait shorter or longer. */
#pragma once

#include <pthread.h>
#include <stdint.h>

/* An instant that is never reached. */
#define SRV_CONDITION_NEVER INT64_MAX

/** Initializes a condition variable for srv_condition_wait; ends with pthread_cond_destroy. */
void srv_condition_init(pthread_cond_t *condition);

/**
 * Waits with the mutex held, as pthread_cond_wait does: the call may return without a reason.
 *
 * until  ns of srv_clock_now, or SRV_CONDITION_NEVER. If the instant has passed, the mutex is
 * released for a moment and the call does not wait.
 *
 * Returns false once that instant has passed.
 */
int srv_condition_wait(pthread_cond_t *condition, pthread_mutex_t *mutex, int64_t until);
