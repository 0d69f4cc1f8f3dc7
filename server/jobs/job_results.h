/* The routes of a job's results, in the representation that the client accepts, of its request, and
 * of what cites it: an entry for a bibliography, and a crate of both.
 * Leaves to others: the encoding (compute, api/call/results, api/call/cite, api/call/crate), the
 * parts in the store.
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

/** GET /v1/jobs/{id}/cite.bib: an entry for BibTeX. Who knows the id may ask. 409 for a job that
 * has not succeeded. */
void srv_job_cite(struct srv_exchange *exchange);

/** GET /v1/jobs/{id}/crate: the results with what says what they are, as an RO-Crate;
 * ?results=EXTENSION chooses their representation, JSON without it. Who knows the id may ask. 409
 * as for its results. */
void srv_job_crate(struct srv_exchange *exchange);

#endif
