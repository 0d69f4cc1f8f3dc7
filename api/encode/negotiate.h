/* Content negotiation by the header fields Content-Type and Accept (RFC 9110).
 * Leaves to others: the representations (encode), other header fields (server).
 * Invariant: a malformed element of a field is ignored. */
#pragma once

#include "api/encode/encode.h"
#include "api/base/problem.h"

/**
 * Returns true for application/json, alone or with charset=utf-8.
 *
 * content_type  value of Content-Type, or NULL if the field is absent.
 */
int api_negotiate_json(const char *content_type);

/**
 * Finds a parameter of a field's value, such as the boundary of `multipart/form-data; boundary=x`.
 *
 * value  the field's value, `bytes` long.
 * type   the media type before the parameters; case does not matter.
 * name   the parameter's name; case does not matter.
 * text   out: the first such parameter without its quotes, a pointer into `value`, `size` bytes
 *        long; NULL if there is no such parameter.
 *
 * Returns non-zero if the value has that media type. O(bytes).
 */
int api_negotiate_parameter(const char *value, size_t bytes, const char *type, const char *name,
                            const char **text, size_t *size);

/**
 * Returns the representation that the client prefers; among equals, the first in the list.
 *
 * accept   value of Accept; NULL = anything.
 * samples  as in struct api_op: 1 for a table of samples, 2 for one with a picture, 0 for JSON
 *          only.
 *
 * Returns NULL if no representation is acceptable. The most specific matching media range decides
 * a type's q. O(length of accept).
 */
const struct api_format *api_negotiate_format(const char *accept, int samples);

/** Sets a problem with status 406 that names the media types available. */
void api_negotiate_refuse(struct api_problem *problem, int samples);
