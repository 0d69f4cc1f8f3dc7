#include "server/protocol/response_body.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

/* A long body has grown by doubling; what it does not need goes back, since it may be kept. Short ones become spares.
 */
static void payload_trim(struct api_buffer *body) {
    if (body->cap > SRV_SPARE_BYTES) api_buffer_trim(body);
}

struct srv_payload *srv_payload_new(int status, const char *media_type, struct api_buffer *body, size_t text,
                                    struct srv_memory *memory, struct srv_spares *spares) {
    struct srv_payload *made = calloc(1, sizeof *made + text);
    if (!made) {
        srv_spares_give(spares, body);
        return NULL;
    }
    atomic_store(&made->users, 1);
    made->status = status;
    made->media_type = media_type;
    made->memory = memory;
    made->spares = spares;
    made->text_cap = text;
    payload_trim(body);
    made->body = *body;
    api_buffer_init(body, body->limit);
    srv_memory_add(memory, SRV_MEMORY_ANSWERS, (long long)made->body.cap);
    return made;
}

void srv_payload_header(struct srv_payload *payload, const char *name, const char *value) {
    size_t bytes = strlen(value) + 1;
    assert(payload->headers < SRV_PAYLOAD_HEADERS && bytes <= payload->text_cap - payload->text_bytes);
    char *copy = payload->text + payload->text_bytes;
    memcpy(copy, value, bytes);
    payload->text_bytes += bytes;
    payload->header[payload->headers].name = name;
    payload->header[payload->headers++].value = copy;
}

struct srv_payload *srv_payload_share(struct srv_payload *payload) {
    atomic_fetch_add_explicit(&payload->users, 1, memory_order_relaxed);
    return payload;
}

void srv_payload_drop(struct srv_payload **payload) {
    struct srv_payload *gone = *payload;
    *payload = NULL;
    if (!gone || atomic_fetch_sub(&gone->users, 1) != 1) return;
    srv_memory_add(gone->memory, SRV_MEMORY_ANSWERS, -(long long)gone->body.cap);
    srv_spares_give(gone->spares, &gone->body);
    free(gone);
}

size_t srv_payload_bytes(const struct srv_payload *payload) {
    return sizeof *payload + payload->text_cap + payload->body.cap;
}
