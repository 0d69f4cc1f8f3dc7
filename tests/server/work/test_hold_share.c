/* Tests of server/work/compute and server/work/inflight through a daemon: sharing, streaming,
 * cutting, counting and refusing. */
#include "server/work/inflight.h"

#include <poll.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>

#include "tests/harness/test.h"
#include "tests/server/live.h"

#define DOUBLE                                                                                     \
    "{\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1]},\"output\":[\"phi\"],"

#define JOINED "pendulumd_cache_lookups_total{result=\"joined\"} "
#define EXACT "pendulumd_cache_lookups_total{result=\"exact\"} "
#define MISSED "pendulumd_cache_lookups_total{result=\"missed\"} "

/* posts with further header lines; uses QUERY if the client may have the answer */
static int share_post(const struct srv_daemon *daemon, struct test_client *client,
                      const char *headers, const char *body) {
    char text[4096];
    snprintf(text, sizeof text,
             "%s /v1/trajectories HTTP/1.1\r\nHost: x\r\nContent-Type: "
             "application/json\r\n%sContent-Length: %zu\r\n\r\n%s",
             strstr(headers, "If-None-Match") ? "QUERY" : "POST", headers, strlen(body), body);
    return live_say(daemon, client, text);
}

static int share_ask(const struct srv_daemon *daemon, struct test_reply *reply, const char *headers,
                     const char *body) {
    OWN(test_client, close) client;
    *reply = (struct test_reply){0};
    if (!share_post(daemon, &client, headers, body)) return 0;
    return test_client_receive(&client, reply, 0, TEST_PATIENCE);
}

static const char *share_header(const struct test_reply *reply, const char *name) {
    const char *value = test_reply_header(reply, name);
    return value ? value : "";
}

TEST(the_same_again_comes_from_the_cache_in_every_coding) {
    OWN(srv_daemon, free) *daemon = live_start(NULL);
    OWN(test_reply, clear) first = {0}, reply = {0};
    static const char body[] = DOUBLE "\"times\":{\"start\":0,\"stop\":5,\"step\":0.01}}";
    /* the same request in another spelling */
    static const char other[] = "{\"times\":{\"step\":1e-2,\"stop\":5.0,\"start\":0},\"output\":["
                                "\"phi\"],\"pendulum\":{\"parent\":[0,1],\"mass\":[1,1.0],"
                                "\"length\":[1,1]}}";
    static const char *const gzip = "Accept-Encoding: gzip\r\n", *const zstd =
                                                                     "Accept-Encoding: zstd\r\n";
    char match[256];
    REQUIRE(daemon != NULL);
    CHECK_INT(share_ask(daemon, &first, "", body), 200);
    CHECK(!test_reply_header(&first, "Content-Encoding"));
    CHECK_TEXT(test_reply_header(&first, "Vary"), "Accept, Accept-Encoding");
    snprintf(match, sizeof match, "If-None-Match: \"x\", %s\r\n", share_header(&first, "ETag"));
    for (int turn = 0; turn < 2; turn++) {
        CHECK_INT(share_ask(daemon, &reply, "", turn ? body : other), 200);
        CHECK(reply.body_bytes == first.body_bytes &&
              !memcmp(reply.body, first.body, first.body_bytes));
        CHECK_TEXT(test_reply_header(&reply, "ETag"), share_header(&first, "ETag"));
        test_reply_clear(&reply);
        for (int coding = 0; coding < 2; coding++) {
            CHECK_INT(share_ask(daemon, &reply, coding ? zstd : gzip, body), 200);
            CHECK_TEXT(test_reply_header(&reply, "Content-Encoding"), coding ? "zstd" : "gzip");
            CHECK(reply.body_bytes < 0.7 * (double)first.body_bytes);
            test_reply_clear(&reply);
        }
        CHECK_INT(share_ask(daemon, &reply, match, turn ? body : other), 304);
        CHECK_TEXT(test_reply_header(&reply, "ETag"), share_header(&first, "ETag"));
        CHECK_INT(atoi(share_header(&reply, "Content-Length")), (int)first.body_bytes);
        test_reply_clear(&reply);
    }
    CHECK(live_metric(daemon, MISSED) == 1);
    CHECK(live_metric(daemon, EXACT) >= 4);
    CHECK(live_metric(daemon, "pendulumd_cache_lookups_total{result=\"digest\"} ") >= 2);
    CHECK_INT((long)live_metric(daemon, "pendulumd_not_modified_total "), 2);
    /* another representation is another answer */
    CHECK_INT(share_ask(daemon, &reply, "Accept: text/csv\r\n", body), 200);
    CHECK(strcmp(share_header(&reply, "ETag"), share_header(&first, "ETag")) != 0);
    CHECK(!strncmp(reply.body, "t,phi_1,phi_2", 13));
}

