/* The routes of jobs: how a request becomes one, and what its client can ask of it.
 * Leaves to others: keeping jobs (store), computing them (part_runner), their JSON
 * (api/call/job_json), results (job_results).
 * Invariant: every exchange that comes in goes out through its finish, once; a job that was told
 * of is kept. */
#ifndef SRV_JOBS_H
#define SRV_JOBS_H

#include "server/work/exchange.h"

/** True where the client prefers a job and this server keeps jobs: Prefer: respond-async on a
 * route that answers a table. */
int srv_jobs_wanted(const struct srv_exchange *exchange);

/** Makes a job of a request: 202, with the job as JSON and where it is. */
void srv_jobs_submit(struct srv_exchange *exchange);

/** GET /v1/jobs: the client's own, newest first; 401 for who has neither token nor account: what
 * comes from an address may be many people's. */
void srv_jobs_list(struct srv_exchange *exchange);

/** GET /v1/jobs/{id}. Who knows the id may ask. */
void srv_jobs_read(struct srv_exchange *exchange);

/** GET /v1/jobs/{id}/events: its progress as server-sent events, until it has ended. Who knows
 * the id may ask. */
void srv_jobs_events(struct srv_exchange *exchange);

/**
 * DELETE /v1/jobs/{id}: for the token or account that posted it; where none did, for who comes from
 * the same address and knows the id.
 *
 * Anybody else gets 403, not 404: to know the id is to be allowed to read the job, so there is
 * nothing to hide, and who has forgotten a token should hear of it. Without a token, one that was
 * posted with one answers 401.
 */
void srv_jobs_dismiss(struct srv_exchange *exchange);

#endif
