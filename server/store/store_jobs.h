/* Jobs, their parts under leases, results as rows, and quotas of clients, for calls that have
 * begun. Rows of large tables are files (store_files), and their results name these. Leaves to
 * others: claiming parts (store_claims), deletion (store_sweep). Invariant: a job ends once; a
 * client's key creates one job, even with concurrent submissions; a part's result is accepted once,
 * from the attempt that holds it. Sums of clients change in the same transaction as the rows that
 * they count. */
#pragma once

#include "server/store/store_call.h"

/* maximum number of parts that are deleted immediately when a job ends */
enum { SRV_FEW_PARTS = 16 };

/** Reads a job by its id with a statement, within a call; its `flaw` may be set. SRV_STORED_NONE */
enum srv_stored srv_store_find(struct srv_store *store, enum srv_statement id, const char *name,
                               struct srv_job *job);

/** True if a job may have files. */
int srv_store_filed(const struct srv_store *store, const struct srv_job *job);

/** Returns true for a job that has not ended. */
int srv_job_open(const struct srv_job *job);

/**
 * Ends a locked job without success, within a call. Its request is deleted at once, its parts and
 * results later in steps; no attempt can write any more.
 *
 * state    SRV_JOB_FAILED or SRV_JOB_DISMISSED.
 * job      in: the job as read; out: its new state.
 * message  NULL: the caller deletes the row, so it is not written: a full disk may lack the space.
 */
enum srv_stored srv_store_job_end(struct srv_store *store, struct srv_job *job,
                                  enum srv_job_state state, const char *message);

/**
 * Ends a job with a damaged row, within a call: the job fails, and its data are deleted.
 *
 * job  in: id, client, operation and message; out: the stored job.
 */
enum srv_stored srv_store_condemn(struct srv_store *store, struct srv_job *job);

/** As srv_store_find, and locks the row; a job with a damaged row is ended first. */
enum srv_stored srv_store_lock(struct srv_store *store, const char *id, struct srv_job *job);

/**
 * Returns at most SQL_PARTS_MOST parts to the queue, within a call.
 *
 * worker  the holder of the parts; NULL: parts with expired leases, which counts against them.
 * before  without a worker: only leases that expired before this instant, us by the store's clock.
 * sweep   counts the parts and jobs that changed.
 * found   out: number of parts found.
 */
enum srv_stored srv_store_back(struct srv_store *store, const char *worker, int64_t before,
                               struct srv_store_sweep *sweep, int *found);

/** Stores the result of a leased part; within a call that has begun, as all functions here. */
enum srv_stored srv_blobs_put(struct srv_store *store, const struct srv_lease *lease,
                              const char *data, size_t bytes);

/** Reads a chunk as srv_store_chunk; *bytes stays 0 if it is damaged. */
enum srv_stored srv_blobs_get(struct srv_store *store, const char *job, long part, long chunk,
                              void *data, size_t *bytes);

/** Deletes results of a job. more: out, 1 = some remain; NULL: they are small, delete all. */
enum srv_stored srv_blobs_drop(struct srv_store *store, const char *job, int *more);

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
