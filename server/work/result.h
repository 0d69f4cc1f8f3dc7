/* Answers as response bodies: their header fields, their codings, and the two kinds of keys under
 * which the cache keeps them.
 * Leaves to others: when an answer is computed and who waits for it (compute, inflight), the
 * memory (cache).
 * Invariant: only answers 200 are remembered. */
#ifndef SRV_RESULT_H
#define SRV_RESULT_H

#include "server/work/inflight.h"

/** Answers an exchange from the cache if a request of the same bytes was answered before; returns 1
 * if so. Any thread. */
int srv_result_cached(struct srv_exchange *exchange);

/** Keeps an answer in the cache under the exact bytes of its request, if it may be kept. */
void srv_result_remember(struct srv_exchange *exchange, struct srv_response_body *response_body);

/**
 * Answers an exchange by a response body, or by 304 where its client has it.
 *
 * cache  for the log: why it was not computed, or NULL.
 */
void srv_result_give(struct srv_exchange *exchange, struct srv_response_body *response_body,
                     const char *cache);

/** Compresses the bytes in work->out if that is worth it; returns the coding that they have then.
 */
enum srv_coding srv_result_code(struct srv_work *work, const char *media_type);

/**
 * Makes a response body: the header fields of an answer, and its bytes.
 *
 * body  taken over, and emptied.
 *
 * Returns NULL without memory.
 */
struct srv_response_body *srv_result_response_body(struct srv_work *work, struct api_answer answer,
                                                   enum srv_coding coding, struct api_buffer *body);

/** Sets a work's ETag and key, which are different for answers, and codings, that differ. A request
 * that was refused has none. */
void srv_result_key(struct srv_work *work, enum srv_coding coding);

/** Looks up the answer of a work's key in the cache; compresses it if only the plain form is there.
 * Returns NULL if there is none. */
struct srv_response_body *srv_result_find(struct srv_work *work);

#endif
