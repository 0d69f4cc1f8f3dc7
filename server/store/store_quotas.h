/* The jobs, scenes and bytes that clients have in the store, and their quotas.
 * Leaves to others: the consequences of an exceeded quota (store_jobs, store_leases, store_scenes).
 * Invariant: sums are changed in the transaction that changes what they count, so that they
 * always equal a recount. */
#ifndef SRV_STORE_QUOTAS_H
#define SRV_STORE_QUOTAS_H

#include "server/store/store_call.h"

/** Adds to the bytes kept for a client's jobs, and to the sum of all clients. */
enum srv_stored srv_store_count_bytes(struct srv_store *store, const char *client, int64_t bytes);

/**
 * Counts a client's jobs, bytes and scenes anew, and all sums: what was kept of them cannot be.
 * What this transaction has changed so far is written already. O(all jobs)
 */
enum srv_stored srv_store_recount(struct srv_store *store, const char *client);

/** Returns the number of parts of a job that can be claimed now. */
long srv_job_claimable(const struct srv_job *job);

/** Counts what became of a job between two readings of it: its state, its parts that can be
 * claimed, its bytes. */
enum srv_stored srv_store_count_job(struct srv_store *store, const struct srv_job *was,
                                    const struct srv_job *is);

/**
 * Whether a client may keep so many bytes more for its jobs: under its quota, under that of all,
 * and on the disk.
 *
 * SRV_STORED_FULL
 * SRV_STORED_QUOTA  message says which.
 */
enum srv_stored srv_store_room(struct srv_store *store, const char *client, size_t bytes,
                               char message[SRV_REQUEST_HEAD_BYTES]);

/**
 * Whether all clients of an address or account together may have one more open job; O(clients of
 * the source).
 *
 * client  whose changes in this transaction are known; notes its source.
 * source  NULL, or the client itself: the client's own quotas say all.
 *
 * SRV_STORED_QUOTA  message says which.
 */
enum srv_stored srv_store_source(struct srv_store *store, const char *client, const char *source,
                                 char message[SRV_REQUEST_HEAD_BYTES]);

/**
 * Whether a client may keep one more scene.
 *
 * bytes  that it is counted for.
 * anew   non-zero: nobody keeps it yet, so that it takes room on the disk as well.
 *
 * SRV_STORED_FULL, SRV_STORED_QUOTA
 */
enum srv_stored srv_store_room_scene(struct srv_store *store, const char *client, size_t bytes,
                                     int anew);

#endif
