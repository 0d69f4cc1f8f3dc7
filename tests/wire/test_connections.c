#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/wire/ask.h"

/* a complete message of a POST of JSON on a connection that stays open */
static char *message(const char *path, const char *body) {
    size_t bytes = strlen(body) + 256;
    char *text = malloc(bytes);
    if (text)
        snprintf(text, bytes,
                 "POST %s HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
                 "Content-Length: %zu\r\n\r\n%s",
                 path, strlen(body), body);
    return text;
}

static int still_healthy(struct test_server *server) {
    OWN(test_reply, clear) reply;
    int status = ask(server, &reply, "/v1/trees", ASK_LITTLE);
    return status == 200;
}

TEST(one_connection_serves_many_requests) {
    OWN(test_server, stop) *server = test_server_start(NULL);
    OWN(test_client, close) client = {.fd = -1};
    struct test_reply reply;
    OWN_MEMORY char *text = message("/v1/trees", ASK_LITTLE);
    REQUIRE(server != NULL);
    REQUIRE(test_client_open(&client, test_server_port(server)));
    for (int i = 0; i < 200; i++) {
        test_client_say(&client, text);
        if (!CHECK_INT(test_client_receive(&client, &reply, 0, TEST_PATIENCE), 200)) break;
        CHECK(reply.keep_alive);
        test_reply_clear(&reply);
    }
}

TEST(pipelined_requests_are_answered_in_their_order) {
    OWN(test_server, stop) *server = test_server_start(NULL);
    OWN(test_client, close) client = {.fd = -1};
    struct test_reply reply;
    enum { COUNT = 20 };
    REQUIRE(server != NULL);
    REQUIRE(test_client_open(&client, test_server_port(server)));
    /* slow and fast ones mixed: the fast ones must not overtake */
    for (int i = 0; i < COUNT; i++) {
        OWN_MEMORY char *text =
            i % 5 ? message("/v1/trees", ASK_LITTLE) : message("/v1/trajectories", ASK_EXAMPLE);
        test_client_say(&client, text);
    }
    for (int i = 0; i < COUNT; i++) {
        if (!CHECK_INT(test_client_receive(&client, &reply, 0, TEST_PATIENCE), 200)) break;
        CHECK_SAYING((strstr(reply.body, "\"lambda\"") != NULL) == (i % 5 == 0),
                     "answer %d is another's", i);
        test_reply_clear(&reply);
    }
}

TEST(an_answer_to_http_1_0_ends_with_the_connection) {
    OWN(test_server, stop) *server = test_server_start(NULL);
    OWN(test_client, close) client = {.fd = -1};
    struct test_reply reply;
    REQUIRE(server != NULL);
    REQUIRE(test_client_open(&client, test_server_port(server)));
    test_client_say(&client, "GET /healthz HTTP/1.0\r\n\r\n");
    CHECK_INT(test_client_receive(&client, &reply, 0, TEST_PATIENCE), 200);
    CHECK(!test_reply_header(&reply, "Transfer-Encoding"));
    test_reply_clear(&reply);
    CHECK(test_client_ended(&client, TEST_PATIENCE));
}

TEST(expect_100_continue_is_answered_before_the_body) {
    OWN(test_server, stop) *server = test_server_start(NULL);
    OWN(test_client, close) client = {.fd = -1};
    OWN(test_reply, clear) reply = {0};
    char head[256];
    REQUIRE(server != NULL);
    REQUIRE(test_client_open(&client, test_server_port(server)));
    snprintf(head, sizeof head,
             "POST /v1/trees HTTP/1.1\r\nHost: x\r\nContent-Type: application/json\r\nExpect: "
             "100-continue\r\n"
             "Content-Length: %zu\r\n\r\n",
             strlen(ASK_LITTLE));
    test_client_say(&client, head);
    struct pollfd look = {.fd = client.fd, .events = POLLIN};
    CHECK_INT(poll(&look, 1, 1000 * TEST_PATIENCE), 1);
    test_client_say(&client, ASK_LITTLE);
    CHECK_INT(test_client_receive(&client, &reply, 0, TEST_PATIENCE), 200);
    CHECK_INT(reply.interim, 1);
}

TEST(a_request_that_drips_in_is_answered_all_the_same) {
    OWN(test_server, stop) *server = test_server_start(NULL);
    OWN(test_client, close) client = {.fd = -1};
    OWN(test_reply, clear) reply = {0};
    OWN_MEMORY char *text = message("/v1/trees", ASK_LITTLE);
    REQUIRE(server != NULL);
    REQUIRE(test_client_open(&client, test_server_port(server)));
    for (size_t i = 0; text[i]; i++) {
        test_client_send(&client, text + i, 1);
        if (i % 16 == 0) test_sleep(0.002);
    }
    CHECK_INT(test_client_receive(&client, &reply, 0, TEST_PATIENCE), 200);
}

TEST(many_half_requests_hold_nobody_up) {
    OWN(test_server, stop) *server = test_server_start(NULL);
    enum { COUNT = 100 };
    struct test_client slow[COUNT];
    REQUIRE(server != NULL);
    for (int i = 0; i < COUNT; i++) {
        test_client_open(&slow[i], test_server_port(server));
        test_client_say(
            &slow[i],
            i % 2 ? "POST /v1/trees HTTP/1.1\r\nHost: x\r\nContent-Le"
                  : "POST /v1/trees HTTP/1.1\r\nHost: x\r\nContent-Type: application/json\r\n"
                    "Content-Length: 1000\r\n\r\n{\"pend");
    }
    for (int i = 0; i < 20; i++) CHECK(still_healthy(server));
    for (int i = 0; i < COUNT; i++) test_client_close(&slow[i]);
}

