/* A slot for one part of a job that this process holds under a lease, and the queries to the store
 * about it.
 * Leaves to others: when to query, and what follows from a result (part_runner), computing
 * (part_run).
 * Invariant: at most one query is in progress, and at most one beat, which renews the lease. */
#pragma once

#include "server/jobs/part_run.h"
#include "server/store/storage.h"

/* The states of a slot. */
enum srv_part_slot_state {
    SRV_PART_SLOT_IDLE,
    SRV_PART_SLOT_CLAIM,   /* waits for the result of the runner's claim */
    SRV_PART_SLOT_REQUEST, /* reads its job's request from the store */
    SRV_PART_SLOT_COMPUTE, /* the slot's task is in the queue or with a worker */
    SRV_PART_SLOT_FILE,    /* writes the result's file */
    SRV_PART_SLOT_DONE,    /* has a result, and waits a moment for those of other small parts */
    SRV_PART_SLOT_FINISH,  /* stores the result */
    SRV_PART_SLOT_FAIL,    /* ends the job in the store as failed */
    SRV_PART_SLOT_RETRY    /* will repeat its query */
};

struct srv_part_slot {
    struct srv_task task; /* first: a task is converted to its slot */
    struct srv_ask ask;
    struct srv_ask beat;
    struct srv_lease beaten; /* copy of the lease being renewed, without request and checkpoint */
    struct srv_service *service;
    struct srv_part_runner *runner;
    const char *holder; /* name of the holder of the parts, and duration of the leases */
    int64_t lease_us;
    struct srv_part_run
        run; /* used by the thread that has the slot; any thread may set its `stop` */

    /* guarded by the runner's lock */
    enum srv_part_slot_state state,
        again; /* again: the query that is repeated after SRV_PART_SLOT_RETRY */
    int beating, looking;
    int64_t at;      /* ns: time of the repetition */
    int64_t beat_at; /* ns: time of the next renewal of the lease */
    int64_t held_at; /* ns: start of the lease */
    struct srv_lease lease;
};

/** The slot that sent a query. */

/** Returns true if the slot holds a part. Called under the runner's lock, as all functions
 * below. */
int srv_part_slot_holds(const struct srv_part_slot *slot);

/** Sends the query of a state: REQUEST, FILE, FINISH or FAIL. */
void srv_part_slot_ask(struct srv_part_slot *slot, enum srv_part_slot_state state);

/** Asks the store to renew the lease or, with `look`, only whether the job has ended: the result is
 * then SRV_STORED_LOST. */
void srv_part_slot_beat(struct srv_part_slot *slot, int look);

/** Returns true if the slot still holds the part whose lease was renewed. */
int srv_part_slot_beats(const struct srv_part_slot *slot);

/** Makes the slot idle; the part is no longer held. */
void srv_part_slot_drop(struct srv_part_slot *slot);
