/* The route that erases what is kept of a client: jobs with their results, and scenes.
 * Leaves to others: rooms of classes, which end by themselves or at their teacher's word (classes);
 * who may have it erased (admission).
 * Invariant: after 204 the store has no row that names the client; what was large of its results
 * goes within seconds. */
#ifndef SRV_ERASURE_H
#define SRV_ERASURE_H

#include "server/work/exchange.h"

/**
 * DELETE /v1/clients/{name}: of "me", whoever asks by a key, a token or an account; of key:NAME,
 * account:NAME or address:ADDRESS, for an operator. 204; 401 or 403 for others; 404 for a name of
 * another form.
 */
void srv_erasure(struct srv_exchange *exchange);

#endif
