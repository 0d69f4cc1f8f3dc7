/* A slot for one part of a job that this process holds under a lease, and the questions to the
 * store about it.
 * Leaves to others: when to ask, and what follows from an answer (part_runner), computing
 * (part_run).
 * Invariant: at most one question is under way, and at most one beat, which extends the lease. */
#pragma once

#include "server/jobs/part_run.h"
#include "server/store/storage.h"

/* What a slot is doing. */
enum srv_part_slot_state {
    SRV_PART_SLOT_IDLE,
    SRV_PART_SLOT_CLAIM,   /* waits for the answer to a claim of the runner */
    SRV_PART_SLOT_REQUEST, /* asks for its job's request */
    SRV_PART_SLOT_COMPUTE, /* its task is in the queue or with a worker */
    SRV_PART_SLOT_DONE,    /* has a result, which other small parts' follow in a moment */
    SRV_PART_SLOT_FINISH,  /* asks the store to keep the result */
    SRV_PART_SLOT_FAIL,    /* asks the store to end the job */
    SRV_PART_SLOT_RETRY    /* will ask again */
};

struct srv_part_slot {
    struct srv_task task; /* first: a task is its slot */
    struct srv_ask ask;
    struct srv_ask beat;
    struct srv_lease beaten; /* the lease that the beat is of; without its start */
    struct srv_service *service;
    struct srv_part_runner *runner;
    const char *holder; /* in whose name parts are held, and for how long */
    int64_t lease_us;
    struct srv_part_run run; /* the thread that has the slot uses it; any thread sets its stop */

    /* under the runner's lock */
    enum srv_part_slot_state state, again; /* again: what is asked after SRV_PART_SLOT_RETRY */
    int beating, looking;
    int64_t at;      /* ns: when to ask again */
    int64_t beat_at; /* ns: when to hold it for longer */
    int64_t held_at; /* ns: since when it holds the part */
    struct srv_lease lease;
};

/**
 * Prepares an idle slot.
 *
 * slot           its service, runner, holder, lease_us and task are set, all else is zero.
 * asked, beaten  called on a thread of the storage when a question, or a beat, is answered.
 */
void srv_part_slot_init(struct srv_part_slot *slot, void (*asked)(struct srv_ask *ask),
                        void (*beaten)(struct srv_ask *beat));

/** Frees what an idle slot holds. */
void srv_part_slot_clear(struct srv_part_slot *slot);

/** The slot that a question is of. */
struct srv_part_slot *srv_part_slot_of_ask(struct srv_ask *ask);
/** The slot that a beat is of. */
struct srv_part_slot *srv_part_slot_of_beat(struct srv_ask *beat);

/** True when the fields of a slot agree with its state; for assertions, under the runner's lock.
 * O(1). */
int srv_part_slot_valid(const struct srv_part_slot *slot);

/** True if the slot holds a part. Called under the runner's lock, as all functions below. */
int srv_part_slot_holds(const struct srv_part_slot *slot);

/** Sends the question of a state: REQUEST, FINISH or FAIL. */
void srv_part_slot_ask(struct srv_part_slot *slot, enum srv_part_slot_state state);

/** Asks the store to extend the lease or, with `look`, only whether the job has ended: then the
 * answer is SRV_STORED_LOST. */
void srv_part_slot_beat(struct srv_part_slot *slot, int look);

/** True if the slot still holds the part that the beat was sent for. */
int srv_part_slot_beats(const struct srv_part_slot *slot);

/** Makes the slot idle: it does not hold the part any more. */
void srv_part_slot_drop(struct srv_part_slot *slot);
