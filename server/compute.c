#include "server/compute.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

#include "server/clock.h"
#include "server/flights.h"

enum {
    COMPUTE_HOLD = 1 << 20,       /* bytes of an answer that may stream are held, so that it can be shared and kept */
    COMPUTE_LONG_BODY = 1 << 18,  /* bytes of a body that takes a while to read */
    COMPUTE_MOST_CODED = 1 << 30, /* bytes of an answer that is compressed whole */
    COMPUTE_REFUSE_COST = 3       /* times max-compute-seconds: an estimate may be wrong by this factor */
};

static const double compute_patience = 0.05; /* s of computation after which a stream begins, however little there is */

/* s of computation from which on it belongs to the next level of the queue */
static const double compute_level[SRV_QUEUE_LEVELS - 1] = {0.003, 0.05, 1};

static int compute_level_of(double seconds) {
    int level = 0;
    while (level < SRV_QUEUE_LEVELS - 1 && seconds >= compute_level[level]) level++;
    return level;
}

/* why a computation is not to go on, as an answer that nobody or somebody reads */
static const char *compute_reason(enum srv_stop why) {
    return why == SRV_STOP_LEFT ? "the client went away" : "the server is stopping";
}

static double compute_seconds(const struct srv_work *work) { return 1e-9 * (double)work->spent; }

/* --- keys of the cache --- */

/* the bytes of a request that make its answer, as a key: written behind its body; returns its length, 0 without memory
 */
static size_t compute_exact_key(struct srv_exchange *exchange, const char **key) {
    struct api_buffer *body = &exchange->body;
    size_t bytes = body->bytes;
    const char *part[] = {exchange->path, exchange->field[SRV_ACCEPT], exchange->field[SRV_CONTENT_TYPE]};
    enum pend_status status = PEND_OK;
    for (size_t i = 0; i < sizeof part / sizeof *part && status == PEND_OK; i++)
        status = api_buffer_add(body, part[i] ? part[i] : "", part[i] ? strlen(part[i]) + 1 : 1);
    if (status == PEND_OK) status = api_buffer_add(body, &(char){(char)('0' + exchange->coding)}, 1);
    size_t all = body->bytes;
    body->bytes = bytes;
    *key = body->data;
    return status == PEND_OK ? all : 0;
}

/* such an exchange is never answered from the exact bytes */
static int compute_unkeyed(const struct srv_exchange *exchange) {
    return !srv_cache_on(exchange->service->cache) || exchange->apart || exchange->body.bytes > SRV_CACHE_KEY ||
           exchange->query;
}

/* an exchange is answered by a payload */
static void compute_give(struct srv_exchange *exchange, struct srv_payload *payload, const char *cache) {
    exchange->cache = cache;
    srv_exchange_payload(exchange, payload);
    if (payload->status != 200 || !srv_exchange_matches(exchange, payload->etag)) return;
    /* with the length of the answer that it stands for, which is not sent */
    exchange->status = 304;
    srv_metrics_count(&exchange->service->metrics.not_modified, 1);
}

int srv_compute_cached(struct srv_exchange *exchange) {
    const char *key;
    if (compute_unkeyed(exchange)) return 0;
    size_t bytes = compute_exact_key(exchange, &key);
    struct srv_payload *payload = bytes ? srv_cache_find(exchange->service->cache, key, bytes) : NULL;
    if (!payload) return 0;
    srv_metrics_count(&exchange->service->metrics.cache_exact, 1);
    compute_give(exchange, payload, "exact");
    srv_payload_drop(&payload);
    return 1;
}

static void compute_remember(struct srv_exchange *exchange, struct srv_payload *payload) {
    const char *key;
    if (payload->status != 200 || compute_unkeyed(exchange)) return;
    size_t bytes = compute_exact_key(exchange, &key);
    if (bytes) srv_cache_add(exchange->service->cache, key, bytes, payload);
}

/* --- payloads --- */

/* compresses what is in out where that is worth it; returns the coding that it has then */
static enum srv_coding compute_code(struct srv_work *work, const char *media_type) {
    double least = work->service->config.compress_above;
    if (!work->coding || least <= 0 || (double)work->out.bytes < least || work->out.bytes > COMPUTE_MOST_CODED ||
        !srv_coding_worth(media_type))
        return SRV_IDENTITY;
    work->coded.bytes = 0;
    srv_spares_take(&work->service->spares, &work->coded);
    if (srv_coding_whole(work->coding, work->out.data, work->out.bytes, &work->coded) != PEND_OK ||
        work->coded.bytes >= work->out.bytes)
        return SRV_IDENTITY;
    struct api_buffer plain = work->out;
    work->out = work->coded;
    work->coded = plain;
    return work->coding;
}

