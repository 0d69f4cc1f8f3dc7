/* Requests and answers about events. Their instants are tested in
 * tests/core/integrate/events/test_events.c. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tests/api/post.h"
#include "tests/harness/test.h"

#define DOUBLE                                                                                     \
    "\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1]},\"initial\":{\"theta\":[1,0." \
    "5]}"
#define TIMES ",\"times\":{\"start\":2,\"stop\":12,\"step\":0.1}"
#define ASK(events) "{" DOUBLE TIMES ",\"events\":" events "}"

TEST(events_stand_beside_the_samples_of_a_trajectory) {
    OWN(test_reply, free) reply =
        test_post(API_OP_TRAJECTORIES,
                  ASK("[{\"of\":\"theta\",\"arm\":1,\"value\":0},{\"of\":\"distance\",\"arm\":1,"
                      "\"to\":2,\"value\":2},{\"of\":\"kinetic\",\"value\":3,\"direction\":\"up\","
                      "\"count\":2}]"));
    CHECK_INT(reply.status, 200);
    CHECK_INT(test_reply_count(&reply, "/t"), 101);
    int count = test_reply_count(&reply, "/events"), kinetic = 0;
    CHECK(count > 4 && test_reply_number(&reply, "/stats/events") == count);
    double before = 2;
    for (int i = 0; i < count; i++) {
        char at[40];
        snprintf(at, sizeof at, "/events/%d/t", i);
        double t = test_reply_number(&reply, at);
        CHECK(t >= before && t <= 12);
        before = t;
        snprintf(at, sizeof at, "/events/%d/event", i);
        int event = (int)test_reply_number(&reply, at);
        snprintf(at, sizeof at, "/events/%d/direction", i);
        const char *way = test_reply_text(&reply, at);
        snprintf(at, sizeof at, "/events/%d/phid/0", i);
        double rate = test_reply_number(&reply, at);
        CHECK(way && (!strcmp(way, "up") || !strcmp(way, "down")));
        snprintf(at, sizeof at, "/events/%d/phi/0", i);
        if (event == 1) CHECK(fabs(test_reply_number(&reply, at) + M_PI_2) < 1e-13);
        if (event == 1 && way) CHECK((rate > 0) == !strcmp(way, "up"));
        // arms of a rod each have tips 1 m apart
        CHECK(event != 2);
        kinetic += event == 3;
    }
    CHECK_INT(kinetic, 2);
}

TEST(events_end_the_motion_at_the_nth_and_no_sample_comes_after) {
    OWN(test_reply, free) all =
        test_post(API_OP_TRAJECTORIES, ASK("[{\"of\":\"theta\",\"arm\":1,\"value\":0}]"));
    OWN(test_reply, free) reply = test_post(
        API_OP_TRAJECTORIES,
        ASK("[{\"of\":\"theta\",\"arm\":1,\"value\":0,\"stop\":3},{\"of\":\"y\",\"arm\":2,"
            "\"bound\":0.5,\"direction\":\"down\"}]"));
    CHECK_INT(reply.status, 200);
    double stopped = test_reply_number(&reply, "/stats/stopped");
    CHECK(stopped == test_reply_number(&all, "/events/2/t"));
    int rows = test_reply_count(&reply, "/t");
    CHECK_INT(rows, (int)floor((stopped - 2) * 10) + 1);
    CHECK_INT(test_reply_count(&reply, "/phi"), rows);
    // the samples are those of the whole motion
    CHECK(test_reply_number(&reply, "/phi/3/1") == test_reply_number(&all, "/phi/3/1"));
}

TEST(events_are_rows_in_every_representation) {
    static const char *const accept[] = {"application/json",     "text/csv",
                                         "application/x-ndjson", "application/octet-stream",
                                         "application/x-npz",    "application/x-matlab-data"};
    static const char *const value[] = {"0", "3"};
    for (int none = 0; none < 2; none++)
        for (int i = 0; i < 6; i++) {
            char body[300];
            snprintf(body, sizeof body,
                     "{" DOUBLE TIMES ",\"rows\":\"events\",\"events\":[{\"of\":\"theta\","
                     "\"arm\":1,\"value\":%s,\"unit\":\"rad\"}]}",
                     value[none]);
            OWN(test_reply, free) reply = test_post_as(API_OP_TRAJECTORIES, body, accept[i], NULL);
            CHECK_INT(reply.status, 200);
            CHECK(!strncmp(reply.media_type, accept[i], strlen(accept[i])));
            if (!i) CHECK((test_reply_count(&reply, "/event") > 4) == !none);
            if (!i)
                CHECK(test_reply_number(&reply, "/stats/events") == test_reply_count(&reply, "/t"));
            if (i == 1)
                CHECK(
                    !strncmp(reply.out.data, "t,event,direction,phi_1,phi_2,phid_1,phid_2\n", 44));
            if (i == 3) CHECK(reply.out.bytes % (7 * 8) == 0 && (reply.out.bytes == 0) == none);
        }
}

TEST(events_that_make_no_sense_are_refused) {
    OWN(test_reply, free) reply = test_post_as(
        API_OP_TRAJECTORIES, ASK("[{\"of\":\"x\",\"arm\":1,\"value\":1}]"), "text/csv", NULL);
    CHECK(test_reply_has_fault(&reply, "/events", "\"rows\": \"events\""));
}

TEST(events_of_places_far_from_the_pivot_are_refused_where_there_are_many) {
    static char body[30000];
    char *at = body + sprintf(body, "{\"pendulum\":{\"length\":[1");
    for (int i = 1; i < 900; i++) at += sprintf(at, ",1");
    at += sprintf(at, "],\"mass\":[1");
    for (int i = 1; i < 900; i++) at += sprintf(at, ",1");
    at += sprintf(at, "],\"parent\":[0");
    for (int i = 1; i < 900; i++) at += sprintf(at, ",%d", i);
    at += sprintf(at, "]},\"times\":[0,0.01],\"events\":[");
    for (int i = 0; i < 24; i++)
        at += sprintf(at, "%s{\"of\":\"y\",\"arm\":900,\"value\":-1,\"count\":1}", i ? "," : "");
    sprintf(at, "]}");
    OWN(test_reply, free) reply = test_post(API_OP_TRAJECTORIES, body);
    CHECK(test_reply_has_fault(&reply, "/events", "21600 arms"));
}

TEST(events_of_too_many_steps_are_refused) {
    struct api_limits limits;
    api_limits_init(&limits);
    limits.steps = 100;
    OWN(test_reply, free) reply = test_post_as(
        API_OP_TRAJECTORIES,
        "{" DOUBLE ",\"times\":[0,5000],\"rows\":\"events\",\"events\":[{\"of\":\"x\",\"arm\":1,"
        "\"value\":5}]}",
        NULL, &limits);
    CHECK_INT(reply.status, 422);
    CHECK(strstr(reply.out.data, "max-steps") != NULL);
}

/* An arm on a free cart: the momentum along the rail stays 0, a small swing's period is that of the
 * reduced mass, and the energy never passes a value. */
