#include "server/http/request_head.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* The treatment of a second field of the same name. */
enum head_several { HEAD_ONE, HEAD_LIST, HEAD_LAST };

static const struct {
    const char *name;
    size_t bytes;
    enum head_several several;
} head_fields[SRV_FIELD_COUNT] = {
#define X(id, name, several) {name, sizeof name - 1, HEAD_##several},
    SRV_FIELD_LIST(X)
#undef X
};

static int head_refuse(struct srv_exchange *exchange, int status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

static int head_refuse(struct srv_exchange *exchange, int status, const char *format, ...) {
    assert(status >= 400 && status <= 599);
    char detail[240];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(detail, sizeof detail, format, arguments);
    va_end(arguments);
    srv_exchange_problem(exchange, status, "%s", detail);
    /* After a malformed message the start of the next one is uncertain, so close the connection. */
    exchange->close |= status == 400;
    return 0;
}

static int head_find(const struct srv_service *service, const char *name) {
    size_t bytes = strlen(name);
    for (int id = 0; id < SRV_FIELD_COUNT; id++)
        if (bytes == head_fields[id].bytes && !strcasecmp(name, head_fields[id].name)) return id;
    /* Fields of a proxy are ignored if no proxy is trusted. */
    if (!srv_peers_any(srv_service_trusted(service))) return SRV_FIELD_COUNT;
    const struct srv_config *config = srv_service_config(service);
    if (!strcasecmp(name, config->client_header)) return SRV_FORWARDED;
    return strcasecmp(name, config->role_header) ? SRV_FIELD_COUNT : SRV_ROLES;
}

int srv_request_head_relayed(const char *name) {
    static const char *const marks[] = {"Via", "Forwarded", "X-Forwarded-For"};
    for (size_t i = 0; i < sizeof marks / sizeof *marks; i++)
        if (!strcasecmp(name, marks[i])) return 1;
    return 0;
}

static const char *head_join(struct srv_exchange *exchange, const char *first, const char *second) {
    size_t bytes = strlen(first) + strlen(second) + 3;
    char *text = srv_exchange_text(exchange, bytes);
    if (text) snprintf(text, bytes, "%s, %s", first, second);
    return text;
}

int srv_request_head_field(struct srv_exchange *exchange, const char *name, const char *value) {
    assert(srv_exchange_valid(exchange) && name && value);
    int id = head_find(exchange->service, name);
    if (id == SRV_FIELD_COUNT) return 1;
    const char **known = &exchange->field[id];
    if (*known && head_fields[id].several == HEAD_ONE)
        return head_refuse(exchange, 400, "there are two header fields %s", head_fields[id].name);
    int joined = *known && head_fields[id].several == HEAD_LIST;
    *known = joined ? head_join(exchange, *known, value) : value;
    if (!*known)
        return head_refuse(exchange, 431, "the header fields %s are too long",
                           head_fields[id].name);
    return 1;
}

/* Finds the length of the body. The strict reader has made sure that it is unambiguous. */
static int head_length(struct srv_exchange *exchange) {
    const char *length = exchange->field[SRV_CONTENT_LENGTH];
    double limit = srv_service_config(exchange->service)->limits.body_bytes;
    exchange->length = exchange->field[SRV_TRANSFER_ENCODING] ? -1
                       : length                               ? strtoll(length, NULL, 10)
                                                              : 0;
    assert(exchange->length >= -1);
    if ((double)exchange->length <= limit) return 1;
    exchange->close = 1;
    return head_refuse(exchange, 413,
                       "the body has %lld bytes, more than the limit max-body-bytes of %.0f",
                       (long long)exchange->length, limit);
}

static int head_hex(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    return c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

/* Decodes the percent encoding of a path. A slash stays encoded, so that it cannot become a
 * separator. Control characters and invalid encodings are refused. Returns the length, -1 on
 * refusal. */
static int head_decode(const char *from, size_t bytes, char *to) {
    int length = 0;
    for (size_t i = 0; i < bytes; i++) {
        if (from[i] != '%') {
            to[length++] = from[i];
            continue;
        }
        int high = i + 2 < bytes ? head_hex(from[i + 1]) : -1,
            low = high >= 0 ? head_hex(from[i + 2]) : -1;
        int c = 16 * high + low;
        if (low < 0 || c < ' ' || c == 0x7f) return -1;
        if (c == '/') {
            memcpy(to + length, from + i, 3);
            length += 3;
        } else {
            to[length++] = (char)c;
        }
        i += 2;
    }
    assert(length >= 0 && (size_t)length <= bytes);
    to[length] = 0;
    return length;
}

/* Reduces the absolute form (RFC 9112 3.2.2) to the origin form; its host replaces the field Host.
 * Returns NULL if the target has neither form, or if memory is short. */
static const char *head_origin(struct srv_exchange *exchange) {
    const char *target = exchange->target;
    exchange->host = exchange->field[SRV_HOST];
    if (target[0] == '/' || !strcmp(target, "*")) return target;
    if (strncasecmp(target, "http://", 7) && strncasecmp(target, "https://", 8)) return NULL;
    const char *host = strstr(target, "://") + 3;
    size_t bytes = strcspn(host, "/?");
    char *text = bytes && !memchr(host, '@', bytes) ? srv_exchange_text(exchange, bytes + 1) : NULL;
    if (!text) return NULL;
    memcpy(text, host, bytes);
    text[bytes] = 0;
    exchange->host = text;
    return host + bytes;
}

static int head_target(struct srv_exchange *exchange) {
    if (strpbrk(exchange->target, "#\"<>\\"))
        return head_refuse(exchange, 400, "the request target has a forbidden character");
    const char *origin = head_origin(exchange);
    if (!origin)
        return head_refuse(exchange, 400, "the request target must begin with / or http://");
    size_t bytes = strcspn(origin, "?");
    char *path = srv_exchange_text(exchange, bytes + 2);
    if (!path) return head_refuse(exchange, 414, "the request target is too long");
    if (head_decode(origin, bytes, path) < 0)
        return head_refuse(exchange, 400, "the request target has a bad percent encoding");
    if (!path[0]) strcpy(path, "/");
    exchange->path = path;
    exchange->query = origin[bytes] ? origin + bytes + 1 : NULL;
    return 1;
}

/* Refuses a body with a content coding: the server decodes none, and the decoded size of a body
 * has no known bound. */
static int head_coding(struct srv_exchange *exchange) {
    const char *coding = exchange->field[SRV_CONTENT_ENCODING];
    if (!exchange->length || !coding || !*coding || !strcasecmp(coding, "identity")) return 1;
    head_refuse(exchange, 415,
                "the body has the Content-Encoding %.60s; request bodies must not be encoded",
                coding);
    srv_exchange_header(exchange, "Accept-Encoding", "identity");
    return 0;
}

int srv_request_head_head(struct srv_exchange *exchange) {
    assert(srv_exchange_valid(exchange));
    const char *expect = exchange->field[SRV_EXPECT];
    if (!head_length(exchange) || !head_coding(exchange)) return 0;
    if (expect && strcasecmp(expect, "100-continue"))
        return head_refuse(exchange, 417, "the only supported expectation is 100-continue");
    return head_target(exchange);
}
