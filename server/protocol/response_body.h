/* The body of a response with its header fields, reference-counted: HTTP exchanges and the cache
 * share it.
 * Leaves to others: computing it (compute), sending it (http), keeping it (cache).
 * Invariant: a response body with more than one reference is not changed; dropping the last
 * reference frees it. */
#pragma once

#include <stdatomic.h>

#include "api/base/buffer.h"
#include "server/base/memory.h"
#include "server/base/buffer_pool.h"

enum {
    SRV_RESPONSE_BODY_HEADERS = 16,
    SRV_ETAG_BYTES = 76 /* W/"64 digits" and a NUL, with room */
};

struct srv_response_body {
    atomic_int users; /* references */
    int status;
    const char *media_type; /* a static string */
    struct api_buffer body;
    char etag[SRV_ETAG_BYTES]; /* value of ETag; "" = none */
    struct {
        const char *name, *value; /* static, or in text */
    } header[SRV_RESPONSE_BODY_HEADERS];
    int headers;
    long steps;                /* steps of the computation, for the log */
    size_t kept;               /* cache keys that refer to it; owned by the cache */
    struct srv_memory *memory; /* the account of its bytes */
    atomic_int readers;        /* exchanges that send it */
    struct srv_buffer_pool *pool;
    size_t text_bytes, text_cap;
    char text[];
};

/**
 * Creates a response body without header fields; the caller owns the only reference.
 *
 * body    moved into the response body (into the pool on failure); empty afterwards.
 * text    bytes of all values that srv_response_body_header will copy, each with its NUL.
 * memory  account of the body's bytes until the response body is freed.
 * pool    receives the body's memory when the response body is freed.
 *
 * Returns NULL if memory is short.
 */
struct srv_response_body *srv_response_body_new(int status, const char *media_type,
                                                struct api_buffer *body, size_t text,
                                                struct srv_memory *memory,
                                                struct srv_buffer_pool *pool);

/** Adds a header field: the name is static, the value is copied. At most SRV_RESPONSE_BODY_HEADERS
 * fields; all values together must fit into `text` bytes of srv_response_body_new. */
void srv_response_body_header(struct srv_response_body *response_body, const char *name,
                              const char *value);

/** Adds a reference and returns the response body. Any thread. */
struct srv_response_body *srv_response_body_share(struct srv_response_body *response_body);

/** Drops a reference and sets the pointer to NULL; the last one frees the response body. NULL is
 * accepted. Any thread. */
void srv_response_body_drop(struct srv_response_body **response_body);

/** Returns the memory of a response body in bytes. */
size_t srv_response_body_bytes(const struct srv_response_body *response_body);
