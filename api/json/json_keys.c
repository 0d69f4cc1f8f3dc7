#include "api/json/json_keys.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

PEND_VALIDATOR keys_valid(const struct api_keys *keys) {
    return keys->count <= keys->cap && (!keys->cap || (keys->key && keys->hash));
}

/* hashes eight bytes at a time */
static uint32_t keys_hash(const char *text, size_t bytes) {
    uint64_t hash = bytes;
    for (size_t at = 0; at < bytes; at += sizeof hash) {
        uint64_t word = 0;
        memcpy(&word, text + at, bytes - at < sizeof word ? bytes - at : sizeof word);
        hash = (hash ^ word) * 0x9e3779b97f4a7c15;
        hash ^= hash >> 32;
    }
    return (uint32_t)hash;
}

/* true if the list contains the hash; the loop has no early exit, so that the compiler vectorizes
 * it */
static int keys_among(size_t count, const uint32_t hashes[], uint32_t hash) {
    uint32_t found = 0;
    for (size_t i = 0; i < count; i++) found |= hashes[i] == hash;
    return found != 0;
}

/* true if the object has the key; the search is linear, because the number of keys is limited */
static int keys_there(const struct api_keys *keys, size_t first, struct api_key key,
                      uint32_t hash) {
    if (!keys_among(keys->count - first, keys->hash + first, hash)) return 0;
    for (size_t i = first; i < keys->count; i++) {
        if (keys->hash[i] != hash || keys->key[i].bytes != key.bytes) continue;
        if (!memcmp(keys->key[i].text, key.text, key.bytes)) return 1;
    }
    return 0;
}

static enum pend_status keys_grow(struct api_keys *keys) {
    if (keys->count < keys->cap) return PEND_OK;
    size_t cap = keys->cap ? 2 * keys->cap : 64;
    struct api_key *key = realloc(keys->key, cap * sizeof *key);
    if (key) keys->key = key;
    uint32_t *hash = realloc(keys->hash, cap * sizeof *hash);
    if (hash) keys->hash = hash;
    if (!key || !hash) return PEND_NO_MEMORY;
    keys->cap = cap;
    return PEND_OK;
}

enum pend_status api_keys_add(struct api_keys *keys, size_t first, size_t most,
                              struct api_key key) {
    assert(keys_valid(keys) && first <= keys->count);
    uint32_t hash = keys_hash(key.text, key.bytes);
    PEND_TRY(keys_grow(keys));
    if (keys->count - first >= most) return PEND_LIMIT;
    if (keys_there(keys, first, key, hash)) return PEND_INVALID;
    keys->key[keys->count] = key;
    keys->hash[keys->count++] = hash;
    assert(keys_valid(keys));
    return PEND_OK;
}

void api_keys_clear(struct api_keys *keys) {
    free(keys->key);
    free(keys->hash);
    *keys = (struct api_keys){0};
}
