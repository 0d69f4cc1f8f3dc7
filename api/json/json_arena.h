/* Memory for many small pieces that are freed together: the nodes and strings of one document.
 * Asking the C library for each piece would take longer than all other work of reading a request.
 * Leaves to others: what the pieces hold (json_scan), how many there may be (json_scan).
 * Invariant: a piece keeps its address until the arena is cleared. */
#ifndef API_JSON_ARENA_H
#define API_JSON_ARENA_H

#include <stddef.h>

struct api_arena_chunk; /* one block of the C library's memory */

/* All zero at first. */
struct api_arena {
    struct api_arena_chunk *last; /* the chunk in use; each knows the one before it */
    char *next;                   /* the first free byte of that chunk */
    size_t left;                  /* free bytes from there on */
};

/** True if the free bytes lie at the end of the last chunk; for assertions. */
int api_arena_valid(const struct api_arena *arena);

/**
 * Takes a piece of memory of at least one byte, aligned as malloc's memory is; its bytes are not
 * set.
 *
 * Returns NULL if memory is short; the earlier pieces are unchanged. Amortised O(1). All chunks
 * together have at most about twice the bytes of all pieces, or 4 KiB where that is more.
 */
void *api_arena_take(struct api_arena *arena, size_t bytes);

/** Frees all pieces; the arena is as new. O(chunks). */
void api_arena_clear(struct api_arena *arena);

#endif
