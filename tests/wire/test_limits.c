#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/wire/ask.h"

/* sends a POST of the long computation and does not wait for its answer */
static int begin_long(struct test_client *client, struct test_server *server, double span) {
    char head[256];
    const char *body = ask_long(span);
    if (!test_client_open(client, test_server_port(server))) return 0;
    snprintf(head, sizeof head,
             "POST /v1/trajectories HTTP/1.1\r\nHost: x\r\nContent-Type: "
             "application/json\r\nContent-Length: %zu\r\n\r\n",
             strlen(body));
    return test_client_say(client, head) && test_client_say(client, body);
}

static void check_retry_after(const struct test_reply *reply) {
    const char *seconds = test_reply_header(reply, "Retry-After");
    CHECK_SAYING(seconds && atoi(seconds) > 0, "Retry-After is %s", seconds);
}

TEST(a_body_that_stops_in_the_middle_gets_408) {
    static const char *const options[] = {"--body-seconds", "0.3", NULL};
    OWN(test_server, stop) *server = test_server_start(options);
    OWN(test_client, close) client = {.fd = -1};
    struct test_reply reply;
    REQUIRE(server != NULL);
    REQUIRE(test_client_open(&client, test_server_port(server)));
    test_client_say(&client,
                    "POST /v1/trees HTTP/1.1\r\nHost: x\r\nContent-Type: application/json\r\n"
                    "Content-Length: 50\r\n\r\n{\"pendulum\":");
    test_client_receive(&client, &reply, 0, TEST_PATIENCE);
    ask_problem(&reply, 408, NULL);
    test_reply_record(&reply, "POST", "/v1/trees");
    test_reply_clear(&reply);
    CHECK(test_client_ended(&client, TEST_PATIENCE));
}

TEST(a_head_that_drips_runs_out_of_time) {
    static const char *const options[] = {"--header-seconds", "0.5", NULL};
    OWN(test_server, stop) *server = test_server_start(options);
    OWN(test_client, close) client = {.fd = -1};
    REQUIRE(server != NULL);
    REQUIRE(test_client_open(&client, test_server_port(server)));
    test_client_say(&client, "GET /healthz HTTP/1.1\r\nHost: x\r\nX: ");
    double begin = test_clock();
    int gone = 0;
    while (!gone && test_clock() - begin < TEST_PATIENCE) {
        gone = !test_client_say(&client, "a");
        test_sleep(0.1);
    }
    CHECK_SAYING(gone, "the server listens to the head for ever");
}

TEST(a_full_queue_is_answered_503) {
    static const char *const options[] = {
        "--workers", "1",           "--max-queue",   "1", "--max-compute-seconds",
        "86400",     "--max-steps", "1000000000000", NULL};
    OWN(test_server, stop) *server = test_server_start(options);
    struct test_client busy, waiting;
    OWN(test_reply, clear) reply = {0};
    REQUIRE(server != NULL);
    REQUIRE(begin_long(&busy, server, 1e6));
    ask_await(server, "pendulumd_workers_busy", 1, 1);
    /* not the same, which would be computed once for both */
    REQUIRE(begin_long(&waiting, server, 2e6));
    ask_await(server, "pendulumd_computations", 2, 2);
    ask(server, &reply, "/v1/trajectories", ASK_EXAMPLE);
    ask_problem(&reply, 503, NULL);
    check_retry_after(&reply);
    test_reply_clear(&reply);
    /* requests that need no worker are answered nevertheless */
    CHECK_INT(test_request(server, &reply, "GET", "/healthz", "", NULL), 200);
    test_client_close(&busy);
    test_client_close(&waiting);
}

TEST(a_computation_that_would_outrun_its_time_is_refused_before_it_runs) {
    static const char *const options[] = {"--max-compute-seconds", "1", NULL};
    OWN(test_server, stop) *server = test_server_start(options);
    OWN(test_reply, clear) reply = {0};
    REQUIRE(server != NULL);
    ask(server, &reply, "/v1/trajectories", ask_long(1000000));
    ask_problem(&reply, 422, NULL);
    CHECK_SAYING(strstr(reply.body, "max-compute-seconds") != NULL, "the limit is not named: %s",
                 reply.body);
}

TEST(a_draining_server_is_not_ready_and_ends_with_its_last_client) {
    static const char *const options[] = {"--max-compute-seconds", "86400", "--max-steps",
                                          "1000000000000", NULL};
    OWN(test_server, stop) *server = test_server_start(options);
    struct test_client open, busy;
    struct test_reply reply;
    REQUIRE(server != NULL);
    REQUIRE(test_client_open(&open, test_server_port(server)));
    test_client_say(&open, "GET /readyz HTTP/1.1\r\nHost: x\r\n\r\n");
    CHECK_INT(test_client_receive(&open, &reply, 0, TEST_PATIENCE), 200);
    test_reply_clear(&reply);
    REQUIRE(begin_long(&busy, server, 1e6));
    ask_await(server, "pendulumd_computations", 1, 1);
    test_server_signal(server, SIGTERM);
    /* the open connection is answered 503, or is closed, as soon as the signal was received */
    int status = 200;
    for (double end = test_clock() + TEST_PATIENCE; status == 200 && test_clock() < end;) {
        test_sleep(0.05);
        test_client_say(&open, "GET /readyz HTTP/1.1\r\nHost: x\r\n\r\n");
        status = test_client_receive(&open, &reply, 0, TEST_PATIENCE);
        test_reply_clear(&reply);
    }
    CHECK_SAYING(status == 503 || status == 0, "status %d", status);
    /* the client leaves, and so nothing delays the server's end */
    test_client_close(&busy);
    test_client_close(&open);
    CHECK_INT(test_server_wait(server), 0);
}

