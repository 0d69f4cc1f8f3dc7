/* A part of a job that this process holds, or room for one, and what is asked of the store about
 * it.
 * Leaves to others: when to ask and what follows an answer (part_runner), computing (part_run).
 * Invariant: beside the beat, which only holds the part for longer, at most one question is
 * under way. */
#ifndef SRV_PART_SLOT_H
#define SRV_PART_SLOT_H

#include "server/jobs/part_run.h"
#include "server/store/storage.h"

/* What a slot is doing. */
enum srv_part_slot_state {
    SRV_PART_SLOT_IDLE,
    SRV_PART_SLOT_CLAIM,   /* waits for what a claim of the runner brings */
    SRV_PART_SLOT_REQUEST, /* asks for its job's request */
    SRV_PART_SLOT_COMPUTE, /* its task is in the queue or with a worker */
    SRV_PART_SLOT_FINISH,  /* asks for the result to be kept */
    SRV_PART_SLOT_FAIL,    /* asks for the job to be ended */
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
    struct srv_part_run run; /* who has the slot has this, but for its stop */

    /* under the runner's lock */
    enum srv_part_slot_state state, again; /* again: what is asked after SRV_PART_SLOT_RETRY */
    int beating;
    int64_t at;      /* ns: when to ask again */
    int64_t beat_at; /* ns: when to hold it for longer */
    int64_t held_at; /* ns: since when it holds the part */
    struct srv_lease lease;
};

/**
 * An idle slot.
 *
 * slot           its service, runner, holder, lease_us and task are set, all else is zero.
 * asked, beaten  called when the answer to a question, or to a beat, is there, on a thread of the
 *                storage.
 */
void srv_part_slot_init(struct srv_part_slot *slot, void (*asked)(struct srv_ask *ask),
                        void (*beaten)(struct srv_ask *beat));

/** Frees what an idle slot holds. */
void srv_part_slot_clear(struct srv_part_slot *slot);

/** The slot that has this question, or this beat. */
struct srv_part_slot *srv_part_slot_of_ask(struct srv_ask *ask);
struct srv_part_slot *srv_part_slot_of_beat(struct srv_ask *beat);

/** Does it hold a part? With the runner's lock, as all that follows. */
int srv_part_slot_holds(const struct srv_part_slot *slot);

/** Asks what the state is about: one of REQUEST, FINISH, FAIL. */
void srv_part_slot_ask(struct srv_part_slot *slot, enum srv_part_slot_state state);

/** Asks that the part be held for longer. */
void srv_part_slot_beat(struct srv_part_slot *slot);

/** Does it still hold the part that the beat was of? */
int srv_part_slot_beats(const struct srv_part_slot *slot);

/** The part is out of its hands. */
void srv_part_slot_drop(struct srv_part_slot *slot);

#endif