TEST(without_a_cache_304_needs_no_computation_all_the_same) {
    static const char *const options[] = {"--cache-bytes", "0", "--compress-above", "0", NULL};
    static const char body[] = DOUBLE "\"times\":{\"start\":0,\"stop\":5,\"step\":0.01}}";
    OWN(srv_daemon, free) *daemon = live_start(options);
    struct test_reply reply;
    char match[256];
    REQUIRE(daemon != NULL);
    CHECK_INT(share_ask(daemon, &reply, "Accept-Encoding: gzip\r\n", body), 200);
    CHECK(!test_reply_header(&reply, "Content-Encoding"));
    snprintf(match, sizeof match, "If-None-Match: %s\r\n", share_header(&reply, "ETag"));
    test_reply_clear(&reply);
    CHECK_INT(share_ask(daemon, &reply, match, body), 304);
    test_reply_clear(&reply);
    CHECK_INT(share_ask(daemon, &reply, "", body), 200);
    test_reply_clear(&reply);
    CHECK(live_metric(daemon, MISSED) == 2);
    CHECK(live_metric(daemon, "pendulumd_cache_bytes ") == 0);
}

enum { CLASS = 12 };

/* a daemon that computes one answer for all clients; if it was over before all had joined, it is
 * repeated with a longer one */
static struct srv_daemon *class_joined(struct test_client client[CLASS]) {
    static const char *const options[] = {"--workers", "2", NULL};
    for (int stop = 12000; stop < 10000000; stop *= 4) {
        struct srv_daemon *daemon = live_start(options);
        char body[256];
        double joined = 0, exact = 0;
        snprintf(body, sizeof body, DOUBLE "\"times\":{\"start\":0,\"stop\":%d,\"count\":5}}",
                 stop);
        for (int i = 0; i < CLASS; i++) {
            if (!daemon || !share_post(daemon, &client[i], "", body)) return NULL;
            if (!i) live_await_least(daemon, "pendulumd_slices_total ", 1);
        }
        for (double until = test_clock() + TEST_PATIENCE;
             joined + exact < CLASS - 1 && test_clock() < until;) {
            joined = live_metric(daemon, JOINED);
            exact = live_metric(daemon, EXACT);
        }
        if (joined == CLASS - 1) return daemon;
        for (int i = 0; i < CLASS; i++) test_client_close(&client[i]);
        srv_daemon_free(&daemon);
    }
    return NULL;
}

TEST(a_class_that_asks_the_same_is_computed_for_once_and_who_leaves_disturbs_nobody) {
    struct test_client client[CLASS];
    struct test_reply reply[CLASS];
    OWN(srv_daemon, free) *daemon = class_joined(client);
    REQUIRE(daemon != NULL);
    /* the one that started it leaves, and one of the others */
    test_client_close(&client[0]);
    test_client_close(&client[5]);
    for (int i = 1; i < CLASS; i++) {
        if (i == 5) continue;
        CHECK_INT(test_client_receive(&client[i], &reply[i], 0, TEST_PATIENCE), 200);
        CHECK_TEXT(reply[i].body, reply[1].body);
    }
    for (int i = 1; i < CLASS; i++) {
        if (i == 5) continue;
        test_reply_clear(&reply[i]);
        test_client_close(&client[i]);
    }
    CHECK(live_metric(daemon, MISSED) == 1);
    CHECK(live_metric(daemon, "pendulumd_cancelled_total ") == 0);
    live_await(daemon, "pendulumd_computations ", 0);
}

