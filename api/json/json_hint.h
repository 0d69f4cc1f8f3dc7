/* Hints for text that is not JSON: habits from other languages and tools.
 * Leaves to others: the grammar, and the position of the error (json_scan).
 * Invariant: a hint only explains; it never makes text acceptable. */
#pragma once

#include <stddef.h>

/**
 * Returns a hint for the position at which a text is no longer JSON, such as ": JSON has no
 * comments"; "" if there is none.
 *
 * at  0 .. bytes.
 * O(blank bytes before at).
 */
const char *api_json_hint(const char *text, size_t bytes, size_t at);
