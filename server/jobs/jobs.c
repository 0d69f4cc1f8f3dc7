#include "server/jobs/jobs.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/random.h>

#include "api/base/engine.h"
#include "api/base/text.h"
#include "api/call/part.h"
#include "server/jobs/job_events.h"
#include "server/jobs/part_runner.h"
#include "server/jobs/store_request.h"
#include "server/work/admission.h"

enum { JOBS_COST = 3, JOBS_SPARE = 64 };

static const char jobs_json[] = "application/json";

/* --- answers --- */

static void jobs_answer_job(struct srv_exchange *exchange, int status, const struct srv_job *job) {
    assert(status == 200 || status == 202 || status == 303);
    struct api_job view = srv_job_view(job);
    if (api_job_write(&view, &exchange->answer) != PEND_OK) {
        srv_exchange_busy(exchange, 1, "out of memory");
        return;
    }
    srv_exchange_answered(exchange, status, jobs_json);
    srv_exchange_header(exchange, "Cache-Control", "no-store");
}

/* The text after a preference (RFC 7240) in the list; NULL if it is absent. */
static const char *jobs_prefers(const char *list, const char *name) {
    size_t bytes = strlen(name);
    for (const char *at = list; at && *at; at = strchr(at, ',') ? strchr(at, ',') + 1 : NULL) {
        at += strspn(at, " \t");
        if (!strncasecmp(at, name, bytes) && (!at[bytes] || strchr(" \t,;=", at[bytes])))
            return at + bytes;
    }
    return NULL;
}

/* Parses the seconds of a wait, whose digits must be followed by one of `ends`. Returns at most
 * SRV_JOB_WAIT_S + 1, or -1 if malformed. */
static int jobs_read_wait(const char *text, const char *ends) {
    size_t digits = strspn(text, "0123456789");
    if (!digits || (text[digits] && !strchr(ends, text[digits]))) return -1;
    int seconds = digits < 5 ? atoi(text) : SRV_JOB_WAIT_S + 1;
    return seconds > SRV_JOB_WAIT_S ? SRV_JOB_WAIT_S + 1 : seconds;
}

/* The seconds that a client prefers to wait for its new job, 0 to SRV_JOB_WAIT_S. A malformed
 * preference is ignored. */
static int jobs_waits(const struct srv_exchange *exchange) {
    const char *text = jobs_prefers(exchange->field[SRV_PREFER], "wait");
    int seconds = text && *text == '=' ? jobs_read_wait(text + 1, " \t,;") : 0;
    return seconds < 0 ? 0 : seconds > SRV_JOB_WAIT_S ? SRV_JOB_WAIT_S : seconds;
}

int srv_jobs_wanted(const struct srv_exchange *exchange) {
    /* only operations that answer a table run as jobs */
    const struct api_op *op = api_op_at(exchange->op);
    if (exchange->method && !strcmp(exchange->method, "QUERY"))
        return 0; /* the method QUERY must not change anything */
    return op && op->table && exchange->service->storage &&
           jobs_prefers(exchange->field[SRV_PREFER], "respond-async") != NULL;
}

/* Reads visible ASCII characters, with or without the quotes of a structured field. */
static int jobs_read_key(const char *text, char key[SRV_STORE_REQUEST_KEY + 1]) {
    size_t bytes = text ? strlen(text) : 0;
    key[0] = 0;
    if (!text) return 1;
    if (bytes >= 2 && text[0] == '"' && text[bytes - 1] == '"') {
        text++;
        bytes -= 2;
    }
    if (!bytes || bytes > SRV_STORE_REQUEST_KEY) return 0;
    for (size_t i = 0; i < bytes; i++)
        if (text[i] <= ' ' || text[i] > '~' || text[i] == '"') return 0;
    memcpy(key, text, bytes);
    key[bytes] = 0;
    return 1;
}

static int jobs_hex(char letter) {
    static const char digits[] = "0123456789abcdefABCDEF";
    const char *at = letter ? strchr(digits, letter) : NULL;
    if (!at) return -1;
    return (int)(at - digits) - (at - digits > 15 ? 6 : 0);
}

int srv_jobs_title(const char *text, size_t bytes, char title[SRV_TITLE_BYTES]) {
    size_t count = 0;
    for (size_t i = 0; i < bytes; i++) {
        int escape = text[i] == '%', high = escape && i + 2 < bytes ? jobs_hex(text[i + 1]) : -1;
        int low = high >= 0 ? jobs_hex(text[i + 2]) : -1;
        if (escape && low < 0) return 0;
        unsigned char byte = (unsigned char)(escape ? 16 * high + low : text[i]);
        if (byte < ' ' || byte == 127 || count + 1 == SRV_TITLE_BYTES) return 0;
        title[count++] = (char)byte;
        i += escape ? 2 : 0;
    }
    title[count] = 0;
    for (size_t at = 0, length; at < count; at += length)
        if (!(length = (size_t)api_text_utf8(title + at, count - at))) return 0;
    return count > 0;
}

