/* The route that lists a client's jobs.
 * Leaves to others: single jobs (jobs), finding them (store), their JSON (api/call/job_json).
 * Invariant: a list contains jobs of the requesting client only. */
#pragma once

#include "server/work/exchange.h"

/** GET /v1/jobs: the client's own jobs, newest first, in pages; the query filters them. 401 for a
 * client without token and account, because many people may share an address. */
void srv_job_list(struct srv_exchange *exchange);
