/* Computes a request in this process, without a server.
 * Leaves to others: the computation (api/call), the destination of the answer (sink).
 * Invariant: the bytes are those that a server of this version answers, without compute_seconds. */
#pragma once

#include "api/clients/cli/sink.h"

/* A part of an answer, 1 .. parts; parts is 0 for the whole. */
struct cli_part {
    long part, parts;
};

/** Computes what POST /v1/ROUTE would answer to the body. The limits are the widest that a server
 * may have. If the request is refused, ends the program with the words of the problem. */
void cli_local(const char *route, const struct api_buffer *body, const char *accept,
               struct cli_part part, struct cli_sink *sink);
