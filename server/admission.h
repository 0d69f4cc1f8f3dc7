/* Who a request counts for, and whether that client may ask now.
 * Leaves to others: room in the queue (queue), memory (exchange), limits of a request's contents (api).
 * Invariant: a request that is refused here has cost no more than its head. */
#ifndef SRV_ADMISSION_H
#define SRV_ADMISSION_H

#include "server/exchange.h"

/** Sets exchange->client: the peer, or whom a trusted proxy names. */
void srv_admission_client(struct srv_exchange *exchange);

/**
 * Counts a request that will compute.
 *
 * Returns 1 when it may go on: exchange->account is set. Else the exchange is answered: 429 over the quota, 503 without
 * memory.
 */
int srv_admission_count(struct srv_exchange *exchange);

#endif
