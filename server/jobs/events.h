/* Streams of server-sent events about the progress of jobs, and the one thread that asks the store
 * for changes.
 * Leaves to others: jobs themselves (store), connections (http), a job as JSON (job_view).
 * Invariant: an open stream holds the memory of one event, no worker and no thread; a slow reader
 * may miss events, but not the last one. */
#ifndef SRV_EVENTS_H
#define SRV_EVENTS_H

#include "server/work/exchange.h"

enum {
    SRV_EVENTS_BEAT_S = 10, /* a comment after so long without an event */
    SRV_EVENTS_RETRY_MS = 2000,
    SRV_EVENTS_SHARE =
        4, /* one client may have an open stream in so many, all of an address three */
    SRV_EVENT_ID = 48
};

struct srv_events;

/**
 * Makes it, without listeners and without its thread.
 *
 * service  outlives it.
 * most     streams that may be open.
 *
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status srv_events_new(struct srv_events **events,
                                                struct srv_service *service, int most);

/** Starts its thread, once service->storage is there. PEND_NO_MEMORY when that cannot be had. */
PEND_MUST_CHECK enum pend_status srv_events_start(struct srv_events *events);

/** Ends its thread; no stream may be open. */
void srv_events_end(struct srv_events *events);

/** Frees, after the end. NULL is accepted. */
void srv_events_free(struct srv_events **events);

/** True when the counts agree with each other and with the list of streams; for assertions, under
 * its lock. O(1). */
int srv_events_valid(const struct srv_events *events);

/** Says that the state of some job may have changed. Any thread; NULL is accepted. */
void srv_events_news(struct srv_events *events);

/** Writes the `id` of an event, which is different for each state of a job: "running-12". */
void srv_events_id(const struct srv_job *job, char id[SRV_EVENT_ID]);

/**
 * Answers an exchange with a stream of a job's events, beginning with its present state unless
 * `last` is the id of that state.
 *
 * PEND_LIMIT     too many streams are open; `own` is set if it is the client that has too many.
 * PEND_NO_MEMORY
 */
PEND_MUST_CHECK enum pend_status srv_events_open(struct srv_events *events,
                                                 struct srv_exchange *exchange,
                                                 const struct srv_job *job, const char *last,
                                                 int *own);

/** As srv_inflight_read, of an exchange whose `listens` is set. */
long srv_events_read(struct srv_exchange *exchange, char *to, size_t cap,
                     void (*pause)(struct srv_exchange *));

/** Ends a stream because its reader is gone or the server is stopping. Any thread. */
void srv_events_leave(struct srv_exchange *exchange, enum srv_stop why);

/** Ends every stream after its last event; the clients connect again, to another process if this
 * one does not listen. Any thread; NULL is accepted. */
void srv_events_drain(struct srv_events *events);

#endif
