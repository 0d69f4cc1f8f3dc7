/* The progress of jobs as server-sent events, on both stores: what is sent, to how many, and how it
 * ends. */
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "tests/wire/place.h"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define WAY "4000"
#else
#define WAY "10000"
#endif
/* one trajectory of a dozen parts or more, about a tenth of a second each */
#define JOB                                                                                        \
    "{\"pendulum\":" ASK_DOUBLE                                                                    \
    ",\"initial\":{\"phi\":[1,2]},\"times\":{\"start\":0,\"stop\":" WAY                            \
    ",\"step\":0.5},\"rtol\":1e-14,\"output\":[\"phi\"]}"

enum { HEARD = 1 << 17 };

/* A client that listens. */
struct ear {
    struct test_client client;
    size_t bytes;
    char text[HEARD]; /* everything received, head and chunks included */
};

static int ear_open(struct ear *ear, const struct test_server *server, const char *id,
                    const char *headers) {
    char text[512];
    memset(ear, 0, sizeof *ear);
    if (!test_client_open(&ear->client, test_server_port(server))) return 0;
    snprintf(text, sizeof text,
             "GET /v1/jobs/%s/events HTTP/1.1\r\nHost: x\r\nAccept: text/event-stream\r\n%s\r\n",
             id, headers);
    return test_client_say(&ear->client, text);
}

/* reads until some text has arrived, or, if that is NULL, the stream has ended; returns 1 if it
 * has */
static int ear_hear(struct ear *ear, const char *text) {
    double end = test_clock() + TEST_PATIENCE;
    while (test_clock() < end && ear->bytes < HEARD - 1) {
        struct pollfd look = {ear->client.fd, POLLIN, 0};
        if (strstr(ear->text, text ? text : "\r\n0\r\n\r\n")) return 1;
        if (poll(&look, 1, 50) <= 0) continue;
        ssize_t got = recv(ear->client.fd, ear->text + ear->bytes, HEARD - 1 - ear->bytes, 0);
        if (got <= 0) return !text || strstr(ear->text, text);
        ear->bytes += (size_t)got;
    }
    return 0;
}

/* how often a text has arrived */
static int ear_count(const struct ear *ear, const char *text) {
    int count = 0;
    for (const char *at = ear->text; (at = strstr(at, text)); at++) count++;
    return count;
}

static struct ear ear[2];

/* sent by a process that computes nothing; another one works, once a client listens */
static int course_events(struct place *place) {
    char id[ID + 1], last[96];
    int events = 0;
    struct test_reply reply;
    struct test_server *worker = NULL, *api = place_serve(place, "api", "0.03", NULL, NULL);
    if (api && CHECK_INT(submit(api, "/v1/trajectories", ASYNC, JOB, id), 202)) {
        CHECK(ear_open(&ear[0], api, id, ""));
        CHECK(ear_hear(&ear[0], "\"status\":\"accepted\""));
        worker = place_serve(place, "worker", "0.03", NULL, NULL);
        CHECK(ear_hear(&ear[0], NULL));
        CHECK(strstr(ear[0].text, "Content-Type: text/event-stream\r\n") &&
              strstr(ear[0].text, "no-store"));
        CHECK(strstr(ear[0].text, "retry: 2000\n\n"));
        events = ear_count(&ear[0], "event: progress\n");
        CHECK_INT(ear_count(&ear[0], "\nid: "), events);
        CHECK_INT(ear_count(&ear[0], "\ndata: {\"id\":\""), events);
        CHECK_INT(ear_count(&ear[0], "\"status\":\"successful\""), 1);
        CHECK(ear_count(&ear[0], "\"status\":\"running\"") >= events - 2);
        /* each is sent once, and the last one last */
        const char *end = strstr(ear[0].text, "\nid: successful-");
        if (CHECK(end != NULL)) {
            CHECK(!strstr(end, "event: "));
            snprintf(last, sizeof last, "Last-Event-ID: %.*s\r\n", (int)strcspn(end + 5, "\n"),
                     end + 5);
            CHECK_INT(job_get(api, &reply, id, "/events", last), 204);
            test_reply_clear(&reply);
        }
        CHECK_INT(job_get(api, &reply, id, "/events", "Last-Event-ID: running-1\r\n"), 200);
        CHECK(strstr(reply.body, "successful") && !strstr(reply.body, "running"));
        test_reply_clear(&reply);
        test_client_close(&ear[0].client);
        CHECK_INT(test_request(api, &reply, "GET", "/v1/jobs/00000000000000000000000000/events", "",
                               NULL),
                  404);
        test_reply_clear(&reply);
    }
    test_server_stop(&worker);
    test_server_stop(&api);
    return events;
}

/* a stream that queries a job too rarely, on a busy machine, misses changes in between */
static void a_course(struct place *place) {
    int events = 0;
    for (int i = 0; i < 6 && events < 3; i++) events = course_events(place);
    CHECK_SAYING(events >= 3, "%d events", events);
}

TEST(a_listener_hears_every_step_of_a_job_and_its_end) { place_on_both(a_course); }

