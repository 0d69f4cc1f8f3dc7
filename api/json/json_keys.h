/* Detects duplicate keys in the objects that are open during the scan.
 * Leaves to others: decoding a key, so that equal keys have equal bytes (json_scan).
 * Invariant: keys of inner objects follow those of outer ones, and are dropped when their object
 * closes. */
#pragma once

#include <stddef.h>
#include <stdint.h>

#include "core/base/status.h"

struct api_key {
    const char *text; /* must outlive the object to which it belongs */
    size_t bytes;
};

/* The table of keys; initially all zero. When an object closes, the caller resets `count` to its
 * value when the object opened. */
struct api_keys {
    struct api_key *key;
    uint32_t *hash; /* hashes of the keys */
    size_t count, cap;
};

/**
 * Adds a key of the innermost object.
 *
 * first  number of keys when that object opened.
 * most   members that an object may have.
 *
 * PEND_LIMIT      the object already has `most` keys.
 * PEND_INVALID    the object has this key already.
 * PEND_NO_MEMORY
 * O(keys of the object) comparisons of hashes; bytes are compared only if hashes agree.
 */
PEND_MUST_CHECK enum pend_status api_keys_add(struct api_keys *keys, size_t first, size_t most,
                                              struct api_key key);

/** Frees the memory of the table; it can be used again. */
void api_keys_clear(struct api_keys *keys);
