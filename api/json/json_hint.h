/* What was meant by a text that is not JSON: the habits of other languages and of tools.
 * Leaves to others: the grammar, and the place of the fault (json_scan).
 * Invariant: a hint is only told; nothing is accepted by it. */
#ifndef API_JSON_HINT_H
#define API_JSON_HINT_H

#include <stddef.h>

/**
 * What was probably meant at the place where a text ceases to be JSON.
 *
 * at  from 0 to bytes.
 * Returns a clause that continues the sentence, ": JSON has no comments", or "". O(bytes before at
 * that are blank).
 */
const char *api_json_hint(const char *text, size_t bytes, size_t at);

#endif
