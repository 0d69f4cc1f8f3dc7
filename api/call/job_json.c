#include "api/call/job_json.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

#include "api/json/json_out.h"

enum { JOB_TIME = 96, JOB_PATH = 96 };

/* the end of the year 9999 in us since 1970; later years have five digits */
#define JOB_LAST INT64_C(253402300799999999)

/* days since 1970 as year, month and day; years begin in March, and 400 of them have 146097 days */
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

/* reads `count` digits; -1 if they are not digits */
static int job_digits(const char *text, int count) {
    int number = 0;
    for (int i = 0; i < count; i++) {
        if (text[i] < '0' || text[i] > '9') return -1;
        number = 10 * number + text[i] - '0';
    }
    return number;
}

/* days since 1970 of a date; -1 if the date does not exist */
static int64_t job_days(int64_t year, int month, int day) {
    int64_t before = year - (month <= 2), era = before / 400, of_era = before - era * 400, back;
    int64_t of_year = (153 * (month + (month > 2 ? -3 : 9)) + 2) / 5 + day - 1;
    int64_t days = era * 146097 + of_era * 365 + of_era / 4 - of_era / 100 + of_year - 719468;
    int back_month, back_day;
    job_date(days, &back, &back_month, &back_day);
    return back == year && back_month == month && back_day == day ? days : -1;
}

/* offset of a time zone from UTC, s: "Z", "+01:00"; 86400 if malformed */
static int job_zone(const char *text) {
    if (!strcmp(text, "Z") || !strcmp(text, "z")) return 0;
    if ((*text != '+' && *text != '-') || strlen(text) != 6 || text[3] != ':') return 86400;
    int hours = job_digits(text + 1, 2), minutes = job_digits(text + 4, 2);
    if (hours < 0 || hours > 23 || minutes < 0 || minutes > 59) return 86400;
    return (*text == '-' ? -60 : 60) * (60 * hours + minutes);
}

/* reads a point and up to six digits as us; -1 if there are no digits. *text moves past them */
static int job_fraction(const char **text) {
    int us = 0, digits = 0;
    if (**text != '.') return 0;
    for (++*text; digits < 6 && job_digits(*text, 1) >= 0; digits++, ++*text)
        us = 10 * us + **text - '0';
    if (!digits) return -1;
    for (; digits < 6; digits++) us *= 10;
    return us;
}

int api_job_instant(const char *text, int64_t *us) {
    static const char form[] = "0000-00-00T00:00:00";
    if (strlen(text) < sizeof form) return 0;
    for (size_t i = 0; i + 1 < sizeof form; i++)
        if (form[i] == '0' ? job_digits(text + i, 1) < 0 : text[i] != form[i]) return 0;
    int64_t days = job_days(job_digits(text, 4), job_digits(text + 5, 2), job_digits(text + 8, 2));
    int hour = job_digits(text + 11, 2), minute = job_digits(text + 14, 2),
        second = job_digits(text + 17, 2);
    text += sizeof form - 1;
    int fraction = job_fraction(&text), zone = job_zone(text);
    if (days < 0 || hour > 23 || minute > 59 || second > 60 || fraction < 0 || zone == 86400)
        return 0;
    *us = ((days * 24 + hour) * 60 + minute) * 60000000 + (int64_t)(second - zone) * 1000000 +
          fraction;
    return *us > 0 && *us <= JOB_LAST;
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

/* percentage, rounded down: only a completed job has 100 */
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
    PEND_TRY(api_out_text(out, "title", job->title[0] ? job->title : NULL));
    PEND_TRY(api_out_text(out, "version", job->version[0] ? job->version : NULL));
    PEND_TRY(api_out_text(out, "status", job->status));
    PEND_TRY(api_out_text(out, "owner", job->owner));
    PEND_TRY(api_out_whole(out, "progress", job_progress(job)));
    PEND_TRY(api_out_open(out, "parts", '{'));
    PEND_TRY(api_out_whole(out, "done", job->done));
    PEND_TRY(api_out_whole(out, "all", job->parts));
    PEND_TRY(api_buffer_text(out, "}"));
    PEND_TRY(api_out_whole(out, "bytes", (long)job->bytes));
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
    snprintf(path, sizeof path, "/v1/jobs/%.40s/request", job->id);
    if (job->request) PEND_TRY(job_link(out, "request", path));
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
