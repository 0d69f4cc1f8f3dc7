#include "server/base/buffer_pool.h"

#include <assert.h>

void srv_buffer_pool_init(struct srv_buffer_pool *pool) {
    pthread_mutex_init(&pool->lock, NULL);
    pool->count = 0;
}

void srv_buffer_pool_clear(struct srv_buffer_pool *pool) {
    while (pool->count) api_buffer_clear(&pool->buffer[--pool->count]);
    pthread_mutex_destroy(&pool->lock);
}

PEND_VALIDATOR buffer_pool_valid(const struct srv_buffer_pool *pool) {
    int good = pool->count >= 0 && pool->count <= SRV_BUFFER_POOL;
    for (int i = 0; good && i < pool->count; i++)
        good = pool->buffer[i].data && !pool->buffer[i].bytes && pool->buffer[i].cap &&
               pool->buffer[i].cap <= SRV_SPARE_BYTES;
    return good;
}

void srv_buffer_pool_take(struct srv_buffer_pool *pool, struct api_buffer *buffer) {
    size_t limit = buffer->limit;
    if (buffer->cap) return;
    assert(!buffer->data && !buffer->bytes);
    pthread_mutex_lock(&pool->lock);
    assert(buffer_pool_valid(pool));
    if (pool->count) *buffer = pool->buffer[--pool->count];
    pthread_mutex_unlock(&pool->lock);
    /* a buffer never has more room than its limit */
    if (buffer->cap > limit) api_buffer_clear(buffer);
    buffer->limit = limit;
}

void srv_buffer_pool_give(struct srv_buffer_pool *pool, struct api_buffer *buffer) {
    size_t limit = buffer->limit;
    pthread_mutex_lock(&pool->lock);
    if (buffer->cap && buffer->cap <= SRV_SPARE_BYTES && pool->count < SRV_BUFFER_POOL) {
        pool->buffer[pool->count] = *buffer;
        pool->buffer[pool->count++].bytes = 0;
        api_buffer_init(buffer, limit);
    }
    assert(buffer_pool_valid(pool));
    pthread_mutex_unlock(&pool->lock);
    api_buffer_clear(buffer);
}
