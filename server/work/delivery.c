#include "server/work/delivery.h"

#include "server/work/result.h"

enum {
    DELIVERY_SHARE = 1 << 23 /* maximum bytes of a response that are held while several exchanges
                              * wait for it, or if it is nearly complete */
};

/* patience: seconds of computation after which a stream starts, whatever its size; soon: a response
 * that needs at most this many more seconds is sent complete */
static const double delivery_patience = 0.05, delivery_soon = 0.25;

double srv_delivery_seconds(const struct srv_work *work) { return 1e-9 * (double)work->spent; }

size_t srv_delivery_bytes(const struct srv_work *work) {
    const struct srv_coding_row *row = srv_coding_at(work->coding);
    size_t buffers = work->out.cap + work->coded.cap + work->ready_cap;
    size_t call = work->call ? srv_hold_count(api_call_bytes(work->call)) : 0;
    if (call > 0 && buffers < work->foreseen) buffers = work->foreseen;
    return call + buffers + (work->coder ? row->bytes : 0) +
           (work->source ? work->source->body_bytes : 0);
}

static void delivery_hold(struct srv_work *work) {
    srv_hold_set(&work->hold, srv_delivery_bytes(work));
}

/* --- the end of a computation --- */

void srv_delivery_done(struct srv_service *service) { atomic_fetch_sub(&service->computing, 1); }

void srv_delivery_release(struct srv_work *work, struct srv_response_body *response_body,
                          const char *cache, int status, const char *detail) {
    struct srv_service *service = work->service;
    struct srv_list taken = {0};
    struct srv_exchange *exchange;
    srv_inflight_take(work, &taken);
    for (const char *how = cache; (exchange = srv_inflight_next(&taken)); how = "joined") {
        exchange->waited = work->begun > exchange->queued ? work->begun - exchange->queued : 0;
        exchange->computed = work->spent;
        if (response_body) {
            srv_result_give(exchange, response_body, how);
            srv_result_remember(exchange, response_body);
        } else if (status == 304) {
            srv_exchange_not_modified(exchange, work->etag);
        } else {
            srv_exchange_busy(exchange, 1, detail);
        }
        exchange->finish(exchange);
    }
    srv_inflight_end(work);
    srv_delivery_done(service);
}

void srv_delivery_fail(struct srv_work *work, const char *detail) {
    srv_delivery_release(work, NULL, NULL, 503, detail);
}

void srv_delivery_settle(struct srv_work *work) {
    struct srv_service *service = work->service;
    struct api_answer answer = api_call_answer(work->call);
    assert(!work->promised);
    if (answer.status == 200 && work->key_bytes)
        srv_metrics_count(&service->metrics.cache_missed, 1);
    enum srv_coding coding = srv_result_code(work, answer.media_type);
    struct srv_response_body *response_body =
        srv_result_response_body(work, answer, coding, &work->out);
    delivery_hold(work); /* From here on the response body accounts for the memory. */
    if (!response_body) {
        srv_delivery_fail(work, "out of memory");
    } else if (response_body->status == 200 && !srv_hold_room(service)) {
        srv_metrics_count(&service->metrics.refused_held, 1);
        srv_response_body_drop(&response_body);
        srv_delivery_fail(
            work, "no memory is left, because other answers are being sent: max-held-bytes");
    } else {
        if (response_body->status == 200 && work->key_bytes)
            srv_cache_add(service->cache, work->key, work->key_bytes, response_body);
        srv_delivery_release(work, response_body, NULL, 0, NULL);
    }
    srv_response_body_drop(&response_body);
}

/* --- streams --- */

