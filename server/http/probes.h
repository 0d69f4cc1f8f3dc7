/* The routes for supervisors and load balancers: /healthz, /version and /readyz.
 * Leaves to others: metrics (metrics).
 * Invariant: they answer at once, from memory; an unreachable store affects only functions that
 * need it. */
#pragma once

#include "server/work/exchange.h"

/** GET /healthz: 200 while the process runs, also while it drains. */
void srv_probes_health(struct srv_exchange *exchange);

/** GET /version: the program's version and its engine's digest, as JSON. */
void srv_probes_version(struct srv_exchange *exchange);

/**
 * GET /readyz: 200 while the process accepts requests of its role; the body lists functions that
 * are not available now.
 *
 * ?need=jobs also requires that jobs are accepted and computed; a process of the role worker always
 * checks that. 503 with Retry-After if not, 422 for another query.
 */
void srv_probes_readiness(struct srv_exchange *exchange);
