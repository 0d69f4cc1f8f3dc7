#include "server/jobs/part_runner.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "server/base/clock.h"
#include "server/base/condition.h"
#include "server/jobs/events.h"
#include "server/jobs/part_claim.h"
#include "server/jobs/part_slot.h"

struct srv_part_runner {
    struct srv_service *service;
    int64_t lease_us;
    struct srv_lane lane; /* the runner's lane in the queue */
    struct srv_ask release;
    pthread_mutex_t lock;
    pthread_cond_t some;
    pthread_t thread;
    int started, over;
    int doubt;         /* the job of a held part may have ended elsewhere */
    int64_t looked_at; /* ns: earliest time of that check */
    int64_t idle;      /* ns: start of the time without work; 0 = there is work, or it is unknown */
    int draining;      /* 1 = no more claims, 2 = returning the parts, 3 = all are returned */
    struct srv_ask ask; /* the query of a claim */
    int claiming;       /* the query is running */
    struct srv_part_claim claim;
    int count;     /* slots */
    int gathered;  /* results that wait to be stored together */
    int most_long; /* maximum number of long parts that are held at the same time */
    struct srv_part_slot slot[];
};

enum {
    RUNNER_REST_MS = 1000, /* the longest sleep */
    RUNNER_AGAIN_MS = 200,
    RUNNER_BEAT_MS = 500,
    RUNNER_LOOK_MS = 20,  /* ms between two checks, however many notifications arrive */
    RUNNER_DEAF_MS = 50,  /* ms between two checks if the store cannot notify */
    RUNNER_YOUNG_MS = 20, /* a part held for less time is not checked, since it may end soon */
    RUNNER_GATHER_MS = 4, /* longest wait of a result for those of other small parts */
    RUNNER_LONG_MS = 200, /* a part that takes longer is not small, whatever its estimate */
    RUNNER_SMALL = 128    /* the number of slots for small parts */
};

static int64_t runner_ms(int ms) { return (int64_t)ms * 1000000; }

static int slot_small(const struct srv_part_slot *slot) {
    return slot->lease.parts == 1 && slot->lease.part_us <= SRV_SMALL_US;
}

/* Returns the interval between renewals of a lease, in ns. It is much shorter than the lease, and,
 * unless the part is small, short enough to notice a dismissal by another process whose
 * notification was lost. */
static int64_t slot_beat_ns(const struct srv_part_slot *slot) {
    int64_t third = slot->lease_us * 1000 / 3, most = runner_ms(RUNNER_BEAT_MS);
    return third < most || slot_small(slot) ? third : most;
}

static enum srv_stored runner_release(struct srv_store *store, struct srv_store_call *call) {
    struct srv_part_runner *runner = SRV_CONTAINER_OF(call, struct srv_part_runner, release.call);
    return srv_store_release(store, runner->claim.name);
}

PEND_VALIDATOR part_runner_valid(const struct srv_part_runner *runner) {
    /* During a query the storage thread changes the number of claimed parts. */
    return runner->service && runner->count >= 0 && runner->lease_us >= 0 &&
           runner->claim.asked.most <= SRV_CLAIMS && runner->draining >= 0 && runner->draining <= 3;
}

/* --- transitions between states --- */

/* Makes a slot idle, and wakes the thread. The caller holds the lock. */
static void slot_end(struct srv_part_slot *slot) {
    srv_part_slot_drop(slot);
    slot->runner->claim.wanted = 1;
    pthread_cond_signal(&slot->runner->some);
}

/* Puts the slot's task into the queue. The caller holds the lock. */
static void slot_compute(struct srv_part_slot *slot) {
    slot->state = SRV_PART_SLOT_COMPUTE;
    srv_queue_again(slot->runner->service->queue, &slot->task);
}

/* Schedules a repetition of the query. The caller holds the lock. */
static void slot_retry(struct srv_part_slot *slot, enum srv_part_slot_state again) {
    slot->state = SRV_PART_SLOT_RETRY;
    slot->again = again;
    slot->at = srv_clock_now() + runner_ms(RUNNER_AGAIN_MS);
    pthread_cond_signal(&slot->runner->some);
}

static enum srv_stored runner_claim_run(struct srv_store *store, struct srv_store_call *call) {
    struct srv_part_runner *runner = SRV_CONTAINER_OF(call, struct srv_part_runner, ask.call);
    return srv_store_claim(store, &runner->claim.asked, runner->claim.lease);
}

