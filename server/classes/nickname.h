/* Nicknames that look alike: what a nickname is folded to.
 * Leaves to others: which nicknames are in a room, and their numbers (store_class_pupils).
 * Invariant: names that differ in nothing that is seen at a glance have the same fold. */
#ifndef SRV_NICKNAME_H
#define SRV_NICKNAME_H

#include <stddef.h>

/**
 * Folds a nickname: compatibility forms (full-width, mathematical letters) are what they stand for,
 * look-alikes of other scripts too (the skeleton of Unicode's UTS 39), small and capital letters
 * are the same, as are i, l and 1, and o and 0; blanks and what cannot be seen are left out.
 *
 * fold  out, cap bytes; UTF-8, cut at a character where it is longer.
 *
 * Returns the length of the fold, 0 where nothing can be seen. Any thread. O(bytes)
 */
int srv_nickname_fold(const char *name, char fold[], size_t cap);

#endif
