/* The field Range of a request (RFC 9110, 14): the bytes of an answer that its client wants.
 * Leaves to others: cutting them out (api/call/call), the condition If-Range (compute).
 * Invariant: a field that is not one good range of bytes is ignored, and the whole answer is
 * sent. */
#ifndef SRV_RANGE_H
#define SRV_RANGE_H

#include "api/call/call.h"

/**
 * Reads the field.
 *
 * field  NULL = there is none.
 * range  out.
 *
 * Returns 1 for one range of bytes; 0 for none, for several, and for what makes no sense.
 */
int srv_range_read(const char *field, struct api_range *range);

#endif