TEST(an_answer_of_megabytes_is_shared_and_kept_too) {
    enum { FEW = 6 };
    static const char before[] = DOUBLE "\"times\":{\"start\":0,\"stop\":6000,\"count\":5}}";
    static const char body[] = DOUBLE "\"times\":{\"start\":0,\"stop\":200,\"count\":150001}}";
    static const char *const options[] = {"--workers", "1", NULL},
                             *const octets = "Accept: application/octet-stream\r\n";
    OWN(srv_daemon, free) *daemon = live_start(options);
    struct test_client blocker, client[FEW];
    struct test_reply reply[FEW], again;
    REQUIRE(daemon != NULL);
    /* while the worker is busy with another request, all of them arrive */
    REQUIRE(share_post(daemon, &blocker, "", before));
    live_await(daemon, "pendulumd_computations ", 1);
    for (int i = 0; i < FEW; i++) REQUIRE(share_post(daemon, &client[i], octets, body));
    for (int i = 0; i < FEW; i++) {
        CHECK_INT(test_client_receive(&client[i], &reply[i], 0, TEST_PATIENCE), 200);
        CHECK_INT((long long)reply[i].body_bytes, 150001 * 3 * 8);
        CHECK_TEXT(test_reply_header(&reply[i], "Content-Length"), "3600024");
        CHECK(!memcmp(reply[i].body, reply[0].body, reply[0].body_bytes));
        test_client_close(&client[i]);
    }
    /* computed for one of them; late ones got it from the cache */
    double exact = live_metric(daemon, EXACT);
    CHECK(live_metric(daemon, JOINED) + exact == FEW - 1);
    CHECK_INT(share_ask(daemon, &again, octets, body), 200);
    CHECK(again.body_bytes == reply[0].body_bytes &&
          !memcmp(again.body, reply[0].body, again.body_bytes));
    CHECK(live_metric(daemon, EXACT) == exact + 1);
    test_reply_clear(&again);
    for (int i = 0; i < FEW; i++) test_reply_clear(&reply[i]);
    test_client_close(&blocker);
    live_await(daemon, "pendulumd_computations ", 0);
    /* the cache holds the rest, up to a few bytes */
    double held = live_metric(daemon, "pendulumd_held_bytes ");
    CHECK_SAYING(held >= 3600024 && held < 6e6, "%.0f bytes are held", held);
}

#define STREAM DOUBLE "\"times\":{\"start\":0,\"stop\":3000,\"count\":300001}}"

