/* Streams of events about the progress of jobs, and answers that wait for a job's end.
 * Leaves to others: jobs themselves (store), the streams (events), a job as JSON (job_view).
 * Invariant: each state of a job has an id of its own, and is told once. */
#ifndef SRV_JOB_EVENTS_H
#define SRV_JOB_EVENTS_H

#include "server/jobs/events.h"

enum { SRV_EVENT_ID = 48 };

/** Makes the topic; `most` streams may be open. NULL without memory. */
struct srv_topic *srv_job_events_new(int most);

/** Writes the `id` of an event, which is different for each state of a job: "running-12". */
void srv_job_events_id(const struct srv_job *job, char id[SRV_EVENT_ID]);

/** Answers an exchange with a stream of a job's events, as srv_events_open does, beginning with its
 * present state unless `last` is the id of that state. */
void srv_job_events_open(struct srv_exchange *exchange, const struct srv_job *job,
                         const char *last);

enum { SRV_JOB_WAIT_S = 60 }; /* that a client may wait for a job at a time */

/**
 * Lets an exchange wait until a job has ended, at most for so many seconds, and answers it then.
 *
 * answer  writes the answer from the job as it is then; NULL for a job that is not stored any more.
 *
 * Returns as srv_events_await.
 */
PEND_MUST_CHECK int
srv_job_events_await(struct srv_exchange *exchange, const struct srv_job *job, int seconds,
                     void (*answer)(struct srv_exchange *exchange, const struct srv_job *job));

#endif
