/* Records a finished request in the metrics, the access log and the audit log.
 * Leaves to others: when and how a request ends (connection).
 * Invariant: every request is recorded once. */
#pragma once

#include "server/work/exchange.h"

/**
 * Records a request.
 *
 * outcome  a word, see the README; static.
 * status   HTTP status sent to the client, 0 = none.
 */
void srv_access_log_enter(const struct srv_exchange *exchange, const char *outcome, int status);