TEST(a_long_answer_flows_and_is_the_same_in_every_coding_and_protocol) {
    OWN(srv_daemon, free) *daemon = live_start(NULL);
    struct test_client client;
    struct test_reply reply, coded, old;
    char text[1024];
    REQUIRE(daemon != NULL);
    CHECK_INT(share_ask(daemon, &reply, "Accept: text/csv\r\n", STREAM), 200);
    CHECK_TEXT(test_reply_header(&reply, "Transfer-Encoding"), "chunked");
    CHECK(reply.body_bytes > 10000000 && reply.body[reply.body_bytes - 1] == '\n');
    int lines = 0;
    for (size_t i = 0; i < reply.body_bytes; i++) lines += reply.body[i] == '\n';
    CHECK_INT(lines, 300003); /* the last one is a warning: the accuracy is lost before the end */
    CHECK(strstr(reply.body + reply.body_bytes - 300, "\n# warning: accuracy is lost") &&
          reply.trailer && strstr(reply.trailer, "X-Horizon: ") &&
          strstr(reply.trailer, "X-Warning: accuracy is lost"));
    CHECK_INT(share_ask(daemon, &coded, "Accept: text/csv\r\nAccept-Encoding: zstd\r\n", STREAM),
              200);
    CHECK_TEXT(test_reply_header(&coded, "Content-Encoding"), "zstd");
    CHECK(coded.body_bytes < 0.7 * (double)reply.body_bytes &&
          coded.body_bytes > 0.2 * (double)reply.body_bytes);
    /* HTTP/1.0 has no chunks: the end of the connection is the end of the body */
    snprintf(text, sizeof text,
             "POST /v1/trajectories HTTP/1.0\r\nContent-Type: application/json\r\nAccept: "
             "text/csv\r\nContent-Length: %zu\r\n\r\n%s",
             strlen(STREAM), STREAM);
    REQUIRE(live_say(daemon, &client, text));
    CHECK_INT(test_client_receive(&client, &old, 0, TEST_PATIENCE), 200);
    CHECK(old.body_bytes == reply.body_bytes && !memcmp(old.body, reply.body, old.body_bytes));
    test_client_close(&client);
    test_reply_clear(&reply);
    test_reply_clear(&coded);
    test_reply_clear(&old);
    live_await(daemon, "pendulumd_computations ", 0);
    CHECK(live_metric(daemon, "pendulumd_held_bytes ") < 100000);
}

#define ENDLESS DOUBLE "\"times\":{\"start\":0,\"stop\":3000,\"count\":1000000}}"

TEST(a_slow_reader_holds_little_memory_and_no_worker_and_is_missed_at_once) {
    enum { SLOW = 6 };
    static const char *const options[] = {"--workers", "1", "--max-samples", "2000000", NULL};
    OWN(srv_daemon, free) *daemon = live_start(options);
    struct test_client slow[SLOW];
    struct test_reply reply;
    REQUIRE(daemon != NULL);
    for (int i = 0; i < SLOW; i++) {
        char body[512];
        snprintf(body, sizeof body, DOUBLE "\"times\":{\"start\":0,\"stop\":%d,\"count\":1000001}}",
                 3000 + i);
        REQUIRE(share_post(daemon, &slow[i], "Accept: text/csv\r\n", body));
    }
    /* they pause once the sockets are full: the worker is idle */
    live_await(daemon, "pendulumd_workers_busy ", 0);
    double busy = 1;
    for (double until = test_clock() + TEST_PATIENCE; busy > 0 && test_clock() < until;) {
        double before = live_metric(daemon, "pendulumd_worker_busy_seconds_total ");
        test_sleep(0.1);
        busy = live_metric(daemon, "pendulumd_worker_busy_seconds_total ") - before;
    }
    CHECK(busy == 0);
    CHECK(live_metric(daemon, "pendulumd_computations ") == SLOW);
    double held = live_metric(daemon, "pendulumd_held_bytes ");
    /* the bytes before the first were sent, 8 MiB at most, and two blocks */
    CHECK_SAYING(held > SLOW * 200000 && held < SLOW * 10.5e6, "%g bytes are held", held);
    CHECK_INT(share_ask(daemon, &reply, "", DOUBLE "\"times\":[0,1]}"), 200);
    test_reply_clear(&reply);
    double begin = test_clock();
    for (int i = 0; i < SLOW; i++) test_client_close(&slow[i]);
    live_await(daemon, "pendulumd_computations ", 0);
    printf("  %d streams were over %.0f ms after their clients had gone\n", SLOW,
           1e3 * (test_clock() - begin));
}

TEST(a_reader_that_does_not_read_runs_out_of_time) {
    static const char *const options[] = {"--send-seconds", "0.5", "--least-rate", "100M", NULL};
    OWN(srv_daemon, free) *daemon = live_start(options);
    OWN(test_client, close) slow = {.fd = -1};
    REQUIRE(daemon != NULL);
    REQUIRE(share_post(daemon, &slow, "Accept: text/csv\r\n", ENDLESS));
    live_await_least(daemon, "pendulumd_slices_total ", 1);
    live_await(daemon, "pendulumd_computations ", 0);
    CHECK(live_metric(daemon, "pendulumd_held_bytes ") < 100000);
}

