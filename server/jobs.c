#include "server/jobs.h"

#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/random.h>

#include "api/job_json.h"
#include "api/part.h"
#include "server/admission.h"
#include "server/clock.h"
#include "server/compute.h"
#include "server/runner.h"

enum { JOBS_PAGE = 100, JOBS_DEFAULT = 20, JOBS_KEY = 80, JOBS_LONG_BODY = 1 << 18, JOBS_COST = 3 };

static const char jobs_letters[] = "0123456789abcdefghjkmnpqrstvwxyz";
static const char jobs_json[] = "application/json";

/* An exchange on its way to the store and back. */
struct jobs_errand {
    struct srv_ask ask; /* first: an ask is its errand */
    struct srv_task task;
    struct srv_exchange *exchange;
    void (*answer)(struct jobs_errand *errand, enum srv_stored stored);
    char id[SRV_ID_BYTES];
    char key[JOBS_KEY + 1]; /* "" = none */
    unsigned char digest[SRV_DIGEST_BYTES];
    long shards;
    int chained;
    struct srv_job job;
    void *request; /* of a job whose results are wanted */
    size_t request_bytes;
    struct srv_job *page; /* room for `most` */
    int most, count;
    const char *before;
};

/* --- an errand's life --- */

/* the exchange is answered and goes home */
static void jobs_end(struct jobs_errand *errand) {
    struct srv_exchange *exchange = errand->exchange;
    struct srv_service *service = exchange->service;
    free(errand->page);
    free(errand->request);
    free(errand);
    exchange->finish(exchange);
    atomic_fetch_sub(&service->computing, 1);
}

static void jobs_done(struct srv_ask *ask) {
    struct jobs_errand *errand = (struct jobs_errand *)ask;
    errand->answer(errand, ask->call.stored);
}

/* asks; the answer comes on a thread of the storage */
static void jobs_ask(struct jobs_errand *errand, enum srv_ask_kind kind,
                     enum srv_stored (*run)(struct srv_store *, struct srv_store_call *),
                     void (*answer)(struct jobs_errand *, enum srv_stored)) {
    errand->ask.call.run = run;
    errand->ask.done = jobs_done;
    errand->answer = answer;
    srv_storage_ask(errand->exchange->service->storage, kind, &errand->ask);
}

/* an errand for an exchange; NULL, with the exchange answered and gone, where that cannot be */
static struct jobs_errand *jobs_begin(struct srv_exchange *exchange) {
    struct jobs_errand *errand = exchange->service->storage ? calloc(1, sizeof *errand) : NULL;
    exchange->apart = 1;
    if (errand) {
        errand->exchange = exchange;
        atomic_fetch_add(&exchange->service->computing, 1);
        return errand;
    }
    if (exchange->service->storage)
        srv_exchange_busy(exchange, 1, "out of memory");
    else
        srv_exchange_problem(exchange, 404, "this server keeps no jobs: its option --store is none");
    exchange->finish(exchange);
    return NULL;
}

/* --- answers --- */

static const char *jobs_word(enum srv_job_state state) {
    static const char *const word[SRV_JOB_STATES] = {"accepted", "running", "successful", "failed", "dismissed"};
    return word[state];
}

/* s until the job is done, from the time that its parts took so far; -1 = unknown */
static double jobs_remaining(const struct srv_job *job) {
    if (job->state != SRV_JOB_RUNNING || !job->done || !job->started) return -1;
    return 1e-6 * (double)(job->now - job->started) / (double)job->done * (double)(job->shards - job->done);
}

static struct api_job jobs_view(const struct srv_job *job) {
    return (struct api_job){.id = job->id,
                            .operation = job->operation,
                            .status = jobs_word(job->state),
                            .message = job->message,
                            .parts = job->shards,
                            .done = job->done,
                            .created = job->created,
                            .started = job->started,
                            .finished = job->finished,
                            .expires = job->expires,
                            .remaining = jobs_remaining(job),
                            .results = job->state == SRV_JOB_SUCCESSFUL};
}

static void jobs_written(struct srv_exchange *exchange, int status, enum pend_status written) {
    if (written != PEND_OK) {
        srv_exchange_busy(exchange, 1, "out of memory");
        return;
    }
    srv_exchange_answered(exchange, status, jobs_json);
    srv_exchange_header(exchange, "Cache-Control", "no-store");
}

