/* Answers that wait for a job's end, on both stores: how long they wait, what they contain, and
 * that nothing waits for a client that has left.
 * Leaves to others: streams of events, which share the code (test_events). */
#include <signal.h>
#include <stdio.h>
#include <string.h>

#include "tests/wire/place.h"

#define LITTLE                                                                                     \
    "{\"pendulum\":" ASK_DOUBLE                                                                    \
    ",\"initial\":{\"phi\":[1,2]},\"times\":{\"start\":0,\"stop\":2,\"step\":1},\"output\":"       \
    "[\"phi\"]}"

static int says(struct test_client *client, const struct test_server *server, const char *method,
                const char *path) {
    char text[256];
    snprintf(text, sizeof text, "%s %s HTTP/1.1\r\nHost: x\r\n\r\n", method, path);
    return test_client_open(client, test_server_port(server)) && test_client_say(client, text);
}

/* posts and waits in one request: the reply leads to the results */
static void waits_for_results(const struct test_server *server) {
    struct test_reply reply, results;
    char path[128];
    CHECK_INT(test_request(server, &reply, "POST", "/v1/trajectories",
                           "Content-Type: application/json\r\nPrefer: respond-async, wait=30\r\n",
                           LITTLE),
              303);
    const char *location = test_reply_header(&reply, "Location");
    if (CHECK(location != NULL)) {
        snprintf(path, sizeof path, "%s", location);
        size_t bytes = strlen(path);
        CHECK(bytes > 8 && !strcmp(path + bytes - 8, "/results"));
        CHECK_TEXT(test_reply_header(&reply, "Preference-Applied"), "respond-async, wait=30");
        CHECK(strstr(reply.body, "\"status\":\"successful\""));
        CHECK_INT(test_request(server, &results, "GET", path, "", NULL), 200);
        CHECK(strstr(results.body, "\"phi\":[[1,2],"));
        test_reply_clear(&results);
    }
    test_reply_clear(&reply);
}

static void a_quick_job(struct place *place) {
    OWN(test_server, stop) *server = place_serve(place, "all", "1", NULL, NULL);
    if (!server) return;
    waits_for_results(server);
}

TEST(who_waits_for_a_quick_job_is_led_to_its_results) { place_on_both(a_quick_job); }

/* nobody works: only time, another client or the end of the process ends a wait */
static void a_job_at_rest(struct place *place) {
    char id[ID + 1], path[96], waits[192];
    OWN(test_reply, clear) reply = {0};
    struct test_client client, gone;
    OWN(test_server, stop) *api = place_serve(place, "api", "1", NULL, NULL);
    if (!api) return;
    double begin = test_clock();
    CHECK_INT(submit(api, "/v1/trajectories", "Prefer: respond-async;x=1 ,wait=1\r\n", LITTLE, id),
              202);
    double took = test_clock() - begin;
    CHECK_SAYING(took >= 0.95 && took < 10, "%.2f s", took);
    snprintf(path, sizeof path, "/v1/jobs/%s", id);
    static const struct {
        const char *query, *word;
        int status;
    } wait[] = {{"wait=0", "accepted", 200},
                {"wait=1", "accepted", 200},
                {"wait=60x", "60x", 422},
                {"wait=", "wait must be", 422},
                {"wait=61", "61", 422},
                {"wait=-1", "wait must be", 422},
                {"wait=99999999999", "60 whole seconds", 422}};
    for (size_t i = 0; i < sizeof wait / sizeof *wait; i++) {
        snprintf(waits, sizeof waits, "%s?%s", path, wait[i].query);
        CHECK_INT(test_request(api, &reply, "GET", waits, "", NULL), wait[i].status);
        CHECK_SAYING(strstr(reply.body, wait[i].word), "%s: %s", wait[i].query, reply.body);
        test_reply_clear(&reply);
    }
    /* a client that leaves meanwhile leaves nothing behind */
    snprintf(waits, sizeof waits, "%s?wait=60", path);
    for (int i = 0; i < 8; i++) {
        CHECK(says(&gone, api, "GET", waits));
        test_sleep(0.02);
        test_client_close(&gone);
    }
    double waiting = 8;
    for (double end = test_clock() + TEST_PATIENCE; test_clock() < end && waiting > 0;
         test_sleep(0.05))
        waiting = ask_metric(api, "pendulumd_event_streams");
    CHECK_SAYING(waiting == 0, "%.0f", waiting);
    begin = test_clock();
    CHECK(says(&client, api, "GET", waits));
    CHECK(ask_await(api, "pendulumd_event_streams", 1, 1));
    CHECK_INT(test_request(api, &reply, "DELETE", path, "", NULL), 200);
    test_reply_clear(&reply);
    CHECK_INT(test_client_receive(&client, &reply, 0, TEST_PATIENCE), 200);
    CHECK(strstr(reply.body, "\"status\":\"dismissed\"") && test_clock() - begin < 15);
    test_reply_clear(&reply);
    /* the same connection sends again, and is answered at once: the job is over */
    snprintf(waits, sizeof waits, "GET %s?wait=60 HTTP/1.1\r\nHost: x\r\n\r\n", path);
    CHECK(test_client_say(&client, waits));
    CHECK_INT(test_client_receive(&client, &reply, 0, TEST_PATIENCE), 200);
    test_client_close(&client);
}

TEST(a_wait_ends_with_its_time_or_the_job) { place_on_both(a_job_at_rest); }

/* a process that is to end answers waiting clients, and does not wait itself */
static void a_drain(struct place *place) {
    char id[ID + 1], path[128];
    struct test_reply reply;
    struct test_client client;
    OWN(test_server, stop) *api = place_serve(place, "api", "1", NULL, NULL);
    if (!api) return;
    CHECK_INT(submit(api, "/v1/trajectories", ASYNC, LITTLE, id), 202);
    snprintf(path, sizeof path, "/v1/jobs/%s?wait=60", id);
    CHECK(says(&client, api, "GET", path));
    test_sleep(0.3);
    double begin = test_clock();
    test_server_signal(api, SIGTERM);
    CHECK_INT(test_client_receive(&client, &reply, 0, TEST_PATIENCE), 200);
    CHECK(strstr(reply.body, "\"status\":\"accepted\""));
    test_reply_clear(&reply);
    test_client_close(&client);
    CHECK_INT(test_server_wait(api), 0);
    CHECK_SAYING(test_clock() - begin < 20, "%.1f s", test_clock() - begin);
}

TEST(a_drain_answers_who_waits) { place_on_both(a_drain); }