TEST(a_stream_that_breaks_is_seen_to_be_incomplete) {
    for (int old = 0; old < 2; old++) {
        OWN(srv_daemon, free) *daemon = live_start(NULL);
        OWN(test_client, close) client = {.fd = -1};
        OWN(test_reply, clear) reply = {0};
        char text[1024];
        REQUIRE(daemon != NULL);
        snprintf(text, sizeof text,
                 "POST /v1/trajectories HTTP/1.%d\r\nHost: x\r\nContent-Type: "
                 "application/json\r\nAccept: text/csv\r\nContent-Length: %zu\r\n\r\n%s",
                 !old, strlen(ENDLESS), ENDLESS);
        REQUIRE(live_say(daemon, &client, text));
        live_await(daemon, "pendulumd_computations ", 1);
        struct pollfd look = {.fd = client.fd, .events = POLLIN};
        CHECK_INT(poll(&look, 1, 1000 * TEST_PATIENCE), 1);
        /* in a hurry: the server cancels running computations */
        srv_daemon_drain(daemon, 1);
        int status = test_client_receive(&client, &reply, 0, TEST_PATIENCE);
        /* the test's client, like others, does not notice the end of an HTTP/1.0 answer that ends
         * without a reset */
        CHECK_INT(status, 0);
    }
}

TEST(requests_a_minute_are_counted_for_each_client) {
    static const char *const options[] = {"--max-requests-a-minute",
                                          "3",
                                          "--trusted-proxy",
                                          "127.0.0.0/8",
                                          "--cache-bytes",
                                          "0",
                                          NULL};
    static const char body[] = DOUBLE "\"times\":[0,1]}";
    OWN(srv_daemon, free) *daemon = live_start(options);
    struct test_reply reply;
    REQUIRE(daemon != NULL);
    for (int i = 0; i < 5; i++) {
        CHECK_INT(share_ask(daemon, &reply, "X-Forwarded-For: 192.0.2.1\r\n", body),
                  i < 3 ? 200 : 429);
        CHECK_TEXT(test_reply_header(&reply, "RateLimit-Limit"), "3");
        CHECK_INT(atoi(share_header(&reply, "RateLimit-Remaining")), i < 3 ? 2 - i : 0);
        CHECK(atoi(share_header(&reply, "RateLimit-Reset")) > 0);
        if (i >= 3)
            CHECK(atoi(share_header(&reply, "Retry-After")) > 0 &&
                  strstr(reply.body, "max-requests-a-minute"));
        test_reply_clear(&reply);
    }
    CHECK_INT(share_ask(daemon, &reply, "X-Forwarded-For: 192.0.2.2\r\n", body), 200);
    test_reply_clear(&reply);
    /* requests that compute nothing are not counted */
    CHECK_INT(live_status(daemon,
                          "GET /healthz HTTP/1.1\r\nHost: x\r\nX-Forwarded-For: 192.0.2.1\r\n\r\n"),
              200);
    CHECK(live_metric(daemon, "pendulumd_refused_total{limit=\"max-requests-a-minute\"} ") == 2);
}

