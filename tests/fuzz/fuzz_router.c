/* Fuzzes requests through all stages on the thread of the sockets: fields, target, route, host,
 * origin, keys, quota, and the routes that answer at once.
 * Leaves to others: the layout of messages (fuzz_front), computations (fuzz_call), jobs and
 * classrooms, which need a store (tests/wire).
 * Invariant: every request is answered with an HTTP status and a text of a known type, or is passed
 * on to be computed. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/json/json_in.h"
#include "server/config/config_load.h"
#include "server/http/request_head.h"
#include "server/http/router.h"
#include "server/service_setup.h"
#include "tests/fuzz/fuzz.h"

static struct srv_service service;
static struct srv_exchange exchange;

static void service_end(void) {
    srv_exchange_clear(&exchange);
    srv_log_free(&service.log);
    srv_service_setup_clear(&service);
}

static void service_begin(void) {
    static int begun;
    static char *argv[] = {(char *)"pendulumd",
                           (char *)"--listen",
                           (char *)"127.0.0.1:0",
                           (char *)"--access-log",
                           (char *)"off",
                           (char *)"--store",
                           (char *)"none",
                           (char *)"--trusted-proxy",
                           (char *)"192.0.2.0/24",
                           (char *)"--cors-origins",
                           (char *)"https://a.example",
                           NULL};
    char *none[] = {NULL};
    struct pend_error error = {.text = ""};
    if (begun) return;
    begun = 1;
    if (srv_config_load(&service.config, sizeof argv / sizeof *argv - 1, argv, none, &error) !=
            PEND_OK ||
        srv_service_setup_init(&service, &error) != PEND_OK ||
        srv_log_new(&service.log, -1, -1) != PEND_OK) {
        fprintf(stderr, "%s\n", error.text);
        abort();
    }
    srv_exchange_init(&exchange, &service);
    atexit(service_end);
}

/* returns one line without its end; NULL at the end of the text */
static char *line_of(char **rest) {
    char *line = *rest, *end;
    if (!line) return NULL;
    end = strchr(line, '\n');
    *rest = end ? end + 1 : NULL;
    if (end) *end = 0;
    return line;
}

static int answer_is_sound(void) {
    if (exchange.status < 200 || exchange.status > 599) return 0;
    if (exchange.bytes && (!exchange.media_type || !exchange.data)) return 0;
    for (int i = 0; i < exchange.headers; i++)
        if (strpbrk(exchange.header[i].name, "\r\n: ") || strpbrk(exchange.header[i].value, "\r\n"))
            return 0;
    if (!exchange.bytes || !strstr(exchange.media_type, "problem")) return 1;
    OWN(api_json, free) *document = NULL;
    OWN(api_problem, clear) problem;
    api_problem_init(&problem);
    enum pend_status status = api_json_new(&document, exchange.data, exchange.bytes, 16, &problem);
    return status == PEND_OK && exchange.status >= 400;
}

/* METHOD LF TARGET LF, then one field NAME:VALUE per line */
static int read_router(char *text, size_t bytes) {
    char *rest = text, *line;
    const char *method = line_of(&rest), *target = line_of(&rest);
    (void)bytes;
    service_begin();
    srv_exchange_reset(&exchange);
    if (!target || strlen(target) >= sizeof exchange.target) return 1;
    exchange.method = method;
    snprintf(exchange.peer, sizeof exchange.peer, "192.0.2.%d", 1 + (int)bytes % 3);
    strcpy(exchange.target, target);
    int passes = 1;
    while (passes && (line = line_of(&rest))) {
        char *value = strchr(line, ':');
        if (!value) continue;
        *value++ = 0;
        /* the strict reader accepts only digits here */
        if (!strcasecmp(line, "Content-Length") && strspn(value, "0123456789") != strlen(value))
            continue;
        passes = srv_request_head_field(&exchange, line, value);
    }
    passes = passes && srv_router_head(&exchange) && srv_router_body(&exchange);
    if (!srv_exchange_valid(&exchange)) return 0;
    return passes ? exchange.route && !exchange.status : answer_is_sound();
}

static const struct fuzz_reader router[] = {
    {"router",
     read_router,
     {"GET\n/v1/jobs?status=running&limit=3\nHost:localhost\nAuthorization:Bearer "
      "0123456789abcdef012345\n",
      "POST\n/v1/trajectories\nHost:127.0.0.1\nContent-Type:application/json\nContent-Length:9\n"
      "Prefer:respond-async, wait=3\nIdempotency-Key:\"a\"\n",
      "OPTIONS\n/v1/trees\nHost:[::1]:8080\nOrigin:https://a.example\n"
      "Access-Control-Request-Method:POST\n",
      "GET\nhttp://a/docs%2f?x=%zz\nHost:a\nX-Forwarded-For:10.0.0.1\nX-Forwarded-Proto:https\n",
      "HEAD\n/main.js\nIf-None-Match:*, W/\"a\"\nAccept-Encoding:gzip\nRange:bytes=0-1\n",
      "GET\n/oembed?url=http%3A%2F%2Fh%2F\nHost:h\nExpect:100-continue\nX-Request-Id:a\n",
      "GET\n/v1/presets/paper\nAccept:text/csv\nTraceparent:00-"
      "0123456789abcdef0123456789abcdef-0123456789abcdef-01\n"},
     0},
};
FUZZ_READERS(router)
