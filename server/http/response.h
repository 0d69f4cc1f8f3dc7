/* Answered exchanges as bytes: whole, as a stream, or written past libmicrohttpd where that
 * takes none.
 * Leaves to others: connections and requests (http), what an answer says (exchange).
 * Invariant: with http the only file that knows libmicrohttpd; every answer has its request id. */
#ifndef SRV_RESPONSE_H
#define SRV_RESPONSE_H

#include <microhttpd.h>

#include "server/work/exchange.h"

/* What a stream's answer needs of its connection. */
struct srv_response_stream {
    struct srv_exchange *exchange;
    /** The client did or did not get bytes: so many since the answer began; 0 = it waits for the
     * next. */
    void (*moved)(struct srv_exchange *exchange, uint64_t bytes);
    /** Suspends the connection until the exchange's finish. */
    void (*pause)(struct srv_exchange *exchange);
    struct MHD_Response *response; /* gets the trailers */
    int broken; /* out: its computation failed, or was ended, before the body was complete */
};

/** The client's own request id, or a new one: numbers of one process never repeat, and look
 * random. */
void srv_response_identify(struct srv_exchange *exchange);

/**
 * Makes libmicrohttpd's answer of an exchange.
 *
 * stream  of one whose body is a stream; must outlive the answer.
 *
 * Returns NULL without memory.
 */
struct MHD_Response *srv_response_new(const struct srv_exchange *exchange,
                                      struct srv_response_stream *stream);

/** Writes an exchange's answer straight to a socket, without waiting; the connection must end
 * then. */
void srv_response_refuse(struct srv_exchange *exchange, int fd);

#endif
