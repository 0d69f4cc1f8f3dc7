/* Tests of server/daemon and server/http/http: all parts together, with real sockets. */
#include "server/base/clock.h"
#include "server/daemon.h"

#include <netinet/in.h>
#include <poll.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "server/base/clock.h"
#include "server/http/http.h"
#include "server/http/watch.h"
#include "tests/harness/test.h"
#include "tests/server/live.h"

#define HEALTH "GET /healthz HTTP/1.1\r\nHost: x\r\n\r\n"
/* the same, relayed by a proxy */
#define RELAYED "GET /healthz HTTP/1.1\r\nHost: x\r\nVia: 1.1 somewhere\r\n\r\n"
#define READY "GET /readyz HTTP/1.1\r\nHost: x\r\n\r\n"

/* drains until nothing is left; 0, with a failed check, if that does not happen */
static int daemon_drained(struct srv_daemon *daemon) {
    double until = test_clock() + TEST_PATIENCE;
    int over = 0;
    while (!(over = srv_daemon_drain(daemon, 0)) && test_clock() < until) test_sleep(0.002);
    return CHECK_SAYING(over, "the drain does not end");
}

TEST(a_daemon_starts_answers_and_ends) {
    OWN(srv_daemon, free) *daemon = live_start(NULL);
    struct test_client client;
    struct test_reply reply;
    REQUIRE(daemon && live_say(daemon, &client, HEALTH));
    CHECK_INT(test_client_receive(&client, &reply, 0, TEST_PATIENCE), 200);
    CHECK_TEXT(reply.body, "{\"status\":\"ok\"}");
    CHECK_TEXT(test_reply_header(&reply, "Content-Type"), "application/json");
    CHECK_TEXT(test_reply_header(&reply, "Content-Length"), "15");
    CHECK_TEXT(test_reply_header(&reply, "Cache-Control"), "no-store");
    CHECK_TEXT(test_reply_header(&reply, "X-Content-Type-Options"), "nosniff");
    CHECK(test_reply_header(&reply, "Date") != NULL);
    CHECK(reply.keep_alive);
    test_reply_clear(&reply);
    test_client_close(&client);
    srv_daemon_free(&daemon);
    CHECK(daemon == NULL);
}

TEST(a_request_id_is_taken_over_or_given_and_never_twice) {
    static const struct {
        const char *field, *taken;
    } asked[] = {
        {"X-Request-Id: abc-1.2_3\r\n", "abc-1.2_3"},
        {"", NULL},
        {"X-Request-Id: with blank\r\n", NULL},
        {"X-Request-Id:\r\n", NULL},
        {"X-Request-Id: 0123456789012345678901234567890123456789012345678901234567890123456789\r\n",
         NULL},
        {"X-Request-Id: \"quoted\"\r\n", NULL},
    };
    OWN(srv_daemon, free) *daemon = live_start(NULL);
    OWN(test_client, close) client = {.fd = -1};
    struct test_reply reply;
    char text[512], last[64] = "";
    REQUIRE(daemon && test_client_open(&client, live_port(daemon)));
    for (size_t i = 0; i < sizeof asked / sizeof *asked; i++) {
        snprintf(text, sizeof text, "GET /healthz HTTP/1.1\r\nHost: x\r\n%s\r\n", asked[i].field);
        test_client_say(&client, text);
        CHECK_INT(test_client_receive(&client, &reply, 0, TEST_PATIENCE), 200);
        const char *id = test_reply_header(&reply, "X-Request-Id");
        if (!CHECK(id != NULL)) continue;
        if (asked[i].taken) CHECK_TEXT(id, asked[i].taken);
        if (!asked[i].taken)
            CHECK(strlen(id) == 16 && strspn(id, "0123456789abcdef") == 16 && strcmp(id, last));
        snprintf(last, sizeof last, "%s", id);
        test_reply_clear(&reply);
    }
}