/* nobody works: nothing progresses, so comments alone show that the server is alive */
static void a_silence(struct place *place) {
    char id[ID + 1];
    struct test_reply reply;
    OWN(test_server, stop) *api = place_serve(place, "api", "0.1", NULL, NULL);
    if (!api) return;
    CHECK_INT(submit(api, "/v1/trajectories", ASYNC, JOB, id), 202);
    CHECK(ear_open(&ear[0], api, id, "") &&
          ear_open(&ear[1], api, id, "Last-Event-ID: accepted-0\r\n"));
    CHECK(ear_hear(&ear[0], "\"status\":\"accepted\""));
    CHECK(ear_hear(&ear[0], "\n:\n\n") && ear_hear(&ear[1], "\n:\n\n"));
    /* a client that has received this does not get it again */
    CHECK_INT(ear_count(&ear[0], "event:"), 1);
    CHECK_INT(ear_count(&ear[1], "event:"), 0);
    /* what another client does is sent at once */
    char path[64];
    snprintf(path, sizeof path, "/v1/jobs/%s", id);
    CHECK_INT(test_request(api, &reply, "DELETE", path, "", NULL), 200);
    test_reply_clear(&reply);
    CHECK(ear_hear(&ear[0], "\"status\":\"dismissed\"") &&
          ear_hear(&ear[1], "\"status\":\"dismissed\""));
    CHECK(ear_hear(&ear[0], NULL) && ear_hear(&ear[1], NULL));
    for (int i = 0; i < 2; i++) test_client_close(&ear[i].client);
}

TEST(a_silent_stream_has_a_heartbeat) {
    OWN(place, end) place;
    if (place_begin(&place, 0)) a_silence(&place);
}

static double here_of(const struct test_server *server, double wanted) {
    double now = -1;
    for (double end = test_clock() + TEST_PATIENCE; test_clock() < end && now != wanted;
         test_sleep(0.05))
        now = ask_metric(server, "pendulumd_event_streams");
    return now;
}

TEST(streams_are_counted_and_a_client_has_its_share) {
    OWN(place, end) place;
    char id[ID + 1];
    enum { SHARE = 2, MOST = 8 };
    static struct ear crowd[MOST];
    struct test_reply reply;
    REQUIRE(place_begin(&place, 0));
    const char *const options[] = {
        "--store", place.url,         "--role",      "api", "--max-event-streams",
        "8",       "--trusted-proxy", "127.0.0.0/8", NULL};
    OWN(test_server, drop) *server = test_server_start(options);
    if (server && CHECK_INT(submit(server, "/v1/trajectories", ASYNC, JOB, id), 202)) {
        for (int i = 0; i < MOST; i++) {
            char from[64];
            snprintf(from, sizeof from, "X-Forwarded-For: 10.0.0.%d\r\n", i / SHARE);
            CHECK(ear_open(&crowd[i], server, id, from) && ear_hear(&crowd[i], "accepted"));
            if (i % SHARE) {
                /* one more of this client's */
                CHECK_INT(job_get(server, &reply, id, "/events", from), 429);
                CHECK(test_reply_header(&reply, "Retry-After") != NULL);
                test_reply_clear(&reply);
            }
        }
        CHECK_INT(job_get(server, &reply, id, "/events", "X-Forwarded-For: 10.0.0.9\r\n"), 503);
        CHECK(test_reply_header(&reply, "Retry-After") != NULL);
        test_reply_clear(&reply);
        CHECK(ask_metric(server, "pendulumd_event_streams") == MOST);
        /* half of them leave, by an end and by a reset; others may come */
        for (int i = 0; i < MOST; i += 2) {
            struct linger reset = {1, 0};
            if (i % 4) setsockopt(crowd[i].client.fd, SOL_SOCKET, SO_LINGER, &reset, sizeof reset);
            test_client_close(&crowd[i].client);
        }
        CHECK(here_of(server, MOST / 2) == MOST / 2);
        CHECK(ear_open(&crowd[0], server, id, "X-Forwarded-For: 10.0.0.9\r\n") &&
              ear_hear(&crowd[0], "accepted"));
        /* told to end, it ends the streams as complete answers, at once, although the job
         * continues */
        test_server_signal(server, SIGTERM);
        for (int i = 1; i < MOST; i += 2) {
            CHECK(ear_hear(&crowd[i], NULL));
            test_client_close(&crowd[i].client);
        }
        CHECK(ear_hear(&crowd[0], NULL));
        test_client_close(&crowd[0].client);
        CHECK_INT(test_server_wait(server), 0);
    }
}

/* many who do not read what they requested: the job and others do not wait for them */
TEST(listeners_that_do_not_read_cost_nothing) {
    OWN(place, end) place;
    char id[ID + 1], word[WORDS];
    enum { MANY = 30 };
    static struct test_client deaf[MANY];
    REQUIRE(place_begin(&place, 0));
    OWN(test_server, stop) *server =
        place_serve(&place, "all", "0.01", "--max-event-streams", "200");
    if (server && CHECK_INT(submit(server, "/v1/trajectories", ASYNC, JOB, id), 202)) {
        for (int i = 0; i < MANY; i++) {
            char text[256];
            int small = 1;
            if (!test_client_open(&deaf[i], test_server_port(server))) break;
            setsockopt(deaf[i].fd, SOL_SOCKET, SO_RCVBUF, &small, sizeof small);
            snprintf(text, sizeof text, "GET /v1/jobs/%s/events HTTP/1.1\r\nHost: x\r\n\r\n", id);
            test_client_say(&deaf[i], text);
        }
        job_wait(server, id, word);
        CHECK_TEXT(word, "successful");
        for (int i = 0; i < MANY; i++) test_client_close(&deaf[i]);
        CHECK(here_of(server, 0) == 0);
    }
}
