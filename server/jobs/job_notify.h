/* The header field Job-Notify: the url that hears of a new job's end.
 * Leaves to others: keeping it (jobs), sending (courier).
 * Invariant: a url that could not be told of, or must not be, is refused when the job is posted,
 * not when it ends. */
#ifndef SRV_JOB_NOTIFY_H
#define SRV_JOB_NOTIFY_H

#include "server/work/exchange.h"

/**
 * Reads the field of a request for a job.
 *
 * url  out; "" where the request has no such field.
 *
 * Returns 1, or 0 where the exchange was answered with what is wrong: 400 for what is no url, 401
 * where nobody says who asks, 422 where this server sends no webhooks, or none to that address.
 */
int srv_job_notify_read(struct srv_exchange *exchange, char url[SRV_HOOK_BYTES]);

/** Answers 400 where the field is in a request that makes no job; else returns 1. */
int srv_job_notify_suits(struct srv_exchange *exchange, int job);

#endif
