#include "server/jobs/jobs.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/random.h>

#include "api/call/part.h"
#include "server/work/admission.h"
#include "server/jobs/store_request.h"
#include "server/jobs/events.h"
#include "server/work/hold.h"
#include "server/jobs/job_view.h"
#include "server/jobs/part_runner.h"

enum { JOBS_PAGE = 100, JOBS_DEFAULT = 20, JOBS_COST = 3, JOBS_SPARE = 64 };

static const char jobs_json[] = "application/json";

/* --- answers --- */

static void jobs_written(struct srv_exchange *exchange, int status, enum pend_status written) {
    if (written != PEND_OK) {
        srv_exchange_busy(exchange, 1, "out of memory");
        return;
    }
    srv_exchange_answered(exchange, status, jobs_json);
    srv_exchange_header(exchange, "Cache-Control", "no-store");
}

static void jobs_answer_job(struct srv_exchange *exchange, int status, const struct srv_job *job) {
    struct api_job view = srv_job_view(job);
    jobs_written(exchange, status, api_job_write(&view, &exchange->answer));
}

/* --- Prefer, Idempotency-Key and the query --- */

/* is a preference (RFC 7240) in the list of them? Its value and parameters are not looked at */
static int jobs_prefers(const char *list, const char *name) {
    size_t bytes = strlen(name);
    for (const char *at = list; at && *at; at = strchr(at, ',') ? strchr(at, ',') + 1 : NULL) {
        at += strspn(at, " \t");
        if (!strncasecmp(at, name, bytes) && (!at[bytes] || strchr(" \t,;=", at[bytes]))) return 1;
    }
    return 0;
}

int srv_jobs_wanted(const struct srv_exchange *exchange) {
    /* what answers a table computes; anything else is there at once */
    const struct api_op *op = api_op_at(exchange->op);
    if (exchange->method && !strcmp(exchange->method, "QUERY")) return 0; /* it is to change nothing */
    return op && op->table && exchange->service->storage && jobs_prefers(exchange->field[SRV_PREFER], "respond-async");
}

/* visible ASCII, with or without the quotes of a structured field */
static int jobs_read_key(const char *text, char key[SRV_ERRAND_KEY + 1]) {
    size_t bytes = text ? strlen(text) : 0;
    key[0] = 0;
    if (!text) return 1;
    if (bytes >= 2 && text[0] == '"' && text[bytes - 1] == '"') {
        text++;
        bytes -= 2;
    }
    if (!bytes || bytes > SRV_ERRAND_KEY) return 0;
    for (size_t i = 0; i < bytes; i++)
        if (text[i] <= ' ' || text[i] > '~' || text[i] == '"') return 0;
    memcpy(key, text, bytes);
    key[bytes] = 0;
    return 1;
}

/* before=ID and limit=N; 0 for anything else */
static int jobs_read_query(const char *query, struct srv_errand *errand) {
    errand->most = JOBS_DEFAULT;
    for (const char *at = query; at && *at; at = strchr(at, '&') ? strchr(at, '&') + 1 : NULL) {
        size_t bytes = strcspn(at, "&");
        if (!strncmp(at, "before=", 7) && bytes == 7 + SRV_ID_BYTES - 1) {
            memcpy(errand->id, at + 7, SRV_ID_BYTES - 1);
            errand->before = errand->id;
            if (!srv_errand_id_good(errand->id)) return 0;
        } else if (!strncmp(at, "limit=", 6) && bytes > 6 && bytes < 10 && strspn(at + 6, "0123456789") == bytes - 6) {
            errand->most = atoi(at + 6);
            if (errand->most < 1 || errand->most > JOBS_PAGE) return 0;
        } else {
            return 0;
        }
    }
    return 1;
}

/* --- submitting --- */

/* 130 bits that nobody can guess: who knows them may see the job */
static int jobs_make_id(char id[SRV_ID_BYTES]) {
    unsigned char bits[SRV_ID_BYTES - 1];
    if (getrandom(bits, sizeof bits, 0) != (ssize_t)sizeof bits) return 0;
    for (size_t i = 0; i < sizeof bits; i++) id[i] = srv_errand_letters[bits[i] & 31];
    id[sizeof bits] = 0;
    return 1;
}