TEST(the_front_refuses_behind_good_requests_and_within_bodies) {
    static const struct {
        const char *text;
        int status[3];
    } said[] = {
        {HEALTH HEALTH "GET / HTTP/1.1\nHost: x\n\n" HEALTH, {200, 200, 400}},
        {"POST /v1/trees HTTP/1.1\r\nHost: x\r\nTransfer-Encoding: "
         "chunked\r\n\r\n5\r\nhello\n" HEALTH,
         {400}},
        {"POST /healthz HTTP/1.1\r\nHost: x\r\nContent-Length: 1\r\n\r\naa/b" HEALTH, {405, 400}},
        {"GET /v1/presets HTTP/1.1\r\nHost: x\r\n\r\nGET : HTTP/1.1\r\n\r\n" HEALTH, {200, 400}},
        {"GET /healthz HTTP/1.1\r\nHost: x\r\nX : y\r\n\r\n" HEALTH, {400}},
    };
    OWN(srv_daemon, free) *daemon = live_start(NULL);
    REQUIRE(daemon != NULL);
    for (size_t i = 0; i < sizeof said / sizeof *said; i++) {
        OWN(test_client, close) client;
        struct test_reply reply;
        if (!live_say(daemon, &client, said[i].text)) continue;
        for (int k = 0; k < 3 && said[i].status[k]; k++) {
            int status = test_client_receive(&client, &reply, 0, TEST_PATIENCE);
            CHECK_SAYING(status == said[i].status[k], "stream %zu, answer %d: %d", i, k, status);
            if (status == 400) {
                CHECK_TEXT(test_reply_header(&reply, "Content-Type"), "application/problem+json");
                CHECK(test_reply_header(&reply, "X-Request-Id") && !reply.keep_alive);
            }
            test_reply_clear(&reply);
        }
        CHECK_SAYING(test_client_ended(&client, TEST_PATIENCE), "stream %zu goes on", i);
    }
    CHECK_INT(live_status(daemon, HEALTH), 200);
}

TEST(an_early_no_reaches_a_client_that_is_still_sending) {
    static const char *const options[] = {"--max-body-bytes", "1024", NULL};
    static char rubbish[65536];
    OWN(srv_daemon, free) *daemon = live_start(options);
    REQUIRE(daemon != NULL);
    for (int chunked = 0; chunked < 2; chunked++) {
        OWN(test_client, close) client;
        struct test_reply reply;
        if (!live_say(
                daemon, &client,
                chunked ? "POST /v1/trees HTTP/1.1\r\nHost: x\r\nTransfer-Encoding: "
                          "chunked\r\n\r\n800000\r\n"
                        : "POST /v1/trees HTTP/1.1\r\nHost: x\r\nContent-Length: 8388608\r\n\r\n"))
            continue;
        int sent = 0;
        double begin = test_clock();
        while (sent < 128 && test_client_send(&client, rubbish, sizeof rubbish)) sent++;
        CHECK_SAYING(sent == 128 || test_clock() > begin + 1e-3 * SRV_WATCH_LINGER_MS,
                     "%d pieces were taken", sent);
        CHECK_INT(test_client_receive(&client, &reply, 0, TEST_PATIENCE), 413);
        CHECK(strstr(reply.body, "max-body-bytes") != NULL);
        test_reply_clear(&reply);
        CHECK(test_client_ended(&client, TEST_PATIENCE));
    }
}

TEST(connections_beyond_the_cap_are_told_so) {
    static const char *const options[] = {"--max-connections", "4", "--max-client-connections", "8",
                                          NULL};
    OWN(srv_daemon, free) *daemon = live_start(options);
    struct test_client client[4];
    REQUIRE(daemon != NULL);
    for (int i = 0; i < 4; i++) {
        OWN(test_reply, clear) reply = {0};
        REQUIRE(live_say(daemon, &client[i], HEALTH));
        CHECK_INT(test_client_receive(&client[i], &reply, 0, TEST_PATIENCE), 200);
    }
    CHECK_INT(live_status(daemon, HEALTH), 503);
    CHECK_INT(live_status(daemon, HEALTH), 503);
    for (int i = 0; i < 4; i++) test_client_close(&client[i]);
    int status = 503;
    for (double until = test_clock() + TEST_PATIENCE; status == 503 && test_clock() < until;)
        status = live_status(daemon, HEALTH);
    CHECK_INT(status, 200);
}

