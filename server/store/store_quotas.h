/* The jobs, scenes and bytes of clients in the store, and their quotas.
 * Leaves to others: the consequences of an exceeded quota (store_jobs, store_leases, store_scenes).
 * Invariant: sums change in the same transaction as the rows that they count, so they always equal
 * a recount. */
#pragma once

#include "server/store/store_call.h"

/** Adds to the bytes of a client's jobs, and to the sum of all clients. */
enum srv_stored srv_store_count_bytes(struct srv_store *store, const char *client, int64_t bytes);

/** Recounts a client's jobs, bytes and scenes, and all sums, because the stored ones are
 * impossible. The changes of this transaction must be written already. O(all jobs). */
enum srv_stored srv_store_recount(struct srv_store *store, const char *client);

/** Returns the number of parts of a job that can be claimed now. */
long srv_job_claimable(const struct srv_job *job);

/** Updates the sums for the change between two states of a job: state, claimable parts, bytes. */
enum srv_stored srv_store_count_job(struct srv_store *store, const struct srv_job *was,
                                    const struct srv_job *is);

/**
 * Checks whether a client may store this many more bytes for its jobs: its quota, that of all
 * clients, and the disk.
 *
 * SRV_STORED_FULL
 * SRV_STORED_QUOTA  message says which.
 */
enum srv_stored srv_store_room(struct srv_store *store, const char *client, size_t bytes,
                               char message[SRV_REQUEST_HEAD_BYTES]);

/**
 * Checks whether all clients of an address or account together may have one more open job.
 * O(clients of the source).
 *
 * client  the client, whose changes in this transaction are known; records its source.
 * source  NULL, or the client itself: only the client's own quotas apply.
 *
 * SRV_STORED_QUOTA  message says which.
 */
enum srv_stored srv_store_source(struct srv_store *store, const char *client, const char *source,
                                 char message[SRV_REQUEST_HEAD_BYTES]);

/**
 * Checks whether a client may store one more scene.
 *
 * bytes  counted for the scene.
 * anew   non-zero: no other client stores it, so it needs disk space too.
 *
 * SRV_STORED_FULL
 * SRV_STORED_QUOTA  srv_store_complaint says which.
 */
enum srv_stored srv_store_room_scene(struct srv_store *store, const char *client, size_t bytes,
                                     int anew);
