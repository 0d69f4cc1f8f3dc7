/* The route that erases the stored data of a client: jobs with their results, and scenes.
 * Leaves to others: class rooms, which expire or are deleted by their teacher (classes);
 * authorization (admission).
 * Invariant: after 204 no row of the store names the client; large results are deleted within
 * seconds.
 */
#pragma once

#include "server/work/exchange.h"

/** DELETE /v1/clients/{name}: "me" for the client itself (identified by key, token or account);
 * key:NAME, account:NAME or address:ADDRESS for an operator. 204; 401 or 403 for others; 404 for
 * any other name. */
void srv_erasure(struct srv_exchange *exchange);