/* Content-Range; 0 where an answer has none */
static int compute_range(const struct api_answer *answer, char text[], size_t cap) {
    if (answer->status == 206)
        snprintf(text, cap, "bytes %lld-%lld/%lld", answer->first, answer->first + answer->length - 1, answer->total);
    else
        snprintf(text, cap, "bytes */%lld", answer->total);
    return answer->status == 206 || answer->status == 416;
}

/* the head of the answer as a payload; its body is what is in `body` */
static struct srv_payload *compute_payload(struct srv_work *work, struct api_answer answer, enum srv_coding coding,
                                           struct api_buffer *body) {
    char disposition[128], range[96];
    const char *columns = answer.columns, *file = answer.file_name;
    if (file) snprintf(disposition, sizeof disposition, "inline; filename=\"%.80s\"", file);
    size_t text = 352 + SRV_ETAG_BYTES + (columns ? strlen(columns) + 1 : 0);
    struct srv_service *service = work->service;
    struct srv_payload *made =
        srv_payload_new(answer.status, answer.media_type, body, text, &service->held, &service->spares);
    if (!made) return NULL;
    made->steps = api_call_steps(work->call);
    if (answer.status >= 400) srv_payload_header(made, "Cache-Control", "no-store");
    srv_payload_header(made, "Vary", srv_exchange_vary);
    if (answer.status < 400 && work->etag[0]) {
        /* a coding may compress differently another time */
        snprintf(made->etag, sizeof made->etag, "%s%.70s", coding && work->source ? "W/" : "", work->etag);
        srv_payload_header(made, "ETag", made->etag);
    }
    if (answer.status < 400 && work->source) srv_payload_header(made, "Accept-Ranges", "bytes");
    if (compute_range(&answer, range, sizeof range)) srv_payload_header(made, "Content-Range", range);
    if (columns) srv_payload_header(made, "X-Columns", columns);
    if (file) srv_payload_header(made, "Content-Disposition", disposition);
    if (coding) srv_payload_header(made, "Content-Encoding", srv_coding_at(coding)->name);
    return made;
}

/* --- the end of a work --- */

static void compute_done(struct srv_service *service) { atomic_fetch_sub(&service->computing, 1); }

/* lets everybody go who waits for a work, and ends it */
static void compute_release(struct srv_work *work, struct srv_payload *payload, const char *cache, int status,
                            const char *detail) {
    struct srv_service *service = work->service;
    for (struct srv_exchange *next, *exchange = srv_flights_take(work); exchange; exchange = next) {
        next = exchange->next_beside;
        exchange->waited = work->begun > exchange->queued ? work->begun - exchange->queued : 0;
        exchange->computed = work->spent;
        if (payload) {
            compute_give(exchange, payload, next ? "joined" : cache);
            compute_remember(exchange, payload);
        } else if (status == 304) {
            srv_exchange_not_modified(exchange, work->etag);
        } else {
            srv_exchange_busy(exchange, 1, detail);
        }
        exchange->finish(exchange);
    }
    srv_flights_end(work);
    compute_done(service);
}

static void compute_fail(struct srv_work *work, const char *detail) { compute_release(work, NULL, NULL, 503, detail); }

/* the answer is complete: in out */
static void compute_settle(struct srv_work *work) {
    struct srv_service *service = work->service;
    struct api_answer answer = api_call_answer(work->call);
    if (answer.status == 200 && work->key_bytes) srv_metrics_count(&service->metrics.cache_missed, 1);
    enum srv_coding coding = compute_code(work, answer.media_type);
    struct srv_payload *payload = compute_payload(work, answer, coding, &work->out);
    if (!payload) {
        compute_fail(work, "out of memory");
    } else if (!srv_service_room(service)) {
        srv_metrics_count(&service->metrics.refused_held, 1);
        srv_payload_drop(&payload);
        compute_fail(work, "the answers that are being sent leave no memory: max-held-bytes");
    } else {
        if (payload->status == 200 && work->key_bytes)
            srv_cache_add(service->cache, work->key, work->key_bytes, payload);
        compute_release(work, payload, NULL, 0, NULL);
    }
    srv_payload_drop(&payload);
}

/* --- streams --- */