TEST(events_on_a_cart_tell_where_it_is) {
    const double mass = 2, cart = 3, gravity = 9.81, swing = 1e-5;
#define FREE(theta, rest)                                                                          \
    "{\"pendulum\":{\"length\":[1],\"mass\":[2],\"parent\":[0],\"pivot\":{\"cart\":{\"mass\":3}}}" \
    ","                                                                                            \
    "\"initial\":{\"theta\":[" theta "]},\"times\":[0,6]," rest "}"
    OWN(test_reply, free) small = test_post(
        API_OP_TRAJECTORIES, FREE("1e-5", "\"events\":[{\"of\":\"phid\",\"arm\":1,\"value\":0}]"));
    OWN(test_reply, free) rows = test_post(
        API_OP_TRAJECTORIES,
        FREE("2", "\"rows\":\"events\",\"events\":[{\"of\":\"kinetic\",\"value\":8},{\"of\":"
                  "\"energy\",\"value\":0},{\"of\":\"x\",\"arm\":1,\"value\":0.6}]"));
    CHECK_INT(small.status, 200);
    CHECK_INT(rows.status, 200);
    double half = M_PI / sqrt(gravity * (1 + mass / cart)), worst = 0x1p-60;
    CHECK_RESIDUAL(fabs(test_reply_number(&small, "/events/0/t") - half), 1e-9,
                   "half a small swing's period on a cart");
    CHECK(fabs(test_reply_number(&small, "/events/0/cart/x") - 2 * swing * mass / (mass + cart)) <
          1e-12);
    int count = test_reply_count(&rows, "/t"), kinetic = 0;
    for (int i = 0; i < count; i++) {
        static const char *const names[][2] = {
            {"/event/", ""}, {"/phi/", "/0"}, {"/phid/", "/0"}, {"/cart/x/", ""}, {"/cart/v/", ""}};
        double number[5];
        for (int j = 0; j < 5; j++) {
            char at[40];
            snprintf(at, sizeof at, "%s%d%s", names[j][0], i, names[j][1]);
            number[j] = test_reply_number(&rows, at);
        }
        double phi = number[1], rate = number[2], v = number[4], across = v - sin(phi) * rate,
               up = cos(phi) * rate;
        worst = fmax(worst, fabs(cart * v + mass * across));
        if (number[0] == 1)
            worst =
                fmax(worst, fabs(cart * v * v / 2 + mass * (across * across + up * up) / 2 - 8));
        if (number[0] == 3) worst = fmax(worst, fabs(number[3] + cos(phi) - 0.6));
        CHECK(number[0] != 2);
        kinetic += number[0] == 1;
    }
    CHECK(kinetic > 1 && count > kinetic);
    CHECK_RESIDUAL(worst, 1e-12, "momentum, energy and place at passages on a cart");
#undef FREE
}

