/* A finished answer that several exchanges and the cache may have at once.
 * Leaves to others: computing it (compute), sending it (http), keeping it (cache).
 * Invariant: nobody changes a response body once a second one has it; the last one that lets go
 * frees it. */
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
    atomic_int users;
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
 * A response body without headers, which its maker has.
 *
 * body    taken over, and emptied; on failure too.
 * text    bytes of texts that srv_response_body_header is to copy, each with its NUL.
 * memory  the body's bytes are counted here, and taken off when the response body is freed.
 * buffer pool  where the body's memory goes then.
 *
 * Returns NULL without memory.
 */
struct srv_response_body *srv_response_body_new(int status, const char *media_type,
                                                struct api_buffer *body, size_t text,
                                                struct srv_memory *memory,
                                                struct srv_buffer_pool *pool);

/** Adds a header field; the name is static, the value is copied. There must be room. */
void srv_response_body_header(struct srv_response_body *response_body, const char *name,
                              const char *value);

/** One more has it. */
struct srv_response_body *srv_response_body_share(struct srv_response_body *response_body);

/** One less has it; NULL is accepted. Any thread. */
void srv_response_body_drop(struct srv_response_body **response_body);

/** Bytes of memory that it takes in all. */
size_t srv_response_body_bytes(const struct srv_response_body *response_body);

#endif
