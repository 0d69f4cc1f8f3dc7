/* Local variables that are freed where their block ends, by a return or a failed REQUIRE too.
 * Leaves to others: how each is freed.
 * Invariant: what was declared last is freed first. */
#pragma once

#include <stdlib.h>
#include <string.h>

/** Declares a local struct that TYPE_VERB frees, or pointers to such structs:
 * OWN(test_tree, clear) t; OWN(pend_tree, free) *tree = NULL; */
#define OWN(type, verb) __attribute__((cleanup(type##_##verb), unused)) struct type

/** Declares a local pointer to memory of malloc: OWN_MEMORY char *text = malloc(100); */
#define OWN_MEMORY __attribute__((cleanup(own_memory_free), unused))

static inline void own_memory_free(void *pointer) {
    void *memory;
    memcpy(&memory, pointer, sizeof memory);
    free(memory);
}
