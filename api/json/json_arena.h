/* Memory for a tree of many small pieces that a library builds by calls of its own: one block,
 * filled from its front, and freed whole. Asking for each piece would take longer than all else
 * of reading a request.
 * Leaves to others: the library (json_in), how large the block has to be (json_scan).
 * Invariant: a thread that has begun no block gets and gives back the C library's memory. */
#ifndef API_JSON_ARENA_H
#define API_JSON_ARENA_H

#include <stddef.h>

/**
 * From now on the calling thread takes its pieces from a block.
 *
 * block  bytes of it; aligned as malloc's memory is.
 */
void api_arena_begin(void *block, size_t bytes);

/** The calling thread takes no more from its block; the pieces remain until the block is freed. */
void api_arena_end(void);

/** As malloc; NULL where the block is full. */
void *api_arena_take(size_t bytes);

/** As free; of a block that the calling thread has begun nothing is given back. */
void api_arena_give(void *piece);

#endif
