#include "server/base/buffer_pool.h"

void srv_buffer_pool_init(struct srv_buffer_pool *pool) {
    pthread_mutex_init(&pool->lock, NULL);
    pool->count = 0;
}

void srv_buffer_pool_clear(struct srv_buffer_pool *pool) {
    while (pool->count) api_buffer_clear(&pool->buffer[--pool->count]);
    pthread_mutex_destroy(&pool->lock);
}

void srv_buffer_pool_take(struct srv_buffer_pool *pool, struct api_buffer *buffer) {
    size_t limit = buffer->limit;
    if (buffer->cap) return;
    pthread_mutex_lock(&pool->lock);
    if (pool->count) {
        *buffer = pool->buffer[--pool->count];
        buffer->limit = limit;
    }
    pthread_mutex_unlock(&pool->lock);
    /* a buffer never has more room than its limit */
    if (buffer->cap > limit) api_buffer_clear(buffer);
}

void srv_buffer_pool_give(struct srv_buffer_pool *pool, struct api_buffer *buffer) {
    size_t limit = buffer->limit;
    pthread_mutex_lock(&pool->lock);
    if (buffer->cap && buffer->cap <= SRV_SPARE_BYTES && pool->count < SRV_BUFFER_POOL) {
        pool->buffer[pool->count] = *buffer;
        pool->buffer[pool->count++].bytes = 0;
        api_buffer_init(buffer, limit);
    }
    pthread_mutex_unlock(&pool->lock);
    api_buffer_clear(buffer);
}