static void compute_push(struct srv_exchange *exchange);

/* those who waited with the one that has become the reader of a stream compute for themselves */
static void compute_apart(struct srv_exchange *others) {
    for (struct srv_exchange *next, *exchange = others; exchange; exchange = next) {
        next = exchange->next_beside;
        compute_push(exchange);
    }
}

static void compute_hold(struct srv_work *work) {
    size_t bytes = work->out.cap + work->coded.cap + SRV_FLIGHT_BLOCK;
    atomic_fetch_add(&work->service->held, (long long)bytes - (long long)work->held);
    work->held = bytes;
}

/* hands over what was appended; 1 when the worker goes on with it */
static int compute_pass(struct srv_work *work, int ended) {
    struct srv_service *service = work->service;
    int over = 0;
    compute_hold(work);
    if (work->coder) {
        enum srv_coding_end how = ended                      ? SRV_CODING_END
                                  : srv_flights_hungry(work) ? SRV_CODING_FLUSH
                                                             : SRV_CODING_MORE;
        const struct srv_coding_row *row = srv_coding_at(work->coding);
        if (row->write(work->coder, work->out.data, work->out.bytes, how, &work->coded) != PEND_OK) ended = -1;
        work->out.bytes = 0;
    }
    if (ended < 0 && !srv_flights_stop(work)) srv_metrics_count(&service->metrics.broken, 1);
    int go_on = srv_flights_pass(work, ended, &over);
    if (over) compute_done(service);
    return go_on;
}

/* from now on what is computed is sent; without memory it is not */
static void compute_promise(struct srv_work *work) {
    struct api_answer answer = api_call_answer(work->call);
    struct api_buffer none;
    const struct srv_coding_row *row = srv_coding_at(work->coding);
    int coded = row && work->service->config.compress_above > 0 && srv_coding_worth(answer.media_type);
    api_buffer_init(&none, 0);
    if (coded && !(work->coder = row->begin())) return;
    struct srv_payload *head = compute_payload(work, answer, coded ? work->coding : SRV_IDENTITY, &none);
    if (!head) return;
    struct srv_exchange *others, *reader = srv_flights_stream(work, &others);
    work->promised = reader != NULL;
    if (reader) {
        srv_exchange_payload(reader, head);
        reader->stream_bytes = coded ? -1 : answer.length;
        reader->waited = work->begun - reader->queued;
        api_call_promise(work->call);
        reader->finish(reader);
    }
    srv_payload_drop(&head);
    compute_apart(others);
}

/* is it time to begin sending? */
static int compute_ripe(struct srv_work *work) {
    int much = work->out.bytes >= COMPUTE_HOLD;
    if (!api_call_streams(work->call)) return 0;
    return much || (work->out.bytes && compute_seconds(work) >= compute_patience && srv_flights_waiters(work) == 1);
}

/* --- turns on a worker --- */

/* ends a computation early; the bytes of a promised answer are sent, and then the connection is cut */
static void compute_stop(struct srv_work *work, const char *detail) {
    enum api_progress progress = api_call_stop(work->call, 503, detail, &work->out);
    if (progress == API_BROKEN)
        (void)compute_pass(work, -1);
    else
        compute_settle(work);
}

/* a reason to end it early; 0 where there is none */
static int compute_over(struct srv_work *work) {
    struct srv_metrics *metrics = &work->service->metrics;
    double limit = work->limits->compute_seconds;
    enum srv_stop why = srv_flights_stop(work);
    char detail[96];
    if (why) {
        srv_metrics_count(&metrics->cancelled, why == SRV_STOP_LEFT);
        compute_stop(work, compute_reason(why));
        return 1;
    }
    if (compute_seconds(work) <= limit) return 0;
    srv_metrics_count(&metrics->overtime, 1);
    snprintf(detail, sizeof detail, "the computation took longer than max-compute-seconds allows: %.15g s", limit);
    compute_stop(work, detail);
    return 1;
}

/* one piece of work; returns 1 when the worker still has it and it is to go on */
static int compute_piece(struct srv_work *work) {
    int64_t begin = srv_clock_now();
    enum api_progress progress = api_call_run(work->call, &work->out);
    work->spent += srv_clock_now() - begin;
    int ended = progress == API_DONE ? 1 : progress == API_BROKEN ? -1 : 0;
    if (!work->promised && !ended && compute_ripe(work)) compute_promise(work);
    if (work->promised) return compute_pass(work, ended);
    if (!ended) return 1;
    compute_settle(work);
    return 0;
}

