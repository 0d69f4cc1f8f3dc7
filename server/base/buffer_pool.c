#include "server/base/buffer_pool.h"

void srv_spares_init(struct srv_spares *spares) {
    pthread_mutex_init(&spares->lock, NULL);
    spares->count = 0;
}

void srv_spares_clear(struct srv_spares *spares) {
    while (spares->count) api_buffer_clear(&spares->buffer[--spares->count]);
    pthread_mutex_destroy(&spares->lock);
}

void srv_spares_take(struct srv_spares *spares, struct api_buffer *buffer) {
    size_t limit = buffer->limit;
    if (buffer->cap) return;
    pthread_mutex_lock(&spares->lock);
    if (spares->count) {
        *buffer = spares->buffer[--spares->count];
        buffer->limit = limit;
    }
    pthread_mutex_unlock(&spares->lock);
    /* a buffer never has more room than its limit */
    if (buffer->cap > limit) api_buffer_clear(buffer);
}

void srv_spares_give(struct srv_spares *spares, struct api_buffer *buffer) {
    size_t limit = buffer->limit;
    pthread_mutex_lock(&spares->lock);
    if (buffer->cap && buffer->cap <= SRV_SPARE_BYTES && spares->count < SRV_SPARES) {
        spares->buffer[spares->count] = *buffer;
        spares->buffer[spares->count++].bytes = 0;
        api_buffer_init(buffer, limit);
    }
    pthread_mutex_unlock(&spares->lock);
    api_buffer_clear(buffer);
}