/* --- submitting --- */

/* Generates an id of 130 random bits, because anyone with the id can read the job. */
static int jobs_make_id(char id[SRV_ID_BYTES]) {
    unsigned char bits[SRV_ID_BYTES - 1];
    if (getrandom(bits, sizeof bits, 0) != (ssize_t)sizeof bits) return 0;
    for (size_t i = 0; i < sizeof bits; i++) id[i] = srv_store_request_letters[bits[i] & 31];
    id[sizeof bits] = 0;
    return 1;
}

/* A limit of the client's role or key, at least 1; 0 = unlimited. */
static double jobs_own(const struct srv_exchange *exchange, enum srv_limit limit) {
    double value = exchange->identity.limits.value[limit];
    return isinf(value) ? 0 : fmax(value, 1);
}

static enum srv_stored jobs_put(struct srv_store *store, struct srv_store_call *call) {
    struct srv_store_request *asked = SRV_CONTAINER_OF(call, struct srv_store_request, ask.call);
    assert(asked->parts >= 1 && asked->id[0] && asked->cost_us >= 0);
    const struct srv_exchange *exchange = asked->exchange;
    const struct srv_identity *who = &exchange->identity;
    char version[SRV_VERSION_BYTES];
    snprintf(version, sizeof version, "%s+%s", PEND_VERSION, api_engine_name);
    struct srv_job_order order = {.id = asked->id,
                                  .title = asked->title,
                                  .version = version,
                                  .client = who->key,
                                  .source = who->source,
                                  .operation = api_op_at(exchange->op)->name,
                                  .key = asked->key[0] ? asked->key : NULL,
                                  .request = asked->body.data,
                                  .request_bytes = asked->body.bytes,
                                  .digest = asked->digest,
                                  .parts = asked->parts,
                                  .chained = asked->chained,
                                  .cost_us = asked->cost_us,
                                  .client_jobs = (long)jobs_own(exchange, SRV_LIMIT_JOBS),
                                  .client_bytes = (long long)jobs_own(exchange, SRV_LIMIT_BYTES),
                                  .turns = 1 << (int)who->limits.value[SRV_LIMIT_PRIORITY]};
    return srv_store_submit(store, &order, &asked->job);
}

/* Answers with an accepted job: 202, or 303 to its results if the client preferred to wait and they
 * are available. `job` is NULL if it no longer exists. */
static void jobs_accepted(struct srv_exchange *exchange, const struct srv_job *job) {
    int seconds = jobs_waits(exchange), done = 0;
    char *location = srv_exchange_text(exchange, 64), *applied = srv_exchange_text(exchange, 64);
    if (!job) {
        srv_exchange_problem(exchange, 404,
                             "the job was deleted while this request waited for it to finish");
        return;
    }
    done = seconds && job->state == SRV_JOB_SUCCESSFUL;
    jobs_answer_job(exchange, done ? 303 : 202, job);
    if (applied) {
        snprintf(applied, 64, seconds ? "respond-async, wait=%d" : "respond-async", seconds);
        srv_exchange_header(exchange, "Preference-Applied", applied);
    }
    if (location) {
        snprintf(location, 64, "/v1/jobs/%s%s", job->id, done ? "/results" : "");
        srv_exchange_header(exchange, "Location", location);
    }
}

static void jobs_submitted(struct srv_store_request *asked, enum srv_stored stored) {
    struct srv_exchange *exchange = asked->exchange;
    if (stored != SRV_STORED) {
        srv_store_request_refuse(asked, stored);
    } else {
        int seconds = jobs_waits(exchange);
        if (strcmp(asked->job.id, asked->id) != 0)
            srv_exchange_header(exchange, "Idempotency-Replayed", "true");
        srv_part_runner_news(exchange->service->runner, SRV_RING_WORK);
        if (!seconds || srv_job_over(&asked->job))
            jobs_accepted(exchange, &asked->job);
        else if (srv_job_events_await(exchange, &asked->job, seconds, jobs_accepted)) {
            srv_store_request_leave(asked);
            return;
        }
    }
    srv_store_request_end(asked);
}

