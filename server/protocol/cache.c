#include "server/protocol/cache.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

enum { CACHE_ROWS = 4096 };

struct cache_entry {
    struct cache_entry *next_in_row;
    struct cache_entry *newer, *older;
    struct srv_response_body *response_body;
    uint64_t hash;
    size_t bytes;
    char key[];
};

struct srv_cache {
    pthread_mutex_t lock;
    size_t cap;
    uint64_t salt;
    atomic_size_t bytes, bodies, entries;
    struct cache_entry *newest, *oldest;
    struct cache_entry *row[CACHE_ROWS];
};

enum pend_status srv_cache_new(struct srv_cache **cache, size_t cap, uint64_t salt) {
    struct srv_cache *made = *cache = calloc(1, sizeof *made);
    if (!made) return PEND_NO_MEMORY;
    pthread_mutex_init(&made->lock, NULL);
    made->cap = cap;
    made->salt = salt | 1;
    return PEND_OK;
}

int srv_cache_on(const struct srv_cache *cache) { return cache->cap > 0; }

/* eight bytes at a time, each product of 64 bits folded: who does not know the salt cannot
 * choose keys of one row */
static uint64_t cache_hash(const struct srv_cache *cache, const char *key, size_t bytes) {
    uint64_t hash = cache->salt ^ bytes, word;
    for (; bytes; key += sizeof word) {
        size_t part = bytes < sizeof word ? bytes : sizeof word;
        word = 0;
        memcpy(&word, key, part);
        bytes -= part;
        __extension__ unsigned __int128 product =
            (unsigned __int128)(hash ^ word) * (cache->salt ^ 0x9e3779b97f4a7c15u);
        hash = (uint64_t)product ^ (uint64_t)(product >> 64);
    }
    return hash;
}

static struct cache_entry **cache_row(struct srv_cache *cache, uint64_t hash) {
    return &cache->row[hash % CACHE_ROWS];
}

static struct cache_entry *cache_look(struct srv_cache *cache, uint64_t hash, const void *key,
                                      size_t bytes) {
    struct cache_entry *entry = *cache_row(cache, hash);
    while (entry &&
           !(entry->hash == hash && entry->bytes == bytes && !memcmp(entry->key, key, bytes)))
        entry = entry->next_in_row;
    return entry;
}

/* --- what is counted --- */

static void cache_count(struct srv_cache *cache, const struct cache_entry *entry, int sign) {
    struct srv_response_body *response_body = entry->response_body;
    size_t bytes = sizeof *entry + entry->bytes, body = 0;
    /* a response body counts with its first key and until its last */
    if (sign > 0 ? !response_body->kept++ : !--response_body->kept) {
        bytes += srv_response_body_bytes(response_body);
        body = response_body->body.cap;
    }
    if (sign > 0) {
        atomic_fetch_add(&cache->bytes, bytes);
        atomic_fetch_add(&cache->bodies, body);
        atomic_fetch_add(&cache->entries, 1);
    } else {
        atomic_fetch_sub(&cache->bytes, bytes);
        atomic_fetch_sub(&cache->bodies, body);
        atomic_fetch_sub(&cache->entries, 1);
    }
}

struct srv_cache_size srv_cache_size(const struct srv_cache *cache) {
    return (struct srv_cache_size){
        .bytes = atomic_load_explicit(&cache->bytes, memory_order_relaxed),
        .bodies = atomic_load_explicit(&cache->bodies, memory_order_relaxed),
        .entries = atomic_load_explicit(&cache->entries, memory_order_relaxed)};
}

/* --- the order of use --- */

static void cache_link(struct srv_cache *cache, struct cache_entry *entry) {
    entry->newer = NULL;
    entry->older = cache->newest;
    *(cache->newest ? &cache->newest->newer : &cache->oldest) = entry;
    cache->newest = entry;
}

static void cache_unlink(struct srv_cache *cache, struct cache_entry *entry) {
    *(entry->newer ? &entry->newer->older : &cache->newest) = entry->older;
    *(entry->older ? &entry->older->newer : &cache->oldest) = entry->newer;
}