TEST(a_client_that_vanishes_leaves_no_computation_behind) {
    static const char *const options[] = {
        "--workers", "1", "--max-compute-seconds", "86400", "--max-steps", "1000000000000", NULL};
    OWN(test_server, stop) *server = test_server_start(options);
    REQUIRE(server != NULL);
    /* six that would take more than an hour each */
    for (int i = 0; i < 6; i++) {
        struct test_client client;
        char *text = message("/v1/trajectories", ask_long(1e6 + i));
        REQUIRE(text && test_client_open(&client, test_server_port(server)));
        test_client_say(&client, text);
        free(text);
        ask_await(server, "pendulumd_computations", 1, 1);
        test_client_close(&client);
        ask_await(server, "pendulumd_computations", 0, 0);
    }
    CHECK(still_healthy(server));
}

TEST(a_client_that_stops_reading_stalls_only_itself) {
    OWN(test_server, stop) *server = test_server_start(NULL);
    enum { COUNT = 8 };
    struct test_client lazy[COUNT];
    OWN_MEMORY char *text =
        message("/v1/trajectories", "{\"pendulum\":" ASK_DOUBLE
                                    ",\"times\":{\"start\":0,\"stop\":10,\"count\":20001}}");
    REQUIRE(server != NULL);
    for (int i = 0; i < COUNT; i++) {
        REQUIRE(test_client_open(&lazy[i], test_server_port(server)));
        test_client_say(&lazy[i], text);
    }
    test_sleep(0.2);
    for (int i = 0; i < 5; i++) CHECK(still_healthy(server));
    struct test_reply reply;
    CHECK_INT(test_client_receive(&lazy[0], &reply, 0, TEST_PATIENCE), 200);
    test_reply_clear(&reply);
    for (int i = 0; i < COUNT; i++) test_client_close(&lazy[i]);
}

struct crowd {
    struct test_server *server;
    const char *text;
    int good;
};

static void *crowd_member(void *context) {
    struct crowd *crowd = context;
    OWN(test_client, close) client;
    struct test_reply reply;
    if (!test_client_open(&client, test_server_port(crowd->server))) return NULL;
    for (int i = 0; i < 10; i++) {
        if (!test_client_say(&client, crowd->text)) break;
        if (test_client_receive(&client, &reply, 0, TEST_PATIENCE) == 200)
            __atomic_add_fetch(&crowd->good, 1, __ATOMIC_RELAXED);
        test_reply_clear(&reply);
    }
    return NULL;
}

TEST(many_clients_at_once_all_get_their_answers) {
    enum { COUNT = 64 };
    pthread_t thread[COUNT];
    char *text = message("/v1/trajectories",
                         "{\"pendulum\":" ASK_DOUBLE ",\"times\":{\"start\":0,\"stop\":1,"
                         "\"step\":0.01}}");
    struct crowd crowd = {test_server_start(NULL), text, 0};
    REQUIRE(crowd.server != NULL);
    for (int i = 0; i < COUNT; i++) pthread_create(&thread[i], NULL, crowd_member, &crowd);
    for (int i = 0; i < COUNT; i++) pthread_join(thread[i], NULL);
    CHECK_INT(crowd.good, 10 * COUNT);
    free(text);
    test_server_stop(&crowd.server);
}

/* one turn of a server's loop can find them all at once: as many as libmicrohttpd takes from the
 * system at a time, one fewer, one more, and twice as many */
TEST(requests_that_come_at_the_same_moment_are_all_answered) {
    static const int counts[] = {127, 128, 129, 256};
    enum { MOST = 256 };
    static struct test_client client[MOST];
    OWN(test_server, stop) *server = test_server_start(NULL);
    REQUIRE(server != NULL);
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++) {
        int good = 0;
        for (int k = 0; k < counts[i]; k++)
            REQUIRE(test_client_open(&client[k], test_server_port(server)));
        /* the first round leaves every connection idle and known; in the second the server finds
         * all of them ready */
        for (int round = 0; round < 2; round++) {
            struct test_reply reply;
            if (round) test_server_signal(server, SIGSTOP);
            for (int k = 0; k < counts[i]; k++)
                test_client_say(&client[k], "GET /healthz HTTP/1.1\r\nHost: x\r\n\r\n");
            if (round) test_server_signal(server, SIGCONT);
            for (int k = 0; k < counts[i] && good == k + round * counts[i]; k++) {
                good += test_client_receive(&client[k], &reply, 0, TEST_PATIENCE) == 200;
                test_reply_clear(&reply);
            }
            test_sleep(0.05);
        }
        CHECK_SAYING(good == 2 * counts[i], "of %d requests at once, only %d were answered",
                     counts[i], good - counts[i]);
        for (int k = 0; k < counts[i]; k++) test_client_close(&client[k]);
    }
}

TEST(a_head_without_end_is_refused) {
    OWN(test_server, stop) *server = test_server_start(NULL);
    struct test_client client;
    struct test_reply reply;
    char line[1024];
    memset(line, 'a', sizeof line - 1);
    line[sizeof line - 1] = 0;
    REQUIRE(server != NULL);
    REQUIRE(test_client_open(&client, test_server_port(server)));
    test_client_say(&client, "GET /healthz HTTP/1.1\r\nHost: x\r\nX: ");
    for (int i = 0; i < 1024; i++)
        if (!test_client_say(&client, line)) break;
    int status = test_client_receive(&client, &reply, 0, TEST_PATIENCE);
    CHECK_SAYING(status == 0 || status == 413 || status == 431 || status == 400, "status %d",
                 status);
    test_reply_clear(&reply);
    test_client_close(&client);
    CHECK(still_healthy(server));
}
