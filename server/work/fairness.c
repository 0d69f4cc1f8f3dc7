#include "server/work/fairness.h"

#include <poll.h>
#include <sched.h>
#include <time.h>

#include "server/base/clock.h"

/* look: ns between two checks of the queue by a worker. nap: longest sleep of a worker, ns. It is
 * longer than a tick of the kernel's clock (4 ms), because for a shorter one the kernel programs
 * the processor's timer, which in a virtual machine costs ten times as much as sleeping and waking.
 * The nap is only a safety net, because workers check often enough. */
static const int64_t fairness_look = 400000, fairness_nap = 5000000;

void srv_fairness_init(struct srv_fairness *fairness, const struct srv_queue *queue, int workers) {
    assert(workers > 0);
    fairness->queue = queue;
    fairness->workers = workers;
    atomic_init(&fairness->computing, 0);
    atomic_init(&fairness->fd, -1);
    atomic_init(&fairness->napping, 0);
    sem_init(&fairness->wake, 0, 0);
}

void srv_fairness_clear(struct srv_fairness *fairness) { sem_destroy(&fairness->wake); }

/* Returns 1 if every worker has a short task or is about to take one. */
static int fairness_all_busy(struct srv_fairness *fairness) {
    return atomic_load(&fairness->computing) + srv_queue_waiting(fairness->queue, 0) >=
           fairness->workers;
}

void srv_fairness_nap(struct srv_fairness *fairness, int fd) {
    assert(fd >= 0 && !atomic_load(&fairness->napping));
    atomic_store(&fairness->fd, fd);
    if (!fairness_all_busy(fairness)) return;
    struct timespec until = srv_clock_timespec(srv_clock_now() + fairness_nap);
    atomic_store(&fairness->napping, 1);
    int over =
        !fairness_all_busy(fairness) || sem_clockwait(&fairness->wake, CLOCK_MONOTONIC, &until);
    /* Another thread cleared the flag, so it raises the semaphore. */
    if (over && !atomic_exchange(&fairness->napping, 0))
        while (sem_wait(&fairness->wake)) continue;
}

static void fairness_wake(struct srv_fairness *fairness) {
    if (atomic_load(&fairness->napping) && atomic_exchange(&fairness->napping, 0))
        sem_post(&fairness->wake);
}

void srv_fairness_begin(struct srv_fairness *fairness, int level) {
    atomic_fetch_add(&fairness->computing, !level);
}

void srv_fairness_end(struct srv_fairness *fairness, int level) {
    int before = atomic_fetch_sub(&fairness->computing, !level);
    assert(before >= !level);
    (void)before;
    if (fairness_all_busy(fairness))
        srv_fairness_look(fairness);
    else
        fairness_wake(fairness);
}

void srv_fairness_look(struct srv_fairness *fairness) {
    static _Thread_local int64_t looked;
    int64_t now = srv_clock_now();
    if (now - looked < fairness_look) return;
    looked = now;
    struct pollfd look = {.fd = atomic_load(&fairness->fd), .events = POLLIN};
    if (poll(&look, 1, 0) <= 0 || !(look.revents & POLLIN)) return;
    fairness_wake(fairness);
    sched_yield();
}
