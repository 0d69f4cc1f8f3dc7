/* Computes a request in this process, without a server.
 * Leaves to others: the computation (api/call), the destination of the answer (sink).
 * Invariant: the bytes are those that a server of this version answers, without compute_seconds. */
#pragma once

#include "api/clients/cli/sink.h"

/** Computes what POST /v1/ROUTE would answer to the body. The limits are the widest that a server
 * may have. If the request is refused, ends the program with the words of the problem. */
void cli_local(const char *route, const struct api_buffer *body, const char *accept,
               struct cli_sink *sink);
