#include "api/json/json_arena.h"

#include <stdalign.h>
#include <stdint.h>
#include <string.h>

#include "tests/harness/test.h"

TEST(json_arena_gives_pieces_that_are_aligned_and_keep_their_bytes) {
    enum { PIECES = 5000 };
    static unsigned char *piece[PIECES];
    struct api_arena arena = {0};
    int faults = 0;
    for (int i = 0; i < PIECES; i++) {
        /* mostly small; some larger than any chunk */
        size_t bytes = i % 1000 == 999 ? 100000 : (size_t)(i % 90) + 1;
        piece[i] = api_arena_take(&arena, bytes);
        REQUIRE(piece[i]);
        faults += (uintptr_t)piece[i] % alignof(max_align_t) != 0 || !api_arena_valid(&arena);
        memset(piece[i], i & 0xff, bytes);
    }
    for (int i = 0; i < PIECES; i++) {
        size_t bytes = i % 1000 == 999 ? 100000 : (size_t)(i % 90) + 1;
        for (size_t k = 0; k < bytes; k++) faults += piece[i][k] != (i & 0xff);
    }
    CHECK_INT(faults, 0);
    api_arena_clear(&arena);
    CHECK(!arena.last && !arena.left && api_arena_valid(&arena));
}

TEST(json_arena_whose_memory_is_short_stays_as_it_was) {
    OWN(api_arena, clear) arena = {0};
    CHECK(!api_arena_take(&arena, SIZE_MAX) && !arena.last);
    char *piece = api_arena_take(&arena, 100);
    REQUIRE(piece);
    size_t left = arena.left;
    CHECK(!api_arena_take(&arena, SIZE_MAX));
    CHECK(!api_arena_take(&arena, SIZE_MAX - 20));
    CHECK(arena.left == left && api_arena_valid(&arena));
}