TEST(bodies_together_stay_within_their_memory) {
    enum { BODIES = 4, BYTES = 200000 };
    static const char *const options[] = {"--max-held-bytes", "2400K", "--max-client-held-bytes",
                                          "2400K", NULL};
    static char body[BYTES];
    OWN(srv_daemon, free) *daemon = live_start(options);
    struct test_client client[BODIES + 1], *last = &client[BODIES];
    struct test_reply reply;
    static const char head[] =
        "POST /v1/trees HTTP/1.1\r\nHost: x\r\nContent-Length: 200000\r\n\r\n";
    REQUIRE(daemon != NULL);
    memset(body, ' ', sizeof body);
    /* small ones count towards the total memory, large ones of one client towards half of its
     * share */
    for (int i = 0; i < BODIES; i++) {
        REQUIRE(live_say(daemon, &client[i], head));
        test_client_send(&client[i], body, i < 2 ? BYTES - 1 : 60000);
    }
    live_await_least(daemon, "pendulumd_held_kind_bytes{kind=\"bodies\"} ", 950000);
    REQUIRE(live_say(daemon, last, head));
    test_client_send(last, body, sizeof body);
    CHECK_INT(test_client_receive(last, &reply, 0, TEST_PATIENCE), 429);
    CHECK(strstr(reply.body, "max-client-held-bytes") != NULL);
    test_reply_clear(&reply);
    test_client_close(last);
    /* the first is not affected, and frees its memory */
    for (int i = 1; i < BODIES; i++) test_client_close(&client[i]);
    live_await(daemon, "pendulumd_connections ", 2);
    test_client_send(&client[0], body, 1);
    CHECK_INT(test_client_receive(&client[0], &reply, 0, TEST_PATIENCE), 415);
    test_reply_clear(&reply);
    test_client_close(&client[0]);
    live_await(daemon, "pendulumd_held_kind_bytes{kind=\"bodies\"} ", 0);
    REQUIRE(live_say(daemon, last, head));
    test_client_send(last, body, sizeof body);
    CHECK_INT(test_client_receive(last, &reply, 0, TEST_PATIENCE), 415);
    test_reply_clear(&reply);
    test_client_close(last);
}

TEST(times_for_heads_bodies_and_silence_are_totals) {
    static const char *const options[] = {
        "--header-seconds", "0.4", "--body-seconds", "0.4", "--idle-seconds", "1", NULL};
    static const struct {
        const char *say, *drip;
        int status;
        double least;
    } slow[] = {
        {"GET /healthz HTTP/1.1\r\nHost: x\r\nX: ", "a", 408, 0.3},
        {"POST /v1/trees HTTP/1.1\r\nHost: x\r\nContent-Length: 500\r\n\r\n", "a", 408, 0.3},
        {"POST /v1/trees HTTP/1.1\r\nHost: x\r\nTransfer-Encoding: chunked\r\n\r\n", "1\r\na\r\n",
         408, 0.3},
        {"G", "", 408, 0.3},
        {"", "", 0, 0.9},
    };
    OWN(srv_daemon, free) *daemon = live_start(options);
    REQUIRE(daemon != NULL);
    for (size_t i = 0; i < sizeof slow / sizeof *slow; i++) {
        OWN(test_client, close) client;
        struct test_reply reply;
        double begin = test_clock();
        if (!live_say(daemon, &client, slow[i].say)) continue;
        /* until the server gives up */
        struct pollfd look = {.fd = client.fd, .events = POLLIN};
        for (int k = 0; k < 400 && slow[i].drip[0] && !poll(&look, 1, 20); k++)
            if (!test_client_say(&client, slow[i].drip)) break;
        int status = test_client_receive(&client, &reply, 0, TEST_PATIENCE);
        CHECK_SAYING(status == slow[i].status, "%zu: status %d", i, status);
        test_reply_clear(&reply);
        CHECK(test_client_ended(&client, TEST_PATIENCE));
        double seconds = test_clock() - begin;
        CHECK_SAYING(seconds > slow[i].least, "%zu: after %.2f s", i, seconds);
    }
}

TEST(between_requests_a_connection_may_be_as_old_as_it_likes) {
    static const char *const options[] = {"--header-seconds", "60", "--body-seconds", "60", NULL};
    OWN(srv_daemon, free) *daemon = live_start(options);
    OWN(test_client, close) client = {.fd = -1};
    REQUIRE(daemon && test_client_open(&client, live_port(daemon)));
    for (int i = 0; i < 2; i++) {
        OWN(test_reply, clear) reply;
        srv_clock_advance(srv_clock_span(3600));
        test_sleep(0.3); /* the watch checks once in this time */
        test_client_say(&client, HEALTH);
        CHECK_INT(test_client_receive(&client, &reply, 0, TEST_PATIENCE), 200);
    }
}

