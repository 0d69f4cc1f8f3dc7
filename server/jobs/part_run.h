/* A part of a job on a worker: begun, computed a piece at a time, and what is to be kept of it.
 * Leaves to others: who holds the part and what becomes of it (part_runner), what it computes
 * (api/call/part).
 * Invariant: used by one thread at a time; a request is kept for the next part of its job. */
#ifndef SRV_PART_RUN_H
#define SRV_PART_RUN_H

#include "api/call/part.h"
#include "server/work/hold.h"

struct srv_part_run {
    struct srv_service *service;
    char job[SRV_ID_BYTES]; /* whose request is kept; "" = none */
    void *request;
    size_t request_bytes;
    struct api_part *part;
    struct srv_hold hold; /* of the memory of all this; no client pays for it */
    struct api_buffer out,
        carry;     /* what is kept of it, and what the next part of a chain begins with */
    int roomy;     /* there was room for the part's memory */
    int64_t spent; /* ns of computation */
    char message[SRV_REQUEST_HEAD_BYTES];
    atomic_int stop; /* set by any thread: it is not to go on */
};

/* How a turn ended. */
enum srv_part_run_end {
    SRV_PART_RUN_YIELDS, /* somebody waits for the worker */
    SRV_PART_RUN_STOPPED,
    SRV_PART_RUN_DONE,  /* out and carry are whole */
    SRV_PART_RUN_FAILED /* message says why */
};

/** No part and no request yet. */
void srv_part_run_init(struct srv_part_run *run, struct srv_service *service);

/** Frees what it holds. */
void srv_part_run_clear(struct srv_part_run *run);

/** Makes room for a job's request, which its owner then fills in; nothing is kept of the one
 * before. */
void srv_part_run_forget(struct srv_part_run *run);

/** Frees what was computed, but not the request. */
void srv_part_run_drop(struct srv_part_run *run);

/** Says what the job's client is to read. */
void srv_part_run_say(struct srv_part_run *run, const char *message);

/**
 * Computes on until the part is over, somebody waits, or `stop` is set, which is seen within a
 * piece of a millisecond.
 *
 * lease  of the part; the run's request is its job's.
 * level  of the queue on which it runs: whoever is above goes first.
 */
enum srv_part_run_end srv_part_run_turn(struct srv_part_run *run, const struct srv_lease *lease,
                                        int level);

#endif
