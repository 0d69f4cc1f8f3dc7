/* A stored job as its client sees it; streams of events about its progress, and answers that wait
 * for its end.
 * Leaves to others: jobs themselves (store), the streams (events), the JSON (api/call/job_json).
 * Invariant: each state of a job has its own event id, and is sent once per stream. */
#pragma once

#include "api/call/job_json.h"
#include "server/jobs/events.h"

/** The name of a state in OGC API - Processes, such as "running". */
const char *srv_job_word(enum srv_job_state state);

/** The values of a job's JSON; the texts point into `job`. */
struct api_job srv_job_view(const struct srv_job *job);

/** True for a job in a final state. */
int srv_job_over(const struct srv_job *job);

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