TEST(an_answer_that_is_not_taken_is_given_up) {
    static const char *const options[] = {"--send-seconds", "0.3", "--least-rate", "1G", NULL};
    static const char body[] = "{\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1]},"
                               "\"times\":{\"start\":0,\"stop\":1,\"count\":200001}}";
    OWN(srv_daemon, free) *daemon = live_start(options);
    struct test_client client;
    REQUIRE(daemon && live_post(daemon, &client, "/v1/trajectories", body));
    /* about 20 MB, more than the sockets hold; nothing is read until the server gives up */
    struct test_reply reply;
    char first;
    CHECK_INT(recv(client.fd, &first, 1, MSG_PEEK), 1);
    live_await(daemon, "pendulumd_connections ", 1); /* the connection of the query itself */
    CHECK_INT(test_client_receive(&client, &reply, 0, TEST_PATIENCE), 0);
    test_reply_clear(&reply);
    test_client_close(&client);
    daemon_drained(daemon);
}

TEST(a_client_that_went_away_frees_its_worker_at_once) {
    /* a slow machine would refuse the request by its own estimate */
    static const char *const options[] = {"--workers", "1", "--max-compute-seconds", "86400", NULL};
    OWN(srv_daemon, free) *daemon = live_start(options);
    struct test_client gone, waiting, next;
    OWN(test_reply, clear) reply = {0};
    REQUIRE(daemon && live_post(daemon, &gone, "/v1/trajectories", LIVE_ENDLESS));
    live_await(daemon, "pendulumd_workers_busy ", 1);
    REQUIRE(live_post(daemon, &waiting, "/v1/trajectories", LIVE_LONG));
    live_await(daemon, "pendulumd_computations ", 2);
    double begin = test_clock();
    test_client_close(&waiting);
    test_client_close(&gone);
    live_await(daemon, "pendulumd_cancelled_total ", 2);
    live_await(daemon, "pendulumd_workers_busy ", 0);
    printf("  a vanished client's worker was free after %.0f ms\n", 1e3 * (test_clock() - begin));
    REQUIRE(live_post(daemon, &next, "/v1/trees", LIVE_SHORT));
    CHECK_INT(test_client_receive(&next, &reply, 0, TEST_PATIENCE), 200);
    test_client_close(&next);
}

TEST(a_client_that_only_shuts_its_side_still_gets_a_short_answer) {
    OWN(srv_daemon, free) *daemon = live_start(NULL);
    OWN(test_client, close) client = {.fd = -1};
    struct test_reply reply;
    REQUIRE(daemon && live_post(daemon, &client, "/v1/trees", LIVE_SHORT));
    shutdown(client.fd, SHUT_WR);
    CHECK_INT(test_client_receive(&client, &reply, 0, TEST_PATIENCE), 200);
    test_reply_clear(&reply);
    CHECK(test_client_ended(&client, TEST_PATIENCE));
}

/* a body that is computed for about this many seconds, on any machine and build */
static void daemon_lasting(struct srv_daemon *daemon, double seconds, char body[], size_t cap) {
    double stop = 50, took = 0;
    while (took < 0.05) {
        struct test_client client;
        struct test_reply reply;
        stop *= 2;
        snprintf(body, cap,
                 "{\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1]},"
                 "\"times\":{\"start\":0,\"stop\":%.0f,\"count\":5}}",
                 stop);
        double begin = test_clock();
        if (!live_post(daemon, &client, "/v1/trajectories", body)) return;
        CHECK_INT(test_client_receive(&client, &reply, 0, TEST_PATIENCE), 200);
        test_reply_clear(&reply);
        test_client_close(&client);
        took = test_clock() - begin;
    }
    snprintf(strstr(body, "\"stop\""), 64, "\"stop\":%.0f,\"count\":5}}", stop * seconds / took);
}

/* a daemon whose drain has begun while it computes for a client, and a connection that was open
 * before; if the computation was over too soon, it is repeated with a longer one */
