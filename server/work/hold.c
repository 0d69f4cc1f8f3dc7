#include "server/work/hold.h"

#include <math.h>

enum {
    HOLD_PART = 4,           /* a client may hold 1/4 of max-held-bytes */
    HOLD_BESIDE = 32 << 20,  /* or a response of the largest size plus this many bytes, if more */
    HOLD_BODY = 1 << 16,     /* bodies below this many bytes are not charged to their client */
    HOLD_UNKNOWN = 48 << 20, /* bytes that may be allocated without being counted */
    HOLD_SMALL =
        1 << 16, /* a reservation below this many bytes succeeds even if too much is allocated */
    HOLD_LARGE =
        1 << 20, /* a reservation above this many bytes must leave some memory to smaller ones */
    HOLD_LEFT = 8
};

size_t srv_hold_count(double bytes) {
    static const double most = 9007199254740992.0;
    return (size_t)(bytes < most ? fmax(bytes, 0) : most);
}

void srv_hold_set(struct srv_hold *hold, size_t bytes) {
    assert(hold->service);
    long long change = (long long)bytes - (long long)hold->bytes;
    if (!change) return;
    hold->bytes = bytes;
    srv_memory_add(&hold->service->memory, hold->kind, change);
    if (!hold->payer) return;
    atomic_fetch_add(&hold->payer->held, change);
    if (hold->kind == SRV_MEMORY_BODIES) atomic_fetch_add(&hold->payer->bodies, change);
}

/* Returns the largest number of bytes that one client may hold. */
static double hold_share(const struct srv_config *config) {
    double most = config->held_bytes;
    if (config->client_held_bytes > 0) return fmin(config->client_held_bytes, most);
    return fmin(fmax(most / HOLD_PART, config->limits.answer_bytes + HOLD_BESIDE), most / 2);
}

double srv_hold_share_of(const struct srv_config *config, const struct srv_client *payer) {
    double any = hold_share(config);
    double own = payer ? (double)atomic_load(&payer->share) : 0;
    return own > 0 ? fmin(own, any) : any;
}

double srv_hold_most(const struct srv_config *config) {
    return config->held_bytes - config->held_bytes / HOLD_LEFT;
}

int srv_hold_never(const struct srv_config *config, double bytes) {
    return bytes > (bytes > HOLD_LARGE ? srv_hold_most(config) : config->held_bytes);
}

/* The sum of all counters. The cache counts its keys and heads itself. */
static double hold_all(const struct srv_service *service) {
    struct srv_cache_size cache = srv_cache_size(service->cache);
    return (double)srv_memory_all(&service->memory) + (double)cache.bytes - (double)cache.bodies;
}

int srv_hold_room(const struct srv_service *service) {
    struct srv_cache_size cache = srv_cache_size(service->cache);
    return (double)srv_memory_all(&service->memory) - (double)cache.bodies <=
           srv_service_config(service)->held_bytes;
}

/* Returns 1 if the process has allocated more than it has counted, and more than its limit; then
 * only small reservations succeed. */
static int hold_tight(struct srv_service *service, size_t change) {
    if (change <= HOLD_SMALL) return 0;
    srv_memory_look(&service->memory);
    return (double)atomic_load(&service->memory.allocated) >
           1.1 * srv_service_config(service)->held_bytes + HOLD_UNKNOWN;
}

static enum srv_room hold_client(const struct srv_hold *hold, const struct srv_config *config) {
    const struct srv_client *payer = hold->payer;
    if (!payer) return SRV_ROOM;
    double share = srv_hold_share_of(config, payer), bytes = (double)hold->bytes;
    if (bytes > share) return SRV_ROOM_NEVER;
    if ((double)atomic_load(&payer->held) > share) return SRV_ROOM_CLIENT;
    if (hold->kind != SRV_MEMORY_BODIES || hold->bytes <= HOLD_BODY || bytes > share / 2)
        return SRV_ROOM;
    return (double)atomic_load(&payer->bodies) > share / 2 ? SRV_ROOM_CLIENT : SRV_ROOM;
}

/* Checks the total, of which `change` bytes are new. */
static enum srv_room hold_room(const struct srv_hold *hold, size_t change) {
    struct srv_service *service = hold->service;
    const struct srv_config *config = srv_service_config(service);
    enum srv_room room = hold_client(hold, config);
    if (room == SRV_ROOM_NEVER || srv_hold_never(config, (double)hold->bytes))
        return SRV_ROOM_NEVER;
    if (room != SRV_ROOM) return room;
    double most = hold->bytes > HOLD_LARGE ? srv_hold_most(config) : config->held_bytes;
    double excess = hold_all(service) - most;
    if (excess > 0) srv_cache_shrink(service->cache, (size_t)excess);
    if (excess > 0 && hold_all(service) > most) return SRV_ROOM_NONE;
    return hold_tight(service, change) ? SRV_ROOM_NONE : SRV_ROOM;
}

enum srv_room srv_hold_try(struct srv_hold *hold, size_t bytes) {
    assert(hold->service && (!hold->payer || hold->payer->key[0]));
    size_t before = hold->bytes;
    srv_hold_set(hold, bytes);
    if (bytes <= before) return SRV_ROOM;
    enum srv_room room = hold_room(hold, bytes - before);
    if (room != SRV_ROOM) srv_hold_set(hold, before);
    assert(hold->bytes == (room == SRV_ROOM ? bytes : before));
    return room;
}