int srv_delivery_pass(struct srv_work *work, int ended) {
    struct srv_service *service = work->service;
    int over = 0;
    assert(work->promised && (ended == 0 || ended == 1 || ended == -1));
    if (work->coder) {
        enum srv_coding_end how = ended                       ? SRV_CODING_END
                                  : srv_inflight_hungry(work) ? SRV_CODING_FLUSH
                                                              : SRV_CODING_MORE;
        const struct srv_coding_row *row = srv_coding_at(work->coding);
        if (row->write(work->coder, work->out.data, work->out.bytes, how, &work->coded) != PEND_OK)
            ended = -1;
        work->out.bytes = 0;
    }
    if (ended < 0 && !srv_inflight_stop(work)) srv_metrics_count(&service->metrics.broken, 1);
    delivery_hold(work);
    int go_on = srv_inflight_pass(work, ended, &over);
    if (over) srv_delivery_done(service);
    return go_on;
}

static void delivery_begin(struct srv_work *work, struct srv_exchange *reader,
                           struct srv_response_body *head, const struct api_answer *answer,
                           int coded) {
    srv_exchange_response_body(reader, head);
    /* A message of known length has no trailers, so the statistics go before the body. Ranges are
     * the exception, because a client needs their length. */
    reader->trails = answer->has_stat_fields &&
                     (answer->length < 0 || coded || !work->source || !work->source->ranged);
    reader->stream_bytes = coded || reader->trails ? -1 : answer->length;
    reader->waited = work->begun - reader->queued;
    api_call_promise(work->call);
    work->foreseen = 2 * SRV_INFLIGHT_BLOCK;
    if (work->out.cap > SRV_DELIVERY_HOLD) api_buffer_trim(&work->out);
    reader->finish(reader);
}

void srv_delivery_promise(struct srv_work *work, struct srv_list *others) {
    struct api_answer answer = api_call_answer(work->call);
    struct api_buffer none;
    const struct srv_coding_row *row = srv_coding_at(work->coding);
    int coded = row && srv_service_config(work->service)->compress_above > 0 &&
                srv_coding_worth(answer.media_type);
    api_buffer_init(&none, 0);
    assert(!work->promised && !work->coder);
    if (coded && !(work->coder = row->begin())) return;
    struct srv_response_body *head =
        srv_result_response_body(work, answer, coded ? work->coding : SRV_IDENTITY, &none);
    if (!head) {
        /* The next piece tries again. */
        if (coded) row->free(work->coder);
        work->coder = NULL;
        return;
    }
    struct srv_exchange *reader = srv_inflight_stream(work, others);
    work->promised = reader != NULL;
    if (reader) delivery_begin(work, reader, head, &answer, coded);
    srv_response_body_drop(&head);
}

/* Returns 1 if a response above SRV_DELIVERY_HOLD should still be completed before it is sent:
 * complete, it can be shared and cached. A response that will be compressed is not held, because
 * compressing it in one go occupies a worker for long. */
static int delivery_whole(struct srv_work *work, int alone) {
    double seconds = srv_delivery_seconds(work);
    if (work->coding && srv_coding_worth(api_call_answer(work->call).media_type)) return 0;
    if (alone && (seconds > work->cost ? seconds : work->cost) >= delivery_soon) return 0;
    /* The buffer doubles when it is full. */
    size_t before = work->foreseen, next = 2 * work->out.cap + SRV_INFLIGHT_BLOCK;
    if (next <= before) return 1;
    work->foreseen = next;
    if (srv_hold_room(work->service) &&
        srv_hold_try(&work->hold, srv_delivery_bytes(work)) == SRV_ROOM)
        return 1;
    work->foreseen = before;
    return 0;
}

int srv_delivery_ripe(struct srv_work *work) {
    if (!api_call_streams(work->call) || !work->out.bytes) return 0;
    if (work->out.bytes < SRV_DELIVERY_HOLD && srv_delivery_seconds(work) < delivery_patience)
        return 0;
    int alone = srv_inflight_waiters(work) == 1;
    size_t most = delivery_whole(work, alone) ? DELIVERY_SHARE : SRV_DELIVERY_HOLD;
    return work->out.bytes >= most || (alone && most == SRV_DELIVERY_HOLD);
}
