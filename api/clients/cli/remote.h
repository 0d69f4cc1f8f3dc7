/* Requests to a server over HTTP. No other file uses libcurl.
 * Leaves to others: which requests (main), the destination of the answer (sink).
 * Invariant: temporary refusals (429, 502, 503, 504) and broken connections are retried for
 * `patience`; an incomplete answer is never treated as complete. */
#pragma once

#include "api/clients/cli/sink.h"

struct cli_remote {
    const char *url;   /* URL of the server, without a path */
    const char *token; /* NULL = none */
    double patience;   /* s without progress before it gives up */
    int met;           /* whether the server has answered this process */
};

struct cli_exchange {
    const char *method, *path;
    const struct api_buffer *body; /* NULL = none */
    const char *accept;            /* value of Accept; NULL = application/json */
    const char *key;               /* Idempotency-Key of a job; NULL = no job */
    const char *title;             /* title of the job; NULL = none */
    char etag[120];                /* ETag of the answer; "" until it is known */
    int resumes;                   /* whether the answer has the same bytes each time, so that a
                                    * download can be resumed */
};

/**
 * Does an exchange, with as many attempts as necessary.
 *
 * Returns the status, below 400. Ends the program with the server's words if it refuses, and at
 * once if it has never answered.
 */
long cli_remote_ask(struct cli_remote *remote, struct cli_exchange *exchange,
                    struct cli_sink *sink);