/* Starts a claimed part in a slot. The caller holds the lock. */
static void slot_begins(struct srv_part_slot *slot, const struct srv_lease *lease, int64_t now) {
    struct srv_part_run *run = &slot->run;
    slot->lease = *lease;
    slot->held_at = now;
    srv_metrics_time(&slot->service->metrics.job_wait, 1000 * lease->waited_us);
    slot->beat_at = now + slot_beat_ns(slot);
    if (slot->runner->draining) {
        slot_end(slot);
    } else if (slot->lease.request) {
        srv_part_run_forget(run);
        run->request = slot->lease.request;
        run->request_bytes = slot->lease.request_bytes;
        slot->lease.request = NULL;
        memcpy(run->job, slot->lease.job, sizeof run->job);
        slot_compute(slot);
    } else if (strcmp(run->job, slot->lease.job)) {
        srv_part_run_forget(run);
        srv_part_slot_ask(slot, SRV_PART_SLOT_REQUEST);
    } else {
        slot_compute(slot);
    }
}

static long runner_workers(const struct srv_part_runner *runner) {
    struct srv_storage *storage = runner->service->storage;
    return storage ? srv_storage_figures(storage).workers : 0;
}

static void runner_claimed(struct srv_ask *ask) {
    struct srv_part_runner *runner = SRV_CONTAINER_OF(ask, struct srv_part_runner, ask);
    enum srv_stored stored = ask->call.stored;
    int64_t now = srv_clock_now();
    int given = 0;
    pthread_mutex_lock(&runner->lock);
    assert(part_runner_valid(runner));
    int count = srv_part_claim_take(&runner->claim, stored, runner_workers(runner), now);
    runner->claiming = 0;
    // since when there is no part, neither held nor available
    int holds = stored != SRV_STORED_NONE;
    for (int i = 0; i < runner->count; i++) holds |= srv_part_slot_holds(&runner->slot[i]);
    runner->idle = holds ? 0 : runner->idle ? runner->idle : now;
    for (int i = 0; i < runner->count; i++) {
        struct srv_part_slot *slot = &runner->slot[i];
        if (slot->state != SRV_PART_SLOT_CLAIM) continue;
        slot->state = SRV_PART_SLOT_IDLE;
        if (given < count) slot_begins(slot, &runner->claim.lease[given++], now);
    }
    if (count) srv_events_news(runner->service->events);
    pthread_cond_signal(&runner->some);
    assert(part_runner_valid(runner));
    pthread_mutex_unlock(&runner->lock);
}

static void slot_finish(struct srv_part_slot *slot);

/* Processes the result of a slot's query. The caller holds the lock. */
static void slot_answered(struct srv_part_slot *slot, enum srv_stored stored) {
    enum srv_part_slot_state asked = slot->state;
    int stores = asked == SRV_PART_SLOT_FINISH || asked == SRV_PART_SLOT_FILE;
    struct srv_metrics *metrics = &slot->runner->service->metrics;
    if (stored == SRV_STORED && asked == SRV_PART_SLOT_REQUEST) {
        memcpy(slot->run.job, slot->lease.job, sizeof slot->run.job);
        slot_compute(slot);
    } else if (stored == SRV_STORED && asked == SRV_PART_SLOT_FILE) {
        slot_finish(slot);
    } else if (stored == SRV_STORED_FULL && stores) {
        srv_part_run_say(&slot->run, "the store's disk is full, or that of its files");
        srv_part_slot_ask(slot, SRV_PART_SLOT_FAIL);
    } else if (stored == SRV_STORED_DAMAGED && asked == SRV_PART_SLOT_REQUEST) {
        srv_part_run_say(
            &slot->run,
            "the store's record of this job is damaged (request): submit the job again");
        srv_part_slot_ask(slot, SRV_PART_SLOT_FAIL);
    } else if (stored >= SRV_STORED_FULL) {
        slot_retry(slot, asked);
    } else {
        if (asked == SRV_PART_SLOT_FINISH)
            srv_metrics_time(&metrics->job_run, srv_clock_now() - slot->held_at);
        if (asked == SRV_PART_SLOT_FINISH)
            srv_metrics_count(stored == SRV_STORED ? &metrics->parts_kept : &metrics->parts_lost,
                              1);
        if (asked == SRV_PART_SLOT_FAIL)
            srv_metrics_count(&metrics->parts_failed, stored == SRV_STORED);
        srv_events_news(slot->runner->service->events);
        slot_end(slot);
    }
}

static void slot_done(struct srv_ask *ask) {
    struct srv_part_slot *slot = SRV_CONTAINER_OF(ask, struct srv_part_slot, ask);
    struct srv_part_runner *runner = slot->runner;
    pthread_mutex_lock(&runner->lock);
    assert(part_runner_valid(runner));
    slot_answered(slot, ask->call.stored);
    pthread_mutex_unlock(&runner->lock);
}

