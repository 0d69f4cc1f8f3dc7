#include "server/exchange.h"

#include <assert.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "api/problem.h"

enum {
    EXCHANGE_MAGIC = 0x65786368,
    EXCHANGE_KEEP = 4096 /* largest buffer that stays with its connection for the next request */
};

static const char exchange_problem_type[] = "application/problem+json";
static const char exchange_no_memory[] = "{\"type\":\"about:blank\",\"title\":\"Service Unavailable\",\"status\":503,"
                                         "\"detail\":\"out of memory\"}";

void srv_exchange_init(struct srv_exchange *exchange, struct srv_service *service) {
    *exchange = (struct srv_exchange){.magic = EXCHANGE_MAGIC, .service = service};
    api_buffer_init(&exchange->body, (size_t)service->config.limits.body_bytes);
    api_buffer_init(&exchange->answer, (size_t)service->config.limits.answer_bytes);
}

void srv_exchange_clear(struct srv_exchange *exchange) {
    srv_exchange_hold(exchange, 0);
    api_buffer_clear(&exchange->body);
    api_buffer_clear(&exchange->answer);
    exchange->magic = 0;
}

static void exchange_empty(struct srv_exchange *exchange, struct api_buffer *buffer) {
    buffer->bytes = 0;
    if (buffer->cap > EXCHANGE_KEEP) srv_spares_give(&exchange->service->spares, buffer);
}

void srv_exchange_reset(struct srv_exchange *exchange) {
    assert(srv_exchange_valid(exchange));
    srv_exchange_hold(exchange, 0);
    exchange_empty(exchange, &exchange->body);
    exchange_empty(exchange, &exchange->answer);
    atomic_store(&exchange->stop, SRV_GO_ON);
    memset(exchange->field, 0, sizeof exchange->field);
    exchange->method = exchange->path = exchange->query = exchange->id = exchange->argument = NULL;
    exchange->route = NULL;
    exchange->length = 0;
    exchange->target[0] = 0;
    exchange->media_type = exchange->data = NULL;
    exchange->status = exchange->headers = exchange->close = 0;
    exchange->received = exchange->queued = exchange->begun = exchange->computed = 0;
    exchange->steps = 0;
    exchange->bytes = exchange->text_bytes = 0;
}

int srv_exchange_valid(const struct srv_exchange *exchange) {
    return exchange->magic == EXCHANGE_MAGIC && exchange->service && exchange->headers <= SRV_HEADERS &&
           exchange->text_bytes <= SRV_TEXT_BYTES && (!exchange->bytes || exchange->data) &&
           memchr(exchange->target, 0, SRV_TARGET_BYTES);
}

char *srv_exchange_text(struct srv_exchange *exchange, size_t bytes) {
    if (bytes > SRV_TEXT_BYTES - exchange->text_bytes) return NULL;
    char *text = exchange->text + exchange->text_bytes;
    exchange->text_bytes += bytes;
    return text;
}

void srv_exchange_header(struct srv_exchange *exchange, const char *name, const char *value) {
    assert(exchange->headers < SRV_HEADERS);
    exchange->header[exchange->headers].name = name;
    exchange->header[exchange->headers++].value = value;
}

void srv_exchange_static(struct srv_exchange *exchange, int status, const char *media_type, const char *data,
                         size_t bytes) {
    exchange->status = status;
    exchange->media_type = media_type;
    exchange->data = data;
    exchange->bytes = bytes;
}

void srv_exchange_answered(struct srv_exchange *exchange, int status, const char *media_type) {
    srv_exchange_static(exchange, status, media_type, exchange->answer.data, exchange->answer.bytes);
    if (status >= 400) srv_exchange_header(exchange, "Cache-Control", "no-store");
}

void srv_exchange_problem(struct srv_exchange *exchange, int status, const char *format, ...) {
    char detail[API_DETAIL_BYTES];
    struct api_problem problem;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(detail, sizeof detail, format, arguments);
    va_end(arguments);
    exchange->headers = 0;
    exchange->answer.bytes = 0;
    api_problem_init(&problem);
    api_problem_set(&problem, status, "%s", detail);
    enum pend_status written = api_problem_write(&problem, &exchange->answer);
    api_problem_clear(&problem);
    if (written == PEND_OK) {
        srv_exchange_answered(exchange, status, exchange_problem_type);
        return;
    }
    srv_exchange_static(exchange, 503, exchange_problem_type, exchange_no_memory, sizeof exchange_no_memory - 1);
    srv_exchange_header(exchange, "Cache-Control", "no-store");
}

void srv_exchange_busy(struct srv_exchange *exchange, int seconds, const char *detail) {
    srv_exchange_problem(exchange, 503, "%s", detail);
    char *text = srv_exchange_text(exchange, 12);
    if (!text) return;
    snprintf(text, 12, "%d", seconds);
    srv_exchange_header(exchange, "Retry-After", text);
}

int srv_exchange_hold(struct srv_exchange *exchange, size_t bytes) {
    if (bytes == exchange->held) return 1;
    long long change = (long long)bytes - (long long)exchange->held;
    long long all = atomic_fetch_add(&exchange->service->held, change) + change;
    exchange->held = bytes;
    return change < 0 || (double)all <= exchange->service->config.held_bytes;
}
