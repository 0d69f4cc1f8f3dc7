/* Asking a server over HTTP; the only user of libcurl.
 * Leaves to others: what is asked (main), where the answer goes (sink).
 * Invariant: a refusal for the moment (429, 502, 503, 504) and a line that breaks are met again
 * within the patience; an answer that broke off is never taken for whole. */
#pragma once

#include "api/clients/cli/sink.h"

struct cli_remote {
    const char *url;   /* of the server, without a path */
    const char *token; /* NULL = none */
    double patience;   /* s without progress */
    int met;           /* it has answered this process */
};

struct cli_exchange {
    const char *method, *path;
    const struct api_buffer *body; /* NULL = none */
    const char *accept;            /* NULL = application/json */
    const char *key;               /* Idempotency-Key of a job; NULL = no job */
    const char *title;             /* what to call the job; NULL = nothing */
    char etag[120];                /* of the answer; "" before */
    int resumes;                   /* the answer is the same to the byte each time */
};

/**
 * Does an exchange, over and over where need be.
 *
 * Returns the status, below 400. Dies with the server's own words where it refuses, and at once
 * where there is none and never was.
 */
long cli_remote_ask(struct cli_remote *remote, struct cli_exchange *exchange,
                    struct cli_sink *sink);
