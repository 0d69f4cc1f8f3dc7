/* Streams of events about the progress of jobs, and answers that wait for a job's end.
 * Leaves to others: jobs themselves (store), the streams (events), a job as JSON (job_view).
 * Invariant: each state of a job has its own event id, and is sent once per stream. */
#pragma once

#include "server/jobs/events.h"

enum { SRV_EVENT_ID = 48 };

/** Creates the topic; `most` is the limit of open streams. Returns NULL if memory is short. */
struct srv_topic *srv_job_events_new(int most);

/** Writes the `id` of an event, which is different for each state of a job: "running-12". */
void srv_job_events_id(const struct srv_job *job, char id[SRV_EVENT_ID]);

/** Answers an exchange with a stream of a job's events, as srv_events_open does. It begins with the
 * current state unless `last` is the id of that state. */
void srv_job_events_open(struct srv_exchange *exchange, const struct srv_job *job,
                         const char *last);

enum { SRV_JOB_WAIT_S = 60 }; /* longest wait for a job, s */

/**
 * Suspends an exchange until a job has ended, at most for the given number of seconds, then answers
 * it.
 *
 * answer  writes the answer from the job's state at that time; the job is NULL if it no longer
 * exists.
 *
 * Returns as srv_events_await.
 */
PEND_MUST_CHECK int
srv_job_events_await(struct srv_exchange *exchange, const struct srv_job *job, int seconds,
                     void (*answer)(struct srv_exchange *exchange, const struct srv_job *job));
