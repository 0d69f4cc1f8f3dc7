/* Creates libmicrohttpd's response for an answered exchange, complete or as a stream; or writes the
 * answer to the socket if libmicrohttpd accepts none.
 * Leaves to others: connections and requests (connection), the contents of answers (exchange).
 * Invariant: every answer has its request id. */
#pragma once

#include <microhttpd.h>

#include "server/work/exchange.h"

/* The connection's functions and state for a streamed response. */
struct srv_response_stream {
    struct srv_exchange *exchange;
    /** Reports the bytes passed to the client since the answer began; 0 = there are none yet. */
    void (*moved)(struct srv_exchange *exchange, uint64_t bytes);
    /** Suspends the connection until the exchange's `finish`. */
    void (*pause)(struct srv_exchange *exchange);
    struct MHD_Response *response; /* the response that gets the trailer fields */
    int broken; /* out: its computation failed, or was cancelled, before the body was complete */
};

/** Sets the request id: the client's own, or a new one. New ids are unique within a process, and
 * look random. */
void srv_response_identify(struct srv_exchange *exchange);

/**
 * Creates libmicrohttpd's response for an exchange.
 *
 * stream  used if the body is a stream; must outlive the response.
 *
 * Returns NULL if memory is short.
 */
struct MHD_Response *srv_response_new(const struct srv_exchange *exchange,
                                      struct srv_response_stream *stream);

/** Writes an exchange's answer to a socket without waiting; the connection must be closed after
 * it. */
void srv_response_refuse(struct srv_exchange *exchange, int fd);
