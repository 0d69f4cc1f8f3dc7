#include "server/message.h"

#include <ctype.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

enum { MESSAGE_FIELDS = 100, MESSAGE_SHOWN = 60 };

/* What a second field of the same name means. */
enum message_several { MESSAGE_ONE, MESSAGE_LIST, MESSAGE_LAST };

static const struct {
    const char *name;
    enum message_several several;
} message_fields[SRV_FIELD_COUNT] = {
#define X(id, name, several) {name, MESSAGE_##several},
    SRV_FIELD_LIST(X)
#undef X
};

/* refuses the message: an answer, and the end of the connection, since what follows may be part of it or not */
static int message_refuse(struct srv_exchange *exchange, int status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

static int message_refuse(struct srv_exchange *exchange, int status, const char *format, ...) {
    char detail[240];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(detail, sizeof detail, format, arguments);
    va_end(arguments);
    srv_exchange_problem(exchange, status, "%s", detail);
    exchange->close = 1;
    return 0;
}

/* a token of RFC 9110 5.6.2 */
static int message_token(const char *text, size_t bytes) {
    for (size_t i = 0; i < bytes; i++)
        if (!isalnum((unsigned char)text[i]) && (!text[i] || !strchr("!#$%&'*+-.^_`|~", text[i]))) return 0;
    return bytes > 0;
}

/* no control character but the tab; bytes from 0x80 on are allowed as RFC 9110 5.5 has it */
static int message_value(const char *text, size_t bytes) {
    for (size_t i = 0; i < bytes; i++)
        if (((unsigned char)text[i] < ' ' && text[i] != '\t') || text[i] == 0x7f) return 0;
    return 1;
}

static int message_find(const struct srv_message_field *field) {
    for (int id = 0; id < SRV_FIELD_COUNT; id++)
        if (!strcasecmp(field->name, message_fields[id].name)) return id;
    return SRV_FIELD_COUNT;
}

/* "a" and "b" of two fields become "a, b" */
static const char *message_join(struct srv_exchange *exchange, const char *first, const char *second) {
    size_t bytes = strlen(first) + strlen(second) + 3;
    char *text = srv_exchange_text(exchange, bytes);
    if (text) snprintf(text, bytes, "%s, %s", first, second);
    return text;
}

int srv_message_field(struct srv_exchange *exchange, const struct srv_message_field *field) {
    if (++exchange->fields > MESSAGE_FIELDS)
        return message_refuse(exchange, 431, "the request has more than %d header fields", MESSAGE_FIELDS);
    if (!message_token(field->name, field->name_bytes))
        return message_refuse(exchange, 400, "header field %d has a name that is no token", exchange->fields);
    if (!message_value(field->value, field->value_bytes))
        return message_refuse(exchange, 400, "the value of the header field %.*s has a control character",
                              MESSAGE_SHOWN, field->name);
    int id = message_find(field);
    if (id == SRV_FIELD_COUNT) return 1;
    const char **known = &exchange->field[id];
    if (*known && message_fields[id].several == MESSAGE_ONE)
        return message_refuse(exchange, 400, "there are two header fields %s", message_fields[id].name);
    int joined = *known && message_fields[id].several == MESSAGE_LIST;
    *known = joined ? message_join(exchange, *known, field->value) : field->value;
    if (!*known) return message_refuse(exchange, 431, "the header fields %s are too long", message_fields[id].name);
    return 1;
}

/* RFC 9112 3.2: exactly one Host from HTTP/1.1 on; its characters are those of a host and a port */
static int message_host(struct srv_exchange *exchange, int old) {
    const char *host = exchange->field[SRV_HOST];
    if (!host) return old || message_refuse(exchange, 400, "an HTTP/1.1 request needs a Host header field");
    for (const char *at = host; *at; at++)
        if (!isalnum((unsigned char)*at) && !strchr("-._~%!$&'()*+,;=:[]", *at))
            return message_refuse(exchange, 400, "the Host header field is no host");
    return 1;
}

/* digits only, at most 18 of them; -1 otherwise */
static int64_t message_length(const char *text) {
    size_t bytes = strlen(text);
    if (!bytes || bytes > 18 || strspn(text, "0123456789") != bytes) return -1;
    int64_t length = 0;
    for (; *text; text++) length = 10 * length + (*text - '0');
    return length;
}

/* RFC 9112 6: how long the body is, and that there is one answer to it only */
static int message_framing(struct srv_exchange *exchange, int old) {
    const char *length = exchange->field[SRV_CONTENT_LENGTH], *coding = exchange->field[SRV_TRANSFER_ENCODING];
    if (coding && length)
        return message_refuse(exchange, 400, "Content-Length and Transfer-Encoding exclude each other");
    if (coding && old) return message_refuse(exchange, 400, "HTTP/1.0 has no Transfer-Encoding");
    if (coding && strcasecmp(coding, "chunked"))
        return message_refuse(exchange, 501, "the only Transfer-Encoding known here is chunked");
    exchange->length = coding ? -1 : length ? message_length(length) : 0;
    if (!coding && exchange->length < 0)
        return message_refuse(exchange, 400, "Content-Length must be a decimal number, got '%.40s'", length);
    double limit = exchange->service->config.limits.body_bytes;
    if ((double)exchange->length > limit)
        return message_refuse(exchange, 413, "the body has %lld bytes, more than the limit max-body-bytes of %.0f",
                              (long long)exchange->length, limit);
    return 1;
}

static int message_hex(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    return c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

/* Undoes the percent encoding of a path. A slash stays encoded, so that it cannot become a separator; a control
 * character is refused, as is what is no encoding. Returns the length, -1 on refusal. */
static int message_decode(const char *from, size_t bytes, char *to) {
    int length = 0;
    for (size_t i = 0; i < bytes; i++) {
        if (from[i] != '%') {
            to[length++] = from[i];
            continue;
        }
        int high = i + 2 < bytes ? message_hex(from[i + 1]) : -1, low = high >= 0 ? message_hex(from[i + 2]) : -1;
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
    to[length] = 0;
    return length;
}

/* the absolute form (RFC 9112 3.2.2) is cut down to the origin form; NULL if it is neither */
static const char *message_origin(const char *target) {
    if (target[0] == '/' || !strcmp(target, "*")) return target;
    if (strncasecmp(target, "http://", 7) && strncasecmp(target, "https://", 8)) return NULL;
    const char *host = strstr(target, "://") + 3;
    size_t bytes = strcspn(host, "/?");
    return bytes && !memchr(host, '@', bytes) ? host + bytes : NULL;
}

static int message_target(struct srv_exchange *exchange) {
    for (const char *at = exchange->target; *at; at++)
        if ((unsigned char)*at <= ' ' || (unsigned char)*at >= 0x7f || strchr("#\"<>\\", *at))
            return message_refuse(exchange, 400, "the request target has a character that is not allowed there");
    const char *origin = message_origin(exchange->target);
    if (!origin) return message_refuse(exchange, 400, "the request target must begin with / or http://");
    size_t bytes = strcspn(origin, "?");
    char *path = srv_exchange_text(exchange, bytes + 2);
    if (!path) return message_refuse(exchange, 414, "the request target is too long");
    if (message_decode(origin, bytes, path) < 0)
        return message_refuse(exchange, 400, "the request target has a bad percent encoding");
    if (!path[0]) strcpy(path, "/");
    exchange->path = path;
    exchange->query = origin[bytes] ? origin + bytes + 1 : NULL;
    return 1;
}

int srv_message_head(struct srv_exchange *exchange, const char *version) {
    int old = !strcmp(version, "HTTP/1.0");
    if (!old && strncmp(version, "HTTP/1.", 7))
        return message_refuse(exchange, 505, "this server speaks HTTP/1.1 and HTTP/1.0");
    if (!message_token(exchange->method, strlen(exchange->method)))
        return message_refuse(exchange, 400, "the request method is no token");
    const char *expect = exchange->field[SRV_EXPECT];
    if (!message_host(exchange, old) || !message_framing(exchange, old)) return 0;
    if (expect && strcasecmp(expect, "100-continue"))
        return message_refuse(exchange, 417, "the only expectation known here is 100-continue");
    return message_target(exchange);
}