static struct srv_daemon *daemon_draining(struct test_client *running, struct test_client *open) {
    static const char *const options[] = {"--workers", "1", NULL};
    for (double seconds = 1; seconds < 100; seconds *= 4) {
        struct srv_daemon *daemon = live_start(options);
        struct test_reply reply;
        char body[256];
        if (!daemon || !live_say(daemon, open, READY)) return NULL;
        CHECK_INT(test_client_receive(open, &reply, 0, TEST_PATIENCE), 200);
        test_reply_clear(&reply);
        daemon_lasting(daemon, seconds, body, sizeof body);
        double slices = live_metric(daemon, "pendulumd_slices_total ");
        if (!live_post(daemon, running, "/v1/trajectories", body)) return NULL;
        live_await_least(daemon, "pendulumd_slices_total ", slices + 1);
        /* a drain waits a moment even without computations: no answer must arrive now */
        struct pollfd look = {.fd = running->fd, .events = POLLIN};
        if (live_metric(daemon, "pendulumd_computations ") > 0 && !srv_daemon_drain(daemon, 0) &&
            !poll(&look, 1, 50))
            return daemon;
        test_client_close(running);
        test_client_close(open);
        srv_daemon_free(&daemon);
    }
    return NULL;
}

/* whether a process still listens there */
static int daemon_listens(const struct srv_daemon *daemon) {
    struct sockaddr_in address = {.sin_family = AF_INET,
                                  .sin_port = htons((uint16_t)live_port(daemon))};
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    int good = !connect(fd, (struct sockaddr *)&address, sizeof address);
    close(fd);
    return good;
}

TEST(a_drain_lets_nobody_in_and_answers_who_is_there) {
    struct test_client running, open;
    OWN(test_reply, clear) reply = {0};
    OWN(srv_daemon, free) *daemon = daemon_draining(&running, &open);
    char text[512];
    REQUIRE(daemon != NULL);
    /* at once, while it computes: a client that is refused a connection tries another process */
    for (int step = 0; step < 5; step++, test_sleep(1e-3 * SRV_HTTP_SETTLE_MS))
        CHECK_INT(srv_daemon_drain(daemon, 0), 0);
    CHECK(!daemon_listens(daemon));
    /* a request on an open connection is computed, and is the connection's last */
    snprintf(text, sizeof text,
             "POST /v1/trees HTTP/1.1\r\nHost: x\r\nContent-Type: "
             "application/json\r\nContent-Length: %zu\r\n\r\n%s",
             strlen(LIVE_SHORT), LIVE_SHORT);
    test_client_say(&open, text);
    CHECK_INT(test_client_receive(&open, &reply, 0, TEST_PATIENCE), 200);
    CHECK(!reply.keep_alive);
    test_reply_clear(&reply);
    CHECK(test_client_ended(&open, TEST_PATIENCE));
    test_client_close(&open);
    daemon_drained(daemon);
    CHECK_INT(test_client_receive(&running, &reply, 0, TEST_PATIENCE), 200);
    CHECK(!reply.keep_alive);
    test_client_close(&running);
}

TEST(who_waits_to_be_accepted_at_the_end_is_answered) {
    enum { COUNT = 100 };
    static struct test_client client[COUNT];
    for (int round = 0; round < 3; round++) {
        struct srv_daemon *daemon = live_start(NULL);
        struct test_reply reply;
        REQUIRE(daemon != NULL);
        for (int i = 0; i < COUNT; i++)
            REQUIRE(live_post(daemon, &client[i], "/v1/trees", LIVE_SHORT));
        daemon_drained(daemon);
        srv_daemon_free(&daemon);
        for (int i = 0; i < COUNT; i++) {
            CHECK_INT(test_client_receive(&client[i], &reply, 0, TEST_PATIENCE), 200);
            test_reply_clear(&reply);
            test_client_close(&client[i]);
        }
    }
}

TEST(a_connection_that_a_proxy_keeps_is_answered_once_more_in_a_drain) {
    static const char *const options[] = {"--drain-idle-seconds", "3600", NULL};
    OWN(srv_daemon, free) *daemon = live_start(options);
    struct test_client kept;
    struct test_reply reply;
    REQUIRE(daemon && live_say(daemon, &kept, RELAYED));
    CHECK_INT(test_client_receive(&kept, &reply, 0, TEST_PATIENCE), 200);
    CHECK(reply.keep_alive);
    test_reply_clear(&reply);
    for (double end = test_clock() + 0.5; test_clock() < end; test_sleep(0.01))
        CHECK_INT(srv_daemon_drain(daemon, 0), 0);
    test_client_say(&kept, HEALTH);
    CHECK_INT(test_client_receive(&kept, &reply, 0, TEST_PATIENCE), 200);
    CHECK(!reply.keep_alive);
    test_reply_clear(&reply);
    test_client_close(&kept);
    daemon_drained(daemon);
}

