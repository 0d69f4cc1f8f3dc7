#include "server/protocol/cache.h"

#include <stdlib.h>
#include <string.h>

#include "server/base/hash_table.h"
#include "server/base/list.h"

struct cache_entry {
    struct srv_hash_node node; /* the key follows the entry in memory */
    struct srv_list link;      /* in the LRU list */
    struct srv_response_body *response_body;
    char key[];
};

struct srv_cache {
    pthread_mutex_t lock;
    size_t cap;
    atomic_size_t bytes, bodies, entries;
    struct srv_list order; /* in order of use; the most recently used entry is last */
    struct srv_hash_table table;
};

enum pend_status srv_cache_new(struct srv_cache **cache, size_t cap, uint64_t salt) {
    struct srv_cache *made = *cache = calloc(1, sizeof *made);
    if (!made) return PEND_NO_MEMORY;
    pthread_mutex_init(&made->lock, NULL);
    made->cap = cap;
    srv_hash_table_init(&made->table, salt);
    return PEND_OK;
}

int srv_cache_on(const struct srv_cache *cache) { return cache->cap > 0; }

static struct cache_entry *cache_look(struct srv_cache *cache, uint64_t hash, const void *key,
                                      size_t bytes) {
    struct srv_hash_node *node = srv_hash_table_find(&cache->table, hash, key, bytes);
    return node ? SRV_CONTAINER_OF(node, struct cache_entry, node) : NULL;
}

static struct cache_entry *cache_of_link(struct srv_list *link) {
    return SRV_CONTAINER_OF(link, struct cache_entry, link);
}

/* --- accounting --- */

static void cache_count(struct srv_cache *cache, const struct cache_entry *entry, int sign) {
    struct srv_response_body *response_body = entry->response_body;
    size_t bytes = sizeof *entry + entry->node.bytes, body = 0;
    /* the bytes of a body count once, while at least one key refers to it */
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

static void cache_forget(struct srv_cache *cache, struct cache_entry *entry) {
    srv_hash_table_remove(&cache->table, &entry->node);
    srv_list_remove(&entry->link);
    cache_count(cache, entry, -1);
    srv_response_body_drop(&entry->response_body);
    free(entry);
}

/* removes the least recently used entries until at most `bytes` remain */
static void cache_forget_down_to(struct srv_cache *cache, size_t bytes) {
    while (!srv_list_empty(&cache->order) && atomic_load(&cache->bytes) > bytes)
        cache_forget(cache, cache_of_link(cache->order.next));
}

void srv_cache_free(struct srv_cache **cache) {
    struct srv_cache *gone = *cache;
    *cache = NULL;
    if (!gone) return;
    cache_forget_down_to(gone, 0);
    assert(!gone->bytes && !gone->bodies && !gone->entries && !gone->table.count);
    pthread_mutex_destroy(&gone->lock);
    free(gone);
}

#ifndef NDEBUG
/* true if the O(1) part of the invariant holds; call with the lock held */
static int cache_sound(const struct srv_cache *cache) {
    size_t entries = atomic_load(&cache->entries), bytes = atomic_load(&cache->bytes);
    return entries == cache->table.count && bytes <= cache->cap &&
           bytes >= entries * sizeof(struct cache_entry) && atomic_load(&cache->bodies) <= bytes &&
           srv_list_valid(&cache->order) && srv_list_empty(&cache->order) == !entries;
}
#endif

/* --- finding and adding --- */

struct srv_response_body *srv_cache_find(struct srv_cache *cache, const void *key, size_t bytes) {
    struct srv_response_body *response_body = NULL;
    if (!cache->cap || bytes > SRV_CACHE_KEY) return NULL;
    uint64_t hash = srv_hash_table_hash(&cache->table, key, bytes);
    pthread_mutex_lock(&cache->lock);
    struct cache_entry *entry = cache_look(cache, hash, key, bytes);
    if (entry) {
        response_body = srv_response_body_share(entry->response_body);
        srv_list_remove(&entry->link);
        srv_list_append(&cache->order, &entry->link);
    }
    assert(cache_sound(cache));
    pthread_mutex_unlock(&cache->lock);
    return response_body;
}

static struct cache_entry *cache_entry_new(const void *key, size_t bytes,
                                           struct srv_response_body *response_body) {
    struct cache_entry *made = malloc(sizeof *made + bytes);
    if (!made) return NULL;
    *made = (struct cache_entry){.node = {.key = made->key, .bytes = bytes},
                                 .response_body = srv_response_body_share(response_body)};
    memcpy(made->key, key, bytes);
    return made;
}

void srv_cache_add(struct srv_cache *cache, const void *key, size_t bytes,
                   struct srv_response_body *response_body) {
    if (bytes > SRV_CACHE_KEY ||
        srv_response_body_bytes(response_body) + bytes > cache->cap / SRV_CACHE_PART)
        return;
    uint64_t hash = srv_hash_table_hash(&cache->table, key, bytes);
    struct cache_entry *made = cache_entry_new(key, bytes, response_body);
    if (!made) return;
    pthread_mutex_lock(&cache->lock);
    struct cache_entry *old = cache_look(cache, hash, key, bytes);
    assert(cache_sound(cache));
    if (old) cache_forget(cache, old);
    srv_hash_table_add(&cache->table, &made->node, hash);
    srv_list_append(&cache->order, &made->link);
    cache_count(cache, made, 1);
    cache_forget_down_to(cache, cache->cap);
    assert(cache_sound(cache));
    pthread_mutex_unlock(&cache->lock);
}

void srv_cache_shrink(struct srv_cache *cache, size_t bytes) {
    pthread_mutex_lock(&cache->lock);
    size_t now = atomic_load(&cache->bytes);
    cache_forget_down_to(cache, now > bytes ? now - bytes : 0);
    assert(cache_sound(cache));
    pthread_mutex_unlock(&cache->lock);
}

int srv_cache_valid(struct srv_cache *cache) {
    size_t bytes = 0, entries = 0;
    pthread_mutex_lock(&cache->lock);
    SRV_LIST_EACH (link, &cache->order) {
        struct cache_entry *entry = cache_of_link(link);
        bytes += sizeof *entry + entry->node.bytes;
        entries++;
        /* a shared response body is counted once */
        size_t earlier = 0;
        SRV_LIST_EACH (other, &cache->order) {
            if (other == link) break;
            earlier += cache_of_link(other)->response_body == entry->response_body;
        }
        if (!earlier) bytes += srv_response_body_bytes(entry->response_body);
    }
    int good = bytes == cache->bytes && entries == cache->entries &&
               srv_hash_table_valid(&cache->table) && cache->table.count == entries &&
               bytes <= cache->cap;
    pthread_mutex_unlock(&cache->lock);
    return good;
}
