/* Lengths of response bodies by entity tag. Some lengths are known only after a body was written
 * once; a remembered length saves a pass when a client requests a range.
 * Leaves to others: the meaning of a tag (result).
 * Invariant: the table has SRV_LENGTHS rows; a new tag replaces the one in its row, whose length
 * is measured again when needed. */
#pragma once

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

/** Frees a table that no thread uses any more. */
void srv_lengths_clear(struct srv_lengths *lengths);

/** Stores the length of a response body by its strong entity tag. Any thread; O(1). */
void srv_lengths_note(struct srv_lengths *lengths, const char *etag, long long bytes);

/** Returns the length of the response body with that tag; -1 if unknown. Any thread; O(1). */
long long srv_lengths_find(struct srv_lengths *lengths, const char *etag);
