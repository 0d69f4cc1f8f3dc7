/* Memory of answers between two uses, so that a large answer does not fetch its pages from the
 * system each time.
 * Leaves to others: what is in the buffers.
 * Invariant: at most SRV_BUFFER_POOL buffers of at most SRV_SPARE_BYTES each lie here. */
#ifndef SRV_BUFFER_POOL_H
#define SRV_BUFFER_POOL_H

#include <pthread.h>

#include "api/base/buffer.h"

enum { SRV_BUFFER_POOL = 16, SRV_SPARE_BYTES = 1 << 18 };

struct srv_buffer_pool {
    pthread_mutex_t lock;
    int count;
    struct api_buffer buffer[SRV_BUFFER_POOL]; /* the last one in is the first one out: it is still
                                                  in the caches */
};

void srv_buffer_pool_init(struct srv_buffer_pool *pool);

/** Frees what lies here. */
void srv_buffer_pool_clear(struct srv_buffer_pool *pool);

/** Gives a buffer without memory the memory of a spare one, if there is one. Any thread. */
void srv_buffer_pool_take(struct srv_buffer_pool *pool, struct api_buffer *buffer);

/** Takes over, or frees, the memory of a buffer; it is empty afterwards. Any thread. */
void srv_buffer_pool_give(struct srv_buffer_pool *pool, struct api_buffer *buffer);

#endif
