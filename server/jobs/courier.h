/* The courier: hands what is due of webhooks to the process that sends them, and tells the store
 * how that went.
 * Leaves to others: what is due (store_hooks), sending (hooks/hook_loop), the message's form
 * (api/call/webhook).
 * Invariant: what it hands out it holds under a lease of the store, so that a message is tried by
 * one server at a time, and by another if this one dies. */
#ifndef SRV_COURIER_H
#define SRV_COURIER_H

#include "server/work/service.h"

struct srv_courier;

/**
 * Starts the process that sends, before this one has threads or secrets.
 *
 * lack  out: walls that are not up around it; "" = all are.
 *
 * PEND_INVALID    error says why there is none.
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status srv_courier_new(struct srv_courier **courier,
                                                 const struct srv_config *config,
                                                 char lack[SRV_CONFIG_TEXT],
                                                 struct pend_error *error);

/** Starts the courier's thread, once the service has its storage and its keys. */
PEND_MUST_CHECK enum pend_status srv_courier_start(struct srv_courier *courier,
                                                   struct srv_service *service);

/** Something may be due. Any thread; does not wait. NULL is accepted. */
void srv_courier_news(struct srv_courier *courier);

/** True once the process that sends has ended by itself. */
int srv_courier_lost(const struct srv_courier *courier);

/** Ends that process and the thread; what was under way is due again at once. Before the storage
 * ends. */
void srv_courier_end(struct srv_courier *courier);

/** Frees a courier that has ended. */
void srv_courier_free(struct srv_courier **courier);

#endif
