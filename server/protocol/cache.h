/* An LRU cache of complete answers in bounded memory; keys are arbitrary bytes.
 * Leaves to others: the contents of a key (compute).
 * Invariant: the reported size equals the bytes of all keys and response bodies, and never exceeds
 * the bound. */
#pragma once

#include <stdint.h>

#include "server/protocol/response_body.h"

enum {
    SRV_CACHE_PART = 8, /* a response body above an eighth of the bound is not stored: it would
                         * evict too many */
    SRV_CACHE_KEY = 65536
};

struct srv_cache;

/**
 * Creates an empty cache.
 *
 * cap   bytes of keys and response bodies; 0 = the cache accepts nothing.
 * salt  a number that clients do not know.
 *
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status srv_cache_new(struct srv_cache **cache, size_t cap, uint64_t salt);

/** Releases all response bodies and frees the cache. */
void srv_cache_free(struct srv_cache **cache);

/** Returns a reference to the response body of a key, which the caller releases, or NULL. Any
 * thread; O(bytes). */
struct srv_response_body *srv_cache_find(struct srv_cache *cache, const void *key, size_t bytes);

/**
 * Stores a response body under a key. Several keys may share a response body; its memory is counted
 * once.
 *
 * Does nothing if the response body or the key is too large, or memory is short.
 */
void srv_cache_add(struct srv_cache *cache, const void *key, size_t bytes,
                   struct srv_response_body *response_body);

/** Removes the least recently used keys until `bytes` are freed or the cache is empty. Any thread.
 */
void srv_cache_shrink(struct srv_cache *cache, size_t bytes);

/** Returns true if the cache's bound is above 0. */
int srv_cache_on(const struct srv_cache *cache);

/** The bytes in the cache, those of response bodies among them, and the number of keys. Any thread,
 * without a lock. */
struct srv_cache_size {
    size_t bytes, bodies, entries;
};
struct srv_cache_size srv_cache_size(const struct srv_cache *cache);

/** Returns true if a recount of all keys and bytes agrees with the counts; for tests. */
int srv_cache_valid(struct srv_cache *cache);