static void slot_beaten(struct srv_ask *beat) {
    struct srv_part_slot *slot = SRV_CONTAINER_OF(beat, struct srv_part_slot, beat);
    struct srv_part_runner *runner = slot->runner;
    enum srv_stored stored = beat->call.stored;
    pthread_mutex_lock(&runner->lock);
    slot->beating = 0;
    if (srv_part_slot_beats(slot)) {
        if (!slot->looking)
            slot->beat_at = srv_clock_now() + (stored == SRV_STORED ? slot_beat_ns(slot)
                                                                    : runner_ms(RUNNER_AGAIN_MS));
        if (stored == SRV_STORED_LOST) atomic_store(&slot->run.stop, 1);
    }
    pthread_cond_signal(&runner->some);
    assert(part_runner_valid(runner));
    pthread_mutex_unlock(&runner->lock);
}

/* --- on a worker --- */

/* Stores the result of a part. Small parts that are claimed together are stored together if they
 * end together: a transaction costs more than such a part. The caller holds the lock. */
static void slot_finish(struct srv_part_slot *slot) {
    struct srv_part_runner *runner = slot->runner;
    int computes = 0, small = slot_small(slot);
    slot->state = SRV_PART_SLOT_DONE;
    slot->at = srv_clock_now() + runner_ms(RUNNER_GATHER_MS);
    for (int i = 0; i < runner->count && small; i++)
        computes |= runner->slot[i].state == SRV_PART_SLOT_COMPUTE && slot_small(&runner->slot[i]);
    if (computes && runner->gathered++ == 0) pthread_cond_signal(&runner->some);
    if (!computes) runner->gathered = 0;
    for (int i = 0; i < runner->count && !computes; i++)
        if (runner->slot[i].state == SRV_PART_SLOT_DONE)
            srv_part_slot_ask(&runner->slot[i], SRV_PART_SLOT_FINISH);
}

/* Ends a part that is complete or should stop. */
static void slot_leave(struct srv_part_slot *slot, enum srv_part_slot_state ask) {
    struct srv_part_runner *runner = slot->runner;
    pthread_mutex_lock(&runner->lock);
    assert(part_runner_valid(runner));
    if (ask == SRV_PART_SLOT_IDLE)
        slot_end(slot);
    else if (ask == SRV_PART_SLOT_FINISH && slot->run.file.bytes)
        srv_part_slot_ask(slot, SRV_PART_SLOT_FILE);
    else if (ask == SRV_PART_SLOT_FINISH)
        slot_finish(slot);
    else
        srv_part_slot_ask(slot, ask);
    pthread_mutex_unlock(&runner->lock);
}

static int slot_run(struct srv_task *task) {
    struct srv_part_slot *slot = SRV_CONTAINER_OF(task, struct srv_part_slot, task);
    struct srv_service *service = slot->runner->service;
    int64_t begin = srv_clock_now();
    int again = 0;
    atomic_fetch_add(&service->busy, 1);
    switch (srv_part_run_turn(&slot->run, &slot->lease, slot->task.level)) {
    case SRV_PART_RUN_YIELDS:
        again = 1;
        break;
    case SRV_PART_RUN_STOPPED:
        slot_leave(slot, SRV_PART_SLOT_IDLE);
        break;
    case SRV_PART_RUN_DONE:
        slot_leave(slot, SRV_PART_SLOT_FINISH);
        break;
    case SRV_PART_RUN_FAILED:
        slot_leave(slot, SRV_PART_SLOT_FAIL);
        break;
    }
    atomic_fetch_sub(&service->busy, 1);
    srv_metrics_count(&service->metrics.busy_ns, (unsigned long long)(srv_clock_now() - begin));
    return again;
}

/* --- the runner's thread; its functions are called with the lock --- */

/* The number of parts that may be claimed: long ones that can be computed soon, and small ones. */
static int runner_room(const struct srv_part_runner *runner, int64_t now) {
    int idle = 0, waiting = 0, longs = 0, alone = 0;
    for (int i = 0; i < runner->count; i++) {
        const struct srv_part_slot *slot = &runner->slot[i];
        idle += slot->state == SRV_PART_SLOT_IDLE;
        waiting += slot->state == SRV_PART_SLOT_COMPUTE || slot->state == SRV_PART_SLOT_REQUEST;
        // it occupies a worker for long, by its estimate or by the time used so far
        int computes = slot->state == SRV_PART_SLOT_COMPUTE,
            used = computes && now - slot->held_at > runner_ms(RUNNER_LONG_MS);
        longs += srv_part_slot_holds(slot) && (slot->lease.part_us > SRV_SMALL_US || used);
        alone |= srv_part_slot_holds(slot) && slot->lease.alone;
    }
    if (alone || longs >= runner->most_long || waiting >= RUNNER_SMALL / 2) return 0;
    return idle < SRV_CLAIMS ? idle : SRV_CLAIMS;
}

