/* Strict checks of a request's head as RFC 9110 and 9112 ask for them: fields, framing, target.
 * Leaves to others: cutting bytes into fields (http), what the path means (router).
 * Invariant: a message that two readers could take apart in two ways is refused, with its connection. */
#ifndef SRV_MESSAGE_H
#define SRV_MESSAGE_H

#include "server/exchange.h"

/* One header field as it came; the texts end with NUL, too. */
struct srv_message_field {
    const char *name, *value;
    size_t name_bytes, value_bytes;
};

/**
 * Takes in one field of the head.
 *
 * field  its texts must live as long as the exchange's request.
 *
 * Returns 1 when it is good. Else the exchange is answered (400 or 431) and its connection is to be closed.
 */
int srv_message_field(struct srv_exchange *exchange, const struct srv_message_field *field);

/**
 * Checks the head as a whole, once every field was taken in: Host, the framing of the body, the expectation, and the
 * target, which is taken apart into path and query.
 *
 * version  "HTTP/1.1", "HTTP/1.0", ...
 *
 * Returns 1 when it is good. Else the exchange is answered (400, 413, 414, 417, 501 or 505) and its connection is to be
 * closed.
 */
int srv_message_head(struct srv_exchange *exchange, const char *version);

#endif
