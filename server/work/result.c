#include "server/work/result.h"

#include <stdio.h>
#include <string.h>

enum {
    RESULT_MOST_CODED = 1 << 30, /* maximum bytes of a response that is compressed in one piece */
    RESULT_DIGITS = 64           /* the hexadecimal digits of a digest */
};

static_assert((int)SRV_ETAG_BYTES > 2 + 1 + RESULT_DIGITS + 1, "a tag is W/\"digest\"");
static_assert((int)SRV_INFLIGHT_KEY > RESULT_DIGITS, "a key is the digest and the coding");

/* Retry-After, in s, for a computation that ran out of time or memory: the machine may be less busy
 * then. */
static const char result_retry[] = "60";
/* the day on which the first names were deprecated (RFC 9745) */
static const char result_deprecated[] = "@1795651200";

/* --- the exact bytes of a request --- */

/* Forms the key of the exact cache from the bytes that determine the response. The key is written
 * after the request's body. Returns its length, 0 if memory is short. */
static size_t result_exact_key(struct srv_exchange *exchange, const char **key) {
    struct api_buffer *body = &exchange->body;
    size_t bytes = body->bytes;
    const char *part[] = {exchange->path, exchange->field[SRV_ACCEPT],
                          exchange->field[SRV_CONTENT_TYPE]};
    enum pend_status status = PEND_OK;
    for (size_t i = 0; i < sizeof part / sizeof *part && status == PEND_OK; i++)
        status = api_buffer_add(body, part[i] ? part[i] : "", part[i] ? strlen(part[i]) + 1 : 1);
    if (status == PEND_OK)
        status = api_buffer_add(body, &(char){(char)('0' + exchange->coding)}, 1);
    size_t all = body->bytes;
    body->bytes = bytes;
    *key = body->data;
    return status == PEND_OK ? all : 0;
}

/* Returns 1 if the exchange is never answered from the exact cache. */
static int result_unkeyed(const struct srv_exchange *exchange) {
    return !srv_cache_on(exchange->service->cache) || exchange->apart ||
           exchange->body.bytes > SRV_CACHE_KEY || exchange->query;
}

void srv_result_give(struct srv_exchange *exchange, struct srv_response_body *response_body,
                     const char *cache) {
    exchange->cache = cache;
    srv_exchange_response_body(exchange, response_body);
    if (response_body->status != 200 || !srv_exchange_matches(exchange, response_body->etag))
        return;
    if (!srv_exchange_safe(exchange)) {
        srv_exchange_not_modified(exchange, response_body->etag);
        return;
    }
    /* 304 has the length of the response that it replaces. */
    exchange->status = 304;
    srv_metrics_count(&exchange->service->metrics.not_modified, 1);
}

int srv_result_cached(struct srv_exchange *exchange) {
    const char *key;
    if (result_unkeyed(exchange)) return 0;
    size_t bytes = result_exact_key(exchange, &key);
    struct srv_response_body *response_body =
        bytes ? srv_cache_find(exchange->service->cache, key, bytes) : NULL;
    if (!response_body) return 0;
    srv_metrics_count(&exchange->service->metrics.cache_exact, 1);
    srv_result_give(exchange, response_body, "exact");
    srv_response_body_drop(&response_body);
    return 1;
}

void srv_result_remember(struct srv_exchange *exchange, struct srv_response_body *response_body) {
    const char *key;
    if (response_body->status != 200 || result_unkeyed(exchange)) return;
    size_t bytes = result_exact_key(exchange, &key);
    if (bytes) srv_cache_add(exchange->service->cache, key, bytes, response_body);
}

/* --- response bodies --- */

enum srv_coding srv_result_code(struct srv_work *work, const char *media_type) {
    double least = srv_service_config(work->service)->compress_above;
    if (!work->coding || least <= 0 || (double)work->out.bytes < least ||
        work->out.bytes > RESULT_MOST_CODED || !srv_coding_worth(media_type))
        return SRV_IDENTITY;
    work->coded.bytes = 0;
    srv_buffer_pool_take(&work->service->pool, &work->coded);
    if (srv_coding_whole(work->coding, work->out.data, work->out.bytes, &work->coded) != PEND_OK ||
        work->coded.bytes >= work->out.bytes)
        return SRV_IDENTITY;
    struct api_buffer plain = work->out;
    work->out = work->coded;
    work->coded = plain;
    return work->coding;
}

/* Writes Content-Range. Returns 0 if the response has none. */
static int result_range(const struct api_answer *answer, char text[], size_t cap) {
    int part = answer->status == 206;
    if (!part && answer->status != 416) return 0;
    if (part)
        snprintf(text, cap, "bytes %lld-%lld/%lld", answer->first,
                 answer->first + answer->length - 1, answer->total);
    else
        snprintf(text, cap, "bytes */%lld", answer->total);
    return 1;
}