TEST(a_browsers_silent_connection_does_not_hold_up_a_drain) {
    static const char *const options[] = {"--drain-idle-seconds", "3600", NULL};
    struct srv_daemon *daemon = live_start(options);
    OWN(test_client, close) kept = {.fd = -1};
    struct test_reply reply;
    REQUIRE(daemon && live_say(daemon, &kept, HEALTH));
    CHECK_INT(test_client_receive(&kept, &reply, 0, TEST_PATIENCE), 200);
    CHECK(reply.keep_alive);
    test_reply_clear(&reply);
    daemon_drained(daemon);
    srv_daemon_free(&daemon);
    CHECK(test_client_ended(&kept, TEST_PATIENCE));
}

TEST(a_drain_in_a_hurry_answers_503_and_ends_at_once) {
    static const char *const options[] = {"--workers", "1", NULL};
    struct srv_daemon *daemon = live_start(options);
    struct test_client running, waiting;
    struct test_reply reply;
    REQUIRE(daemon && live_post(daemon, &running, "/v1/trajectories", LIVE_ENDLESS));
    REQUIRE(live_post(daemon, &waiting, "/v1/trajectories", LIVE_LONG));
    live_await(daemon, "pendulumd_computations ", 2);
    CHECK_INT(srv_daemon_drain(daemon, 0), 0);
    srv_daemon_free(&daemon);
    for (int i = 0; i < 2; i++) {
        struct test_client *client = i ? &waiting : &running;
        CHECK_INT(test_client_receive(client, &reply, 0, TEST_PATIENCE), 503);
        CHECK(strstr(reply.body, "the server is stopping") != NULL);
        test_reply_clear(&reply);
        test_client_close(client);
    }
}

/* A client that sends requests as fast as it can until the server has ended. */
struct daemon_crowd {
    int port;
    atomic_long answered;
    long refused, lost;
};

static void *daemon_client(void *argument) {
    struct daemon_crowd *crowd = argument;
    struct sockaddr_in {
        unsigned short family, port;
        unsigned address;
        char rest[8];
    } address = {AF_INET, (unsigned short)(crowd->port << 8 | crowd->port >> 8), 0x0100007f, ""};
    char text[512];
    snprintf(text, sizeof text,
             "POST /v1/trees HTTP/1.1\r\nHost: x\r\nContent-Type: "
             "application/json\r\nContent-Length: %zu\r\n\r\n%s",
             strlen(LIVE_SHORT), LIVE_SHORT);
    for (;;) {
        OWN(test_client, close) client = {.fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)};
        struct test_reply reply;
        if (connect(client.fd, (struct sockaddr *)&address, sizeof address)) {
            close(client.fd);
            return NULL;
        }
        for (int more = 1, first = 1; more; first = 0) {
            if (!test_client_say(&client, text)) break;
            int status = test_client_receive(&client, &reply, 0, TEST_PATIENCE);
            crowd->answered += status == 200;
            crowd->refused += status == 503;
            /* an idle connection may be closed during a request (RFC 9112 9.5); a new one never */
            crowd->lost += status == 0 && first;
            more = status && reply.keep_alive;
            test_reply_clear(&reply);
        }
    }
}

TEST(a_drain_under_load_loses_no_request) {
    enum { CLIENTS = 8 };
    static const char *const options[] = {"--workers", "2", NULL};
    for (int round = 0; round < 3; round++) {
        struct srv_daemon *daemon = live_start(options);
        struct daemon_crowd crowd[CLIENTS];
        pthread_t thread[CLIENTS];
        REQUIRE(daemon != NULL);
        for (int i = 0; i < CLIENTS; i++) {
            crowd[i].port = live_port(daemon);
            crowd[i].refused = crowd[i].lost = 0;
            atomic_init(&crowd[i].answered, 0);
            pthread_create(&thread[i], NULL, daemon_client, &crowd[i]);
        }
        for (int i = 0; i < CLIENTS; i++) {
            double until = test_clock() + TEST_PATIENCE;
            while (atomic_load(&crowd[i].answered) < 10 && test_clock() < until) test_sleep(0.002);
        }
        daemon_drained(daemon);
        srv_daemon_free(&daemon);
        long answered = 0, lost = 0;
        for (int i = 0; i < CLIENTS; i++) {
            pthread_join(thread[i], NULL);
            answered += crowd[i].answered;
            lost += crowd[i].lost;
        }
        CHECK(answered >= 10 * CLIENTS);
        CHECK_INT(lost, 0);
    }
}

