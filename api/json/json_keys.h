/* Keys of objects that are open: each must be the only one of its name.
 * Leaves to others: how a key is spelt, so that equal ones have equal bytes (json_scan).
 * Invariant: keys of the inner objects follow those of the outer ones, and go when their object
 * closes. */
#ifndef API_JSON_KEYS_H
#define API_JSON_KEYS_H

#include <stddef.h>
#include <stdint.h>

#include "core/base/status.h"

/* A key's bytes in the text of all keys. */
struct api_key {
    size_t at, bytes;
};

/* All zero at first; an object that closes sets `count` back to what it was when it opened. */
struct api_keys {
    struct api_key *key;
    uint32_t *hash; /* of the keys */
    size_t count, cap;
};

/**
 * Adds a key of the innermost object.
 *
 * first  number of keys when that object opened.
 * most   members that an object may have.
 * text   that this key, and all before, are in.
 *
 * PEND_LIMIT      the object has as many already.
 * PEND_INVALID    the object has this key already.
 * PEND_NO_MEMORY
 * O(keys of the object), a few bytes of each unless hashes agree.
 */
PEND_MUST_CHECK enum pend_status api_keys_add(struct api_keys *keys, size_t first, size_t most,
                                              const char *text, struct api_key key);

/** Frees what they hold. */
void api_keys_clear(struct api_keys *keys);

#endif
