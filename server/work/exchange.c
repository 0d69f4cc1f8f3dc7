#include "server/work/exchange.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum {
    EXCHANGE_MAGIC = 0x65786368,
    EXCHANGE_KEEP = 4096,     /* the largest buffer in bytes that a connection keeps */
    EXCHANGE_ANSWER = 1 << 16 /* own responses above this many bytes reserve memory */
};

const char srv_exchange_vary[] = "Accept, Accept-Encoding";

const char srv_exchange_accepts[] = "application/json";

static const char exchange_problem_type[] = "application/problem+json";
static const char exchange_no_memory[] =
    "{\"type\":\"about:blank\",\"title\":\"Service Unavailable\",\"status\":503,"
    "\"detail\":\"out of memory\"}";

void srv_exchange_init(struct srv_exchange *exchange, struct srv_service *service) {
    *exchange = (struct srv_exchange){.magic = EXCHANGE_MAGIC, .service = service};
    exchange->hold = (struct srv_hold){.service = service, .kind = SRV_MEMORY_BODIES};
    api_buffer_init(&exchange->body, (size_t)srv_service_config(service)->limits.body_bytes);
    api_buffer_init(&exchange->answer, (size_t)srv_service_config(service)->limits.answer_bytes);
}

struct srv_client *srv_exchange_payer(struct srv_exchange *exchange) {
    if (exchange->payer || !exchange->identity.source[0]) return exchange->payer;
    exchange->payer = srv_clients_take(exchange->service->clients, exchange->identity.source, NULL);
    double memory = exchange->identity.limits.value[SRV_LIMIT_MEMORY];
    /* Without a key file a client may hold as much as the options allow. */
    if (exchange->payer && exchange->identity.role != SRV_ROLE_NONE)
        atomic_store(&exchange->payer->share, isinf(memory) ? 0 : (long long)memory);
    return exchange->payer;
}

static void exchange_drop(struct srv_exchange *exchange) {
    if (!exchange->response_body) return;
    atomic_fetch_sub(&exchange->response_body->readers, 1);
    if (exchange->share) atomic_fetch_sub(&exchange->payer->held, (long long)exchange->share);
    exchange->share = 0;
    srv_response_body_drop(&exchange->response_body);
}

static void exchange_let_go(struct srv_exchange *exchange) {
    assert(!exchange->work && !exchange->stream && !exchange->listener);
    srv_hold_set(&exchange->hold, 0);
    exchange_drop(exchange);
    if (exchange->payer) srv_clients_give(exchange->service->clients, exchange->payer);
    exchange->payer = exchange->hold.payer = NULL;
    if (exchange->source) exchange->source->free(exchange->source);
    exchange->source = NULL;
    if (exchange->account) srv_clients_give(exchange->service->clients, exchange->account);
    exchange->account = NULL;
}

void srv_exchange_clear(struct srv_exchange *exchange) {
    exchange_let_go(exchange);
    api_buffer_clear(&exchange->body);
    api_buffer_clear(&exchange->answer);
    exchange->magic = 0;
}

static void exchange_empty(struct srv_exchange *exchange, struct api_buffer *buffer) {
    buffer->bytes = 0;
    if (buffer->cap > EXCHANGE_KEEP) srv_buffer_pool_give(&exchange->service->pool, buffer);
}

void srv_exchange_reset(struct srv_exchange *exchange) {
    assert(srv_exchange_valid(exchange));
    exchange_let_go(exchange);
    exchange_empty(exchange, &exchange->body);
    exchange_empty(exchange, &exchange->answer);
    exchange->body.limit = (size_t)srv_service_config(exchange->service)->limits.body_bytes;
    exchange->answer.limit = (size_t)srv_service_config(exchange->service)->limits.answer_bytes;
    exchange->stop = SRV_GO_ON;
    exchange->streams = exchange->apart = 0;
    atomic_store(&exchange->listens, 0);
    memset(exchange->field, 0, sizeof exchange->field);
    exchange->method = exchange->path = exchange->query = exchange->id = exchange->argument =
        exchange->trace = NULL;
    exchange->coding = SRV_IDENTITY;
    exchange->quota = (struct srv_quota){0};
    exchange->identity.shown[0] = exchange->identity.secret[0] = 0;
    exchange->closed = 0;
    exchange->host = NULL;
    exchange->route = NULL;
    exchange->length = 0;
    exchange->target[0] = 0;
    exchange->media_type = exchange->data = NULL;
    exchange->status = exchange->headers = exchange->close = 0;
    exchange->received = exchange->queued = exchange->sending = exchange->waited =
        exchange->computed = 0;
    exchange->steps = 0;
    exchange->cache = NULL;
    exchange->bytes = exchange->text_bytes = 0;
}

