/* The field Range of a request (RFC 9110, 14): which bytes of an answer its client wants.
 * Leaves to others: cutting them out (api/call/call), whether If-Range allows it (compute).
 * Invariant: what is not one good range of bytes asks for nothing: the whole answer is as good. */
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
