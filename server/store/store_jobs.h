/* Jobs as a whole: submitting, reading, listing and ending them.
 * Leaves to others: their parts (store_leases), their removal (store_sweep).
 * Invariant: a job ends once; a client's key makes one job, however many submissions come at
 * once. */
#ifndef SRV_STORE_JOBS_H
#define SRV_STORE_JOBS_H

#include "server/store/store_call.h"

/* a job that ends has no more parts than so many removed at once */
enum { SRV_FEW_PARTS = 16 };

/** Reads a job by a statement of its id, in a call that has begun; its `flaw` may be set.
 * SRV_STORED_NONE */
enum srv_stored srv_store_find(struct srv_store *store, enum srv_statement id, const char *name,
                               struct srv_job *job);

/** True for a job that has not ended. */
int srv_job_open(const struct srv_job *job);

/**
 * Ends a locked job without success, in a call that has begun. Its request is removed at once, its
 * parts and results later, piece by piece; no attempt can write any more.
 *
 * state  SRV_JOB_FAILED or SRV_JOB_DISMISSED.
 * job    in: as it was read; out: as it is.
 */
enum srv_stored srv_store_job_end(struct srv_store *store, struct srv_job *job,
                                  enum srv_job_state state, const char *message);

/**
 * Ends a job whose row is damaged, in a call that has begun: the job has failed, and its data are
 * removed.
 *
 * job  id, client, operation and the message are read; set to what the store now has.
 */
enum srv_stored srv_store_condemn(struct srv_store *store, struct srv_job *job);

/** As srv_store_find with a lock on the row; a job whose row is damaged is ended first. */
enum srv_stored srv_store_lock(struct srv_store *store, const char *id, struct srv_job *job);

#endif
