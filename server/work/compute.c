#include "server/work/compute.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "server/base/clock.h"
#include "server/work/delivery.h"
#include "server/work/result.h"

enum {
    COMPUTE_LONG_BODY = 1 << 18, /* bytes of a body from which reading it counts as long */
    COMPUTE_REFUSE_COST = 3,  /* a request is refused if its estimate exceeds max-compute-seconds by
                               * this factor, the error of estimates */
    COMPUTE_REFUSE_STEPS = 30 /* the same factor for the estimated steps, which the computation also
                               * checks */
};

/* seconds of computation from which a request belongs to the next level of the queue */
static const double compute_level[SRV_QUEUE_LEVELS - 1] = {0.003, 0.05, 1};

static int compute_level_of(const struct srv_work *work, double seconds) {
    int level = 0, behind = atomic_load(&work->account->priority);
    while (level < SRV_QUEUE_LEVELS - 1 && seconds >= compute_level[level]) level++;
    return level + behind < SRV_QUEUE_LEVELS ? level + behind : SRV_QUEUE_LEVELS - 1;
}

/* The reason why a computation ends early, as the detail of a problem response. */
static const char *compute_reason(enum srv_stop why) {
    return why == SRV_STOP_LEFT ? "the client disconnected" : "the server is stopping";
}

/* --- turns on a worker --- */

static void compute_push(struct srv_exchange *exchange);

/* Ends a computation early. If the head of the response was already sent, the bytes that are ready
 * follow and the connection is cut. */
static void compute_stop(struct srv_work *work, int status, const char *detail) {
    enum api_progress progress = api_call_stop(work->call, status, detail, &work->out);
    if (progress == API_BROKEN)
        (void)srv_delivery_pass(work, -1);
    else
        srv_delivery_settle(work);
}

enum { COMPUTE_WAY = 96 };

/* Writes how to get the needed time, in s, as a job; nothing if a job may not take so long. */
static void compute_way(const struct srv_work *work, double seconds, char text[COMPUTE_WAY]) {
    double most = srv_service_job_limits(work->service)->compute_seconds;
    *text = 0;
    if (work->service->storage && seconds <= most)
        snprintf(text, COMPUTE_WAY,
                 "; a job, by Prefer: respond-async, may take max-job-seconds, %.15g s", most);
}

/* Ends the computation if the client left, the server stops or its time is used up. Returns 1 if
 * it ended. */
static int compute_over(struct srv_work *work) {
    struct srv_metrics *metrics = &work->service->metrics;
    double limit = work->limits->compute_seconds;
    enum srv_stop why = srv_inflight_stop(work);
    char detail[256], way[COMPUTE_WAY];
    if (why) {
        srv_metrics_count(&metrics->cancelled, why == SRV_STOP_LEFT);
        compute_stop(work, 503, compute_reason(why));
        return 1;
    }
    if (srv_delivery_seconds(work) <= limit) return 0;
    srv_metrics_count(&metrics->overtime, 1);
    compute_way(work, fmax(limit, work->cost), way);
    snprintf(detail, sizeof detail,
             "the computation took longer than max-compute-seconds allows: %.15g s%s", limit, way);
    compute_stop(work, 503, detail);
    return 1;
}

/* Reserves the memory that the computation will hold after its next piece. If the reservation
 * fails, the computation ends with 503 (the server is full), 429 (the client holds too much) or 422
 * (no client may hold so much), and 0 is returned. */
static int compute_room(struct srv_work *work) {
    struct srv_metrics *metrics = &work->service->metrics;
    size_t bytes = srv_delivery_bytes(work);
    enum srv_room room = srv_hold_try(&work->hold, bytes);
    char detail[256];
    if (room == SRV_ROOM) return 1;
    srv_metrics_count(room == SRV_ROOM_NONE ? &metrics->refused_held : &metrics->refused_share, 1);
    double share = srv_hold_share_of(srv_service_config(work->service), work->hold.payer);
    if (room == SRV_ROOM_NONE)
        snprintf(
            detail, sizeof detail,
            "this takes about %zu bytes of memory, more than is free now (limit: max-held-bytes)",
            bytes);
    else if (room == SRV_ROOM_CLIENT)
        snprintf(detail, sizeof detail,
                 "this takes about %zu bytes of memory, too much together with your other "
                 "requests: max-client-held-bytes is %.0f; read or end those that are open",
                 bytes, share);
    else
        snprintf(detail, sizeof detail,
                 "this takes about %zu bytes of memory, more than the limit max-client-held-bytes "
                 "of %.0f: ask for fewer rows or numbers at a time, or, for samples, a "
                 "representation that is streamed",
                 bytes, share);
    compute_stop(work, room == SRV_ROOM_NONE ? 503 : room == SRV_ROOM_CLIENT ? 429 : 422, detail);
    return 0;
}

