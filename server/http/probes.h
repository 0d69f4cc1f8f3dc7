/* What supervisors and load balancers ask: /healthz and /readyz.
 * Leaves to others: what is counted (metrics).
 * Invariant: answers from memory, at once; a store that is away takes nothing away that needs no
 * store. */
#ifndef SRV_PROBES_H
#define SRV_PROBES_H

#include "server/work/exchange.h"

/** GET /healthz: 200 as long as the process runs, also while it drains. */
void srv_probes_health(struct srv_exchange *exchange);

/** GET /version: the program's version and its engine's digest, as JSON. */
void srv_probes_version(struct srv_exchange *exchange);

/**
 * GET /readyz: 200 while the process takes what is for its role; the body says what it cannot do
 * just now.
 *
 * ?need=jobs asks whether jobs are taken and computed as well. A process of the role worker is
 * there for nothing else, and is always asked that. 503 with Retry-After where the answer is no,
 * 422 for another query.
 */
void srv_probes_readiness(struct srv_exchange *exchange);

#endif