/* passages of a chaotic motion are certain for some seconds only, as for sections */
TEST(passages_as_rows_say_how_many_of_them_hold) {
    static const char motion[] = "\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1]},"
                                 "\"initial\":{\"theta\":[2,2.5]}";
    char body[600];
    snprintf(body, sizeof body, "{%s,\"section\":{\"arm\":1,\"theta\":0},\"duration\":40}", motion);
    OWN(test_reply, free) section = test_post(API_OP_SECTIONS, body);
    snprintf(body, sizeof body,
             "{%s,\"times\":[0,40],\"rows\":\"events\",\"events\":[{\"of\":\"theta\",\"arm\":1,"
             "\"value\":0}]}",
             motion);
    OWN(test_reply, free) all = test_post(API_OP_TRAJECTORIES, body);
    double held = test_reply_number(&all, "/stats/horizon");
    CHECK(held > 1 && held < 39 && held == test_reply_number(&section, "/stats/horizon"));
    int holding = (int)test_reply_number(&all, "/stats/holding"), count = 0;
    for (int i = 0; i < test_reply_count(&all, "/t"); i++) {
        char at[20];
        snprintf(at, sizeof at, "/t/%d", i);
        count += test_reply_number(&all, at) <= held;
    }
    CHECK_INT(holding, count);
    CHECK(holding < test_reply_number(&all, "/stats/events"));
    CHECK(test_reply_text(&all, "/warnings/0") != NULL);
    // backwards, and up to a passage that ends the motion early
    snprintf(body, sizeof body,
             "{%s,\"times\":[0,-40],\"rows\":\"events\",\"events\":[{\"of\":\"theta\",\"arm\":1,"
             "\"value\":0,\"stop\":1}]}",
             motion);
    OWN(test_reply, free) one = test_post(API_OP_TRAJECTORIES, body);
    CHECK(test_reply_number(&one, "/stats/horizon") == test_reply_number(&one, "/stats/stopped"));
    CHECK_INT((int)test_reply_number(&one, "/stats/holding"), 1);
    CHECK(!test_reply_text(&one, "/warnings/0"));
}
