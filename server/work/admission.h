/* The stages of a request that depend on its client: authentication and quota.
 * Leaves to others: the queue's bounds (queue), memory (exchange), limits of a request's contents
 * (api), the order of the stages (http/router).
 * Invariant: a request refused here has cost only the reading of its head. */
#pragma once

#include "server/work/exchange.h"

/**
 * Sets exchange->identity, once per request: that of the token, of the connection's address, or the
 * one named by a trusted proxy. An invalid token or account is not part of the identity in the log,
 * and sets its fault.
 *
 * Always returns 1: this stage refuses nobody.
 */
int srv_admission_identify(struct srv_exchange *exchange);

/**
 * Checks the identity's fault.
 *
 * Returns 1 if there is none. Otherwise answers the exchange: 401 for an invalid token and for a
 * key that is malformed, unknown, expired or revoked, 400 for an invalid account.
 */
int srv_admission_named(struct srv_exchange *exchange);

/** Answers 401 and explains how to authenticate; format and arguments are the beginning of that
 * sentence: why authentication is needed. */
void srv_admission_challenge(struct srv_exchange *exchange, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/**
 * Answers that the client's role does not permit the request: 401 without a key, else 403.
 *
 * needed  a role that permits it.
 * what    the beginning of the sentence: what is not permitted.
 */
void srv_admission_forbid(struct srv_exchange *exchange, enum srv_role needed, const char *what);

/**
 * Subtracts one request from the client's quota, and checks whether it has seconds of computation
 * left.
 *
 * Returns 1 if both permit the request, and sets exchange->account. Otherwise answers the exchange:
 * 429 if one is exceeded, 503 if memory is short.
 */
int srv_admission_count(struct srv_exchange *exchange);
