/* Escapes in JSON strings: the characters that \n, \u20ac and their like stand for.
 * Leaves to others: all else of a string (json_scan), writing escapes (text).
 * Invariant: what comes out is one character in UTF-8, never U+0000 and never half of a pair. */
#ifndef API_JSON_ESCAPE_H
#define API_JSON_ESCAPE_H

#include <stddef.h>

/**
 * Reads one escape.
 *
 * text   begins with the backslash.
 * bytes  of text, >= 1; none behind them is read.
 * taken  out: length of the escape.
 * utf8   out: the character; `length` its bytes, 1 to 4.
 * Returns NULL, or what is wrong, as a clause; then nothing else is set.
 */
const char *api_escape_read(const char *text, size_t bytes, size_t *taken, char utf8[4],
                            size_t *length);

#endif
