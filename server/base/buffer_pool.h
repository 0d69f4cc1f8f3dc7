/* A pool of buffers whose memory is reused, so that a large result does not get its pages from the
 * system each time.
 * Leaves to others: the contents of the buffers.
 * Invariant: a pool has at most SRV_BUFFER_POOL buffers of at most SRV_SPARE_BYTES each. */
#pragma once

#include <pthread.h>

#include "api/base/buffer.h"

enum { SRV_BUFFER_POOL = 16, SRV_SPARE_BYTES = 1 << 18 };

struct srv_buffer_pool {
    pthread_mutex_t lock;
    int count;
    struct api_buffer buffer[SRV_BUFFER_POOL]; /* last in, first out, because that memory is still
                                                * in the caches */
};

/** Makes an empty pool. */
void srv_buffer_pool_init(struct srv_buffer_pool *pool);

/** Frees the buffers of a pool that no thread uses any more. */
void srv_buffer_pool_clear(struct srv_buffer_pool *pool);

/** Gives a buffer without memory the memory that the pool received last; if the pool is empty the
 * buffer stays without memory. Any thread. */
void srv_buffer_pool_take(struct srv_buffer_pool *pool, struct api_buffer *buffer);

/** Moves the memory of a buffer into the pool, or frees it if the pool is full or the buffer is too
 * large; the buffer then has no memory. Any thread. */
void srv_buffer_pool_give(struct srv_buffer_pool *pool, struct api_buffer *buffer);