/* Refuses a job whose first or largest part would exceed a limit. Returns 1 if it fits. */
static int jobs_fit(struct srv_exchange *exchange, const struct api_plan *plan, size_t body_bytes) {
    assert(plan->parts >= 1 && plan->bytes >= 0);
    const struct srv_config *config = srv_service_config(exchange->service);
    double bytes = plan->bytes + 2 * (double)body_bytes, answer = config->limits.answer_bytes;
    if (srv_hold_never(config, bytes))
        srv_exchange_problem(exchange, 422,
                             API_TYPE_LIMIT
                             "a part of this job would take about %.0f bytes of memory, but "
                             "max-held-bytes allows at most %.0f for one part",
                             bytes, srv_hold_most(config));
    else if (plan->kept > answer)
        srv_exchange_problem(
            exchange, 422,
            API_TYPE_LIMIT
            "a part of this job would have at least %.0f bytes of results, more than "
            "max-answer-bytes allows: %.0f; ask for fewer instants, members or columns",
            plan->kept, answer);
    else
        return 1;
    return 0;
}

/* Reads the whole request. Returns 1 if the job may be stored; else the exchange is answered. */
static int jobs_plan(struct srv_store_request *asked) {
    struct srv_exchange *exchange = asked->exchange;
    const struct srv_service *service = exchange->service;
    double limit = srv_service_job_limits(service)->compute_seconds;
    struct api_plan plan;
    struct api_request request = {.op = exchange->op,
                                  .query = exchange->query,
                                  .content_type = exchange->field[SRV_CONTENT_TYPE],
                                  .body = exchange->body.bytes ? exchange->body.data : NULL,
                                  .body_bytes = exchange->body.bytes};
    /* canonical JSON of a multipart form is longer: a line end takes two bytes, "1e20," takes 22 */
    api_buffer_init(&asked->body, 5 * exchange->body.bytes + JOBS_SPARE);
    int http = api_plan_read(&plan, &request, srv_service_job_limits(service),
                             service->config.job_part_seconds, &asked->body, &exchange->answer);
    if (http) {
        srv_exchange_answered(exchange, http, "application/problem+json");
        return 0;
    }
    if (plan.cost > JOBS_COST * limit) {
        srv_exchange_problem(
            exchange, 422,
            API_TYPE_LIMIT
            "this would take about %.0f s, longer than max-job-seconds allows: %.15g s",
            plan.cost, limit);
        return 0;
    }
    if (!jobs_fit(exchange, &plan, asked->body.bytes)) return 0;
    asked->parts = plan.parts;
    asked->chained = plan.chained;
    asked->cost_us = (int64_t)(1e6 * plan.cost);
    for (int i = 0; i < SRV_DIGEST_BYTES; i++)
        sscanf(plan.digest + 2 * i, "%2hhx", &asked->digest[i]);
    if (jobs_make_id(asked->id)) return 1;
    srv_exchange_busy(exchange, 1, "the system has no random numbers");
    return 0;
}

void srv_jobs_submit(struct srv_exchange *exchange) {
    assert(api_op_at(exchange->op));
    struct srv_store_request *asked = srv_store_request_begin(exchange, &srv_store_request_jobs);
    if (!asked) return;
    if (!jobs_read_key(exchange->field[SRV_IDEMPOTENCY_KEY], asked->key)) {
        srv_exchange_problem(exchange, 400,
                             "Idempotency-Key must be 1 to %d visible ASCII characters",
                             SRV_STORE_REQUEST_KEY);
        srv_store_request_end(asked);
        return;
    }
    const char *title = exchange->field[SRV_JOB_TITLE];
    if (title && !srv_jobs_title(title, strlen(title), asked->title)) {
        srv_exchange_problem(exchange, 400,
                             "Job-Title must be 1 to %d bytes of UTF-8 without control characters; "
                             "characters outside ASCII, and %%, may be percent-encoded",
                             SRV_TITLE_BYTES - 1);
        srv_store_request_end(asked);
        return;
    }
    srv_store_request_work(asked, jobs_plan, jobs_put, jobs_submitted);
}

/* --- one job --- */

/* Cancels a job in the store; SRV_STORED_CLASH if it belongs to another client. */
static enum srv_stored jobs_drop(struct srv_store *store, struct srv_store_call *call) {
    struct srv_store_request *asked = SRV_CONTAINER_OF(call, struct srv_store_request, ask.call);
    enum srv_stored stored = srv_store_request_find(store, call);
    if (stored != SRV_STORED) return stored;
    if (!srv_identity_owns(&asked->exchange->identity, asked->job.client)) return SRV_STORED_CLASH;
    return srv_store_dismiss(store, asked->id, &asked->job);
}

