/* The routes of a job's results, in the negotiated representation, and of its request.
 * Leaves to others: the encoding (compute, api/call/results), the parts in the store.
 * Invariant: the same job, representation and engine give the same bytes, at any time and from any
 * process. */
#pragma once

#include "server/work/exchange.h"

/** GET /v1/jobs/{id}/results. Anyone with the id can read them. With ?partial=true a job that has
 * not ended answers 202 with the rows of its first parts, up to the first incomplete one. */
void srv_job_results(struct srv_exchange *exchange);

/** GET /v1/jobs/{id}/request: the stored request. Anyone with the id can read it. 409 for a failed
 * or dismissed job, whose request is deleted. */
void srv_job_request(struct srv_exchange *exchange);