/* Sends the head of the response. Other exchanges that wait for this computation get their own
 * computations. */
static void compute_promise(struct srv_work *work) {
    struct srv_list others = {0};
    struct srv_exchange *exchange;
    srv_delivery_promise(work, &others);
    while ((exchange = srv_inflight_next(&others))) compute_push(exchange);
}

/* Runs one piece of the computation. Returns 1 if this worker should continue with it. */
static int compute_piece(struct srv_work *work) {
    int64_t begin = srv_clock_now();
    enum api_progress progress = api_call_run(work->call, &work->out);
    work->spent += srv_clock_now() - begin;
    int ended = progress == API_DONE ? 1 : progress == API_BROKEN ? -1 : 0;
    if (!work->promised && !ended && srv_delivery_ripe(work)) compute_promise(work);
    if (!ended && !compute_room(work)) return 0;
    if (work->promised && !srv_delivery_pass(work, ended)) return 0;
    if (!work->promised && ended) {
        srv_delivery_settle(work);
        return 0;
    }
    /* While the source reads the next piece, the worker runs other tasks. */
    return progress != API_WAITS || !work->source->park(work->source, work);
}

/* Continues with the computation unless others wait. If they do, the computation goes to the end of
 * its client's lane, and 1 is returned. */
static int compute_turn(struct srv_work *work) {
    struct srv_queue *queue = work->service->queue;
    srv_metrics_count(&work->service->metrics.slices, 1);
    while (!compute_over(work)) {
        if (!compute_piece(work)) return 0;
        if (!srv_queue_shorter(queue, SRV_QUEUE_LEVELS)) continue;
        double seconds = srv_delivery_seconds(work);
        work->task.level = compute_level_of(work, seconds > work->cost ? seconds : work->cost);
        return 1;
    }
    return 0;
}

/* Called between two pieces of a computation: returns 1 if a shorter task waits. */
static int compute_hurry(void *company) {
    struct srv_work *work = company;
    srv_fairness_look(&work->service->fairness);
    return srv_queue_shorter(work->service->queue, work->task.level);
}

/* --- the first turn: reading the request --- */

/* The exchange whose request the computation reads. Until srv_inflight_opened is called no other
 * exchange waits for the computation. */
static struct srv_exchange *compute_exchange(const struct srv_work *work) {
    return SRV_CONTAINER_OF(work->waiters.next, struct srv_exchange, beside);
}

/* Answers a request that needs no computation: the client has the response already, the cache has
 * it, or another request computes it. Returns 1 if it was answered. */
static int compute_spared(struct srv_work *work) {
    struct srv_service *service = work->service;
    struct srv_exchange *exchange = compute_exchange(work);
    srv_result_key(work, work->coding);
    /* A stored result differs in its bytes from a computed response, so the cache is skipped. */
    struct srv_response_body *found = work->source ? NULL : srv_result_find(work);
    if (found) {
        srv_metrics_count(&service->metrics.cache_digest, 1);
        srv_delivery_release(work, found, "digest", 0, NULL);
        srv_response_body_drop(&found);
        return 1;
    }
    if (srv_exchange_matches(exchange, work->etag)) {
        srv_delivery_release(work, NULL, NULL, 304, NULL);
        return 1;
    }
    /* A stored result is not shared between exchanges, because its job may be deleted meanwhile. */
    if (work->source) {
        work->key_bytes = 0;
        /* a date never matches, because responses have no dates */
        const char *known = exchange->field[SRV_IF_RANGE];
        if (known && strcmp(known, work->etag)) work->source->ranged = 0;
    }
    if (!srv_inflight_opened(work)) return 0;
    srv_metrics_count(&service->metrics.cache_joined, 1);
    srv_inflight_end(work);
    srv_delivery_done(service);
    return 1;
}