TEST(heads_at_the_front_s_limits_fit_into_the_connection_s_memory) {
    OWN(srv_daemon, free) *daemon = live_start(NULL);
    static char text[12000];
    REQUIRE(daemon != NULL);
    /* the maximum of everything at once: target, parameters, fields, cookies */
    size_t at = (size_t)sprintf(text, "GET /healthz?");
    for (int i = 0; i < SRV_TARGET_BYTES - 10; i++) text[at++] = i % 16 == 15 ? '&' : 'a';
    at += (size_t)sprintf(text + at, " HTTP/1.1\r\nHost: x\r\nCookie: a=b");
    for (int i = 0; i < 98; i++) at += (size_t)sprintf(text + at, "; c%02d=d", i);
    for (int i = 0; i < 97; i++) at += (size_t)sprintf(text + at, "\r\nX%02d: %040d", i, i);
    size_t rest = 8192 - at - 12;
    at += (size_t)sprintf(text + at, "\r\nX: ");
    memset(text + at, 'a', rest);
    strcpy(text + at + rest, "\r\n\r\n");
    CHECK_INT(live_status(daemon, text), 200);
    /* and with a body that arrived at the same time */
    OWN_MEMORY char *both = malloc(60000);
    REQUIRE(both != NULL);
    sprintf(both, "POST%s", text + 3);
    strcpy(strstr(both, "\r\nX: ") + 2, "Content-Length: 40000\r\n\r\n");
    size_t bytes = strlen(both);
    memset(both + bytes, ' ', 40000);
    both[bytes + 40000] = 0;
    CHECK_INT(live_status(daemon, both), 405);
}

TEST(a_daemon_that_cannot_start_says_why_and_leaves_nothing) {
    struct srv_config config = live_config(NULL);
    struct srv_daemon *daemon;
    struct pend_error error;
    int passed = 0;
    for (long fail = 1; fail < 100 && !passed; fail++) {
        error = (struct pend_error){.text = ""};
        test_alloc_fail(fail, 0);
        enum pend_status status = srv_daemon_new(&daemon, &config, &error);
        test_alloc_faults_off();
        passed = status == PEND_OK;
        if (!passed)
            CHECK_SAYING(status == PEND_NO_MEMORY && !daemon && error.text[0], "allocation %ld",
                         fail);
    }
    CHECK(passed);
    if (daemon) CHECK_INT(live_status(daemon, HEALTH), 200);
    srv_daemon_free(&daemon);
    strcpy(config.listen, "192.0.2.1:1");
    CHECK(srv_daemon_new(&daemon, &config, &error) == PEND_INVALID && !daemon);
    CHECK_SAYING(strstr(error.text, "cannot listen on 192.0.2.1:1") != NULL, "%s", error.text);
}

TEST(requests_survive_want_of_memory) {
    OWN(srv_daemon, free) *daemon = live_start(NULL);
    REQUIRE(daemon != NULL);
    int good = 0;
    for (long fail = 1; fail < 400 && good < 3; fail += 1 + fail / 20) {
        OWN(test_client, close) client;
        OWN(test_reply, clear) reply = {0};
        if (!live_post(daemon, &client, "/v1/trees", "{")) break;
        test_client_close(&client);
        if (!test_client_open(&client, live_port(daemon))) break;
        test_alloc_fail(fail, 0);
        char text[512];
        snprintf(text, sizeof text,
                 "POST /v1/trees HTTP/1.1\r\nHost: x\r\nContent-Type: "
                 "application/json\r\nContent-Length: %zu\r\n"
                 "Connection: close\r\n\r\n%s",
                 strlen(LIVE_SHORT), LIVE_SHORT);
        send(client.fd, text, strlen(text), MSG_NOSIGNAL);
        test_sleep(0.02);
        test_alloc_faults_off();
        int status = test_client_receive(&client, &reply, 0, 5);
        CHECK_SAYING(status == 200 || status == 503 || status == 0 || status == 500,
                     "allocation %ld: %d", fail, status);
        good = status == 200 ? good + 1 : 0;
    }
    CHECK_INT(live_status(daemon, HEALTH), 200);
}
