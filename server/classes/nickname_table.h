/* The folds of characters; nickname_table.py generates the table from nickname_alike.txt.
 * Leaves to others: folding a name (nickname).
 * Invariant: rows and marks are in the order of their characters. */
#pragma once

#include <stddef.h>

/* A character that does not fold to itself. */
struct srv_nickname_row {
    unsigned code, at; /* the character's fold is the text at srv_nickname_text + at, UTF-8 */
};

extern const struct srv_nickname_row srv_nickname_rows[];
extern const unsigned srv_nickname_marks[][2]; /* first and last character of each range of
                                                * combining marks */
extern const char srv_nickname_text[];
extern const size_t srv_nickname_row_count, srv_nickname_mark_count;
