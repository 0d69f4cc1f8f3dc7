/* The lengths of response bodies by their entity tags. Some lengths are known only once the body
 * was written; with the length a range of such a body needs no first pass.
 * Leaves to others: the meaning of a tag (result).
 * Invariant: the table has SRV_LENGTHS rows; a new tag replaces the one in its row, whose length
 * is measured again when it is needed. */
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

/** Initializes a table without lengths. */
void srv_lengths_init(struct srv_lengths *lengths);

/** Ends a table that no thread uses any more. */
void srv_lengths_clear(struct srv_lengths *lengths);

/** Remembers the bytes of a response body by its strong entity tag. Any thread; O(1). */
void srv_lengths_note(struct srv_lengths *lengths, const char *etag, long long bytes);

/** Returns the bytes of the response body of that tag; -1 if they are not known. Any thread;
 * O(1). */
long long srv_lengths_find(struct srv_lengths *lengths, const char *etag);

#endif
