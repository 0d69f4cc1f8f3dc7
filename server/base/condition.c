#include "server/base/condition.h"

#include <assert.h>
#include <time.h>

#include "server/base/clock.h"

void srv_condition_init(pthread_cond_t *condition) {
    pthread_condattr_t attributes;
    pthread_condattr_init(&attributes);
    pthread_condattr_setclock(&attributes, CLOCK_MONOTONIC);
    pthread_cond_init(condition, &attributes);
    pthread_condattr_destroy(&attributes);
}

int srv_condition_wait(pthread_cond_t *condition, pthread_mutex_t *mutex, int64_t until) {
    assert(until >= 0);
    if (until == SRV_CONDITION_NEVER) return !pthread_cond_wait(condition, mutex);
    struct timespec time = srv_clock_timespec(until);
    return !pthread_cond_timedwait(condition, mutex, &time);
}