int srv_exchange_valid(const struct srv_exchange *exchange) {
    return exchange->magic == EXCHANGE_MAGIC && exchange->service &&
           exchange->headers <= SRV_HEADERS && exchange->text_bytes <= SRV_TEXT_BYTES &&
           (!exchange->bytes || exchange->data || exchange->streams) &&
           memchr(exchange->target, 0, SRV_TARGET_BYTES);
}

char *srv_exchange_text(struct srv_exchange *exchange, size_t bytes) {
    if (bytes > SRV_TEXT_BYTES - exchange->text_bytes) return NULL;
    char *text = exchange->text + exchange->text_bytes;
    exchange->text_bytes += bytes;
    return text;
}

void srv_exchange_header(struct srv_exchange *exchange, const char *name, const char *value) {
    assert(exchange->headers < SRV_HEADERS && name[0] && !strpbrk(value, "\r\n"));
    exchange->header[exchange->headers].name = name;
    exchange->header[exchange->headers++].value = value;
}

void srv_exchange_static(struct srv_exchange *exchange, int status, const char *media_type,
                         const char *data, size_t bytes) {
    assert(status >= 200 && status <= 599 && (data || !bytes));
    exchange->status = status;
    exchange->media_type = media_type;
    exchange->data = data;
    exchange->bytes = bytes;
}

void srv_exchange_answered(struct srv_exchange *exchange, int status, const char *media_type) {
    srv_exchange_static(exchange, status, media_type, exchange->answer.data,
                        exchange->answer.bytes);
    if (status >= 400) srv_exchange_header(exchange, "Cache-Control", "no-store");
    if (status == 415) srv_exchange_header(exchange, "Accept-Post", srv_exchange_accepts);
}

void srv_exchange_response_body(struct srv_exchange *exchange,
                                struct srv_response_body *response_body) {
    srv_exchange_static(exchange, response_body->status, response_body->media_type,
                        response_body->body.data, response_body->body.bytes);
    exchange_drop(exchange);
    exchange->response_body = srv_response_body_share(response_body);
    exchange->steps = response_body->steps;
    /* Exchanges with the same response share its memory. */
    int readers = 1 + atomic_fetch_add(&response_body->readers, 1);
    exchange->share = srv_exchange_payer(exchange) ? response_body->body.cap / (size_t)readers : 0;
    if (exchange->share) atomic_fetch_add(&exchange->payer->held, (long long)exchange->share);
}

int srv_exchange_safe(const struct srv_exchange *exchange) {
    static const char *const safe[] = {"GET", "HEAD", "QUERY"};
    for (size_t i = 0; exchange->method && i < sizeof safe / sizeof *safe; i++)
        if (!strcmp(exchange->method, safe[i])) return 1;
    return 0;
}

int srv_exchange_matches(const struct srv_exchange *exchange, const char *etag) {
    const char *at = exchange->field[SRV_IF_NONE_MATCH];
    if (!at || !*etag) return 0;
    /* The weak comparison of RFC 9110 8.8.3.2, which ignores W/. */
    size_t weak = strncmp(etag, "W/", 2) ? 0 : 2, bytes = strlen(etag + weak);
    for (; *at; at += strcspn(at, ","), at += *at == ',') {
        at += strspn(at, " \t");
        if (*at == '*') return 1;
        if (!strncmp(at, "W/", 2)) at += 2;
        if (!strncmp(at, etag + weak, bytes)) return 1;
    }
    return 0;
}

void srv_exchange_not_modified(struct srv_exchange *exchange, const char *etag) {
    char *text = srv_exchange_text(exchange, SRV_ETAG_BYTES);
    if (text) snprintf(text, SRV_ETAG_BYTES, "%s", etag);
    if (srv_exchange_safe(exchange)) {
        srv_exchange_static(exchange, 304, NULL, NULL, 0);
        srv_metrics_count(&exchange->service->metrics.not_modified, 1);
    } else {
        srv_exchange_problem(
            exchange, 412,
            "If-None-Match names the current answer of this request; use the method QUERY instead "
            "of %s to get 304, or send %s without this field to get the answer",
            exchange->method, exchange->method);
    }
    srv_exchange_header(exchange, "Vary", srv_exchange_vary);
    if (text) srv_exchange_header(exchange, "ETag", text);
}

