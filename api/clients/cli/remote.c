#include "api/clients/cli/remote.h"

#include <assert.h>
#include <curl/curl.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <time.h>
#include <unistd.h>

#include "api/clients/cli/request.h"

struct attempt {
    CURL *curl;
    struct cli_sink *sink;
    long status; /* 0 = no byte of the body has arrived */
    int began, page;
    long long told; /* MiB in the last line of progress */
};

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* whether the answer is a web page, which no route of the API returns */
static int is_page(CURL *curl) {
    const char *kind = NULL;
    curl_easy_getinfo(curl, CURLINFO_CONTENT_TYPE, &kind);
    return kind && !strncasecmp(kind, "text/html", 9);
}

static size_t receive(char *data, size_t one, size_t bytes, void *context) {
    struct attempt *attempt = context;
    if (!attempt->began) {
        attempt->began = 1;
        curl_easy_getinfo(attempt->curl, CURLINFO_RESPONSE_CODE, &attempt->status);
        attempt->page = is_page(attempt->curl);
        if (attempt->status == 200) cli_sink_again(attempt->sink);
    }
    if (attempt->status >= 400 || attempt->page) {
        cli_need(api_buffer_add(&attempt->sink->text, data, one * bytes) == PEND_OK);
    } else {
        cli_sink_add(attempt->sink, data, one * bytes);
        if (attempt->sink->part && attempt->sink->have >> 20 > attempt->told) {
            attempt->told = attempt->sink->have >> 20;
            cli_progress("%.1f MB", 1e-6 * (double)attempt->sink->have);
        }
    }
    return one * bytes;
}

static void header(struct curl_slist **list, const char *name, const char *value) {
    char line[5000];
    if (!value) return;
    if (snprintf(line, sizeof line, "%s: %s", name, value) >= (int)sizeof line)
        cli_die("%s is too long", name);
    struct curl_slist *longer = curl_slist_append(*list, line);
    cli_need(longer != NULL);
    *list = longer;
}

/* prints warnings in header fields, for answers that cannot contain them */
static void warn(CURL *curl) {
    struct curl_header *field;
    for (size_t i = 0; curl_easy_header(curl, "X-Warning", i, CURLH_HEADER | CURLH_TRAILER, -1,
                                        &field) == CURLHE_OK;
         i++)
        cli_warn(field->value);
}

enum { URL_BYTES = 2000, BEARER_BYTES = 4200 };

/* composes the URL, without a double slash, and the header field with the token */
static void address(const struct cli_remote *remote, const struct cli_exchange *exchange,
                    char url[URL_BYTES], char bearer[BEARER_BYTES]) {
    const char *token = remote->token ? remote->token : "";
    int server = (int)strlen(remote->url);
    while (server > 0 && remote->url[server - 1] == '/') server--;
    if (snprintf(url, URL_BYTES, "%.*s%s", server, remote->url, exchange->path) >= URL_BYTES ||
        snprintf(bearer, BEARER_BYTES, "Bearer %s", token) >= BEARER_BYTES)
        cli_die("the URL or the token is too long");
}

static CURLcode attempt_once(struct attempt *attempt, const struct cli_remote *remote,
                             struct cli_exchange *exchange) {
    struct curl_slist *fields = NULL;
    char url[URL_BYTES], range[40], bearer[BEARER_BYTES];
    CURL *curl = attempt->curl;
    int rest = exchange->resumes && attempt->sink->have > 0 && *exchange->etag;
    snprintf(range, sizeof range, "bytes=%lld-", attempt->sink->have);
    address(remote, exchange, url, bearer);
    header(&fields, "Content-Type", exchange->body ? "application/json" : NULL);
    header(&fields, "Accept", exchange->accept ? exchange->accept : "application/json");
    header(&fields, "Authorization", remote->token ? bearer : NULL);
    header(&fields, "Prefer", exchange->key ? "respond-async" : NULL);
    header(&fields, "Idempotency-Key", exchange->key);
    char *title =
        exchange->key && exchange->title ? curl_easy_escape(curl, exchange->title, 0) : NULL;
    header(&fields, "Job-Title", title);
    curl_free(title);
    header(&fields, "Range", rest ? range : NULL);
    header(&fields, "If-Range", rest ? exchange->etag : NULL);
    curl_easy_reset(curl);
    curl_easy_setopt(curl, CURLOPT_URL, url);
    curl_easy_setopt(curl, CURLOPT_PROTOCOLS_STR, "http,https");
    curl_easy_setopt(curl, CURLOPT_CONNECTTIMEOUT, 10L);
    curl_easy_setopt(curl, CURLOPT_TCP_KEEPALIVE, 1L); /* detects a server that has disappeared */
    curl_easy_setopt(curl, CURLOPT_CUSTOMREQUEST, exchange->method);
    curl_easy_setopt(curl, CURLOPT_NOBODY, (long)!strcmp(exchange->method, "HEAD"));
    curl_easy_setopt(curl, CURLOPT_HTTPHEADER, fields);
    curl_easy_setopt(curl, CURLOPT_WRITEFUNCTION, receive);
    curl_easy_setopt(curl, CURLOPT_WRITEDATA, attempt);
    if (exchange->body) {
        curl_easy_setopt(curl, CURLOPT_POSTFIELDS, exchange->body->data);
        curl_easy_setopt(curl, CURLOPT_POSTFIELDSIZE_LARGE, (curl_off_t)exchange->body->bytes);
    }
    attempt->status = 0, attempt->began = 0, attempt->page = 0;
    attempt->sink->text.bytes = 0;
    CURLcode code = curl_easy_perform(curl);
    attempt->page = is_page(curl);
    curl_easy_getinfo(curl, CURLINFO_RESPONSE_CODE, &attempt->status);
    struct curl_header *etag;
    if (attempt->status < 300 && !curl_easy_header(curl, "ETag", 0, CURLH_HEADER, -1, &etag))
        snprintf(exchange->etag, sizeof exchange->etag, "%s", etag->value);
    curl_slist_free_all(fields);
    return code;
}

