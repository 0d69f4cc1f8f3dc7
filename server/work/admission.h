/* The stages of a request that depend on its client: who asks, and whether the quota allows it.
 * Leaves to others: the queue's bounds (queue), memory (exchange), limits of a request's contents
 * (api), the order of the stages (http/router).
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
 * Returns 1 when there is none. Else the exchange is answered: 401 for what is no token and for a
 * key that is broken, unknown, expired or revoked, 400 for what is no account.
 */
int srv_admission_named(struct srv_exchange *exchange);

/** Answers 401 and says how a client names itself; format and arguments are the beginning of that
 * sentence: why a name is needed. */
void srv_admission_challenge(struct srv_exchange *exchange, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/**
 * Answers that the client's role may not have what it asks for: 401 where it has shown no key, else
 * 403.
 *
 * needed  a role that may.
 * what    the beginning of the sentence: what it may not.
 */
void srv_admission_forbid(struct srv_exchange *exchange, enum srv_role needed, const char *what);

/**
 * Takes one request off the client's quota, and looks whether it has seconds of computation left.
 *
 * Returns 1 when both allow it: exchange->account is set. Else the exchange is answered: 429 over
 * one of them, 503 without memory.
 */
int srv_admission_count(struct srv_exchange *exchange);

#endif
