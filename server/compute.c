#include "server/compute.h"

#include <assert.h>
#include <stdio.h>

#include "api/call.h"
#include "server/clock.h"
#include "server/router.h"

/* why the computation is not to go on, as an answer that nobody or somebody reads */
static const char *compute_reason(enum srv_stop why) {
    return why == SRV_STOP_LEFT ? "the client went away" : "the server is stopping";
}

static void compute_finish(struct srv_exchange *exchange) {
    if (exchange->begun) exchange->computed = srv_clock_now();
    if (!srv_exchange_hold(exchange, exchange->body.cap + exchange->answer.cap)) {
        api_buffer_clear(&exchange->answer);
        srv_exchange_busy(exchange, 1, "the answers that are being sent leave no memory: max-held-bytes");
    }
    struct srv_service *service = exchange->service;
    exchange->finish(exchange);
    atomic_fetch_sub(&service->computing, 1);
}

/* a piece after the other until it is done, stopped, or over time */
static void compute_pieces(struct srv_exchange *exchange, struct api_call *call, enum api_progress progress) {
    double limit = exchange->service->config.limits.compute_seconds;
    int64_t deadline = exchange->begun + srv_clock_span(limit);
    while (progress == API_MORE) {
        enum srv_stop why = atomic_load(&exchange->stop);
        if (why != SRV_GO_ON) {
            (void)api_call_stop(call, 503, compute_reason(why), &exchange->answer);
            exchange->close = 1;
            break;
        }
        if (srv_clock_now() > deadline) {
            char detail[96];
            snprintf(detail, sizeof detail, "the computation took longer than max-compute-seconds allows: %.15g s",
                     limit);
            (void)api_call_stop(call, 503, detail, &exchange->answer);
            break;
        }
        progress = api_call_run(call, &exchange->answer);
    }
}

static void compute_call(struct srv_exchange *exchange, struct api_call *call) {
    struct api_request request = {.op = exchange->route->op,
                                  .argument = exchange->argument,
                                  .query = exchange->query,
                                  .content_type = exchange->field[SRV_CONTENT_TYPE],
                                  .accept = exchange->field[SRV_ACCEPT],
                                  .body = exchange->body.bytes ? exchange->body.data : NULL,
                                  .body_bytes = exchange->body.bytes};
    srv_spares_take(&exchange->service->spares, &exchange->answer);
    api_call_clock(call, srv_clock_seconds, NULL);
    compute_pieces(exchange, call, api_call_open(call, &request, &exchange->answer));
    struct api_answer answer = api_call_answer(call);
    exchange->steps = api_call_steps(call);
    srv_exchange_answered(exchange, answer.status, answer.media_type);
}

static void compute_run(struct srv_task *task) {
    struct srv_exchange *exchange = (struct srv_exchange *)task;
    struct api_call *call = NULL;
    assert(srv_exchange_valid(exchange));
    exchange->begun = srv_clock_now();
    if (api_call_new(&call, &exchange->service->config.limits) == PEND_OK)
        compute_call(exchange, call);
    else
        srv_exchange_busy(exchange, 1, "out of memory");
    api_call_free(&call);
    compute_finish(exchange);
}

void srv_compute_queue(struct srv_exchange *exchange) {
    assert(srv_exchange_valid(exchange) && exchange->route && !exchange->route->handle);
    exchange->task.run = compute_run;
    exchange->queued = srv_clock_now();
    atomic_fetch_add(&exchange->service->computing, 1);
    if (srv_queue_push(exchange->service->queue, &exchange->task) == PEND_OK) return;
    srv_exchange_busy(exchange, 1, "every worker is busy and the queue is full: max-queue");
    compute_finish(exchange);
}

void srv_compute_stop(struct srv_exchange *exchange, enum srv_stop why) {
    atomic_store(&exchange->stop, why);
    if (!srv_queue_remove(exchange->service->queue, &exchange->task)) return;
    srv_exchange_busy(exchange, 1, compute_reason(why));
    exchange->close = 1;
    compute_finish(exchange);
}