/* Refuses a computation that will certainly exceed its time limit. Returns 1 if it was refused. */
static int compute_too_long(struct srv_work *work) {
    char detail[256], job[COMPUTE_WAY];
    double limit = work->limits->compute_seconds;
    int factor = api_call_foresees(work->call) ? COMPUTE_REFUSE_STEPS : COMPUTE_REFUSE_COST;
    if (work->cost <= factor * limit) return 0;
    compute_way(work, work->cost, job);
    snprintf(detail, sizeof detail,
             "this would take about %.0f s, longer than max-compute-seconds allows: %.15g s%s",
             work->cost, limit, job);
    (void)api_call_stop(work->call, 422, detail, &work->out);
    srv_delivery_settle(work);
    return 1;
}

/* Reserves the memory for reading a request in addition to its body: lists of numbers and the JSON
 * tree. */
static int compute_read_room(struct srv_work *work, size_t body) {
    if (body <= SRV_HOLD_READ_FREE) return 1;
    work->foreseen = SRV_HOLD_READ * body;
    enum srv_room room = srv_hold_try(&work->hold, work->foreseen);
    if (room == SRV_ROOM) return 1;
    struct srv_list taken = {0};
    struct srv_exchange *exchange;
    srv_inflight_take(work, &taken);
    while ((exchange = srv_inflight_next(&taken))) {
        srv_exchange_crowded(exchange, room, "reading the body");
        exchange->finish(exchange);
    }
    srv_inflight_end(work);
    srv_delivery_done(work->service);
    return 0;
}

/* Estimates the memory of the response during its computation: all of it, or the part held before
 * it streams plus two blocks. */
static void compute_foresee(struct srv_work *work) {
    double answer = api_call_answer_bytes(work->call);
    work->foreseen =
        (size_t)(answer < SRV_DELIVERY_HOLD ? answer : SRV_DELIVERY_HOLD) + SRV_INFLIGHT_BLOCK / 2;
    if (answer > SRV_DELIVERY_HOLD) work->foreseen += 2 * SRV_INFLIGHT_BLOCK;
}

/* Returns the request for api: that of the computation's exchange or of a stored result's
 * source. */
static struct api_request compute_request(const struct srv_work *work) {
    const struct srv_exchange *exchange = compute_exchange(work);
    const struct srv_source *source = work->source;
    struct api_request request = {.op = exchange->op,
                                  .argument = exchange->argument,
                                  .query = exchange->query,
                                  .content_type = exchange->field[SRV_CONTENT_TYPE],
                                  .accept = exchange->field[SRV_ACCEPT],
                                  .body = exchange->body.bytes ? exchange->body.data : NULL,
                                  .body_bytes = exchange->body.bytes};
    if (source) {
        request.content_type = "application/json";
        request.body = source->body;
        request.body_bytes = source->body_bytes;
        request.argument = NULL;
    }
    return request;
}

/* Applies the Range field. Returns 1 if the response is then complete. */
static int compute_range(struct srv_work *work) {
    if (!work->source || !work->source->ranged) return 0;
    api_call_length(work->call, srv_lengths_find(&work->service->lengths, work->etag));
    if (api_call_range(work->call, work->source->range, &work->out) != API_DONE) return 0;
    srv_delivery_settle(work);
    return 1;
}

/* A stream is never in memory as a whole, so max-answer-bytes limits neither it nor its buffers. */
static void compute_flow(struct srv_work *work) {
    struct api_buffer *const buffer[] = {&work->out, &work->coded, &work->ready};
    for (size_t i = 0; i < sizeof buffer / sizeof *buffer; i++)
        if (buffer[i]->limit < API_CALL_STREAM) buffer[i]->limit = API_CALL_STREAM;
}