static void cache_forget(struct srv_cache *cache, struct cache_entry *entry) {
    struct cache_entry **at = cache_row(cache, entry->hash);
    while (*at != entry) at = &(*at)->next_in_row;
    *at = entry->next_in_row;
    cache_unlink(cache, entry);
    cache_count(cache, entry, -1);
    srv_response_body_drop(&entry->response_body);
    free(entry);
}

void srv_cache_free(struct srv_cache **cache) {
    struct srv_cache *gone = *cache;
    *cache = NULL;
    if (!gone) return;
    while (gone->oldest) cache_forget(gone, gone->oldest);
    pthread_mutex_destroy(&gone->lock);
    free(gone);
}

/* --- finding and adding --- */

struct srv_response_body *srv_cache_find(struct srv_cache *cache, const void *key, size_t bytes) {
    struct srv_response_body *response_body = NULL;
    if (!cache->cap || bytes > SRV_CACHE_KEY) return NULL;
    uint64_t hash = cache_hash(cache, key, bytes);
    pthread_mutex_lock(&cache->lock);
    struct cache_entry *entry = cache_look(cache, hash, key, bytes);
    if (entry) {
        response_body = srv_response_body_share(entry->response_body);
        cache_unlink(cache, entry);
        cache_link(cache, entry);
    }
    pthread_mutex_unlock(&cache->lock);
    return response_body;
}

static struct cache_entry *cache_entry_new(const void *key, size_t bytes, uint64_t hash,
                                           struct srv_response_body *response_body) {
    struct cache_entry *made = malloc(sizeof *made + bytes);
    if (!made) return NULL;
    *made = (struct cache_entry){
        .response_body = srv_response_body_share(response_body), .hash = hash, .bytes = bytes};
    memcpy(made->key, key, bytes);
    return made;
}

void srv_cache_add(struct srv_cache *cache, const void *key, size_t bytes,
                   struct srv_response_body *response_body) {
    if (bytes > SRV_CACHE_KEY ||
        srv_response_body_bytes(response_body) + bytes > cache->cap / SRV_CACHE_PART)
        return;
    uint64_t hash = cache_hash(cache, key, bytes);
    struct cache_entry *made = cache_entry_new(key, bytes, hash, response_body);
    if (!made) return;
    pthread_mutex_lock(&cache->lock);
    struct cache_entry *old = cache_look(cache, hash, key, bytes);
    if (old) cache_forget(cache, old);
    made->next_in_row = *cache_row(cache, hash);
    *cache_row(cache, hash) = made;
    cache_link(cache, made);
    cache_count(cache, made, 1);
    while (atomic_load(&cache->bytes) > cache->cap) cache_forget(cache, cache->oldest);
    pthread_mutex_unlock(&cache->lock);
}

void srv_cache_shrink(struct srv_cache *cache, size_t bytes) {
    pthread_mutex_lock(&cache->lock);
    size_t now = atomic_load(&cache->bytes), aim = now > bytes ? now - bytes : 0;
    while (cache->oldest && atomic_load(&cache->bytes) > aim) cache_forget(cache, cache->oldest);
    pthread_mutex_unlock(&cache->lock);
}

int srv_cache_valid(struct srv_cache *cache) {
    size_t bytes = 0, entries = 0, in_rows = 0;
    pthread_mutex_lock(&cache->lock);
    for (struct cache_entry *entry = cache->newest; entry; entry = entry->older) {
        bytes += sizeof *entry + entry->bytes;
        entries++;
        /* a response body counts once */
        size_t earlier = 0;
        for (struct cache_entry *other = cache->newest; other != entry; other = other->older)
            earlier += other->response_body == entry->response_body;
        if (!earlier) bytes += srv_response_body_bytes(entry->response_body);
    }
    for (int row = 0; row < CACHE_ROWS; row++)
        for (struct cache_entry *entry = cache->row[row]; entry; entry = entry->next_in_row)
            in_rows++;
    int good = bytes == cache->bytes && entries == cache->entries && in_rows == entries &&
               bytes <= cache->cap;
    pthread_mutex_unlock(&cache->lock);
    return good;
}
