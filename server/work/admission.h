/* Who a request counts for, and whether that client may ask now.
 * Leaves to others: room in the queue (queue), memory (exchange), limits of a request's contents
 * (api).
 * Invariant: a request that is refused here has cost no more than its head. */
#ifndef SRV_ADMISSION_H
#define SRV_ADMISSION_H

#include "server/work/exchange.h"

/**
 * Sets exchange->identity, once a request: the token's, or who is at the other end of the
 * connection, or whom a trusted proxy names there. What is no token or no account leaves the
 * identity without it, for the log, and sets its fault.
 *
 * Returns 1: nobody is refused here.
 */
int srv_admission_identify(struct srv_exchange *exchange);

/**
 * Looks at the identity's fault.
 *
 * Returns 1 when there is none. Else the exchange is answered: 401 for what is no token, 400 for
 * what is no account.
 */
int srv_admission_named(struct srv_exchange *exchange);

/** Answers 401 and how a client names itself; format and arguments say why, a sentence's part. */
void srv_admission_challenge(struct srv_exchange *exchange, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/**
 * Counts a request that will compute.
 *
 * Returns 1 when it may go on: exchange->account is set. Else the exchange is answered: 429 over
 * the quota, 503 without memory.
 */
int srv_admission_count(struct srv_exchange *exchange);

#endif
