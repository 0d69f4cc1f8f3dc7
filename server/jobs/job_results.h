/* The routes of a job's results, in the representation that the client accepts, and of its
 * request.
 * Leaves to others: the encoding (compute, api/call/results), the parts in the store.
 * Invariant: the same job, representation and engine: the same bytes, whenever and from
 * whichever process. */
#ifndef SRV_JOB_RESULTS_H
#define SRV_JOB_RESULTS_H

#include "server/work/exchange.h"

/** GET /v1/jobs/{id}/results. Who knows the id may ask. With ?partial=true 202 for a job that has
 * not ended: the rows of its first parts, up to the first that is not done. */
void srv_job_results(struct srv_exchange *exchange);

/** GET /v1/jobs/{id}/request: the request as it is kept. Who knows the id may
 * ask. 409 for a job that failed or was dismissed, which has none any more. */
void srv_job_request(struct srv_exchange *exchange);

#endif
