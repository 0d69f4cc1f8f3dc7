#include "server/jobs/store_request.h"

#include <stdlib.h>
#include <string.h>

#include "server/base/clock.h"
#include "server/work/inflight.h"

enum { STORE_REQUEST_LONG_BODY = 1 << 18 };

const char srv_store_request_letters[] = "0123456789abcdefghjkmnpqrstvwxyz";

const struct srv_store_request_words srv_store_request_jobs = {
    "jobs", "repeating the request with the same Idempotency-Key creates only one job"};

int srv_store_request_id_good(const char *id) {
    return strlen(id) == SRV_ID_BYTES - 1 &&
           strspn(id, srv_store_request_letters) == SRV_ID_BYTES - 1;
}

struct srv_store_request *srv_store_request_begin(struct srv_exchange *exchange,
                                                  const struct srv_store_request_words *words) {
    struct srv_store_request *asked = exchange->service->storage ? calloc(1, sizeof *asked) : NULL;
    assert(srv_exchange_valid(exchange) && !exchange->status && words);
    exchange->apart = 1;
    if (asked) {
        asked->words = words;
        asked->exchange = exchange;
        asked->service = exchange->service;
        atomic_fetch_add(&exchange->service->computing, 1);
        return asked;
    }
    if (exchange->service->storage)
        srv_exchange_busy(exchange, 1, "out of memory");
    else
        srv_exchange_problem(
            exchange, 404, API_TYPE_NO_STORE "this server stores no %s: its option --store is none",
            words->many);
    exchange->finish(exchange);
    return NULL;
}

struct srv_store_request *srv_store_request_begin_one(struct srv_exchange *exchange) {
    struct srv_store_request *asked = srv_store_request_begin(exchange, &srv_store_request_jobs);
    if (!asked) return NULL;
    if (srv_store_request_id_good(exchange->argument)) {
        memcpy(asked->id, exchange->argument, SRV_ID_BYTES);
        return asked;
    }
    srv_store_request_refuse(asked, SRV_STORED_NONE);
    srv_store_request_end(asked);
    return NULL;
}

static void store_request_done(struct srv_ask *ask) {
    struct srv_store_request *asked = SRV_CONTAINER_OF(ask, struct srv_store_request, ask);
    asked->answer(asked, ask->call.stored);
}

static enum srv_stored store_request_run(struct srv_store *store, struct srv_store_call *call) {
    struct srv_store_request *asked = SRV_CONTAINER_OF(call, struct srv_store_request, ask.call);
    if (asked->reads && srv_inflight_left(asked->exchange) == SRV_STOP_LEFT)
        return SRV_STORED_AGAIN;
    return asked->run(store, call);
}

static void
store_request_sends(struct srv_store_request *asked, enum srv_ask_kind kind,
                    enum srv_stored (*run)(struct srv_store *store, struct srv_store_call *call),
                    void (*answer)(struct srv_store_request *asked, enum srv_stored stored)) {
    struct srv_exchange *exchange = asked->exchange;
    struct srv_client *client =
        exchange->account ? exchange->account : srv_exchange_payer(exchange);
    assert(srv_exchange_valid(exchange) && asked->service->storage && run && answer);
    asked->run = run;
    asked->reads = kind == SRV_ASK_READ;
    asked->ask.call.run = store_request_run;
    asked->ask.done = store_request_done;
    asked->ask.asker = client ? &client->asker : NULL;
    asked->answer = answer;
}

void srv_store_request_ask(struct srv_store_request *asked, enum srv_ask_kind kind,
                           enum srv_stored (*run)(struct srv_store *store,
                                                  struct srv_store_call *call),
                           void (*answer)(struct srv_store_request *asked,
                                          enum srv_stored stored)) {
    store_request_sends(asked, kind, run, answer);
    srv_storage_ask(asked->service->storage, kind, &asked->ask);
}

/* Reserves the memory to parse a long body. Returns 0, with the exchange answered, if there is no
 * space. */
static int store_request_room(struct srv_store_request *asked) {
    struct srv_exchange *exchange = asked->exchange;
    size_t bytes = exchange->body.bytes;
    if (bytes <= SRV_HOLD_READ_FREE) return 1;
    asked->hold = (struct srv_hold){.service = asked->service,
                                    .payer = srv_exchange_payer(exchange),
                                    .kind = SRV_MEMORY_COMPUTATIONS};
    enum srv_room room = srv_hold_try(&asked->hold, SRV_HOLD_READ * bytes);
    if (room != SRV_ROOM) srv_exchange_crowded(exchange, room, "reading the body");
    return room == SRV_ROOM;
}

