/* Answers as response bodies: their heads, their codings, and the two kinds of keys under which
 * the cache has them.
 * Leaves to others: when an answer is computed and who waits for it (compute, inflight), the
 * memory (cache).
 * Invariant: only answers 200 are remembered. */
#ifndef SRV_RESULT_H
#define SRV_RESULT_H

#include "server/work/inflight.h"

/** Answers an exchange from the cache where its very bytes were seen before; returns 1 when it did.
 * No worker needed.
 */
int srv_result_cached(struct srv_exchange *exchange);

/** Remembers the answer to an exchange's exact bytes, where that may be. */
void srv_result_remember(struct srv_exchange *exchange, struct srv_response_body *response_body);

/**
 * Answers an exchange by a response body, or by 304 where its client has it.
 *
 * cache  for the log: why it was not computed, or NULL.
 */
void srv_result_give(struct srv_exchange *exchange, struct srv_response_body *response_body,
                     const char *cache);

/** Compresses what is in work->out where that is worth it; returns the coding that it has then. */
enum srv_coding srv_result_code(struct srv_work *work, const char *media_type);

/**
 * The head of an answer as a response body.
 *
 * body  its body, taken over.
 *
 * Returns NULL without memory.
 */
struct srv_response_body *srv_result_response_body(struct srv_work *work, struct api_answer answer,
                                                   enum srv_coding coding, struct api_buffer *body);

/** Sets a work's ETag and key: what tells its answer, in that coding, from others. None for a
 * request refused. */
void srv_result_key(struct srv_work *work, enum srv_coding coding);

/** The answer in the cache by its work's key, compressed now if it is there only as it is; NULL
 * if it is not there. */
struct srv_response_body *srv_result_find(struct srv_work *work);

#endif
