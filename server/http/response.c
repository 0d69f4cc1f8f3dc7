#include "server/http/response.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/uio.h>
#include <time.h>

#include "api/call/job_json.h"
#include "server/jobs/events.h"
#include "server/protocol/cors.h"
#include "server/work/inflight.h"

enum {
    RESPONSE_BLOCK =
        65536, /* bytes of a stream of known length that libmicrohttpd requests at a time */
    RESPONSE_HEAD = 1536 /* space in bytes for a head that is sent without libmicrohttpd */
};

/* --- ids --- */

static int response_id_good(const char *text) {
    size_t bytes = strlen(text);
    return bytes >= 1 && bytes <= 64 &&
           strspn(text, "0123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ-_.:=+/") ==
               bytes;
}

/* Checks a trace parent: version, trace, parent and flags as 2, 32, 16 and 2 digits (W3C Trace
 * Context). */
static int response_trace_good(const char *text) {
    static const char form[] = "##-################################-################-##";
    if (strlen(text) != sizeof form - 1) return 0;
    for (size_t i = 0; i < sizeof form - 1; i++)
        if (form[i] == '-' ? text[i] != '-' : !memchr("0123456789abcdef", text[i], 16)) return 0;
    /* The version ff is invalid, and so are ids that are all zeros. */
    return strncmp(text, "ff", 2) && strspn(text + 3, "0") < 32 && strspn(text + 36, "0") < 16;
}

static void response_id_make(struct srv_exchange *exchange, char text[17]) {
    static const char digit[] = "0123456789abcdef";
    /* splitmix64 */
    uint64_t x = exchange->service->seed +
                 0x9e3779b97f4a7c15u * (atomic_fetch_add(&exchange->service->number, 1) + 1);
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    x ^= x >> 31;
    for (int i = 0; i < 16; i++) text[i] = digit[x >> (60 - 4 * i) & 15];
    text[16] = 0;
}

void srv_response_identify(struct srv_exchange *exchange) {
    const char *given = exchange->field[SRV_REQUEST_ID], *trace = exchange->field[SRV_TRACE];
    if (trace && response_trace_good(trace)) exchange->trace = trace;
    if (given && response_id_good(given)) {
        exchange->id = given;
        return;
    }
    char *text = srv_exchange_text(exchange, 17);
    if (text) response_id_make(exchange, text);
    exchange->id = text ? text : "0";
}

/* --- header fields --- */

static int response_field(struct MHD_Response *response, const char *name, const char *value) {
    return MHD_add_response_header(response, name, value) == MHD_YES;
}

static int response_cors(struct MHD_Response *response, const struct srv_exchange *exchange) {
    const char *allowed = srv_service_config(exchange->service)->cors_origins,
               *asked = exchange->field[SRV_ORIGIN];
    const char *origin = srv_cors_origin(allowed, asked, exchange->closed);
    int good = !srv_cors_varies(allowed) || response_field(response, "Vary", "Origin");
    if (!origin) return good;
    good = good && response_field(response, "Access-Control-Allow-Origin", origin);
    return good &&
           (!asked || response_field(response, "Access-Control-Expose-Headers", srv_cors_expose));
}

static int response_number(struct MHD_Response *response, const char *name, double value) {
    char text[24];
    snprintf(text, sizeof text, "%.0f", value);
    return response_field(response, name, text);
}

/* The fields of draft-ietf-httpapi-ratelimit-headers-10; those of draft 03 stay for the programs
 * that read them. */
static int response_policy(struct MHD_Response *response, const struct srv_quota *quota) {
    char text[80];
    snprintf(text, sizeof text, "\"requests\";q=%.0f;w=60", quota->limit);
    if (!response_field(response, "RateLimit-Policy", text)) return 0;
    snprintf(text, sizeof text, "\"requests\";r=%.0f;t=%.0f", floor(quota->left),
             ceil(quota->refresh));
    return response_field(response, "RateLimit", text);
}

