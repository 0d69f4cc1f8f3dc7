/* Creates the parts of a service in the order of their dependencies, and frees them.
 * Leaves to others: threads and sockets (daemon).
 * Invariant: parts are freed in the reverse order, also after a failure half-way. */
#pragma once

#include "server/work/service.h"

/**
 * Creates all parts of the service except the log and the threads. Free with
 * srv_service_setup_clear, after a failure too.
 *
 * service  zero except `config`.
 *
 * PEND_NO_MEMORY
 * PEND_INVALID    error says which option is wrong.
 */
PEND_MUST_CHECK enum pend_status srv_service_setup_init(struct srv_service *service,
                                                        struct pend_error *error);
void srv_service_setup_clear(struct srv_service *service);

/**
 * Opens the store and starts computing jobs, if configured; service->log, the queue and its workers
 * must exist.
 *
 * PEND_NO_MEMORY
 * PEND_INVALID    error says what is wrong with the store.
 */
PEND_MUST_CHECK enum pend_status srv_service_setup_jobs(struct srv_service *service,
                                                        struct pend_error *error);

/** Ends what srv_service_setup_jobs started; call it after srv_part_runner_drain, when no thread
 * queries the storage any more. */
void srv_service_setup_jobs_end(struct srv_service *service);