/* Sends one claim at a time. If it finds parts, the next one follows. */
static void runner_claim(struct srv_part_runner *runner, int64_t now) {
    if (runner->draining || runner->claiming) return;
    int room = runner_room(runner, now), holds = 0;
    for (int i = 0; i < runner->count; i++) holds |= srv_part_slot_holds(&runner->slot[i]);
    if (!srv_part_claim_due(&runner->claim, room, holds, now)) return;
    runner->claiming = 1;
    for (int i = 0; i < runner->count && room; i++)
        if (runner->slot[i].state == SRV_PART_SLOT_IDLE) {
            runner->slot[i].state = SRV_PART_SLOT_CLAIM;
            room--;
        }
    srv_storage_ask(runner->service->storage, SRV_ASK_WRITE, &runner->ask);
}

/* Checks whether the jobs of held parts have ended elsewhere. */
static void runner_look(struct srv_part_runner *runner, int64_t now) {
    if (runner->draining || !runner->doubt || now < runner->looked_at) return;
    int deaf = !srv_storage_hears(runner->service->storage);
    /* a part that is being claimed may belong to such a job */
    runner->doubt = runner->claiming || deaf;
    runner->looked_at = now + runner_ms(deaf ? RUNNER_DEAF_MS : RUNNER_LOOK_MS);
    for (int i = 0; i < runner->count; i++) {
        struct srv_part_slot *slot = &runner->slot[i];
        int later = slot->beating || now - slot->held_at < runner_ms(RUNNER_YOUNG_MS);
        if (!srv_part_slot_holds(slot)) continue;
        runner->doubt |= later;
        if (!later) srv_part_slot_beat(slot, 1);
    }
}

static void runner_retry(struct srv_part_slot *slot, int64_t now) {
    if (slot->state == SRV_PART_SLOT_DONE && now >= slot->at) {
        slot->runner->gathered = 0;
        srv_part_slot_ask(slot, SRV_PART_SLOT_FINISH);
    }
    if (slot->state != SRV_PART_SLOT_RETRY) return;
    if (slot->runner->draining || atomic_load(&slot->run.stop))
        slot_end(slot);
    else if (now >= slot->at)
        srv_part_slot_ask(slot, slot->again);
}

/* ns: the next time at which the thread must act without a notification. */
static int64_t runner_next(const struct srv_part_runner *runner, int64_t now) {
    int64_t next = now + runner_ms(RUNNER_REST_MS),
            claim = srv_part_claim_next(&runner->claim, now);
    if (!runner->draining && !runner->claiming && claim < next) next = claim;
    if (!runner->draining && runner->doubt && runner->looked_at < next) next = runner->looked_at;
    for (int i = 0; i < runner->count; i++) {
        const struct srv_part_slot *slot = &runner->slot[i];
        if (srv_part_slot_holds(slot) && !slot->beating && slot->beat_at < next)
            next = slot->beat_at;
        int waits = slot->state == SRV_PART_SLOT_RETRY || slot->state == SRV_PART_SLOT_DONE;
        if (waits && slot->at < next) next = slot->at;
    }
    return next;
}

static void *runner_main(void *context) {
    struct srv_part_runner *runner = context;
    pthread_mutex_lock(&runner->lock);
    while (!runner->over) {
        int64_t now = srv_clock_now();
        for (int i = 0; i < runner->count; i++) {
            struct srv_part_slot *slot = &runner->slot[i];
            if (srv_part_slot_holds(slot) && !slot->beating && now >= slot->beat_at)
                srv_part_slot_beat(slot, 0);
            runner_retry(slot, now);
        }
        runner_look(runner, now);
        runner_claim(runner, now);
        int64_t next = runner_next(runner, now);
        if (next > now) srv_condition_wait(&runner->some, &runner->lock, next);
    }
    pthread_mutex_unlock(&runner->lock);
    return NULL;
}

/* --- from outside --- */

static void runner_released(struct srv_ask *ask) {
    struct srv_part_runner *runner = SRV_CONTAINER_OF(ask, struct srv_part_runner, release);
    pthread_mutex_lock(&runner->lock);
    runner->draining = 3;
    pthread_mutex_unlock(&runner->lock);
}

