/* Enters a request that has ended in the metrics and in the log, and a deed among the deeds.
 * Leaves to others: when a request has ended, and how (connection).
 * Invariant: every request is entered once. */
#ifndef SRV_ACCESS_LOG_H
#define SRV_ACCESS_LOG_H

#include "server/work/exchange.h"

/**
 * Enters a request.
 *
 * outcome  a word, see the README; static.
 * status   HTTP status that the client was sent, 0 = none.
 */
void srv_access_log_enter(const struct srv_exchange *exchange, const char *outcome, int status);

#endif
