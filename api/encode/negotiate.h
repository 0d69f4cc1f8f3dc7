/* Content negotiation: the header fields Content-Type and Accept of RFC 9110.
 * Leaves to others: the representations themselves (encode), other header fields (server).
 * Invariant: a malformed element of a field is ignored. */
#ifndef API_NEGOTIATE_H
#define API_NEGOTIATE_H

#include "api/encode/encode.h"
#include "api/base/problem.h"

/**
 * True if a body of this type is read as JSON: application/json, with charset=utf-8 or without a
 * charset.
 *
 * content_type  the field's value, or NULL if there is no such field.
 */
int api_negotiate_json(const char *content_type);

/**
 * Finds a parameter of a field's value, such as the boundary of `multipart/form-data; boundary=x`.
 *
 * value  `bytes` of it.
 * type   what stands before the parameters, of any case.
 * name   of the parameter, of any case.
 * text   out: the first such parameter without its quotes, in `value`, of `size` bytes; NULL if
 *        there is none.
 *
 * Returns whether the value is of that type. O(bytes).
 */
int api_negotiate_parameter(const char *value, size_t bytes, const char *type, const char *name,
                            const char **text, size_t *size);

/**
 * Returns the representation that the client prefers; among equals the first of the table.
 *
 * accept   the field's value, or NULL: anything.
 * samples  of struct api_op: 1 for a table of samples, 2 for one with a picture, 0 for JSON only.
 *
 * Returns NULL if none is acceptable. The most specific range that matches a type decides its q.
 * O(length of accept).
 */
const struct api_format *api_negotiate_format(const char *accept, int samples);

/** States a problem of status 406 that names the media types that are served. */
void api_negotiate_refuse(struct api_problem *problem, int samples);

#endif