/* Returns an upper bound of the bytes of a response's header texts. */
static size_t result_texts(const struct api_answer *answer) {
    size_t bytes = 416 + SRV_ETAG_BYTES + (answer->columns ? strlen(answer->columns) + 1 : 0);
    for (int i = 0; answer->stat_fields && i < answer->stat_fields->count; i++)
        bytes += strlen(answer->stat_fields->field[i].value) + 1;
    return bytes;
}

static void result_good(struct srv_response_body *made, const struct srv_work *work,
                        const struct api_answer *answer, enum srv_coding coding) {
    /* An operator's announcement for the whole interface takes the place of this one. */
    if (answer->deprecated && !strcmp(srv_service_config(work->service)->deprecated, "none")) {
        srv_response_body_header(made, "Deprecation", result_deprecated);
        srv_response_body_header(made, "Link", "</docs#deprecation>; rel=\"deprecation\"");
    }
    if (work->etag[0]) {
        /* A coding may produce different bytes another time, so the entity tag is weak. */
        stpcpy(stpcpy(made->etag, coding && work->source ? "W/" : ""), work->etag);
        srv_response_body_header(made, "ETag", made->etag);
    }
    if (work->source && !work->source->from.partial)
        srv_response_body_header(made, "Accept-Ranges", "bytes");
}

static void result_about(struct srv_response_body *made, const struct api_answer *answer) {
    char disposition[128], range[96];
    if (result_range(answer, range, sizeof range))
        srv_response_body_header(made, "Content-Range", range);
    if (answer->columns) srv_response_body_header(made, "X-Columns", answer->columns);
    if (answer->file_name) {
        snprintf(disposition, sizeof disposition, "inline; filename=\"%.80s\"", answer->file_name);
        srv_response_body_header(made, "Content-Disposition", disposition);
    }
    for (int i = 0; answer->stat_fields && i < answer->stat_fields->count; i++)
        srv_response_body_header(made, answer->stat_fields->field[i].name,
                                 answer->stat_fields->field[i].value);
}

struct srv_response_body *srv_result_response_body(struct srv_work *work, struct api_answer answer,
                                                   enum srv_coding coding,
                                                   struct api_buffer *body) {
    struct srv_service *service = work->service;
    assert(answer.status >= 200 && answer.status <= 599);
    struct srv_response_body *made =
        srv_response_body_new(answer.status, answer.media_type, body, result_texts(&answer),
                              &service->memory, &service->pool);
    if (!made) return NULL;
    made->steps = api_call_steps(work->call);
    if (answer.status >= 400) srv_response_body_header(made, "Cache-Control", "no-store");
    if (answer.status == 415)
        srv_response_body_header(made, "Accept-Post",
                                 answer.accepts ? answer.accepts : srv_exchange_accepts);
    if (answer.status == 503 || answer.status == 429)
        srv_response_body_header(made, "Retry-After", result_retry);
    srv_response_body_header(made, "Vary", srv_exchange_vary);
    if (answer.status < 400) result_good(made, work, &answer, coding);
    if (answer.status == 206) srv_lengths_note(&service->lengths, work->etag, answer.total);
    result_about(made, &answer);
    if (coding) srv_response_body_header(made, "Content-Encoding", srv_coding_at(coding)->name);
    return made;
}

/* --- by what a request means --- */

void srv_result_key(struct srv_work *work, enum srv_coding coding) {
    const char *digest = api_call_etag(work->call);
    work->etag[0] = 0;
    work->key_bytes = 0;
    if (!digest) return;
    size_t digits = strnlen(digest, RESULT_DIGITS);
    char *at = work->key;
    memcpy(at, digest, digits);
    at[digits] = (char)('0' + coding);
    work->key_bytes = digits + 1;
    /* A job's result is the same to the byte every time, compute_seconds included; a computed
     * response is not, so its tag is weak. */
    at = stpcpy(work->etag, work->source ? "\"" : "W/\"");
    memcpy(at, digest, digits);
    stpcpy(at + digits, "\"");
}

struct srv_response_body *srv_result_find(struct srv_work *work) {
    struct srv_cache *cache = work->service->cache;
    struct srv_response_body *found = srv_cache_find(cache, work->key, work->key_bytes);
    if (found || !work->coding) return found;
    srv_result_key(work, SRV_IDENTITY);
    found = srv_cache_find(cache, work->key, work->key_bytes);
    srv_result_key(work, work->coding);
    if (!found || api_buffer_add(&work->out, found->body.data, found->body.bytes) != PEND_OK)
        return found;
    enum srv_coding coding = srv_result_code(work, found->media_type);
    struct srv_response_body *coded =
        coding ? srv_result_response_body(work, api_call_answer(work->call), coding, &work->out)
               : NULL;
    work->out.bytes = 0;
    if (!coded) return found;
    srv_cache_add(cache, work->key, work->key_bytes, coded);
    srv_response_body_drop(&found);
    return coded;
}
