#include "server/jobs/job_view.h"

const char *srv_job_word(enum srv_job_state state) {
    static const char *const word[SRV_JOB_STATES] = {"accepted", "running", "successful", "failed",
                                                     "dismissed"};
    /* a state from the store may be out of range: then the job counts as failed */
    return state >= 0 && state < SRV_JOB_STATES ? word[state] : "failed";
}

/* Seconds until the job is done, extrapolated from its completed parts; running parts count half.
 * -1 = unknown. */
static double job_remaining(const struct srv_job *job) {
    if (job->state != SRV_JOB_RUNNING || !job->done || !job->started) return -1;
    double done = 0.5 * (double)(job->done + job->begun - job->waiting);
    return 1e-6 * (double)(job->now - job->started) / done * ((double)job->parts - done);
}

struct api_job srv_job_view(const struct srv_job *job) {
    return (struct api_job){.id = job->id,
                            .operation = job->operation,
                            .status = srv_job_word(job->state),
                            .message = job->message,
                            .title = job->title,
                            .version = job->version,
                            .owner = srv_identity_word(job->client),
                            .parts = job->parts,
                            .done = job->done,
                            .created = job->created,
                            .started = job->started,
                            .finished = job->finished,
                            .expires = job->expires,
                            .bytes = job->bytes,
                            .remaining = job_remaining(job),
                            .request = job->state <= SRV_JOB_SUCCESSFUL,
                            .results = job->state == SRV_JOB_SUCCESSFUL};
}

int srv_job_over(const struct srv_job *job) { return job->state > SRV_JOB_RUNNING; }