enum pend_status srv_part_runner_new(struct srv_part_runner **runner, struct srv_service *service,
                                     int parts) {
    int slots = parts ? parts + RUNNER_SMALL : 0;
    struct srv_part_runner *made = *runner =
        calloc(1, sizeof *made + (size_t)slots * sizeof made->slot[0]);
    if (!made) return PEND_NO_MEMORY;
    made->service = service;
    made->count = slots;
    made->most_long = parts;
    made->ask = (struct srv_ask){.call = {.run = runner_claim_run}, .done = runner_claimed};
    made->lease_us = (int64_t)(1e6 * service->config.job_lease_seconds);
    made->release = (struct srv_ask){.call = {.run = runner_release}, .done = runner_released};
    srv_part_claim_init(&made->claim, made->lease_us);
    pthread_mutex_init(&made->lock, NULL);
    srv_condition_init(&made->some);
    for (int i = 0; i < slots; i++) {
        struct srv_part_slot *slot = &made->slot[i];
        *slot = (struct srv_part_slot){
            .task = {.run = slot_run, .lane = &made->lane, .level = SRV_QUEUE_LEVELS - 1},
            .service = service,
            .runner = made,
            .holder = made->claim.name,
            .lease_us = made->lease_us,
            .ask = {.done = slot_done},
            .beat = {.done = slot_beaten},
        };
        srv_part_run_init(&slot->run, service);
    }
    return PEND_OK;
}

enum pend_status srv_part_runner_start(struct srv_part_runner *runner) {
    if (!runner->count) return PEND_OK;
    runner->started = !pthread_create(&runner->thread, NULL, runner_main, runner);
    return runner->started ? PEND_OK : PEND_NO_MEMORY;
}

void srv_part_runner_free(struct srv_part_runner **runner) {
    struct srv_part_runner *gone = *runner;
    *runner = NULL;
    if (!gone) return;
    pthread_mutex_lock(&gone->lock);
    gone->over = 1;
    pthread_cond_signal(&gone->some);
    pthread_mutex_unlock(&gone->lock);
    if (gone->started) pthread_join(gone->thread, NULL);
    for (int i = 0; i < gone->count; i++) {
        assert(gone->slot[i].state == SRV_PART_SLOT_IDLE && !gone->slot[i].beating);
        srv_part_run_clear(&gone->slot[i].run);
    }
    pthread_cond_destroy(&gone->some);
    pthread_mutex_destroy(&gone->lock);
    free(gone);
}

void srv_part_runner_news(struct srv_part_runner *runner, int rings) {
    pthread_mutex_lock(&runner->lock);
    if (rings & SRV_RING_WORK)
        srv_part_claim_hear(&runner->claim, runner_workers(runner), srv_clock_now());
    runner->doubt |= (rings & SRV_RING_STOP) != 0;
    pthread_cond_signal(&runner->some);
    pthread_mutex_unlock(&runner->lock);
}

void srv_part_runner_dismiss(struct srv_part_runner *runner, const char *job) {
    pthread_mutex_lock(&runner->lock);
    for (int i = 0; i < runner->count; i++)
        if (srv_part_slot_holds(&runner->slot[i]) && !strcmp(runner->slot[i].lease.job, job))
            atomic_store(&runner->slot[i].run.stop, 1);
    pthread_mutex_unlock(&runner->lock);
}

double srv_part_runner_idle(struct srv_part_runner *runner) {
    pthread_mutex_lock(&runner->lock);
    double seconds = runner->idle ? 1e-9 * (double)(srv_clock_now() - runner->idle) : 0;
    pthread_mutex_unlock(&runner->lock);
    return seconds;
}

int srv_part_runner_drain(struct srv_part_runner *runner) {
    pthread_mutex_lock(&runner->lock);
    int busy = 0;
    if (!runner->draining) runner->draining = 1;
    for (int i = 0; i < runner->count; i++) {
        struct srv_part_slot *slot = &runner->slot[i];
        if (srv_part_slot_holds(slot)) atomic_store(&slot->run.stop, 1);
        busy |= slot->state != SRV_PART_SLOT_IDLE || slot->beating;
    }
    pthread_cond_signal(&runner->some);
    if (!busy && runner->draining == 1) {
        runner->draining = runner->started ? 2 : 3;
        if (runner->started)
            srv_storage_ask(runner->service->storage, SRV_ASK_WRITE, &runner->release);
    }
    int over = runner->draining == 3;
    pthread_mutex_unlock(&runner->lock);
    return over;
}