/* whether the server refuses temporarily */
static int busy(long status) { return status == 429 || (status >= 502 && status <= 504); }

/* whether an attempt was successful; ends the program if another attempt would not help */
static int settled(const struct attempt *attempt, CURLcode code) {
    if (attempt->status == 416 && attempt->sink->have > 0) {
        struct curl_header *field;
        long long whole = -1;
        if (!curl_easy_header(attempt->curl, "Content-Range", 0, CURLH_HEADER, -1, &field))
            sscanf(field->value, "bytes */%lld", &whole);
        if (whole == attempt->sink->have) return 1; /* the file is already complete */
        cli_sink_again(attempt->sink);              /* the file contains the beginning of another
                                                     * answer */
        return 0;
    }
    if (code != CURLE_OK || busy(attempt->status)) return 0;
    if (attempt->status >= 400) cli_refuse(attempt->status, &attempt->sink->text);
    return 1;
}

#define WHERE "set its address by PENDULUM_URL or --server"

/* Ends the program if a server has never answered, because then its address is wrong. A server that
 * has answered may be down for a moment. */
static void look_for(struct cli_remote *remote, const struct attempt *attempt, CURLcode code) {
    curl_off_t begun = 0; /* 0 = there was no connection */
    curl_easy_getinfo(attempt->curl, CURLINFO_PRETRANSFER_TIME_T, &begun);
    if (attempt->page && !busy(attempt->status))
        cli_end(CLI_AWAY, "%ld: %s answers with a web page, so it is not pendulumd: " WHERE,
                attempt->status, remote->url);
    if (code == CURLE_OK || begun > 0)
        remote->met = 1;
    else if (!remote->met)
        cli_end(CLI_AWAY, "no server at %s (%s): " WHERE, remote->url, curl_easy_strerror(code));
}

long cli_remote_ask(struct cli_remote *remote, struct cli_exchange *exchange,
                    struct cli_sink *sink) {
    struct attempt attempt = {.curl = curl_easy_init(), .sink = sink};
    double end = now() + remote->patience, pause = 0.1;
    cli_need(attempt.curl != NULL);
    assert(!exchange->key || exchange->body);
    for (;;) {
        long long before = sink->have;
        CURLcode code = attempt_once(&attempt, remote, exchange);
        look_for(remote, &attempt, code);
        if (settled(&attempt, code)) break;
        if (exchange->resumes && sink->have > before) end = now() + remote->patience, pause = 0.1;
        curl_off_t after = 0;
        curl_easy_getinfo(attempt.curl, CURLINFO_RETRY_AFTER, &after);
        double wait = (double)after > pause ? (double)after : pause;
        if (now() + wait > end) {
            if (code == CURLE_OK) cli_refuse(attempt.status, &sink->text);
            cli_end(CLI_AWAY, "%s: %s", remote->url, curl_easy_strerror(code));
        }
        if (!exchange->resumes) cli_sink_again(sink);
        usleep((useconds_t)(1e6 * wait));
        pause = 2 * pause < 5 ? 2 * pause : 5;
    }
    if (strcmp(exchange->method, "HEAD")) warn(attempt.curl);
    curl_easy_cleanup(attempt.curl);
    assert(attempt.status < 400 || attempt.status == 416);
    return attempt.status;
}
