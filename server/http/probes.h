/* The routes for supervisors and load balancers: /healthz, /version and /readyz.
 * Leaves to others: what is counted (metrics).
 * Invariant: they answer at once, from memory; a store that is out of reach changes only what needs
 * the store. */
#ifndef SRV_PROBES_H
#define SRV_PROBES_H

#include "server/work/exchange.h"

/** GET /healthz: 200 as long as the process runs, also while it drains. */
void srv_probes_health(struct srv_exchange *exchange);

/** GET /version: the program's version and its engine's digest, as JSON. */
void srv_probes_version(struct srv_exchange *exchange);

/**
 * GET /readyz: 200 while the process takes requests of its role; the body says what it cannot do
 * now.
 *
 * ?need=jobs asks whether jobs are taken and computed as well; a process of the role worker always
 * answers that question. 503 with Retry-After where the answer is no,
 * 422 for another query.
 */
void srv_probes_readiness(struct srv_exchange *exchange);

#endif
