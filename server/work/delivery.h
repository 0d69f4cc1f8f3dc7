/* Delivers the output of a computation to the waiting exchanges: complete, or as a stream while the
 * rest is computed.
 * Leaves to others: computing (compute), sending (http), the header fields of an answer (result).
 * Invariant: until a stream begins, the answer can still become a problem. */
#pragma once

#include "server/work/inflight.h"

enum {
    SRV_DELIVERY_HOLD = 1 << 20
}; /* bytes of a streamable answer that are held, so that it can be shared and cached */

/* All functions are called by the worker that has the computation. */

/** Returns the seconds that workers have spent on a computation. */
double srv_delivery_seconds(const struct srv_work *work);

/** Returns the bytes that a computation holds, including those reserved for its next piece. */
size_t srv_delivery_bytes(const struct srv_work *work);

/** Counts the end of a computation, for metrics and for a process that drains. */
void srv_delivery_done(struct srv_service *service);

/**
 * Answers all exchanges that wait for a computation, and frees it.
 *
 * response_body  NULL: the answer is a status without a body.
 * cache          for the log: the reason why it was not computed, or NULL.
 * status         304 if the clients have the answer already; else 503 with `detail`.
 */
void srv_delivery_release(struct srv_work *work, struct srv_response_body *response_body,
                          const char *cache, int status, const char *detail);

/** Answers all exchanges that wait for a computation with 503, and frees it. */
void srv_delivery_fail(struct srv_work *work, const char *detail);

/** Answers all waiting exchanges with the complete answer in work->out, which is cached if
 * permitted, and frees the computation. */
void srv_delivery_settle(struct srv_work *work);

/** Returns true if the head of the answer should be sent now, and the rest as a stream. */
int srv_delivery_ripe(struct srv_work *work);

/**
 * Starts a stream: the exchange that has waited longest becomes its reader, and work->promised is
 * set. If memory is short, nothing changes, and the next piece may try again.
 *
 * others  out: the other waiting exchanges, as from srv_inflight_take: each needs its own
 *         computation.
 */
void srv_delivery_promise(struct srv_work *work, struct srv_list *others);

/**
 * Passes the bytes in work->out to the reader of a stream.
 *
 * ended  0 = more will come, 1 = that was all, -1 = the rest is missing.
 *
 * Returns 1 if the worker should continue. Otherwise the worker no longer owns the computation.
 */
int srv_delivery_pass(struct srv_work *work, int ended);
