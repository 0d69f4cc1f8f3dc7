/* The routes of jobs, of their results and of scenes, and the erasure of a client's data.
 * Leaves to others: storing (store), computing (part_runner, compute), JSON (api/call/job_json),
 * the contents of a scene (api/link/scene), classrooms (classes), authorization (admission).
 * Invariant: the finish of every exchange is called exactly once; a job is stored before it is
 * acknowledged; a result has the same bytes at any time and from any process. */
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

/** GET /v1/jobs: the client's own jobs, newest first, in pages; the query filters them. 401 for a
 * client without token and account, because many people may share an address. */
void srv_job_list(struct srv_exchange *exchange);

/** GET /v1/jobs/{id}/results. Anyone with the id can read them. With ?partial=true a job that has
 * not ended answers 202 with the rows of its first parts, up to the first incomplete one. */
void srv_job_results(struct srv_exchange *exchange);

/** GET /v1/jobs/{id}/request: the stored request. Anyone with the id can read it. 409 for a failed
 * or dismissed job, whose request is deleted. */
void srv_job_request(struct srv_exchange *exchange);

/** DELETE /v1/clients/{name}: "me" for the client itself (identified by key, token or account);
 * key:NAME, account:NAME or address:ADDRESS for an operator. 204; 401 or 403 for others; 404 for
 * any other name. */
void srv_erasure(struct srv_exchange *exchange);

/** POST /v1/scenes: 201 with the scene and its Location; an existing scene keeps its id. */
void srv_scenes_create(struct srv_exchange *exchange);

/**
 * DELETE /v1/scenes/{id}: removes the client's share; the scene is deleted with the last share.
 *
 * Allowed for a token or account that stored the scene; 403 for others, because the existence of a
 * shared link is no secret. A scene stored without a token cannot be deleted, because many people
 * may share an address.
 */
void srv_scenes_drop(struct srv_exchange *exchange);

/** GET /v1/scenes/{id}. Anyone with the id can read it. */
void srv_scenes_read(struct srv_exchange *exchange);
