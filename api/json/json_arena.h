/* An arena: memory for the nodes and strings of one document, freed together. A malloc for each
 * would take longer than the rest of parsing.
 * Leaves to others: the contents and their limits (json_scan).
 * Invariant: a piece keeps its address until the arena is cleared. */
#pragma once

#include <stddef.h>

struct api_arena_chunk; /* a block from malloc */

/* An arena; initially all zero. */
struct api_arena {
    struct api_arena_chunk *last; /* the chunk in use; each chunk points to the previous one */
    char *next;                   /* first free byte of the chunk in use */
    size_t left;                  /* number of free bytes from `next` on */
};

/**
 * Allocates at least one byte, aligned as by malloc and uninitialized.
 *
 * Returns NULL if memory is short; earlier pieces stay valid. Amortised O(1). All chunks together
 * take at most about twice the bytes of all pieces, or 4 KiB if that is more.
 */
void *api_arena_take(struct api_arena *arena, size_t bytes);

/** Frees all pieces; the arena can be used again. O(chunks). */
void api_arena_clear(struct api_arena *arena);
int api_arena_valid(const struct api_arena *arena);