static int response_quota(struct MHD_Response *response, const struct srv_exchange *exchange) {
    const struct srv_quota *quota = &exchange->quota;
    if (quota->refresh <= 0) return 1;
    return response_number(response, "RateLimit-Limit", quota->limit) &&
           response_number(response, "RateLimit-Remaining", floor(quota->left)) &&
           response_number(response, "RateLimit-Reset", ceil(quota->refresh)) &&
           response_policy(response, quota);
}

/* The fields of RFC 9745 and RFC 8594; "" = not sent. */
struct response_ages {
    char deprecation[32], sunset[48];
};

static const char response_ages_link[] = "</docs#deprecation>; rel=\"deprecation\", "
                                         "</docs#deprecation>; rel=\"sunset\"";

/* Reads the operator's announcements of the deprecation of the interface. Returns 0 if there are
 * none. */
static int response_ages_read(const struct srv_exchange *exchange, struct response_ages *ages) {
    const struct srv_config *config = srv_service_config(exchange->service);
    int64_t us;
    struct tm part;
    ages->deprecation[0] = ages->sunset[0] = 0;
    if (!exchange->path || strncmp(exchange->path, "/v1/", 4) != 0) return 0;
    if (api_job_instant(config->deprecated, &us))
        snprintf(ages->deprecation, sizeof ages->deprecation, "@%lld", (long long)(us / 1000000));
    if (api_job_instant(config->sunset, &us)) {
        time_t at = (time_t)(us / 1000000);
        strftime(ages->sunset, sizeof ages->sunset, "%a, %d %b %Y %H:%M:%S GMT",
                 gmtime_r(&at, &part));
    }
    return ages->deprecation[0] || ages->sunset[0];
}

static int response_ages(struct MHD_Response *response, const struct srv_exchange *exchange) {
    struct response_ages ages;
    if (!response_ages_read(exchange, &ages)) return 1;
    return (!ages.deprecation[0] || response_field(response, "Deprecation", ages.deprecation)) &&
           (!ages.sunset[0] || response_field(response, "Sunset", ages.sunset)) &&
           response_field(response, "Link", response_ages_link);
}

static int response_client(struct MHD_Response *response, const struct srv_exchange *exchange) {
    return response_cors(response, exchange) && response_quota(response, exchange) &&
           response_ages(response, exchange);
}

static int response_fields(struct MHD_Response *response, const struct srv_exchange *exchange) {
    const struct srv_response_body *response_body = exchange->response_body;
    int good =
        !exchange->media_type || response_field(response, "Content-Type", exchange->media_type);
    for (int i = 0; i < exchange->headers && good; i++)
        good = response_field(response, exchange->header[i].name, exchange->header[i].value);
    for (int i = 0; response_body && i < response_body->headers && good; i++)
        good =
            response_field(response, response_body->header[i].name, response_body->header[i].value);
    good = good && response_field(response, "X-Request-Id", exchange->id);
    good = good && response_field(response, "X-Content-Type-Options", "nosniff");
    if (exchange->trace) good = good && response_field(response, "Traceparent", exchange->trace);
    if (exchange->close) good = good && response_field(response, "Connection", "close");
    return good && response_client(response, exchange);
}

/* --- bodies --- */

static ssize_t response_read(void *context, uint64_t position, char *to, size_t cap) {
    struct srv_response_stream *stream = context;
    long count = stream->exchange->listens
                     ? srv_events_read(stream->exchange, to, cap, stream->pause)
                     : srv_inflight_read(stream->exchange, to, cap, stream->pause);
    if (count == SRV_INFLIGHT_END) {
        /* if memory is short, trailers are omitted; the body is complete all the same */
        struct api_stats_headers told = {.count = 0};
        if (stream->exchange->trails) srv_inflight_stat_fields(stream->exchange, &told);
        for (int i = 0; i < told.count; i++)
            (void)MHD_add_response_footer(stream->response, told.field[i].name,
                                          told.field[i].value);
        return MHD_CONTENT_READER_END_OF_STREAM;
    }
    stream->broken = count == SRV_INFLIGHT_BROKEN;
    if (stream->broken) return MHD_CONTENT_READER_END_WITH_ERROR;
    stream->moved(stream->exchange, count ? position + (uint64_t)count : 0);
    return count;
}