/* the worker goes on with it unless somebody waits: then it goes to the end of its client's lane */
static void compute_turn(struct srv_work *work) {
    struct srv_queue *queue = work->service->queue;
    srv_metrics_count(&work->service->metrics.slices, 1);
    while (!compute_over(work)) {
        if (!compute_piece(work)) return;
        if (!srv_queue_count(queue)) continue;
        double seconds = compute_seconds(work);
        work->task.level = compute_level_of(seconds > work->cost ? seconds : work->cost);
        srv_queue_again(queue, &work->task);
        return;
    }
}

/* between two pieces of a computation: does a shorter one wait? */
static int compute_hurry(void *company) {
    struct srv_work *work = company;
    srv_intake_look(&work->service->intake);
    for (int level = 0; level < work->task.level; level++)
        if (srv_queue_waiting(work->service->queue, level)) return 1;
    return 0;
}

/* --- the first turn: reading the request --- */

/* what tells the answer from others, as the cache knows it, of that coding */
static void compute_key(struct srv_work *work, enum srv_coding coding) {
    const char *digest = api_call_etag(work->call);
    work->etag[0] = 0;
    work->key_bytes = 0;
    if (!digest) return;
    /* what a job has found out comes the same to the byte, even compute_seconds */
    snprintf(work->etag, sizeof work->etag, "%s\"%.64s\"", work->source ? "" : "W/", digest);
    work->key_bytes = (size_t)snprintf(work->key, sizeof work->key, "%.64s %d", digest, coding);
}

/* the answer in the cache, compressed now if it is there only as it is; NULL if it is not there */
static struct srv_payload *compute_find(struct srv_work *work) {
    struct srv_cache *cache = work->service->cache;
    struct srv_payload *found = srv_cache_find(cache, work->key, work->key_bytes);
    if (found || !work->coding) return found;
    compute_key(work, SRV_IDENTITY);
    found = srv_cache_find(cache, work->key, work->key_bytes);
    compute_key(work, work->coding);
    if (!found || api_buffer_add(&work->out, found->body.data, found->body.bytes) != PEND_OK) return found;
    enum srv_coding coding = compute_code(work, found->media_type);
    struct srv_payload *coded = coding ? compute_payload(work, api_call_answer(work->call), coding, &work->out) : NULL;
    work->out.bytes = 0;
    if (!coded) return found;
    srv_cache_add(cache, work->key, work->key_bytes, coded);
    srv_payload_drop(&found);
    return coded;
}

/* does If-Range, where there is one, name this very answer? A date names none: answers have no dates */
static int compute_range_holds(const struct srv_exchange *exchange, const char *etag) {
    const char *known = exchange->field[SRV_IF_RANGE];
    return !known || !strcmp(known, etag);
}

/* answers a request that was read and needs no computation: it is in the client's memory, in the cache, or computed
 * already by another; returns 1 when it is */
static int compute_spared(struct srv_work *work) {
    struct srv_service *service = work->service;
    struct srv_exchange *exchange = work->waiters;
    compute_key(work, work->coding);
    /* what lies somewhere already is not what others have computed, to the byte */
    struct srv_payload *found = work->source ? NULL : compute_find(work);
    if (found) {
        srv_metrics_count(&service->metrics.cache_digest, 1);
        compute_release(work, found, "digest", 0, NULL);
        srv_payload_drop(&found);
        return 1;
    }
    if (srv_exchange_matches(exchange, work->etag)) {
        compute_release(work, NULL, NULL, 304, NULL);
        return 1;
    }
    /* what lies somewhere already is not joined: it may cease to, which is nobody else's concern */
    if (work->source) {
        work->key_bytes = 0;
        work->source->ranged = work->source->ranged && compute_range_holds(exchange, work->etag);
    }
    if (!srv_flights_opened(work)) return 0;
    srv_metrics_count(&service->metrics.cache_joined, 1);
    srv_flights_end(work);
    compute_done(service);
    return 1;
}

/* a computation that is sure to outrun its limit is not begun */
static int compute_too_long(struct srv_work *work) {
    char detail[160];
    double limit = work->limits->compute_seconds;
    if (work->cost <= COMPUTE_REFUSE_COST * limit) return 0;
    snprintf(detail, sizeof detail,
             "this would compute for about %.0f s, longer than max-compute-seconds allows: %.15g s", work->cost, limit);
    (void)api_call_stop(work->call, 422, detail, &work->out);
    compute_settle(work);
    return 1;
}

