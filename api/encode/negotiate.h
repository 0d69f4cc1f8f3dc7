/* What a client sends and what it wants back: Content-Type and Accept of RFC 9110.
 * Leaves to others: the representations themselves (encode), other headers (server).
 * Invariant: an element of a header that is malformed is as if it were not there. */
#ifndef API_NEGOTIATE_H
#define API_NEGOTIATE_H

#include "api/encode/encode.h"
#include "api/base/problem.h"

/**
 * True when a body of this type is read as JSON: application/json, with charset=utf-8 or without a
 * charset.
 *
 * content_type  the header's value, or NULL where there is none.
 */
int api_negotiate_json(const char *content_type);

/**
 * The representation that the client likes best; of equals the one that stands first in the table.
 *
 * accept   the header's value, or NULL: anything.
 * samples  1 where the answer is a table of samples, 2 where it may be drawn as well; 0: JSON alone
 *          is served.
 *
 * Returns NULL where none fits. The most specific range that matches a type decides its q. O(length
 * of accept).
 */
const struct api_format *api_negotiate_format(const char *accept, int samples);

/** States the 406 and the media types that are served. */
void api_negotiate_refuse(struct api_problem *problem, int samples);

#endif
