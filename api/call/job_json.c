#include "api/call/job_json.h"

#include <assert.h>
#include <stdio.h>

#include "api/json/json_out.h"

enum { JOB_TIME = 96, JOB_PATH = 96 };

/* days since 1970 as year, month and day: the years begin in March, 400 of them have 146097 days */
static void job_date(int64_t days, int64_t *year, int *month, int *day) {
    int64_t since = days + 719468, era = (since >= 0 ? since : since - 146096) / 146097;
    int64_t of_era = since - era * 146097;
    int64_t years = (of_era - of_era / 1460 + of_era / 36524 - of_era / 146096) / 365;
    int64_t of_year = of_era - (365 * years + years / 4 - years / 100),
            march = (5 * of_year + 2) / 153;
    *day = (int)(of_year - (153 * march + 2) / 5 + 1);
    *month = (int)(march < 10 ? march + 3 : march - 9);
    *year = years + era * 400 + (*month <= 2);
}

enum pend_status api_job_time(struct api_buffer *out, const char *name, int64_t us) {
    char text[JOB_TIME];
    int64_t seconds = us / 1000000, year;
    int month, day, second = (int)(seconds % 86400);
    if (us <= 0) return api_out_text(out, name, NULL);
    job_date(seconds / 86400, &year, &month, &day);
    snprintf(text, sizeof text, "%04d-%02d-%02dT%02d:%02d:%02d.%03dZ", (int)year, month, day,
             second / 3600, second / 60 % 60, second % 60, (int)(us / 1000 % 1000));
    return api_out_text(out, name, text);
}

static enum pend_status job_link(struct api_buffer *out, const char *relation, const char *path) {
    PEND_TRY(api_out_comma(out));
    PEND_TRY(api_buffer_text(out, "{"));
    PEND_TRY(api_out_text(out, "href", path));
    PEND_TRY(api_out_text(out, "rel", relation));
    return api_buffer_text(out, "}");
}

/* whole percents, rounded down: only a job that is done has 100 */
static long job_progress(const struct api_job *job) {
    if (job->results) return 100;
    long progress = (long)(100 * ((double)job->done / (double)(job->parts > 0 ? job->parts : 1)));
    return progress < 99 ? progress : 99;
}

enum pend_status api_job_write(const struct api_job *job, struct api_buffer *out) {
    assert(job->id && job->status && job->owner && job->done >= 0);
    char path[JOB_PATH];
    PEND_TRY(api_out_comma(out));
    PEND_TRY(api_buffer_text(out, "{"));
    PEND_TRY(api_out_text(out, "id", job->id));
    PEND_TRY(api_out_text(out, "type", "process"));
    PEND_TRY(api_out_text(out, "operation", job->operation));
    PEND_TRY(api_out_text(out, "status", job->status));
    PEND_TRY(api_out_text(out, "owner", job->owner));
    PEND_TRY(api_out_whole(out, "progress", job_progress(job)));
    PEND_TRY(api_job_time(out, "created", job->created));
    PEND_TRY(api_job_time(out, "started", job->started));
    PEND_TRY(api_job_time(out, "finished", job->finished));
    PEND_TRY(api_job_time(out, "expires", job->expires));
    if (job->remaining >= 0) PEND_TRY(api_out_number(out, "remaining_seconds", job->remaining, 3));
    PEND_TRY(api_out_text(out, "message", job->message));
    PEND_TRY(api_out_open(out, "links", '['));
    snprintf(path, sizeof path, "/v1/jobs/%.40s", job->id);
    PEND_TRY(job_link(out, "self", path));
    snprintf(path, sizeof path, "/v1/jobs/%.40s/events", job->id);
    PEND_TRY(job_link(out, "events", path));
    snprintf(path, sizeof path, "/v1/jobs/%.40s/results", job->id);
    if (job->results) PEND_TRY(job_link(out, "results", path));
    return api_buffer_text(out, "]}");
}

enum pend_status api_jobs_write(const struct api_job job[], int count, const char *next,
                                struct api_buffer *out) {
    assert(count >= 0 && (job || !count));
    PEND_TRY(api_buffer_text(out, "{"));
    PEND_TRY(api_out_open(out, "jobs", '['));
    for (int i = 0; i < count; i++) PEND_TRY(api_job_write(&job[i], out));
    PEND_TRY(api_buffer_text(out, "]"));
    PEND_TRY(api_out_open(out, "links", '['));
    if (next) PEND_TRY(job_link(out, "next", next));
    return api_buffer_text(out, "]}");
}
