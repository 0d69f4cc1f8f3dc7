/* What clients keep and hold, and how much of it they may.
 * Leaves to others: what follows when it is too much (store_jobs, store_leases); scenes, which store_scenes counts.
 * Invariant: a client's account is changed in the transaction that changes what it counts. */
#ifndef SRV_STORE_QUOTAS_H
#define SRV_STORE_QUOTAS_H

#include "server/store_call.h"

/**
 * Changes a client's account: open jobs, bytes of results, turns taken.
 *
 * total  out: its bytes afterwards; or NULL.
 */
enum srv_stored srv_store_client(struct srv_store *store, const char *client, long jobs, long long bytes, int turn,
                                 int64_t *total);

/**
 * Whether so many new bytes, and all bytes of a client's, leave room on the disk and under the quotas.
 *
 * SRV_STORED_FULL
 * SRV_STORED_QUOTA  message says which.
 */
enum srv_stored srv_store_room(struct srv_store *store, size_t bytes, int64_t client_bytes,
                               char message[SRV_MESSAGE_BYTES]);

/**
 * Whether all clients of an address or account together may have one more open job, that of a client which is counted
 * already; O(clients of the source that have something).
 *
 * source  NULL, or the client itself: the client's own quotas say all.
 *
 * SRV_STORED_QUOTA  message says which.
 */
enum srv_stored srv_store_source(struct srv_store *store, const char *client, const char *source,
                                 char message[SRV_MESSAGE_BYTES]);

#endif