/* The first turn of a computation. Returns 1 if the computation must return to the queue. */
static int compute_open(struct srv_work *work) {
    struct srv_queue *queue = work->service->queue;
    int reader = work->task.level == SRV_QUEUE_READ;
    const struct api_request request = compute_request(work);
    if (!compute_read_room(work, request.body_bytes)) return 0;
    if (api_call_new(&work->call, work->limits) != PEND_OK) {
        srv_delivery_fail(work, "out of memory");
        return 0;
    }
    srv_buffer_pool_take(&work->service->pool, &work->out);
    api_call_clock(work->call, srv_clock_seconds, NULL);
    api_call_hurry(work->call, compute_hurry, work);
    enum api_progress read =
        work->source ? api_call_results(work->call, &request, &work->source->from, &work->out)
                     : api_call_open(work->call, &request, &work->out);
    if (read == API_DONE) {
        srv_delivery_settle(work);
        return 0;
    }
    if (api_call_streams(work->call)) compute_flow(work);
    if (compute_spared(work) || compute_range(work)) return 0;
    work->cost = api_call_cost(work->call);
    if (compute_too_long(work)) return 0;
    compute_foresee(work);
    if (!compute_room(work)) return 0;
    work->task.level = compute_level_of(work, work->cost);
    int wait = work->task.level && srv_queue_shorter(queue, SRV_QUEUE_LEVELS);
    return reader || wait || compute_turn(work);
}

static int compute_first(struct srv_work *work, int64_t now) {
    double limit = srv_service_config(work->service)->wait_seconds;
    assert(!work->call && !work->promised && now >= work->queued);
    work->begun = now;
    if (now - work->queued <= srv_clock_span(limit)) return compute_open(work);
    srv_metrics_count(&work->service->metrics.refused_wait, 1);
    srv_delivery_fail(work, "no worker became free within max-wait-seconds");
    return 0;
}

static int compute_run(struct srv_task *task) {
    struct srv_work *work = SRV_CONTAINER_OF(task, struct srv_work, task);
    struct srv_service *service = work->service;
    assert(work->account && service);
    int64_t begin = srv_clock_now();
    atomic_fetch_add(&service->busy, 1);
    int again = work->begun ? compute_turn(work) : compute_first(work, begin);
    atomic_fetch_sub(&service->busy, 1);
    srv_metrics_count(&service->metrics.busy_ns, (unsigned long long)(srv_clock_now() - begin));
    return again;
}

/* --- in and out --- */

static void compute_refuse(struct srv_work *work, enum pend_status status) {
    struct srv_service *service = work->service;
    struct srv_list taken = {0};
    int road_full = work->task.road_full;
    srv_inflight_take(work, &taken);
    struct srv_exchange *exchange = srv_inflight_next(&taken);
    srv_inflight_end(work);
    srv_delivery_done(service);
    srv_exchange_queued_out(exchange, status, road_full);
    exchange->finish(exchange);
}

static void compute_push(struct srv_exchange *exchange) {
    struct srv_service *service = exchange->service;
    struct srv_work *work = srv_inflight_begin(exchange);
    if (!work) {
        srv_exchange_busy(exchange, 1, "out of memory");
        exchange->finish(exchange);
        return;
    }
    work->task.run = compute_run;
    size_t bytes = work->source ? work->source->body_bytes : exchange->body.bytes;
    work->task.level = bytes > COMPUTE_LONG_BODY ? SRV_QUEUE_READ : 0;
    work->queued = srv_clock_now();
    atomic_fetch_add(&service->computing, 1);
    enum pend_status status = srv_queue_push(service->queue, &work->task);
    if (status != PEND_OK) compute_refuse(work, status);
}

void srv_compute_begin(struct srv_exchange *exchange) {
    assert(srv_exchange_valid(exchange) && exchange->account);
    exchange->queued = srv_clock_now();
    compute_push(exchange);
}

void srv_compute_leave(struct srv_exchange *exchange, enum srv_stop why) {
    struct srv_service *service = exchange->service;
    int detached, over;
    struct srv_work *gone = srv_inflight_leave(exchange, why, &detached);
    if (gone) {
        over = gone->over;
        if (!over) srv_metrics_count(&service->metrics.cancelled, why == SRV_STOP_LEFT);
        srv_inflight_end(gone);
        if (!over) srv_delivery_done(service);
    }
    if (!detached) return;
    if (!exchange->streams) {
        srv_exchange_busy(exchange, 1, compute_reason(why));
        exchange->close = 1;
    }
    exchange->finish(exchange);
}