static void compute_open(struct srv_work *work) {
    struct srv_exchange *exchange = work->waiters;
    struct srv_queue *queue = work->service->queue;
    struct api_request request = {.op = exchange->op,
                                  .argument = exchange->argument,
                                  .query = exchange->query,
                                  .content_type = exchange->field[SRV_CONTENT_TYPE],
                                  .accept = exchange->field[SRV_ACCEPT],
                                  .body = exchange->body.bytes ? exchange->body.data : NULL,
                                  .body_bytes = exchange->body.bytes};
    struct srv_source *source = work->source;
    if (source) {
        request.content_type = "application/json";
        request.body = source->body;
        request.body_bytes = source->body_bytes;
        request.argument = NULL;
    }
    if (api_call_new(&work->call, work->limits) != PEND_OK) {
        compute_fail(work, "out of memory");
        return;
    }
    srv_spares_take(&work->service->spares, &work->out);
    api_call_clock(work->call, srv_clock_seconds, NULL);
    api_call_hurry(work->call, compute_hurry, work);
    enum api_progress progress = source ? api_call_results(work->call, &request, &source->from, &work->out)
                                        : api_call_open(work->call, &request, &work->out);
    if (progress == API_DONE) {
        compute_settle(work);
        return;
    }
    if (compute_spared(work)) return;
    if (source && source->ranged) {
        if (api_call_range(work->call, source->range, &work->out) == API_DONE) {
            compute_settle(work);
            return;
        }
    }
    work->cost = api_call_cost(work->call);
    if (compute_too_long(work)) return;
    work->task.level = compute_level_of(work->cost);
    if (work->task.level && srv_queue_count(queue))
        srv_queue_again(queue, &work->task);
    else
        compute_turn(work);
}

static void compute_first(struct srv_work *work, int64_t now) {
    double limit = work->service->config.wait_seconds;
    work->begun = now;
    if (now - work->queued <= srv_clock_span(limit)) {
        compute_open(work);
        return;
    }
    srv_metrics_count(&work->service->metrics.refused_wait, 1);
    compute_fail(work, "no worker was free for longer than max-wait-seconds");
}

static void compute_run(struct srv_task *task) {
    struct srv_work *work = (struct srv_work *)task;
    struct srv_service *service = work->service;
    int64_t begin = srv_clock_now();
    atomic_fetch_add(&service->busy, 1);
    if (work->begun)
        compute_turn(work);
    else
        compute_first(work, begin);
    atomic_fetch_sub(&service->busy, 1);
    srv_metrics_count(&service->metrics.busy_ns, (unsigned long long)(srv_clock_now() - begin));
}

/* --- in and out --- */

/* a work that was not begun for want of room */
static void compute_refuse(struct srv_work *work, enum pend_status status) {
    struct srv_metrics *metrics = &work->service->metrics;
    struct srv_service *service = work->service;
    struct srv_exchange *exchange = srv_flights_take(work);
    srv_flights_end(work);
    compute_done(service);
    if (status == PEND_LIMIT) {
        srv_metrics_count(&metrics->refused_queue, 1);
        srv_exchange_busy(exchange, 1, "every worker is busy and the queue is full: max-queue");
    } else {
        srv_metrics_count(&metrics->refused_client, 1);
        srv_exchange_problem(exchange, 429, "%.0f requests of yours wait for a worker: max-client-queue",
                             service->config.client_queue);
        srv_exchange_retry(exchange, 1);
    }
    exchange->finish(exchange);
}

static void compute_push(struct srv_exchange *exchange) {
    struct srv_service *service = exchange->service;
    struct srv_work *work = srv_flights_begin(exchange);
    if (!work) {
        srv_exchange_busy(exchange, 1, "out of memory");
        exchange->finish(exchange);
        return;
    }
    work->task.run = compute_run;
    work->task.level = exchange->body.bytes > COMPUTE_LONG_BODY;
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
    struct srv_work *gone = srv_flights_leave(exchange, why, &detached);
    if (gone) {
        over = gone->over;
        if (!over) srv_metrics_count(&service->metrics.cancelled, why == SRV_STOP_LEFT);
        srv_flights_end(gone);
        if (!over) compute_done(service);
    }
    if (!detached) return;
    if (!exchange->streams) {
        srv_exchange_busy(exchange, 1, compute_reason(why));
        exchange->close = 1;
    }
    exchange->finish(exchange);
}
