/* Which of some jobs have ended, asked of the store by reading.
 * Leaves to others: which jobs, and what follows (part_runner).
 * Invariant: a job that cannot be read just now is not said to have ended. */
#ifndef SRV_PART_POLL_H
#define SRV_PART_POLL_H

#include "server/store/storage.h"

struct srv_part_poll {
    struct srv_ask ask; /* first */
    void *context;
    int count; /* jobs that are listed; its owner sets it to 0 */
    struct {
        char id[SRV_ID_BYTES];
        int ended; /* out; a job that is not known has */
    } job[];
};

/**
 * A poll that lists nothing yet.
 *
 * most     jobs that it may list.
 * done     called when the answer is there, on a thread of the storage.
 * context  for done.
 *
 * NULL without memory; ends with free().
 */
struct srv_part_poll *srv_part_poll_new(int most, void (*done)(struct srv_ask *ask), void *context);

/** Lists a job, once however often it is listed; not while it is asked. */
void srv_part_poll_list(struct srv_part_poll *poll, const char *id);

/** Did a job that was listed end? */
int srv_part_poll_ended(const struct srv_part_poll *poll, const char *id);

#endif
