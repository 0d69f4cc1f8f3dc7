/* How long answers are whose length shows only when they are written: remembered by their entity
 * tags, so that a range of one is not written twice each time.
 * Leaves to others: what a tag stands for (result).
 * Invariant: bounded: a new one takes the place of an older one, and one that was forgotten is
 * found out again. */
#ifndef SRV_LENGTHS_H
#define SRV_LENGTHS_H

#include <pthread.h>

#include "server/protocol/response_body.h"

enum { SRV_LENGTHS = 256 };

struct srv_lengths {
    pthread_mutex_t lock;
    struct {
        char etag[SRV_ETAG_BYTES]; /* "" = free */
        long long bytes;
    } row[SRV_LENGTHS];
};

void srv_lengths_init(struct srv_lengths *lengths);

void srv_lengths_clear(struct srv_lengths *lengths);

/** Remembers the bytes of an answer, by its strong entity tag. Any thread. */
void srv_lengths_note(struct srv_lengths *lengths, const char *etag, long long bytes);

/** The bytes of the answer of that tag; -1 where they are not known. Any thread. */
long long srv_lengths_find(struct srv_lengths *lengths, const char *etag);

#endif
