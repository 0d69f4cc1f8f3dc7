#include "server/work/fairness.h"

#include <poll.h>
#include <sched.h>
#include <time.h>

#include "server/base/clock.h"

/* ns: between two looks of a worker; longest nap. The nap is longer than a tick of the kernel's clock (4 ms): a shorter
 * time than that is what the processor's own timer has to be set to and back for each nap, which in a virtual machine
 * takes ten times as long as going to sleep and waking. It is no more than a net: workers look. */
static const int64_t intake_look = 400000, intake_nap = 5000000;

void srv_intake_init(struct srv_intake *intake, const struct srv_queue *queue, int workers) {
    intake->queue = queue;
    intake->workers = workers;
    atomic_init(&intake->computing, 0);
    atomic_init(&intake->fd, -1);
    atomic_init(&intake->napping, 0);
    sem_init(&intake->wake, 0, 0);
}

void srv_intake_clear(struct srv_intake *intake) { sem_destroy(&intake->wake); }

/* every worker has a short task, or is about to */
static int intake_all_busy(struct srv_intake *intake) {
    return atomic_load(&intake->computing) + srv_queue_waiting(intake->queue, 0) >= intake->workers;
}

void srv_intake_nap(struct srv_intake *intake, int fd) {
    atomic_store(&intake->fd, fd);
    if (!intake_all_busy(intake)) return;
    int64_t end = srv_clock_now() + intake_nap;
    struct timespec until = {end / 1000000000, end % 1000000000};
    atomic_store(&intake->napping, 1);
    int over = !intake_all_busy(intake) || sem_clockwait(&intake->wake, CLOCK_MONOTONIC, &until);
    /* who took the flag away has raised the semaphore, or is about to */
    if (over && !atomic_exchange(&intake->napping, 0))
        while (sem_wait(&intake->wake)) continue;
}

static void intake_wake(struct srv_intake *intake) {
    if (atomic_load(&intake->napping) && atomic_exchange(&intake->napping, 0)) sem_post(&intake->wake);
}

void srv_intake_begin(struct srv_intake *intake, int level) { atomic_fetch_add(&intake->computing, !level); }

void srv_intake_end(struct srv_intake *intake, int level) {
    atomic_fetch_sub(&intake->computing, !level);
    if (intake_all_busy(intake))
        srv_intake_look(intake);
    else
        intake_wake(intake);
}

void srv_intake_look(struct srv_intake *intake) {
    static _Thread_local int64_t looked;
    int64_t now = srv_clock_now();
    if (now - looked < intake_look) return;
    looked = now;
    struct pollfd look = {.fd = atomic_load(&intake->fd), .events = POLLIN};
    if (poll(&look, 1, 0) <= 0 || !(look.revents & POLLIN)) return;
    intake_wake(intake);
    sched_yield();
}
