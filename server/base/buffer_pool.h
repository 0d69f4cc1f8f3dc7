/* Memory of answers between two uses, so that a large answer does not fetch its pages from the system each time.
 * Leaves to others: what is in the buffers.
 * Invariant: at most SRV_SPARES buffers of at most SRV_SPARE_BYTES each lie here. */
#ifndef SRV_BUFFER_POOL_H
#define SRV_BUFFER_POOL_H

#include <pthread.h>

#include "api/base/buffer.h"

enum { SRV_SPARES = 16, SRV_SPARE_BYTES = 1 << 18 };

struct srv_spares {
    pthread_mutex_t lock;
    int count;
    struct api_buffer buffer[SRV_SPARES]; /* the last one in is the first one out: it is still in the caches */
};

void srv_spares_init(struct srv_spares *spares);

/** Frees what lies here. */
void srv_spares_clear(struct srv_spares *spares);

/** Gives a buffer without memory the memory of a spare one, if there is one. Any thread. */
void srv_spares_take(struct srv_spares *spares, struct api_buffer *buffer);

/** Takes over, or frees, the memory of a buffer; it is empty afterwards. Any thread. */
void srv_spares_give(struct srv_spares *spares, struct api_buffer *buffer);

#endif