static enum srv_stored jobs_put(struct srv_store *store, struct srv_store_call *call) {
    struct srv_errand *errand = (struct srv_errand *)call;
    const struct srv_exchange *exchange = errand->exchange;
    struct srv_job_order order = {.id = errand->id,
                                  .client = exchange->identity.key,
                                  .source = exchange->identity.source,
                                  .operation = api_op_at(exchange->op)->name,
                                  .key = errand->key[0] ? errand->key : NULL,
                                  .request = errand->body.data,
                                  .request_bytes = errand->body.bytes,
                                  .digest = errand->digest,
                                  .shards = errand->shards,
                                  .chained = errand->chained,
                                  .cost_us = errand->cost_us};
    return srv_store_submit(store, &order, &errand->job);
}

static void jobs_submitted(struct srv_errand *errand, enum srv_stored stored) {
    struct srv_exchange *exchange = errand->exchange;
    char *location = srv_exchange_text(exchange, 64);
    if (stored != SRV_STORED) {
        srv_errand_refuse(errand, stored);
    } else {
        jobs_answer_job(exchange, 202, &errand->job);
        srv_exchange_header(exchange, "Preference-Applied", "respond-async");
        if (location) {
            snprintf(location, 64, "/v1/jobs/%s", errand->job.id);
            srv_exchange_header(exchange, "Location", location);
        }
        srv_runner_news(exchange->service->runner);
    }
    srv_errand_end(errand);
}

/* a digest's 64 digits as bytes */
static void jobs_digest(const char *text, unsigned char digest[SRV_DIGEST_BYTES]) {
    for (int i = 0; i < SRV_DIGEST_BYTES; i++) {
        unsigned byte = 0;
        sscanf(text + 2 * i, "%2x", &byte);
        digest[i] = (unsigned char)byte;
    }
}

/* Refuses what would be accepted and fail for its size at the first part, or at the largest. Returns 1 where it fits.
 */
static int jobs_fit(struct srv_exchange *exchange, const struct api_plan *plan, size_t body_bytes) {
    const struct srv_config *config = srv_service_config(exchange->service);
    double bytes = plan->bytes + 2 * (double)body_bytes, answer = config->limits.answer_bytes;
    if (srv_hold_never(config, bytes))
        srv_exchange_problem(exchange, 422,
                             "a part of this job would take about %.0f bytes of memory while it is computed, and "
                             "max-held-bytes leaves at most %.0f to one",
                             bytes, srv_hold_most(config));
    else if (plan->kept > answer)
        srv_exchange_problem(exchange, 422,
                             "a part of this job would have at least %.0f bytes of results, more than "
                             "max-answer-bytes allows: %.0f; ask for fewer instants, members or columns",
                             plan->kept, answer);
    else
        return 1;
    return 0;
}

/* reads the request as a whole; returns 1 when the job may be kept, else the exchange is answered */
static int jobs_plan(struct srv_errand *errand) {
    struct srv_exchange *exchange = errand->exchange;
    const struct srv_service *service = exchange->service;
    double limit = srv_service_job_limits(service)->compute_seconds;
    struct api_plan plan;
    struct api_request request = {.op = exchange->op,
                                  .query = exchange->query,
                                  .content_type = exchange->field[SRV_CONTENT_TYPE],
                                  .body = exchange->body.bytes ? exchange->body.data : NULL,
                                  .body_bytes = exchange->body.bytes};
    api_buffer_init(&errand->body, exchange->body.bytes + JOBS_SPARE);
    int http = api_plan_read(&plan, &request, srv_service_job_limits(service), service->config.job_part_seconds,
                             &errand->body, &exchange->answer);
    if (http) {
        srv_exchange_answered(exchange, http, "application/problem+json");
        return 0;
    }
    if (plan.cost > JOBS_COST * limit) {
        srv_exchange_problem(exchange, 422,
                             "this would compute for about %.0f s, longer than max-job-seconds allows: %.15g s",
                             plan.cost, limit);
        return 0;
    }
    if (!jobs_fit(exchange, &plan, errand->body.bytes)) return 0;
    errand->shards = plan.parts;
    errand->chained = plan.chained;
    errand->cost_us = (int64_t)(1e6 * plan.cost);
    jobs_digest(plan.digest, errand->digest);
    if (jobs_make_id(errand->id)) return 1;
    srv_exchange_busy(exchange, 1, "the system has no random numbers");
    return 0;
}

