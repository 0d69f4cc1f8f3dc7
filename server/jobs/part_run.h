/* A part of a job on a worker: it is started, computed a piece at a time, and its results are kept
 * until they are stored. Leaves to others: leases and storing (part_runner), what it computes
 * (api/call/part).
 * Invariant: one thread at a time uses it, except `stop`; the request stays for the next part of
 * the same job. */
#pragma once

#include "api/call/part.h"
#include "server/work/hold.h"

struct srv_part_run {
    struct srv_service *service;
    char job[SRV_ID_BYTES]; /* the job of the cached request; "" = none */
    void *request;
    size_t request_bytes;
    struct api_part *part;
    struct srv_hold hold; /* memory of the run, not charged to any client */
    struct api_buffer out,
        carry; /* the results to store, and the checkpoint for the next part of a chain */
    struct api_buffer file; /* the file of the results; empty if all of them are in the database */
    int roomy;              /* the memory of the part is reserved */
    int64_t spent;          /* ns of computation */
    char message[SRV_REQUEST_HEAD_BYTES];
    atomic_int stop; /* set by any thread: the run must stop */
};

/* How a turn ended. */
enum srv_part_run_end {
    SRV_PART_RUN_YIELDS, /* another task waits for the worker */
    SRV_PART_RUN_STOPPED,
    SRV_PART_RUN_DONE,  /* `out` and `carry` are complete */
    SRV_PART_RUN_FAILED /* message says why */
};

/** Prepares an empty run, without a part or a request. */
void srv_part_run_init(struct srv_part_run *run, struct srv_service *service);
void srv_part_run_clear(struct srv_part_run *run);

/** Frees the cached request; the owner then sets the request of another job. */
void srv_part_run_forget(struct srv_part_run *run);

/** Frees the results, but not the request. */
void srv_part_run_drop(struct srv_part_run *run);

/** Sets the message that the client of a failed job reads. */
void srv_part_run_say(struct srv_part_run *run, const char *message);

/**
 * Computes until the part is complete, another task waits, or `stop` is set, which is looked at
 * after each piece of about a millisecond.
 *
 * lease  of the part; the run's request is its job's.
 * level  of the queue on which it runs: it yields to tasks of lower levels.
 */
enum srv_part_run_end srv_part_run_turn(struct srv_part_run *run, const struct srv_lease *lease,
                                        int level);
