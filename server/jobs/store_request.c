#include "server/jobs/store_request.h"

#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "server/base/clock.h"

enum { ERRAND_LONG_BODY = 1 << 18 };

const char srv_errand_letters[] = "0123456789abcdefghjkmnpqrstvwxyz";

const struct srv_errand_words srv_errand_jobs = {
    "jobs", "a job whose request is repeated with the same Idempotency-Key is made once"};

int srv_errand_id_good(const char *id) {
    return strlen(id) == SRV_ID_BYTES - 1 && strspn(id, srv_errand_letters) == SRV_ID_BYTES - 1;
}

struct srv_errand *srv_errand_begin(struct srv_exchange *exchange, const struct srv_errand_words *words) {
    struct srv_errand *errand = exchange->service->storage ? calloc(1, sizeof *errand) : NULL;
    exchange->apart = 1;
    if (errand) {
        errand->words = words;
        errand->exchange = exchange;
        errand->service = exchange->service;
        atomic_fetch_add(&exchange->service->computing, 1);
        return errand;
    }
    if (exchange->service->storage)
        srv_exchange_busy(exchange, 1, "out of memory");
    else
        srv_exchange_problem(exchange, 404, "this server keeps no %s: its option --store is none", words->many);
    exchange->finish(exchange);
    return NULL;
}

struct srv_errand *srv_errand_begin_one(struct srv_exchange *exchange) {
    struct srv_errand *errand = srv_errand_begin(exchange, &srv_errand_jobs);
    if (!errand) return NULL;
    if (srv_errand_id_good(exchange->argument)) {
        memcpy(errand->id, exchange->argument, SRV_ID_BYTES);
        return errand;
    }
    srv_errand_refuse(errand, SRV_STORED_NONE);
    srv_errand_end(errand);
    return NULL;
}

static void errand_done(struct srv_ask *ask) {
    struct srv_errand *errand = (struct srv_errand *)ask;
    errand->answer(errand, ask->call.stored);
}

/* what will be asked, and who hears the answer */
static void errand_sends(struct srv_errand *errand,
                         enum srv_stored (*run)(struct srv_store *store, struct srv_store_call *call),
                         void (*answer)(struct srv_errand *errand, enum srv_stored stored)) {
    errand->ask.call.run = run;
    errand->ask.done = errand_done;
    errand->answer = answer;
}

void srv_errand_ask(struct srv_errand *errand, enum srv_ask_kind kind,
                    enum srv_stored (*run)(struct srv_store *store, struct srv_store_call *call),
                    void (*answer)(struct srv_errand *errand, enum srv_stored stored)) {
    errand_sends(errand, run, answer);
    srv_storage_ask(errand->service->storage, kind, &errand->ask);
}

static int errand_work(struct srv_task *task) {
    struct srv_errand *errand = (struct srv_errand *)((char *)task - offsetof(struct srv_errand, task));
    struct srv_exchange *exchange = errand->exchange;
    struct srv_service *service = errand->service;
    int64_t begin = srv_clock_now();
    exchange->waited = begin - exchange->queued;
    atomic_fetch_add(&service->busy, 1);
    int good = errand->check(errand);
    exchange->computed = srv_clock_now() - begin;
    atomic_fetch_sub(&service->busy, 1);
    srv_metrics_count(&service->metrics.busy_ns, (unsigned long long)exchange->computed);
    if (good)
        srv_storage_ask(service->storage, SRV_ASK_WRITE, &errand->ask);
    else
        srv_errand_end(errand);
    return 0;
}

/* there is no room in the queue */
static void errand_crowded(struct srv_exchange *exchange, enum pend_status status) {
    struct srv_metrics *metrics = &exchange->service->metrics;
    if (status == PEND_LIMIT) {
        srv_metrics_count(&metrics->refused_queue, 1);
        srv_exchange_busy(exchange, 1, "every worker is busy and the queue is full: max-queue");
        return;
    }
    srv_metrics_count(&metrics->refused_client, 1);
    srv_exchange_problem(exchange, 429,
                         "%.0f requests of yours wait for a worker, max-client-queue, or those of your address "
                         "are three quarters of max-queue",
                         srv_service_config(exchange->service)->client_queue);
    srv_exchange_retry(exchange, 1);
}

void srv_errand_work(struct srv_errand *errand, int (*check)(struct srv_errand *errand),
                     enum srv_stored (*run)(struct srv_store *store, struct srv_store_call *call),
                     void (*answer)(struct srv_errand *errand, enum srv_stored stored)) {
    struct srv_exchange *exchange = errand->exchange;
    errand_sends(errand, run, answer);
    errand->check = check;
    exchange->queued = srv_clock_now();
    errand->task = (struct srv_task){
        .run = errand_work, .lane = &exchange->account->lane, .level = exchange->body.bytes > ERRAND_LONG_BODY};
    enum pend_status status = srv_queue_push(errand->service->queue, &errand->task);
    if (status == PEND_OK) return;
    errand_crowded(exchange, status);
    srv_errand_end(errand);
}

enum srv_stored srv_errand_find(struct srv_store *store, struct srv_store_call *call) {
    struct srv_errand *errand = (struct srv_errand *)call;
    return srv_store_job(store, errand->id, &errand->job);
}

void srv_errand_refuse(struct srv_errand *errand, enum srv_stored stored) {
    struct srv_exchange *exchange = errand->exchange;
    switch (stored) {
    case SRV_STORED_NONE:
        srv_exchange_problem(exchange, 404, "there is no job of this id; ended ones are kept for keep-seconds, %.15g s",
                             exchange->service->config.keep_seconds);
        break;
    case SRV_STORED_CLASH:
        srv_exchange_problem(exchange, 422, "this Idempotency-Key has come with another request before%s",
                             exchange->identity.kind != SRV_IDENTITY_ADDRESS
                                 ? ""
                                 : ", from your address; who sends Authorization: Bearer SECRET has keys of its own");
        break;
    case SRV_STORED_QUOTA:
        srv_exchange_problem(exchange, 429, "%.200s", errand->job.message);
        srv_exchange_retry(exchange, 5);
        break;
    case SRV_STORED_DAMAGED:
        srv_exchange_problem(exchange, 500, "what the store has kept of this is damaged");
        break;
    case SRV_STORED_FULL:
        srv_exchange_busy(exchange, 60, "the store's disk is full");
        break;
    case SRV_STORED_AGAIN:
        srv_exchange_busy(exchange, 1, "the store is busy; nothing was changed");
        break;
    default:
        srv_exchange_problem(exchange, 503, "the store is out of reach; %s", errand->words->again);
        srv_exchange_retry(exchange, 2);
        break;
    }
}

static void errand_free(struct srv_errand *errand) {
    api_buffer_clear(&errand->scene);
    api_buffer_clear(&errand->body);
    free(errand->kept);
    free(errand->page);
    free(errand->request);
    free(errand);
}

void srv_errand_end(struct srv_errand *errand) {
    struct srv_exchange *exchange = errand->exchange;
    struct srv_service *service = errand->service;
    errand_free(errand);
    exchange->finish(exchange);
    atomic_fetch_sub(&service->computing, 1);
}

void srv_errand_leave(struct srv_errand *errand) {
    struct srv_service *service = errand->service;
    errand_free(errand);
    atomic_fetch_sub(&service->computing, 1);
}