void srv_exchange_problem(struct srv_exchange *exchange, int status, const char *format, ...) {
    struct api_problem problem;
    va_list arguments;
    assert(srv_exchange_valid(exchange) && status >= 400 && status <= 599);
    api_problem_init(&problem);
    va_start(arguments, format);
    api_problem_set_list(&problem, status, format, arguments);
    va_end(arguments);
    exchange->headers = 0;
    exchange->answer.bytes = 0;
    exchange_drop(exchange);
    enum pend_status written = api_problem_write(&problem, &exchange->answer);
    api_problem_clear(&problem);
    if (written == PEND_OK) {
        srv_exchange_answered(exchange, status, exchange_problem_type);
        return;
    }
    srv_exchange_static(exchange, 503, exchange_problem_type, exchange_no_memory,
                        sizeof exchange_no_memory - 1);
    srv_exchange_header(exchange, "Cache-Control", "no-store");
}

void srv_exchange_retry(struct srv_exchange *exchange, double seconds) {
    char *text = srv_exchange_text(exchange, 12);
    if (!text) return;
    snprintf(text, 12, "%.0f", ceil(seconds > 1 ? seconds : 1));
    srv_exchange_header(exchange, "Retry-After", text);
}

void srv_exchange_busy(struct srv_exchange *exchange, int seconds, const char *detail) {
    srv_exchange_problem(exchange, 503, "%s", detail);
    srv_exchange_retry(exchange, seconds);
}

enum srv_room srv_exchange_hold(struct srv_exchange *exchange, size_t bytes) {
    struct srv_hold *hold = &exchange->hold;
    if (bytes == hold->bytes) return SRV_ROOM;
    if (!hold->payer && !hold->bytes) hold->payer = srv_exchange_payer(exchange);
    enum srv_room room = srv_hold_try(hold, bytes);
    srv_hold_set(hold, bytes);
    return room;
}

void srv_exchange_crowded(struct srv_exchange *exchange, enum srv_room room, const char *what) {
    struct srv_metrics *metrics = &exchange->service->metrics;
    const struct srv_config *config = srv_service_config(exchange->service);
    assert(room != SRV_ROOM);
    double share = srv_hold_share_of(config, exchange->payer);
    if (room == SRV_ROOM_NONE) {
        srv_metrics_count(&metrics->refused_held, 1);
        srv_exchange_busy(exchange, 1, "no memory is left for this request: max-held-bytes");
        return;
    }
    srv_metrics_count(&metrics->refused_share, 1);
    if (room == SRV_ROOM_NEVER) {
        srv_exchange_problem(
            exchange, 413,
            API_TYPE_LIMIT
            "%s takes more memory than one client may hold: max-client-held-bytes, %.0f",
            what, share);
        return;
    }
    srv_exchange_problem(exchange, 429,
                         API_TYPE_QUOTA
                         "your other requests leave too little memory for %s: "
                         "max-client-held-bytes is %.0f; read or end those that are open",
                         what, share);
    srv_exchange_retry(exchange, 5);
}

void srv_exchange_queued_out(struct srv_exchange *exchange, enum pend_status status,
                             int road_full) {
    struct srv_metrics *metrics = &exchange->service->metrics;
    const struct srv_config *config = srv_service_config(exchange->service);
    assert(status == PEND_LIMIT || status == PEND_INVALID);
    if (status == PEND_LIMIT) {
        srv_metrics_count(&metrics->refused_queue, 1);
        srv_exchange_busy(exchange, 1, "every worker is busy and the queue is full: max-queue");
        return;
    }
    srv_metrics_count(&metrics->refused_client, 1);
    if (road_full)
        srv_exchange_problem(exchange, 429,
                             API_TYPE_RATE
                             "requests of your address fill three quarters of the queue: "
                             "max-queue is %.0f",
                             config->queue);
    else
        srv_exchange_problem(exchange, 429,
                             API_TYPE_RATE
                             "as many of your requests wait for a worker as max-client-queue "
                             "allows: %.0f",
                             config->client_queue);
    srv_exchange_retry(exchange, 1);
}

void srv_exchange_settle(struct srv_exchange *exchange) {
    assert(srv_exchange_valid(exchange) && exchange->status);
    size_t received = exchange->body.bytes;
    if (exchange->body.cap > EXCHANGE_KEEP) {
        exchange->body.bytes = 0;
        srv_buffer_pool_give(&exchange->service->pool, &exchange->body);
        exchange->body.bytes = received; /* The access log reports this number. */
    }
    enum srv_room room = srv_exchange_hold(exchange, exchange->body.cap + exchange->answer.cap);
    if (room == SRV_ROOM || exchange->answer.cap <= EXCHANGE_ANSWER || !exchange->bytes) return;
    api_buffer_clear(&exchange->answer);
    srv_exchange_crowded(exchange, room, "the answer");
    srv_hold_set(&exchange->hold, exchange->body.cap + exchange->answer.cap);
}
