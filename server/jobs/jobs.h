/* The routes of jobs: creating, reading and dismissing them, and their events.
 * Leaves to others: storing jobs (store), computing them (part_runner), their JSON
 * (api/call/job_json), results and requests (job_results), lists (job_list).
 * Invariant: the finish of every exchange is called exactly once; a job is stored before it is
 * acknowledged. */
#pragma once

#include "server/work/exchange.h"

/** True if the client prefers a job (Prefer: respond-async), the route answers a table, and this
 * server keeps jobs. */
int srv_jobs_wanted(const struct srv_exchange *exchange);

/** Creates a job from a request: 202, with the job as JSON and its Location. With Prefer: wait=N
 * the answer waits up to N seconds (at most 60) for the job's end: 303 to its results if it
 * succeeds in time. */
void srv_jobs_submit(struct srv_exchange *exchange);

/** Decodes a job's title or a part of it: UTF-8 without control characters, percent-encoding
 * allowed. Returns 0 if the text is invalid, empty or too long. */
int srv_jobs_title(const char *text, size_t bytes, char title[SRV_TITLE_BYTES]);

/** GET /v1/jobs/{id}. Anyone with the id can read it. With ?wait=N, 0 to 60, the answer waits up to
 * N seconds for the job's end. */
void srv_jobs_read(struct srv_exchange *exchange);

/** GET /v1/jobs/{id}/events: its progress as server-sent events, until it ends. Anyone with the id
 * can read them. */
void srv_jobs_events(struct srv_exchange *exchange);

/**
 * DELETE /v1/jobs/{id}: allowed for the token or account that posted the job; if it was posted
 * without either, for clients of the same address.
 *
 * Other clients get 403, not 404: anyone with the id can read the job, so its existence is no
 * secret, and a client with the wrong token should learn why. A request without a token gets 401 if
 * the job was posted with one.
 */
void srv_jobs_dismiss(struct srv_exchange *exchange);
