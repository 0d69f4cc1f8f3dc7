/* Reads a request's head that the strict reader has accepted: the fields that matter, the length of
 * the body, the target.
 * Leaves to others: the form of a message (http_strict), what the path means (router).
 * Invariant: a field that may come once and comes twice with two meanings is refused. */
#ifndef SRV_REQUEST_HEAD_H
#define SRV_REQUEST_HEAD_H

#include "server/work/exchange.h"

/**
 * Notes one field of the head.
 *
 * name, value  must live as long as the exchange's request.
 *
 * Returns 1 if it is well-formed. Else the exchange is answered (400 or 431).
 */
int srv_request_head_field(struct srv_exchange *exchange, const char *name, const char *value);

/** True for the name of a field that a proxy adds to what it relays: Via, Forwarded,
 * X-Forwarded-For. */
int srv_request_head_relayed(const char *name);

/**
 * Reads the head as a whole, after every field was noted: the length of the body, the
 * expectation, and the target, which is taken apart into path and query.
 *
 * Returns 1 if it is well-formed. Else the exchange is answered (400, 413, 414, 415 or 417).
 */
int srv_request_head_head(struct srv_exchange *exchange);

#endif
