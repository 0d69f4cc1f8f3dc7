/* Jobs as JSON for their client: one job, or a page of them.
 * Leaves to others: storing jobs, and access to them (server).
 * Invariant: the same job gives the same bytes, except remaining_seconds. */
#pragma once

#include <stdint.h>

#include "api/base/buffer.h"

/* A job as its client sees it; texts are UTF-8. Times are microseconds since 1970, 0 = not yet. */
struct api_job {
    const char *id, *operation;
    const char *status;  /* as in OGC API - Processes: "running" */
    const char *message; /* how it ended; "" = no message */
    const char *title;   /* "" = no title */
    const char *version; /* version of the program that accepted it; "" = unknown */
    const char *owner;   /* kind of client that may list and cancel it: "key", "token", "account" or
                          * "address" */
    long parts, done;
    int64_t created, started, finished, expires;
    double remaining; /* s, estimated remaining time; < 0 = unknown */
    long long bytes;  /* bytes of stored results */
    int results;      /* non-zero: results can be fetched */
    int request;      /* non-zero: the request can be fetched */
};

/** Appends a member with an instant, given in us since 1970, in UTC in the form of RFC 3339; null
 * for 0. Fails as api_buffer_room does. */
PEND_MUST_CHECK enum pend_status api_job_time(struct api_buffer *out, const char *name, int64_t us);

/**
 * Reads an instant in the form of RFC 3339, in UTC ("2026-01-31T09:30:00Z", with up to six digits
 * after a point) or with an offset ("+01:00").
 *
 * us  out: us since 1970.
 *
 * Returns 0 for any other text, and for years before 1970 and, in UTC, beyond 9999.
 */
int api_job_instant(const char *text, int64_t *us);

/** Appends a job as a JSON object; fails as api_buffer_room does. */
PEND_MUST_CHECK enum pend_status api_job_write(const struct api_job *job, struct api_buffer *out);

/**
 * Appends a page of jobs.
 *
 * next  path and query of the next page; NULL = there is none.
 */
PEND_MUST_CHECK enum pend_status api_jobs_write(const struct api_job job[], int count,
                                                const char *next, struct api_buffer *out);