static void jobs_answer_job(struct srv_exchange *exchange, int status, const struct srv_job *job) {
    struct api_job view = jobs_view(job);
    jobs_written(exchange, status, api_job_write(&view, &exchange->answer));
}

/* what went wrong in the store */
static void jobs_refuse(struct srv_exchange *exchange, enum srv_stored stored, const struct srv_job *job) {
    switch (stored) {
    case SRV_STORED_NONE:
        srv_exchange_problem(exchange, 404, "there is no job of this id; ended ones are kept for keep-seconds, %.15g s",
                             exchange->service->config.keep_seconds);
        break;
    case SRV_STORED_CLASH:
        srv_exchange_problem(exchange, 422, "this Idempotency-Key has come with another request before");
        break;
    case SRV_STORED_QUOTA:
        srv_exchange_problem(exchange, 429, "%.200s", job->message);
        srv_exchange_retry(exchange, 5);
        break;
    case SRV_STORED_FULL:
        srv_exchange_busy(exchange, 60, "the store's disk is full");
        break;
    case SRV_STORED_AGAIN:
        srv_exchange_busy(exchange, 1, "the store is busy; nothing was changed");
        break;
    default:
        srv_exchange_busy(exchange, 2,
                          "the store is out of reach; a job whose request is repeated with the same "
                          "Idempotency-Key is made once");
        break;
    }
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
    int op = exchange->op == API_OP_TRAJECTORIES || exchange->op == API_OP_FORCES || exchange->op == API_OP_MODES ||
             exchange->op == API_OP_ENSEMBLES;
    return op && exchange->service->storage && jobs_prefers(exchange->field[SRV_PREFER], "respond-async");
}

/* visible ASCII, with or without the quotes of a structured field */
static int jobs_read_key(const char *text, char key[JOBS_KEY + 1]) {
    size_t bytes = text ? strlen(text) : 0;
    key[0] = 0;
    if (!text) return 1;
    if (bytes >= 2 && text[0] == '"' && text[bytes - 1] == '"') {
        text++;
        bytes -= 2;
    }
    if (!bytes || bytes > JOBS_KEY) return 0;
    for (size_t i = 0; i < bytes; i++)
        if (text[i] <= ' ' || text[i] > '~' || text[i] == '"') return 0;
    memcpy(key, text, bytes);
    key[bytes] = 0;
    return 1;
}

static int jobs_id_good(const char *id) {
    return strlen(id) == SRV_ID_BYTES - 1 && strspn(id, jobs_letters) == SRV_ID_BYTES - 1;
}

