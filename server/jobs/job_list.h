/* The route that lists a client's jobs.
 * Leaves to others: one job (jobs), finding them (store), their JSON (api/call/job_json).
 * Invariant: a list holds jobs of the client that asks and of nobody else. */
#ifndef SRV_JOB_LIST_H
#define SRV_JOB_LIST_H

#include "server/work/exchange.h"

/** GET /v1/jobs: the client's own, newest first, a page at a time; the query says which of them.
 * 401 for a client without token and account, since many people may share an address. */
void srv_job_list(struct srv_exchange *exchange);

#endif
