/* Answers that can be given again, in bounded memory, found by keys of any bytes.
 * Leaves to others: what a key is made of (compute).
 * Invariant: what it says it holds is what its keys and response bodies take; never above its
 * bound; the least recently used key goes first. */
#ifndef SRV_CACHE_H
#define SRV_CACHE_H

#include <stdint.h>

#include "server/protocol/response_body.h"

enum {
    SRV_CACHE_PART = 8, /* a response body above an eighth of the bound is not taken in: it would
                           push out too many */
    SRV_CACHE_KEY = 65536
};

struct srv_cache;

/**
 * An empty cache.
 *
 * cap   bytes of keys and response bodies; 0 = it takes nothing in.
 * salt  a number that clients do not know.
 *
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status srv_cache_new(struct srv_cache **cache, size_t cap, uint64_t salt);

/** Lets go of everything, and frees it. */
void srv_cache_free(struct srv_cache **cache);

/** The response body of a key, to be dropped by the caller, or NULL. Any thread; O(bytes). */
struct srv_response_body *srv_cache_find(struct srv_cache *cache, const void *key, size_t bytes);

/**
 * Makes a key lead to a response body from now on. Several keys may lead to one response body,
 * whose memory counts once.
 *
 * Does nothing where the response body or the key is too large, or without memory.
 */
void srv_cache_add(struct srv_cache *cache, const void *key, size_t bytes,
                   struct srv_response_body *response_body);

/** Lets go of what was not used for longest until it is so many bytes smaller, or empty. Any
 * thread. */
void srv_cache_shrink(struct srv_cache *cache, size_t bytes);

/** True when it can take anything in. */
int srv_cache_on(const struct srv_cache *cache);

/** Bytes, of which are bodies of response bodies, and keys that it holds; any thread, without a
 * lock. */
struct srv_cache_size {
    size_t bytes, bodies, entries;
};
struct srv_cache_size srv_cache_size(const struct srv_cache *cache);

/** Counts everything anew and compares; for tests. */
int srv_cache_valid(struct srv_cache *cache);

#endif
