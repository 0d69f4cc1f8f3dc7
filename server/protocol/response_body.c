#include "server/protocol/response_body.h"

#include <stdlib.h>
#include <string.h>

struct srv_response_body *srv_response_body_new(int status, const char *media_type,
                                                struct api_buffer *body, size_t text,
                                                struct srv_memory *memory,
                                                struct srv_buffer_pool *pool) {
    struct srv_response_body *made = calloc(1, sizeof *made + text);
    if (!made) {
        srv_buffer_pool_give(pool, body);
        return NULL;
    }
    atomic_store(&made->users, 1);
    made->status = status;
    made->media_type = media_type;
    made->memory = memory;
    made->pool = pool;
    made->text_cap = text;
    // long bodies grew by doubling and may be cached; the buffers of short ones go back to the pool
    if (body->cap > SRV_SPARE_BYTES) api_buffer_trim(body);
    made->body = *body;
    api_buffer_init(body, body->limit);
    srv_memory_add(memory, SRV_MEMORY_ANSWERS, (long long)made->body.cap);
    return made;
}

void srv_response_body_header(struct srv_response_body *response_body, const char *name,
                              const char *value) {
    size_t bytes = strlen(value) + 1;
    assert(response_body->headers < SRV_RESPONSE_BODY_HEADERS &&
           bytes <= response_body->text_cap - response_body->text_bytes);
    char *copy = response_body->text + response_body->text_bytes;
    memcpy(copy, value, bytes);
    response_body->text_bytes += bytes;
    response_body->header[response_body->headers].name = name;
    response_body->header[response_body->headers++].value = copy;
}

struct srv_response_body *srv_response_body_share(struct srv_response_body *response_body) {
    int before = atomic_fetch_add_explicit(&response_body->users, 1, memory_order_relaxed);
    assert(before > 0);
    (void)before;
    return response_body;
}

void srv_response_body_drop(struct srv_response_body **response_body) {
    struct srv_response_body *gone = *response_body;
    *response_body = NULL;
    int users = gone ? atomic_fetch_sub(&gone->users, 1) : 0;
    assert(!gone || users > 0);
    if (users != 1) return;
    assert(!gone->kept);
    srv_memory_add(gone->memory, SRV_MEMORY_ANSWERS, -(long long)gone->body.cap);
    srv_buffer_pool_give(gone->pool, &gone->body);
    free(gone);
}

size_t srv_response_body_bytes(const struct srv_response_body *response_body) {
    return sizeof *response_body + response_body->text_cap + response_body->body.cap;
}
