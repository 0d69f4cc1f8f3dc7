/* Reads a request's head that the strict reader has accepted: the fields that matter, the length of
 * the body, the target.
 * Leaves to others: the syntax of messages (http_strict), the meaning of paths (router).
 * Invariant: a field that may occur once and occurs twice with different values is refused. */
#pragma once

#include "server/work/exchange.h"

/**
 * Stores one field of the head.
 *
 * name, value  valid as long as the exchange's request.
 *
 * Returns 1 if it is well-formed. Otherwise answers the exchange (400 or 431).
 */
int srv_request_head_field(struct srv_exchange *exchange, const char *name, const char *value);

/** Returns true for the name of a field that a proxy adds to forwarded requests: Via, Forwarded,
 * X-Forwarded-For. */
int srv_request_head_relayed(const char *name);

/**
 * Evaluates the head after every field was stored: the length of the body, the expectation, and the
 * target, which is split into path and query.
 *
 * Returns 1 if it is well-formed. Otherwise answers the exchange (400, 413, 414, 415 or 417).
 */
int srv_request_head_head(struct srv_exchange *exchange);
