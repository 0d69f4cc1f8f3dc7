/* What a service is made of, gotten and let go in the order that the parts need each other.
 * Leaves to others: threads and sockets (daemon).
 * Invariant: what was gotten is let go in reverse, after a failure in mid-way too. */
#ifndef SRV_SERVICE_SETUP_H
#define SRV_SERVICE_SETUP_H

#include "server/work/service.h"

/**
 * Gets everything that the config asks for but the log, and no threads. Ends with
 * srv_service_setup_clear, after a failure too.
 *
 * service  zeroed but for config.
 *
 * PEND_NO_MEMORY
 * PEND_INVALID    error says which option is wrong.
 */
PEND_MUST_CHECK enum pend_status srv_service_setup_init(struct srv_service *service,
                                                        struct pend_error *error);

/**
 * Opens the store and starts computing jobs, as the config says; service->log, the queue and its
 * workers are there.
 *
 * PEND_NO_MEMORY
 * PEND_INVALID    error says what is wrong with the store.
 */
PEND_MUST_CHECK enum pend_status srv_service_setup_jobs(struct srv_service *service,
                                                        struct pend_error *error);

/** Ends what srv_service_setup_jobs started; after srv_part_runner_drain, while nobody asks the
 * storage any more. */
void srv_service_setup_jobs_end(struct srv_service *service);

/** Frees what srv_service_setup_init got. */
void srv_service_setup_clear(struct srv_service *service);

#endif
