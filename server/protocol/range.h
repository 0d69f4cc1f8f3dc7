/* The request field Range (RFC 9110, 14).
 * Leaves to others: cutting out the bytes (api/call/call), the condition If-Range (compute).
 * Invariant: a field that is not a single valid byte range is ignored: the whole answer is sent. */
#pragma once

#include "api/call/call.h"

/**
 * Reads the field.
 *
 * field  value of Range; NULL if absent.
 * range  out.
 *
 * Returns 1 for a single valid byte range, else 0.
 */
int srv_range_read(const char *field, struct api_range *range);
