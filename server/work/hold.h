/* Memory that something holds: counted for all and for the client that pays for it, when it is
 * promised, and bounded.
 * Leaves to others: what is held (exchange, inflight, part_run), what a refusal says to the
 * client (exchange).
 * Invariant: a hold counts its bytes once; set to 0 it counts nothing. */
#ifndef SRV_HOLD_H
#define SRV_HOLD_H

#include "server/work/service.h"

/* Whether there is room for what is to be held. */
enum srv_room {
    SRV_ROOM,
    SRV_ROOM_NONE,   /* all together hold too much: later there may be room */
    SRV_ROOM_CLIENT, /* the client holds too much of it */
    SRV_ROOM_NEVER   /* it is more than one client may ever hold */
};

struct srv_hold {
    struct srv_service *service;
    struct srv_client *payer; /* whose share it is of; NULL = nobody's. Outlives what is held */
    enum srv_memory_kind kind;
    size_t bytes;
};

/** Counts bytes, all that is held now; never refuses. Any thread, one at a time for a hold. */
void srv_hold_set(struct srv_hold *hold, size_t bytes);

/**
 * Counts bytes, all that is to be held from now on, where there is room for what they are more than
 * before. What only the cache has makes room.
 *
 * Returns SRV_ROOM, or why there is none; then nothing has changed.
 */
enum srv_room srv_hold_try(struct srv_hold *hold, size_t bytes);

/** Bytes that one client may hold. */
double srv_hold_share(const struct srv_config *config);

/** True where a part of a job that holds so many bytes has no room even where nobody else holds
 * anything. */
int srv_hold_never(const struct srv_config *config, double bytes);

/** Bytes that such a part may hold at most. */
double srv_hold_most(const struct srv_config *config);

/** True where the process holds no more than max-held-bytes, without what only the cache has. */
int srv_hold_room(const struct srv_service *service);

#endif
