/* The bytes of a result in one representation, which several exchanges and the cache may share.
 * Leaves to others: computing them (compute), sending them (http), keeping them (cache).
 * Invariant: a response body with more than one reference is not changed; dropping the last
 * reference frees it. */
#ifndef SRV_RESPONSE_BODY_H
#define SRV_RESPONSE_BODY_H

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
    char etag[SRV_ETAG_BYTES]; /* as the header field; "" where there is none */
    struct {
        const char *name, *value; /* static, or in text */
    } header[SRV_RESPONSE_BODY_HEADERS];
    int headers;
    long steps;                /* of the computation, for the log */
    size_t kept;               /* the cache's: keys that lead here */
    struct srv_memory *memory; /* where its bytes are counted */
    atomic_int readers;        /* exchanges that have it as their answer */
    struct srv_buffer_pool *pool;
    size_t text_bytes, text_cap;
    char text[];
};

/**
 * Makes a response body without header fields; the caller has its only reference.
 *
 * body    its memory is moved into the response body, or into the pool on failure; it is empty
 *         afterwards.
 * text    bytes of all values that srv_response_body_header will copy, each with its NUL.
 * memory  counts the body's bytes until the response body is freed.
 * pool    gets the body's memory when the response body is freed.
 *
 * Returns NULL when memory is short.
 */
struct srv_response_body *srv_response_body_new(int status, const char *media_type,
                                                struct api_buffer *body, size_t text,
                                                struct srv_memory *memory,
                                                struct srv_buffer_pool *pool);

/** Adds a header field: the name is static, the value is copied. At most SRV_RESPONSE_BODY_HEADERS
 * fields, and the values must fit into the bytes that were asked for. */
void srv_response_body_header(struct srv_response_body *response_body, const char *name,
                              const char *value);

/** Adds a reference and returns the response body. Any thread. */
struct srv_response_body *srv_response_body_share(struct srv_response_body *response_body);

/** Drops a reference and sets the pointer to NULL; the last one frees the response body. NULL is
 * accepted. Any thread. */
void srv_response_body_drop(struct srv_response_body **response_body);

/** Returns the bytes of memory of a response body in all. */
size_t srv_response_body_bytes(const struct srv_response_body *response_body);

#endif
