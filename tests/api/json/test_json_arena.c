#include "api/json/json_arena.h"

#include <stdalign.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "tests/harness/test.h"

TEST(json_arena_gives_pieces_side_by_side_until_the_block_is_full) {
    enum { BYTES = 1 << 12 };
    char *block = malloc(BYTES), *end = block;
    int pieces = 0, faults = 0;
    REQUIRE(block);
    api_arena_begin(block, BYTES);
    for (size_t bytes = 1;; bytes = bytes % 90 + 1, pieces++) {
        char *piece = api_arena_take(bytes);
        if (!piece) break;
        faults += piece < end || piece >= end + alignof(max_align_t) ||
                  (uintptr_t)piece % alignof(max_align_t);
        end = piece + bytes;
        /* gives nothing back: the next piece is behind it all the same */
        api_arena_give(piece);
    }
    CHECK_INT(faults, 0);
    CHECK(pieces > 50 && end <= block + BYTES && end > block + BYTES - 128);
    CHECK(!api_arena_take(SIZE_MAX));
    api_arena_end();
    free(block);
}

TEST(json_arena_is_the_heap_for_whoever_has_begun_no_block) {
    char *piece = api_arena_take(100);
    REQUIRE(piece);
    memset(piece, 1, 100);
    api_arena_give(piece);
}
