#include "api/json/json_arena.h"

#include <assert.h>
#include <stdalign.h>
#include <stdint.h>
#include <stdlib.h>

enum { CHUNK_FIRST = 1 << 12, CHUNK_MOST = 1 << 16 };

struct api_arena_chunk {
    alignas(max_align_t) struct api_arena_chunk *before; /* NULL in the first chunk */
    size_t bytes;                                        /* bytes after this head */
};

int api_arena_valid(const struct api_arena *arena) {
    const struct api_arena_chunk *last = arena->last;
    if (!last) return !arena->next && !arena->left;
    return arena->left <= last->bytes &&
           arena->next + arena->left == (const char *)(last + 1) + last->bytes;
}

/* adds a chunk that can hold the piece; chunk sizes double up to CHUNK_MOST */
static int arena_grow(struct api_arena *arena, size_t piece) {
    size_t bytes = arena->last ? 2 * arena->last->bytes : CHUNK_FIRST;
    if (bytes > CHUNK_MOST) bytes = CHUNK_MOST;
    if (bytes < piece) bytes = piece;
    if (bytes > SIZE_MAX - sizeof *arena->last) return 0;
    struct api_arena_chunk *chunk = malloc(sizeof *chunk + bytes);
    if (!chunk) return 0;
    *chunk = (struct api_arena_chunk){arena->last, bytes};
    *arena = (struct api_arena){chunk, (char *)(chunk + 1), bytes};
    return 1;
}

void *api_arena_take(struct api_arena *arena, size_t bytes) {
    assert(bytes && api_arena_valid(arena));
    size_t whole = (bytes + alignof(max_align_t) - 1) / alignof(max_align_t) * alignof(max_align_t);
    if (whole < bytes || (whole > arena->left && !arena_grow(arena, whole))) return NULL;
    char *piece = arena->next;
    arena->next += whole;
    arena->left -= whole;
    assert(api_arena_valid(arena));
    return piece;
}

void api_arena_clear(struct api_arena *arena) {
    assert(api_arena_valid(arena));
    while (arena->last) {
        struct api_arena_chunk *chunk = arena->last;
        arena->last = chunk->before;
        free(chunk);
    }
    *arena = (struct api_arena){0};
}
