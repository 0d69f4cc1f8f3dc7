/* Answers as response bodies: header fields, content codings, and the two kinds of keys in the
 * cache.
 * Leaves to others: computing answers and waiting for them (compute, inflight), the memory (cache).
 * Invariant: only answers with status 200 are cached. */
#pragma once

#include "server/work/inflight.h"

/** Answers an exchange from the cache if a request with the same bytes was answered before; returns
 * 1 if so. Any thread. */
int srv_result_cached(struct srv_exchange *exchange);

/** Stores an answer in the cache under the exact bytes of its request, if it may be cached. */
void srv_result_remember(struct srv_exchange *exchange, struct srv_response_body *response_body);

/**
 * Answers an exchange with a response body, or with 304 if its client has it.
 *
 * cache  for the log: the reason why it was not computed, or NULL.
 */
void srv_result_give(struct srv_exchange *exchange, struct srv_response_body *response_body,
                     const char *cache);

/** Compresses the bytes in work->out if that is useful; returns their coding. */
enum srv_coding srv_result_code(struct srv_work *work, const char *media_type);

/**
 * Creates a response body from an answer's header fields and its bytes.
 *
 * body  taken over, and emptied.
 *
 * Returns NULL if memory is short.
 */
struct srv_response_body *srv_result_response_body(struct srv_work *work, struct api_answer answer,
                                                   enum srv_coding coding, struct api_buffer *body);

/** Sets a computation's ETag and key, which differ for different answers and codings. A refused
 * request has none. */
void srv_result_key(struct srv_work *work, enum srv_coding coding);

/** Looks up the answer of a computation's key in the cache; compresses it if only the plain form is
 * cached. Returns NULL if there is none. */
struct srv_response_body *srv_result_find(struct srv_work *work);
