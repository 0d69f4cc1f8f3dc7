/* Computing a request here, without a server.
 * Leaves to others: the computation (api/call), where the answer goes (sink).
 * Invariant: the bytes are those that a server of this version answers, but for compute_seconds,
 * which is left out. */
#pragma once

#include "api/clients/cli/sink.h"

/** Computes what POST /v1/ROUTE would answer to the body. Its limits are the widest that a server
 * may have. Dies with the words of the problem where it is refused. */
void cli_local(const char *route, const struct api_buffer *body, const char *accept,
               struct cli_sink *sink);