void srv_jobs_submit(struct srv_exchange *exchange) {
    struct srv_errand *errand = srv_errand_begin(exchange, &srv_errand_jobs);
    if (!errand) return;
    if (!jobs_read_key(exchange->field[SRV_IDEMPOTENCY_KEY], errand->key)) {
        srv_exchange_problem(exchange, 400, "Idempotency-Key must be 1 to %d visible ASCII characters", SRV_ERRAND_KEY);
        srv_errand_end(errand);
        return;
    }
    srv_errand_work(errand, jobs_plan, jobs_put, jobs_submitted);
}

/* --- one job --- */

/* a question: the end of a job that this client may end; SRV_STORED_CLASH where it is somebody else's */
static enum srv_stored jobs_drop(struct srv_store *store, struct srv_store_call *call) {
    struct srv_errand *errand = (struct srv_errand *)call;
    enum srv_stored stored = srv_errand_find(store, call);
    if (stored != SRV_STORED) return stored;
    if (!srv_identity_owns(&errand->exchange->identity, errand->job.client)) return SRV_STORED_CLASH;
    return srv_store_dismiss(store, errand->id, &errand->job);
}

static void jobs_found(struct srv_errand *errand, enum srv_stored stored) {
    if (stored == SRV_STORED)
        jobs_answer_job(errand->exchange, 200, &errand->job);
    else
        srv_errand_refuse(errand, stored);
    srv_errand_end(errand);
}

/* Who knows an id may read the job, so that it is there is no secret: who may not end it is told so. */
static void jobs_denied(struct srv_exchange *exchange, const struct srv_job *job) {
    const char *owner = srv_identity_word(job->client);
    if (exchange->identity.kind == SRV_IDENTITY_TOKEN || strcmp(owner, "token") != 0)
        srv_exchange_problem(exchange, 403,
                             "this job is not yours to end: it was posted %s, and only from there it can be ended",
                             !strcmp(owner, "token")     ? "with another token"
                             : !strcmp(owner, "account") ? "from another account"
                                                         : "without a token, from another address");
    else
        srv_admission_challenge(exchange, "this job was posted with a token, which is needed to end it");
}

static void jobs_dropped(struct srv_errand *errand, enum srv_stored stored) {
    if (stored == SRV_STORED_CLASH) {
        jobs_denied(errand->exchange, &errand->job);
        srv_errand_end(errand);
        return;
    }
    if (stored == SRV_STORED) {
        srv_runner_dismiss(errand->service->runner, errand->id);
        srv_events_news(errand->service->events);
    }
    jobs_found(errand, stored);
}

void srv_jobs_read(struct srv_exchange *exchange) {
    struct srv_errand *errand = srv_errand_begin_one(exchange);
    if (errand) srv_errand_ask(errand, SRV_ASK_READ, srv_errand_find, jobs_found);
}

void srv_jobs_dismiss(struct srv_exchange *exchange) {
    struct srv_errand *errand = srv_errand_begin_one(exchange);
    if (!errand) return;
    if (srv_admission_count(exchange))
        srv_errand_ask(errand, SRV_ASK_WRITE, jobs_drop, jobs_dropped);
    else
        srv_errand_end(errand);
}

/* --- events --- */

/* a client that has seen the end and comes again is told not to: 204 (HTML's EventSource) */
static int jobs_ended(struct srv_errand *errand) {
    char id[SRV_EVENT_ID];
    const char *last = errand->exchange->field[SRV_LAST_EVENT_ID];
    srv_events_id(&errand->job, id);
    if (!last || strcmp(last, id) != 0 || !srv_job_over(&errand->job)) return 0;
    srv_exchange_static(errand->exchange, 204, NULL, NULL, 0);
    return 1;
}

