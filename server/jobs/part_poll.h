/* A question to the store: which jobs of a list have ended.
 * Leaves to others: which jobs, and what follows (part_runner).
 * Invariant: a job that cannot be read is not reported as ended. */
#ifndef SRV_PART_POLL_H
#define SRV_PART_POLL_H

#include "server/store/storage.h"

struct srv_part_poll {
    struct srv_ask ask; /* first */
    void *context;
    int count; /* jobs that are listed; its owner sets it to 0 */
    struct {
        char id[SRV_ID_BYTES];
        int ended; /* out; also 1 for a job that the store does not have */
    } job[];
};

/**
 * Makes a poll with an empty list.
 *
 * most     jobs that it may list.
 * done     called on a thread of the storage when the store has answered.
 * context  for done.
 *
 * NULL without memory; ends with free().
 */
struct srv_part_poll *srv_part_poll_new(int most, void (*done)(struct srv_ask *ask), void *context);

/** Adds a job to the list, unless it is there already. Not while the question is under way. */
void srv_part_poll_list(struct srv_part_poll *poll, const char *id);

/** True if a job of the list has ended. */
int srv_part_poll_ended(const struct srv_part_poll *poll, const char *id);

#endif
