/* The lengths of response bodies that are known only once they were written, by their entity tags:
 * so a range of one does not need a first pass each time.
 * Leaves to others: what a tag stands for (result).
 * Invariant: the table has SRV_LENGTHS rows; a new tag replaces the one in its row, whose length is
 * measured again when it is needed. */
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

/** Makes a table that knows no length. */
void srv_lengths_init(struct srv_lengths *lengths);

/** Ends a table that no thread uses any more. */
void srv_lengths_clear(struct srv_lengths *lengths);

/** Remembers the bytes of a response body by its strong entity tag. Any thread; O(1). */
void srv_lengths_note(struct srv_lengths *lengths, const char *etag, long long bytes);

/** The bytes of the response body of that tag; -1 where they are not known. Any thread; O(1). */
long long srv_lengths_find(struct srv_lengths *lengths, const char *etag);

#endif
