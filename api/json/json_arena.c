#include "api/json/json_arena.h"

#include <stdalign.h>
#include <stdlib.h>

struct room {
    char *next; /* NULL = no block */
    size_t left;
};

static _Thread_local struct room room_here;

void api_arena_begin(void *block, size_t bytes) { room_here = (struct room){block, bytes}; }

void api_arena_end(void) { room_here = (struct room){NULL, 0}; }

void *api_arena_take(size_t bytes) {
    struct room *room = &room_here;
    if (!room->next) return malloc(bytes);
    size_t whole = (bytes + alignof(max_align_t) - 1) / alignof(max_align_t) * alignof(max_align_t);
    if (whole < bytes || whole > room->left) return NULL;
    char *piece = room->next;
    room->next += whole;
    room->left -= whole;
    return piece;
}

void api_arena_give(void *piece) {
    if (!room_here.next) free(piece);
}