static void jobs_listen(struct srv_errand *errand) {
    struct srv_exchange *exchange = errand->exchange;
    int own, most = (int)errand->service->config.event_streams;
    enum pend_status status =
        srv_events_open(errand->service->events, exchange, &errand->job, exchange->field[SRV_LAST_EVENT_ID], &own);
    if (status == PEND_NO_MEMORY) {
        srv_exchange_busy(exchange, 1, "out of memory");
    } else if (status != PEND_OK && own) {
        srv_exchange_problem(exchange, 429,
                             "you have a quarter of max-event-streams, %d, open, or all of your address three", most);
        srv_exchange_retry(exchange, 5);
    } else if (status != PEND_OK) {
        srv_exchange_busy(exchange, 5, "too many streams of events are open: max-event-streams");
    } else {
        srv_exchange_static(exchange, 200, "text/event-stream", NULL, 0);
        srv_exchange_header(exchange, "Cache-Control", "no-store");
        /* nginx would hold the events back */
        srv_exchange_header(exchange, "X-Accel-Buffering", "no");
    }
}

static void jobs_found_events(struct srv_errand *errand, enum srv_stored stored) {
    if (stored != SRV_STORED)
        srv_errand_refuse(errand, stored);
    else if (!jobs_ended(errand))
        jobs_listen(errand);
    srv_errand_end(errand);
}

void srv_jobs_events(struct srv_exchange *exchange) {
    struct srv_errand *errand = srv_errand_begin_one(exchange);
    if (!errand) return;
    srv_errand_ask(errand, SRV_ASK_READ, srv_errand_find, jobs_found_events);
}

/* --- many jobs --- */

static enum srv_stored jobs_find_page(struct srv_store *store, struct srv_store_call *call) {
    struct srv_errand *errand = (struct srv_errand *)call;
    return srv_store_list(store, errand->exchange->identity.key, errand->before, errand->most, errand->page,
                          &errand->count);
}

static void jobs_found_page(struct srv_errand *errand, enum srv_stored stored) {
    struct srv_exchange *exchange = errand->exchange;
    struct api_job view[JOBS_PAGE];
    char next[96];
    if (stored != SRV_STORED) {
        srv_errand_refuse(errand, stored);
    } else {
        for (int i = 0; i < errand->count; i++) view[i] = srv_job_view(&errand->page[i]);
        int full = errand->count == errand->most;
        if (full) snprintf(next, sizeof next, "/v1/jobs?before=%s&limit=%d", view[errand->count - 1].id, errand->most);
        jobs_written(exchange, 200, api_jobs_write(view, errand->count, full ? next : NULL, &exchange->answer));
    }
    srv_errand_end(errand);
}

void srv_jobs_list(struct srv_exchange *exchange) {
    struct srv_errand *errand = srv_errand_begin(exchange, &srv_errand_jobs);
    if (!errand) return;
    if (!jobs_read_query(exchange->query, errand)) {
        srv_exchange_problem(exchange, 422, "the query may say before=ID and limit=1 to %d, got ?%.100s", JOBS_PAGE,
                             exchange->query);
        srv_errand_end(errand);
        return;
    }
    if (exchange->identity.kind == SRV_IDENTITY_ADDRESS) {
        srv_admission_challenge(exchange,
                                "a list is of what was posted with a token, and an address is nobody's alone");
        srv_errand_end(errand);
        return;
    }
    if (!srv_admission_count(exchange)) {
        srv_errand_end(errand);
        return;
    }
    errand->page = calloc((size_t)errand->most, sizeof *errand->page);
    if (errand->page) {
        srv_errand_ask(errand, SRV_ASK_READ, jobs_find_page, jobs_found_page);
        return;
    }
    srv_exchange_busy(exchange, 1, "out of memory");
    srv_errand_end(errand);
}