TEST(an_interface_that_ages_says_so_with_every_answer_below_v1) {
    static const char *const options[] = {"--deprecated",
                                          "2026-01-31T01:00:00+01:00",
                                          "--sunset",
                                          "2027-06-30T12:00:00Z",
                                          "--max-body-bytes",
                                          "1024",
                                          NULL};
    static const char *const bad[] = {"--sunset", "soon", NULL};
    struct test_server *server = test_server_start(options);
    struct test_reply reply;
    char text[3000];
    REQUIRE(server != NULL);
    for (int i = 0; i < 3; i++) {
        if (i < 2)
            ask(server, &reply, i ? "/v1/nothing" : "/v1/trees", ASK_LITTLE);
        else
            test_request(server, &reply, "GET", "/healthz", "", NULL);
        const char *since = test_reply_header(&reply, "Deprecation"),
                   *until = test_reply_header(&reply, "Sunset"),
                   *more = test_reply_header(&reply, "Link");
        if (i < 2) {
            CHECK_TEXT(since, "@1769817600");
            CHECK_TEXT(until, "Wed, 30 Jun 2027 12:00:00 GMT");
            CHECK(more && strstr(more, "rel=\"deprecation\"") && strstr(more, "rel=\"sunset\""));
        } else {
            CHECK(!since && !until && !more);
        }
        test_reply_clear(&reply);
    }
    /* an answer in the middle of a body, which bypasses libmicrohttpd */
    struct test_client client;
    REQUIRE(test_client_open(&client, test_server_port(server)));
    snprintf(text, sizeof text,
             "POST /v1/trees HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n"
             "Content-Type: application/json\r\n\r\n800\r\n%0*d",
             2048, 0);
    test_client_say(&client, text);
    CHECK(test_client_receive(&client, &reply, 0, TEST_PATIENCE) && reply.status == 413);
    CHECK_TEXT(test_reply_header(&reply, "Deprecation"), "@1769817600");
    CHECK_TEXT(test_reply_header(&reply, "Sunset"), "Wed, 30 Jun 2027 12:00:00 GMT");
    test_reply_clear(&reply);
    test_client_close(&client);
    test_server_stop(&server);
    CHECK(test_server_run(bad, text, sizeof text) != 0);
    CHECK_SAYING(strstr(text, "sunset") && strstr(text, "2027-01-31T00:00:00Z"), "%s", text);
}

TEST(requests_beyond_a_minutes_quota_are_answered_429) {
    static const char *const options[] = {"--max-requests-a-minute", "2", NULL};
    OWN(test_server, stop) *server = test_server_start(options);
    struct test_reply reply;
    REQUIRE(server != NULL);
    for (int i = 0; i < 3; i++) {
        ask(server, &reply, "/v1/trees", ASK_LITTLE);
        CHECK_TEXT(test_reply_header(&reply, "RateLimit-Limit"), "2");
        CHECK_TEXT(test_reply_header(&reply, "RateLimit-Policy"), "\"requests\";q=2;w=60");
        int left = -1, seconds = -1;
        const char *now = test_reply_header(&reply, "RateLimit");
        CHECK_INT(sscanf(now ? now : "", "\"requests\";r=%d;t=%d", &left, &seconds), 2);
        CHECK_SAYING(left == (i < 2 ? 1 - i : 0) && seconds > 0 && seconds <= 60, "%s", now);
        if (i < 2) CHECK_INT(reply.status, 200);
        if (i == 2) ask_problem(&reply, 429, NULL);
        if (i == 2) check_retry_after(&reply);
        test_reply_clear(&reply);
    }
}

TEST(an_answer_that_flows_has_no_limit_of_size) {
    /* 280 kB, more than any answer that is held in memory may have here */
    static const char *const options[] = {"--max-answer-bytes", "65536", NULL};
    static const char *const flowing[] = {"Accept: application/octet-stream\r\n",
                                          "Accept: application/x-ndjson\r\n",
                                          "Accept: text/csv\r\nAccept-Encoding: gzip\r\n"};
    static const char body[] =
        "{\"pendulum\":" ASK_DOUBLE ",\"times\":{\"start\":0,\"stop\":50,\"step\":0.01}}";
    OWN(test_server, stop) *server = test_server_start(options);
    OWN(test_reply, clear) reply = {0};
    REQUIRE(server != NULL);
    for (size_t i = 0; i < sizeof flowing / sizeof *flowing; i++) {
        CHECK_INT(test_request(server, &reply, "POST", "/v1/trajectories", flowing[i], body), 200);
        CHECK_SAYING(reply.body_bytes > 65536, "%zu bytes", reply.body_bytes);
        test_reply_clear(&reply);
    }
    CHECK_INT(test_request(server, &reply, "POST", "/v1/trajectories", "", body), 422);
}
