/* Jobs as a whole: submitting, reading, listing and ending them.
 * Leaves to others: their parts (store_leases), their deletion (store_sweep).
 * Invariant: a job ends once; a client's key creates one job, even with concurrent submissions. */
#pragma once

#include "server/store/store_call.h"

/* most parts that are deleted immediately when a job ends */
enum { SRV_FEW_PARTS = 16 };

/** Reads a job by its id with a statement, within a call; its `flaw` may be set. SRV_STORED_NONE */
enum srv_stored srv_store_find(struct srv_store *store, enum srv_statement id, const char *name,
                               struct srv_job *job);

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
