/* Folds nicknames so that names that look alike become equal. */
#pragma once

#include <stddef.h>

/**
 * Folds a nickname: resolves compatibility forms (full-width, mathematical letters) and look-alikes
 * of other scripts (the skeleton of Unicode's UTS 39), ignores case, equates i, l and 1, o and 0,
 * and drops blanks and invisible characters.
 *
 * fold  out, cap bytes; UTF-8, truncated at a character.
 *
 * Returns the length of the fold; 0 if the name has no visible character. Any thread. O(bytes).
 */
int srv_nickname_fold(const char *name, char fold[], size_t cap);