/* before=ID and limit=N; 0 for anything else */
static int jobs_read_query(const char *query, struct jobs_errand *errand) {
    errand->most = JOBS_DEFAULT;
    for (const char *at = query; at && *at; at = strchr(at, '&') ? strchr(at, '&') + 1 : NULL) {
        size_t bytes = strcspn(at, "&");
        if (!strncmp(at, "before=", 7) && bytes == 7 + SRV_ID_BYTES - 1) {
            memcpy(errand->id, at + 7, SRV_ID_BYTES - 1);
            errand->before = errand->id;
            if (!jobs_id_good(errand->id)) return 0;
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
    for (size_t i = 0; i < sizeof bits; i++) id[i] = jobs_letters[bits[i] & 31];
    id[sizeof bits] = 0;
    return 1;
}

static enum srv_stored jobs_put(struct srv_store *store, struct srv_store_call *call) {
    struct jobs_errand *errand = (struct jobs_errand *)call;
    const struct srv_exchange *exchange = errand->exchange;
    struct srv_job_order order = {.id = errand->id,
                                  .client = exchange->account->key,
                                  .operation = api_op_at(exchange->op)->name,
                                  .key = errand->key[0] ? errand->key : NULL,
                                  .request = exchange->body.data,
                                  .request_bytes = exchange->body.bytes,
                                  .digest = errand->digest,
                                  .shards = errand->shards,
                                  .chained = errand->chained};
    return srv_store_submit(store, &order, &errand->job);
}

static void jobs_submitted(struct jobs_errand *errand, enum srv_stored stored) {
    struct srv_exchange *exchange = errand->exchange;
    char *location = srv_exchange_text(exchange, 64);
    if (stored != SRV_STORED) {
        jobs_refuse(exchange, stored, &errand->job);
    } else {
        jobs_answer_job(exchange, 202, &errand->job);
        srv_exchange_header(exchange, "Preference-Applied", "respond-async");
        if (location) {
            snprintf(location, 64, "/v1/jobs/%s", errand->job.id);
            srv_exchange_header(exchange, "Location", location);
        }
        srv_runner_news(exchange->service->runner);
    }
    jobs_end(errand);
}

/* a digest's 64 digits as bytes */
static void jobs_digest(const char *text, unsigned char digest[SRV_DIGEST_BYTES]) {
    for (int i = 0; i < SRV_DIGEST_BYTES; i++) {
        unsigned byte = 0;
        sscanf(text + 2 * i, "%2x", &byte);
        digest[i] = (unsigned char)byte;
    }
}

/* reads the request as a whole; returns 1 when the job may be kept, else the exchange is answered */
static int jobs_plan(struct jobs_errand *errand) {
    struct srv_exchange *exchange = errand->exchange;
    const struct srv_service *service = exchange->service;
    double limit = service->job_limits.compute_seconds;
    struct api_plan plan;
    struct api_request request = {.op = exchange->op,
                                  .query = exchange->query,
                                  .content_type = exchange->field[SRV_CONTENT_TYPE],
                                  .body = exchange->body.bytes ? exchange->body.data : NULL,
                                  .body_bytes = exchange->body.bytes};
    int http =
        api_plan_read(&plan, &request, &service->job_limits, service->config.job_part_seconds, &exchange->answer);
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
    errand->shards = plan.parts;
    errand->chained = plan.chained;
    jobs_digest(plan.digest, errand->digest);
    if (jobs_make_id(errand->id)) return 1;
    srv_exchange_busy(exchange, 1, "the system has no random numbers");
    return 0;
}

static void jobs_run(struct srv_task *task) {
    struct jobs_errand *errand = (struct jobs_errand *)((char *)task - offsetof(struct jobs_errand, task));
    int64_t begin = srv_clock_now();
    struct srv_service *service = errand->exchange->service;
    errand->exchange->waited = begin - errand->exchange->queued;
    atomic_fetch_add(&service->busy, 1);
    int good = jobs_plan(errand);
    errand->exchange->computed = srv_clock_now() - begin;
    atomic_fetch_sub(&service->busy, 1);
    srv_metrics_count(&service->metrics.busy_ns, (unsigned long long)(srv_clock_now() - begin));
    if (good)
        jobs_ask(errand, SRV_ASK_WRITE, jobs_put, jobs_submitted);
    else
        jobs_end(errand);
}

/* there is no room in the queue */
static void jobs_crowded(struct srv_exchange *exchange, enum pend_status status) {
    struct srv_metrics *metrics = &exchange->service->metrics;
    if (status == PEND_LIMIT) {
        srv_metrics_count(&metrics->refused_queue, 1);
        srv_exchange_busy(exchange, 1, "every worker is busy and the queue is full: max-queue");
        return;
    }
    srv_metrics_count(&metrics->refused_client, 1);
    srv_exchange_problem(exchange, 429, "%.0f requests of yours wait for a worker: max-client-queue",
                         exchange->service->config.client_queue);
    srv_exchange_retry(exchange, 1);
}

void srv_jobs_submit(struct srv_exchange *exchange) {
    struct jobs_errand *errand = jobs_begin(exchange);
    if (!errand) return;
    if (!jobs_read_key(exchange->field[SRV_IDEMPOTENCY_KEY], errand->key)) {
        srv_exchange_problem(exchange, 400, "Idempotency-Key must be 1 to %d visible ASCII characters", JOBS_KEY);
        jobs_end(errand);
        return;
    }
    exchange->queued = srv_clock_now();
    errand->task = (struct srv_task){
        .run = jobs_run, .lane = &exchange->account->lane, .level = exchange->body.bytes > JOBS_LONG_BODY};
    enum pend_status status = srv_queue_push(exchange->service->queue, &errand->task);
    if (status == PEND_OK) return;
    jobs_crowded(exchange, status);
    jobs_end(errand);
}

/* --- one job --- */

static enum srv_stored jobs_find(struct srv_store *store, struct srv_store_call *call) {
    struct jobs_errand *errand = (struct jobs_errand *)call;
    return srv_store_job(store, errand->id, &errand->job);
}

static enum srv_stored jobs_drop(struct srv_store *store, struct srv_store_call *call) {
    struct jobs_errand *errand = (struct jobs_errand *)call;
    return srv_store_dismiss(store, errand->id, &errand->job);
}

static void jobs_found(struct jobs_errand *errand, enum srv_stored stored) {
    if (stored == SRV_STORED)
        jobs_answer_job(errand->exchange, 200, &errand->job);
    else
        jobs_refuse(errand->exchange, stored, &errand->job);
    jobs_end(errand);
}

static void jobs_dropped(struct jobs_errand *errand, enum srv_stored stored) {
    if (stored == SRV_STORED) srv_runner_dismiss(errand->exchange->service->runner, errand->id);
    jobs_found(errand, stored);
}

/* an errand for the job that the path names; NULL, with the exchange answered and gone, where it cannot be one's id */
static struct jobs_errand *jobs_begin_one(struct srv_exchange *exchange) {
    struct jobs_errand *errand = jobs_begin(exchange);
    if (!errand) return NULL;
    if (jobs_id_good(exchange->argument)) {
        memcpy(errand->id, exchange->argument, SRV_ID_BYTES);
        return errand;
    }
    jobs_refuse(exchange, SRV_STORED_NONE, NULL);
    jobs_end(errand);
    return NULL;
}

void srv_jobs_read(struct srv_exchange *exchange) {
    struct jobs_errand *errand = jobs_begin_one(exchange);
    if (errand) jobs_ask(errand, SRV_ASK_READ, jobs_find, jobs_found);
}

void srv_jobs_dismiss(struct srv_exchange *exchange) {
    struct jobs_errand *errand = jobs_begin_one(exchange);
    if (errand) jobs_ask(errand, SRV_ASK_WRITE, jobs_drop, jobs_dropped);
}

/* --- many jobs --- */

static enum srv_stored jobs_find_page(struct srv_store *store, struct srv_store_call *call) {
    struct jobs_errand *errand = (struct jobs_errand *)call;
    return srv_store_list(store, errand->exchange->account->key, errand->before, errand->most, errand->page,
                          &errand->count);
}

static void jobs_found_page(struct jobs_errand *errand, enum srv_stored stored) {
    struct srv_exchange *exchange = errand->exchange;
    struct api_job view[JOBS_PAGE];
    char next[96];
    if (stored != SRV_STORED) {
        jobs_refuse(exchange, stored, &errand->job);
    } else {
        for (int i = 0; i < errand->count; i++) view[i] = jobs_view(&errand->page[i]);
        int full = errand->count == errand->most;
        if (full) snprintf(next, sizeof next, "/v1/jobs?before=%s&limit=%d", view[errand->count - 1].id, errand->most);
        jobs_written(exchange, 200, api_jobs_write(view, errand->count, full ? next : NULL, &exchange->answer));
    }
    jobs_end(errand);
}

void srv_jobs_list(struct srv_exchange *exchange) {
    struct jobs_errand *errand = jobs_begin(exchange);
    if (!errand) return;
    if (!jobs_read_query(exchange->query, errand)) {
        srv_exchange_problem(exchange, 422, "the query may say before=ID and limit=1 to %d, got ?%.100s", JOBS_PAGE,
                             exchange->query);
        jobs_end(errand);
        return;
    }
    exchange->account = srv_clients_take(exchange->service->clients, exchange->client);
    errand->page = calloc((size_t)errand->most, sizeof *errand->page);
    if (exchange->account && errand->page) {
        jobs_ask(errand, SRV_ASK_READ, jobs_find_page, jobs_found_page);
        return;
    }
    srv_exchange_busy(exchange, 1, "out of memory");
    jobs_end(errand);
}

/* --- results --- */

/* Where a job's parts are read from, a chunk at a time. */
struct jobs_source {
    struct srv_source source; /* first */
    struct srv_ask ask;
    struct srv_storage *storage;
    char id[SRV_ID_BYTES];
    long shards, shard, chunk;
    void *request, *data; /* data: where the chunk goes */
    size_t bytes;
};

static enum srv_stored source_read(struct srv_store *store, struct srv_store_call *call) {
    struct jobs_source *source = (struct jobs_source *)((char *)call - offsetof(struct jobs_source, ask));
    return srv_store_chunk(store, source->id, source->shard, source->chunk, source->data, &source->bytes);
}

static enum pend_status source_fetch(void *context, void *data, size_t cap, size_t *bytes, struct pend_error *error) {
    struct jobs_source *source = context;
    enum srv_stored stored = SRV_STORED;
    *bytes = 0;
    if (cap < SRV_CHUNK_BYTES)
        return pend_fail(error, PEND_BUG, -1, 0, "a chunk of %d bytes has no room", SRV_CHUNK_BYTES);
    source->data = data;
    while (source->shard < source->shards && !*bytes) {
        source->ask.call.run = source_read;
        stored = srv_storage_wait(source->storage, SRV_ASK_READ, &source->ask);
        int none = stored == SRV_STORED_NONE && source->chunk > 0;
        if (stored != SRV_STORED && !none)
            return pend_fail(error, PEND_CANCELLED, -1, 0,
                             stored == SRV_STORED_NONE ? "the job's results are not kept any more"
                                                       : "the store is out of reach");
        *bytes = none ? 0 : source->bytes;
        source->chunk++;
        if (*bytes == SRV_CHUNK_BYTES) break;
        source->shard++;
        source->chunk = 0;
    }
    return PEND_OK;
}

static void source_free(struct srv_source *source) {
    struct jobs_source *gone = (struct jobs_source *)source;
    free(gone->request);
    free(gone);
}

/* the exchange goes on to a worker, which takes the answer from the store */
static void jobs_deliver(struct jobs_errand *errand) {
    struct srv_exchange *exchange = errand->exchange;
    struct jobs_source *source = calloc(1, sizeof *source);
    int op = 0;
    while (op < API_OP_COUNT && strcmp(api_op_at((enum api_op_id)op)->name, errand->job.operation)) op++;
    if (!source || op == API_OP_COUNT) {
        srv_exchange_busy(exchange, 1, source ? "this version does not know the job's operation" : "out of memory");
        free(source);
        jobs_end(errand);
        return;
    }
    source->source = (struct srv_source){.from = {.fetch = source_fetch, .context = source},
                                         .body = errand->request,
                                         .body_bytes = errand->request_bytes,
                                         .free = source_free};
    source->request = errand->request;
    source->storage = exchange->service->storage;
    source->shards = errand->job.shards;
    memcpy(source->id, errand->id, sizeof source->id);
    exchange->source = &source->source;
    exchange->op = (enum api_op_id)op;
    struct srv_service *service = exchange->service;
    free(errand);
    srv_compute_begin(exchange);
    atomic_fetch_sub(&service->computing, 1);
}

static enum srv_stored jobs_find_request(struct srv_store *store, struct srv_store_call *call) {
    struct jobs_errand *errand = (struct jobs_errand *)call;
    enum srv_stored stored = srv_store_job(store, errand->id, &errand->job);
    if (stored != SRV_STORED || errand->job.state != SRV_JOB_SUCCESSFUL) return stored;
    free(errand->request);
    return srv_store_request(store, errand->id, &errand->request, &errand->request_bytes);
}

static void jobs_found_request(struct jobs_errand *errand, enum srv_stored stored) {
    struct srv_exchange *exchange = errand->exchange;
    const struct srv_job *job = &errand->job;
    if (stored == SRV_STORED && job->state == SRV_JOB_SUCCESSFUL) {
        jobs_deliver(errand);
        return;
    }
    if (stored != SRV_STORED)
        jobs_refuse(exchange, stored, job);
    else if (job->state <= SRV_JOB_RUNNING)
        srv_exchange_problem(exchange, 409, "the job is %s, with %ld of %ld parts done: its results come with its end",
                             jobs_word(job->state), job->done, job->shards);
    else
        srv_exchange_problem(exchange, 409, "the job has no results: it is %s%s%.200s", jobs_word(job->state),
                             job->message[0] ? ": " : "", job->message);
    jobs_end(errand);
}

void srv_jobs_results(struct srv_exchange *exchange) {
    struct jobs_errand *errand = jobs_begin_one(exchange);
    if (!errand) return;
    if (srv_admission_count(exchange))
        jobs_ask(errand, SRV_ASK_READ, jobs_find_request, jobs_found_request);
    else
        jobs_end(errand);
}