TEST(one_client_cannot_fill_the_queue) {
    static const char *const options[] = {
        "--workers",       "1",         "--max-queue", "20", "--max-client-queue", "3",
        "--trusted-proxy", "127.0.0.1", NULL};
    OWN(srv_daemon, free) *daemon = live_start(options);
    struct test_client client[8];
    struct test_reply reply;
    REQUIRE(daemon != NULL);
    for (int i = 0; i < 8; i++) {
        char body[512];
        snprintf(body, sizeof body, DOUBLE "\"times\":{\"start\":0,\"stop\":%d,\"count\":5}}",
                 100000000 + i);
        REQUIRE(share_post(daemon, &client[i], "X-Forwarded-For: 192.0.2.1\r\n", body));
        if (i == 0) live_await(daemon, "pendulumd_workers_busy ", 1);
        if (i < 4) live_await(daemon, "pendulumd_computations ", i + 1);
        if (i < 4) continue; /* three wait, whichever of the four the worker has */
        CHECK_INT(test_client_receive(&client[i], &reply, 0, TEST_PATIENCE), 429);
        test_reply_clear(&reply);
    }
    /* another client is served at once, before those that take many minutes */
    CHECK_INT(
        share_ask(daemon, &reply, "X-Forwarded-For: 192.0.2.2\r\n", DOUBLE "\"times\":[0,1]}"),
        200);
    test_reply_clear(&reply);
    for (int i = 0; i < 8; i++) test_client_close(&client[i]);
    CHECK(live_metric(daemon, "pendulumd_refused_total{limit=\"max-client-queue\"} ") == 4);
    live_await(daemon, "pendulumd_computations ", 0);
}

/* a new token for each request fills three quarters of the queue, and takes turns with others */
TEST(one_address_cannot_fill_the_queue_with_tokens) {
    enum { TOKENS = 12 };
    static const char *const options[] = {
        "--workers",       "1",         "--max-queue", "8", "--max-client-queue", "3",
        "--trusted-proxy", "127.0.0.1", NULL};
    OWN(srv_daemon, free) *daemon = live_start(options);
    struct test_client client[TOKENS];
    struct test_reply reply;
    REQUIRE(daemon != NULL);
    for (int i = 0; i < TOKENS; i++) {
        char body[512], headers[160];
        snprintf(body, sizeof body, DOUBLE "\"times\":{\"start\":0,\"stop\":%d,\"count\":5}}",
                 100000000 + i);
        snprintf(headers, sizeof headers,
                 "X-Forwarded-For: 192.0.2.1\r\nAuthorization: Bearer a-new-one-each-time-%04d\r\n",
                 i);
        REQUIRE(share_post(daemon, &client[i], headers, body));
        if (i == 0) live_await(daemon, "pendulumd_workers_busy ", 1);
        if (i < 7) live_await(daemon, "pendulumd_computations ", i + 1);
        if (i < 7) continue; /* six wait, whichever the worker has */
        CHECK_INT(test_client_receive(&client[i], &reply, 0, TEST_PATIENCE), 429);
        test_reply_clear(&reply);
    }
    CHECK_INT(
        share_ask(daemon, &reply, "X-Forwarded-For: 192.0.2.2\r\n", DOUBLE "\"times\":[0,1]}"),
        200);
    test_reply_clear(&reply);
    for (int i = 0; i < TOKENS; i++) test_client_close(&client[i]);
    live_await(daemon, "pendulumd_computations ", 0);
}

