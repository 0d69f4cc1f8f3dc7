/* Escapes in JSON strings, such as \n and \u20ac.
 * Leaves to others: the rest of a string (json_scan), writing escapes (text).
 * Invariant: the result is one character in UTF-8, never U+0000 and never a lone surrogate. */
#pragma once

#include <stddef.h>

/**
 * Reads one escape.
 *
 * text   begins with the backslash.
 * bytes  length of text, >= 1; nothing beyond is read.
 * taken  out: length of the escape.
 * utf8   out: the character; `length` its bytes, 1 to 4.
 * Returns NULL, or a clause that describes the error; then the outputs are unset.
 */
const char *api_escape_read(const char *text, size_t bytes, size_t *taken, char utf8[4],
                            size_t *length);