static void jobs_found(struct srv_store_request *asked, enum srv_stored stored) {
    if (stored == SRV_STORED)
        jobs_answer_job(asked->exchange, 200, &asked->job);
    else
        srv_store_request_refuse(asked, stored);
    srv_store_request_end(asked);
}

static void jobs_awaited(struct srv_exchange *exchange, const struct srv_job *job) {
    if (job)
        jobs_answer_job(exchange, 200, job);
    else
        srv_exchange_problem(exchange, 404,
                             "the job was deleted while this request waited for it to finish");
}

static void jobs_found_wait(struct srv_store_request *asked, enum srv_stored stored) {
    int seconds = jobs_read_wait(asked->exchange->query + strlen("wait="), "");
    if (stored != SRV_STORED || !seconds || srv_job_over(&asked->job))
        jobs_found(asked, stored);
    else if (srv_job_events_await(asked->exchange, &asked->job, seconds, jobs_awaited))
        srv_store_request_leave(asked);
    else
        srv_store_request_end(asked);
}

/* Answers 403. That the job exists is no secret: anyone with the id can read it. */
static void jobs_denied(struct srv_exchange *exchange, const struct srv_job *job) {
    const char *owner = srv_identity_word(job->client);
    int named = exchange->identity.kind == SRV_IDENTITY_TOKEN ||
                exchange->identity.kind == SRV_IDENTITY_ISSUED;
    if (named || (strcmp(owner, "token") != 0 && strcmp(owner, "key") != 0))
        srv_exchange_problem(exchange, 403,
                             API_TYPE_OWNER "you may not cancel this job: it was submitted %s",
                             !strcmp(owner, "token")     ? "with another token"
                             : !strcmp(owner, "key")     ? "with another key"
                             : !strcmp(owner, "account") ? "from another account"
                                                         : "without a token, from another address");
    else
        srv_admission_challenge(
            exchange, "this job was submitted with a %s, which is needed to cancel it", owner);
}

static void jobs_dropped(struct srv_store_request *asked, enum srv_stored stored) {
    if (stored == SRV_STORED_CLASH) {
        jobs_denied(asked->exchange, &asked->job);
        srv_store_request_end(asked);
        return;
    }
    if (stored == SRV_STORED) {
        srv_part_runner_dismiss(asked->service->runner, asked->id);
        srv_events_news(asked->service->events);
    }
    jobs_found(asked, stored);
}

void srv_jobs_read(struct srv_exchange *exchange) {
    const char *query = exchange->query;
    int waits = query && !strncmp(query, "wait=", 5);
    int seconds = waits ? jobs_read_wait(query + 5, "") : 0;
    struct srv_store_request *asked = srv_store_request_begin_one(exchange);
    if (!asked) return;
    if (seconds >= 0 && seconds <= SRV_JOB_WAIT_S) {
        srv_store_request_ask(asked, SRV_ASK_READ, srv_store_request_find,
                              waits ? jobs_found_wait : jobs_found);
        return;
    }
    srv_exchange_problem(exchange, 422, "wait must be 0 to %d whole seconds, got ?%.100s",
                         SRV_JOB_WAIT_S, query);
    srv_store_request_end(asked);
}

void srv_jobs_dismiss(struct srv_exchange *exchange) {
    struct srv_store_request *asked = srv_store_request_begin_one(exchange);
    if (asked) srv_store_request_ask(asked, SRV_ASK_WRITE, jobs_drop, jobs_dropped);
}

/* --- events --- */

/* Answers 204 to a client that reconnects after the last event, so that EventSource stops. */
static int jobs_ended(struct srv_store_request *asked) {
    char id[SRV_EVENT_ID];
    const char *last = asked->exchange->field[SRV_LAST_EVENT_ID];
    srv_job_events_id(&asked->job, id);
    if (!last || strcmp(last, id) != 0 || !srv_job_over(&asked->job)) return 0;
    srv_exchange_static(asked->exchange, 204, NULL, NULL, 0);
    return 1;
}

static void jobs_found_events(struct srv_store_request *asked, enum srv_stored stored) {
    if (stored != SRV_STORED)
        srv_store_request_refuse(asked, stored);
    else if (!jobs_ended(asked))
        srv_job_events_open(asked->exchange, &asked->job,
                            asked->exchange->field[SRV_LAST_EVENT_ID]);
    srv_store_request_end(asked);
}

void srv_jobs_events(struct srv_exchange *exchange) {
    struct srv_store_request *asked = srv_store_request_begin_one(exchange);
    if (!asked) return;
    srv_store_request_ask(asked, SRV_ASK_READ, srv_store_request_find, jobs_found_events);
}