struct MHD_Response *srv_response_new(const struct srv_exchange *exchange,
                                      struct srv_response_stream *stream) {
    uint64_t length =
        exchange->stream_bytes < 0 ? MHD_SIZE_UNKNOWN : (uint64_t)exchange->stream_bytes;
    struct MHD_Response *response =
        exchange->streams
            ? MHD_create_response_from_callback(length, RESPONSE_BLOCK, response_read, stream, NULL)
            : MHD_create_response_from_buffer(exchange->bytes, (void *)exchange->data,
                                              MHD_RESPMEM_PERSISTENT);
    assert(exchange->id && exchange->status >= 200 && exchange->status <= 599);
    stream->response = response;
    int good = response &&
               (!exchange->trails || response_field(response, "Trailer", api_stats_field_names));
    if (!response || (good && response_fields(response, exchange))) return response;
    MHD_destroy_response(response);
    return NULL;
}

/* Adds a field to a head of RESPONSE_HEAD bytes that is sent without libmicrohttpd. A field that
 * does not fit is left out. */
static void response_line(char head[], const char *name, const char *value) {
    size_t used = strlen(head), room = RESPONSE_HEAD - used - sizeof "\r\n";
    int bytes = snprintf(head + used, room, "%s: %s\r\n", name, value);
    if (bytes < 0 || (size_t)bytes >= room) head[used] = 0;
}

static void response_line_ages(char head[], const struct srv_exchange *exchange) {
    struct response_ages ages;
    if (!response_ages_read(exchange, &ages)) return;
    if (ages.deprecation[0]) response_line(head, "Deprecation", ages.deprecation);
    if (ages.sunset[0]) response_line(head, "Sunset", ages.sunset);
    response_line(head, "Link", response_ages_link);
}

void srv_response_refuse(struct srv_exchange *exchange, int fd) {
    char head[RESPONSE_HEAD], date[40], length[24];
    time_t now = time(NULL);
    struct tm part;
    const char *origin = srv_cors_origin(srv_service_config(exchange->service)->cors_origins,
                                         exchange->field[SRV_ORIGIN], exchange->closed);
    assert(exchange->status >= 400 && exchange->id && exchange->media_type);
    strftime(date, sizeof date, "%a, %d %b %Y %H:%M:%S GMT", gmtime_r(&now, &part));
    snprintf(length, sizeof length, "%zu", exchange->bytes);
    snprintf(head, sizeof head, "HTTP/1.1 %d %s\r\n", exchange->status,
             MHD_get_reason_phrase_for((unsigned)exchange->status));
    response_line(head, "Content-Length", length);
    response_line(head, "Content-Type", exchange->media_type);
    response_line(head, "Connection", "close");
    response_line(head, "Date", date);
    response_line(head, "X-Request-Id", exchange->id);
    response_line(head, "X-Content-Type-Options", "nosniff");
    if (origin) response_line(head, "Access-Control-Allow-Origin", origin);
    for (int i = 0; i < exchange->headers; i++)
        response_line(head, exchange->header[i].name, exchange->header[i].value);
    response_line_ages(head, exchange);
    strcat(head, "\r\n");
    struct iovec parts[] = {{head, strlen(head)}, {(void *)exchange->data, exchange->bytes}};
    (void)!sendmsg(fd, &(struct msghdr){.msg_iov = parts, .msg_iovlen = 2},
                   MSG_DONTWAIT | MSG_NOSIGNAL);
    exchange->close = 1;
}
