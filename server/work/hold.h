/* Memory of one owner, counted before it is allocated: for the whole process and for the client
 * that pays for it. Both counts are bounded.
 * Leaves to others: the use of the memory (exchange, inflight, part_run), the text of refusals
 * (exchange).
 * Invariant: a hold counts its bytes once; set to 0 it counts nothing. */
#pragma once

#include "server/work/service.h"

enum {
    SRV_HOLD_READ = 5,           /* memory that reading a body takes, in multiples of its size */
    SRV_HOLD_READ_FREE = 1 << 16 /* reading a body below this many bytes is not counted */
};

/* Whether more memory may be counted, and if not, why. */
enum srv_room {
    SRV_ROOM,
    SRV_ROOM_NONE,   /* the process holds too much memory now */
    SRV_ROOM_CLIENT, /* the client holds too much memory now */
    SRV_ROOM_NEVER   /* no client may ever hold that much */
};

struct srv_hold {
    struct srv_service *service;
    struct srv_client
        *payer; /* the client whose share is charged; NULL = none. Valid longer than the hold */
    enum srv_memory_kind kind;
    size_t bytes;
};

/** Sets the bytes of a hold; never refuses. Any thread, but one at a time for each hold. */
void srv_hold_set(struct srv_hold *hold, size_t bytes);

/**
 * Sets the bytes of a hold if the bounds allow the increase; a decrease is always allowed. Evicts
 * answers that only the cache references if that frees enough memory.
 *
 * Returns SRV_ROOM, or the reason of the refusal; then nothing has changed.
 */
enum srv_room srv_hold_try(struct srv_hold *hold, size_t bytes);

/** Returns the largest number of bytes that this client may hold, which its role may reduce. NULL =
 * any client. */
double srv_hold_share_of(const struct srv_config *config, const struct srv_client *payer);

/** Returns bytes as a count that can be added up; 2^53 for NaN and for values above any real
 * memory, which a checkpoint of another process might contain. */
size_t srv_hold_count(double bytes);

/** Returns true if a job's part of this size does not fit even if nothing else is held. */
int srv_hold_never(const struct srv_config *config, double bytes);

/** Returns the largest number of bytes that a part of a job may hold. */
double srv_hold_most(const struct srv_config *config);

/** Returns true if the process holds at most max-held-bytes, without the answers that only the
 * cache references. */
int srv_hold_room(const struct srv_service *service);
