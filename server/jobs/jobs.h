/* The routes of jobs: creating, reading and dismissing them, and their events.
 * Leaves to others: keeping jobs (store), computing them (part_runner), their JSON
 * (api/call/job_json), results and requests (job_results), lists (job_list).
 * Invariant: the finish of every exchange is called exactly once; a job is in the store before the
 * client is told of it. */
#ifndef SRV_JOBS_H
#define SRV_JOBS_H

#include "server/work/exchange.h"

/** True if the client prefers a job (Prefer: respond-async), the route answers a table, and this
 * server keeps jobs. */
int srv_jobs_wanted(const struct srv_exchange *exchange);

/** Makes a job of a request: 202, with the job as JSON and where it is. With Prefer: wait=N the
 * answer waits up to N seconds (60 at most) for the job's end: 303 to its results if it succeeds in
 * this time. */
void srv_jobs_submit(struct srv_exchange *exchange);

/** Reads what a client calls a job, or a piece of that: UTF-8 without control characters, any byte
 * of which may be percent-encoded. Returns 0 for any other text, and for an empty or too long one.
 */
int srv_jobs_title(const char *text, size_t bytes, char title[SRV_TITLE_BYTES]);

/** GET /v1/jobs/{id}. Whoever knows the id may ask. With ?wait=N, 0 to 60, the answer waits up to N
 * seconds for the job's end. */
void srv_jobs_read(struct srv_exchange *exchange);

/** GET /v1/jobs/{id}/events: its progress as server-sent events, until it has ended. Who knows
 * the id may ask. */
void srv_jobs_events(struct srv_exchange *exchange);

/**
 * DELETE /v1/jobs/{id}: allowed for the token or account that posted the job; if it was posted
 * without either, for clients of the same address.
 *
 * Other clients get 403, not 404: whoever knows the id may read the job, so its existence is no
 * secret, and a client that sent the wrong token should be told. A request without a token for a
 * job that was posted with one gets 401.
 */
void srv_jobs_dismiss(struct srv_exchange *exchange);

#endif