static int store_request_work(struct srv_task *task) {
    struct srv_store_request *asked = SRV_CONTAINER_OF(task, struct srv_store_request, task);
    struct srv_exchange *exchange = asked->exchange;
    struct srv_service *service = asked->service;
    int64_t begin = srv_clock_now();
    exchange->waited = begin - exchange->queued;
    atomic_fetch_add(&service->busy, 1);
    int good = store_request_room(asked) && asked->check(asked);
    assert(good == !exchange->status);
    size_t kept = asked->body.cap + asked->scene.cap;
    if (asked->hold.bytes) srv_hold_set(&asked->hold, kept);
    exchange->computed = srv_clock_now() - begin;
    atomic_fetch_sub(&service->busy, 1);
    srv_metrics_count(&service->metrics.busy_ns, (unsigned long long)exchange->computed);
    if (good)
        srv_storage_ask(service->storage, SRV_ASK_WRITE, &asked->ask);
    else
        srv_store_request_end(asked);
    return 0;
}

void srv_store_request_work(
    struct srv_store_request *asked, int (*check)(struct srv_store_request *asked),
    enum srv_stored (*run)(struct srv_store *store, struct srv_store_call *call),
    void (*answer)(struct srv_store_request *asked, enum srv_stored stored)) {
    struct srv_exchange *exchange = asked->exchange;
    store_request_sends(asked, SRV_ASK_WRITE, run, answer);
    assert(check && exchange->account);
    asked->check = check;
    exchange->queued = srv_clock_now();
    asked->task = (struct srv_task){
        .run = store_request_work,
        .lane = &exchange->account->lane,
        .level = exchange->body.bytes > STORE_REQUEST_LONG_BODY ? SRV_QUEUE_READ : 0};
    enum pend_status status = srv_queue_push(asked->service->queue, &asked->task);
    if (status == PEND_OK) return;
    srv_exchange_queued_out(exchange, status, asked->task.road_full);
    srv_store_request_end(asked);
}

enum srv_stored srv_store_request_find(struct srv_store *store, struct srv_store_call *call) {
    struct srv_store_request *asked = SRV_CONTAINER_OF(call, struct srv_store_request, ask.call);
    return srv_store_job(store, asked->id, &asked->job);
}

void srv_store_request_refuse(struct srv_store_request *asked, enum srv_stored stored) {
    struct srv_exchange *exchange = asked->exchange;
    switch (stored) {
    case SRV_STORED_NONE:
        srv_exchange_problem(
            exchange, 404,
            "there is no job with this id; ended jobs are stored for keep-seconds, %.15g s",
            exchange->service->config.keep_seconds);
        break;
    case SRV_STORED_CLASH:
        srv_exchange_problem(exchange, 422,
                             API_TYPE_KEY_REUSED
                             "this Idempotency-Key was used with another request%s",
                             exchange->identity.kind != SRV_IDENTITY_ADDRESS
                                 ? ""
                                 : ", from your address; clients that send Authorization: Bearer "
                                   "SECRET have separate keys");
        break;
    case SRV_STORED_QUOTA:
        srv_exchange_problem(exchange, 429, API_TYPE_QUOTA "%.200s", asked->job.message);
        srv_exchange_retry(exchange, 5);
        break;
    case SRV_STORED_DAMAGED:
        srv_exchange_problem(exchange, 500, "the stored data are damaged");
        break;
    case SRV_STORED_FULL:
        srv_exchange_busy(exchange, 60, "the store's disk is full");
        break;
    case SRV_STORED_AGAIN:
        srv_exchange_busy(exchange, 1, "the store is busy; nothing was changed");
        break;
    default:
        srv_exchange_problem(exchange, 503, "the store is not reachable; %s", asked->words->again);
        srv_exchange_retry(exchange, 2);
        break;
    }
}

static void store_request_free(struct srv_store_request *asked) {
    if (asked->hold.bytes) srv_hold_set(&asked->hold, 0);
    api_buffer_clear(&asked->scene);
    api_buffer_clear(&asked->body);
    free(asked->kept);
    free(asked->request);
    if (asked->more) asked->more_free(asked->more);
    free(asked);
}

void srv_store_request_end(struct srv_store_request *asked) {
    struct srv_exchange *exchange = asked->exchange;
    struct srv_service *service = asked->service;
    store_request_free(asked);
    /* account for the memory of this answer before the next answer is made */
    srv_exchange_settle(exchange);
    exchange->finish(exchange);
    atomic_fetch_sub(&service->computing, 1);
}

void srv_store_request_leave(struct srv_store_request *asked) {
    struct srv_service *service = asked->service;
    store_request_free(asked);
    atomic_fetch_sub(&service->computing, 1);
}
