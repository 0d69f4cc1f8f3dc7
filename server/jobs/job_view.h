/* A stored job as its client sees it.
 * Leaves to others: the JSON (api/call/job_json), who may read it (jobs).
 * Invariant: every value comes from the store's row. */
#pragma once

#include "api/call/job_json.h"
#include "server/protocol/identity.h"
#include "server/store/store.h"

/** The name of a state in OGC API - Processes, such as "running". */
const char *srv_job_word(enum srv_job_state state);

/** The values of a job's JSON; the texts point into `job`. */
struct api_job srv_job_view(const struct srv_job *job);

/** True for a job in a final state. */
int srv_job_over(const struct srv_job *job);