TEST(pages_of_other_origins_may_ask_and_traces_go_on) {
    static const char trace[] = "00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01";
    static const char *const options[] = {"--cors-origins", "https://a.org, https://b.org", NULL};
    OWN(srv_daemon, free) *daemon = live_start(NULL);
    OWN(test_client, close) client = {.fd = -1};
    OWN(test_reply, clear) reply = {0};
    char text[512];
    REQUIRE(daemon != NULL);
    REQUIRE(live_say(daemon, &client,
                     "OPTIONS /v1/trees HTTP/1.1\r\nHost: x\r\nOrigin: "
                     "https://c.org\r\nAccess-Control-Request-Method: "
                     "POST\r\nAccess-Control-Request-Headers: content-type, x-y\r\n\r\n"));
    CHECK_INT(test_client_receive(&client, &reply, 0, TEST_PATIENCE), 204);
    CHECK_TEXT(test_reply_header(&reply, "Access-Control-Allow-Origin"), "*");
    CHECK_TEXT(test_reply_header(&reply, "Access-Control-Allow-Methods"), "POST, QUERY, OPTIONS");
    CHECK(strstr(share_header(&reply, "Access-Control-Allow-Headers"), "Content-Type, ") != NULL);
    CHECK(!strstr(share_header(&reply, "Access-Control-Allow-Headers"), "x-y"));
    CHECK_TEXT(test_reply_header(&reply, "Allow"), "POST, QUERY, OPTIONS");
    test_reply_clear(&reply);
    snprintf(text, sizeof text,
             "GET /healthz HTTP/1.1\r\nHost: x\r\nOrigin: https://c.org\r\ntraceparent: %s\r\n\r\n",
             trace);
    test_client_say(&client, text);
    CHECK_INT(test_client_receive(&client, &reply, 0, TEST_PATIENCE), 200);
    CHECK_TEXT(test_reply_header(&reply, "Traceparent"), trace);
    CHECK(strstr(share_header(&reply, "Access-Control-Expose-Headers"), "X-Columns") != NULL);
    test_reply_clear(&reply);
    /* an invalid trace is not passed on */
    test_client_say(&client, "GET /healthz HTTP/1.1\r\nHost: x\r\ntraceparent: 00-xyz\r\n\r\n");
    CHECK_INT(test_client_receive(&client, &reply, 0, TEST_PATIENCE), 200);
    CHECK(!test_reply_header(&reply, "Traceparent"));
    test_reply_clear(&reply);
    test_client_close(&client);
    srv_daemon_free(&daemon);
    daemon = live_start(options);
    REQUIRE(daemon &&
            live_say(daemon, &client,
                     "GET /healthz HTTP/1.1\r\nHost: x\r\nOrigin: https://b.org\r\n\r\n"));
    CHECK_INT(test_client_receive(&client, &reply, 0, TEST_PATIENCE), 200);
    CHECK_TEXT(test_reply_header(&reply, "Access-Control-Allow-Origin"), "https://b.org");
    CHECK_TEXT(test_reply_header(&reply, "Vary"), "Origin");
    test_reply_clear(&reply);
    test_client_say(&client, "GET /healthz HTTP/1.1\r\nHost: x\r\nOrigin: https://c.org\r\n\r\n");
    CHECK_INT(test_client_receive(&client, &reply, 0, TEST_PATIENCE), 200);
    CHECK(!test_reply_header(&reply, "Access-Control-Allow-Origin"));
}

TEST(what_is_known_of_the_digits_is_told_with_every_answer) {
    static const char octets[] = "Accept: application/octet-stream\r\n",
                      trusted[] = DOUBLE "\"initial\":{\"theta\":[2,2.5]},\"trust\":true,\"times\":"
                                         "{\"start\":0,\"stop\":20,\"count\":40001}}";
    OWN(srv_daemon, free) *daemon = live_start(NULL);
    OWN(test_reply, clear) reply = {0};
    REQUIRE(daemon != NULL);
    /* doubles cannot contain it: before the body, or after it if it is sent while it is computed */
    CHECK_INT(share_ask(daemon, &reply, octets, STREAM), 200);
    CHECK(reply.trailer
              ? strstr(reply.trailer, "X-Horizon: ") && strstr(reply.trailer, "X-Warning: ") &&
                    strstr(share_header(&reply, "Trailer"), "X-Horizon")
              : *share_header(&reply, "X-Horizon") && *share_header(&reply, "X-Warning"));
    CHECK_INT((long long)reply.body_bytes, 300001 * 24);
    test_reply_clear(&reply);
    /* values that the request determines are sent before the body */
    CHECK_INT(share_ask(daemon, &reply, octets, trusted), 200);
    double until = atof(share_header(&reply, "X-Trust-Until")),
           horizon = atof(share_header(&reply, "X-Horizon"));
    CHECK_SAYING(!reply.trailer && horizon > 0.5 * until && horizon <= 1.1 * until &&
                     *share_header(&reply, "X-Warning"),
                 "%g and %g", horizon, until);
}
