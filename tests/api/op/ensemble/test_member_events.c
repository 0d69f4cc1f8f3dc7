/* Requests and answers about conditions on an ensemble's members. Their instants are tested in
 * tests/core/ensemble/test_ensemble_events.c. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tests/api/post.h"
#include "tests/harness/test.h"

/* arm 2 of this one is at the pivot: stored order and the caller's differ */
#define TURNED "\"pendulum\":{\"length\":[0.7,1,0.9],\"mass\":[2,1,3],\"parent\":[2,0,2]}"
#define CARRIED                                                                                    \
    "\"pendulum\":{\"length\":[1,0.5],\"mass\":[1,2],\"parent\":[0,1],\"pivot\":{\"cart\":{"       \
    "\"mass\":3,\"stiffness\":40}}}"
#define ONE "{\"theta\":[1,2,-1],\"thetad\":[0,1,2]}"
#define RISES "{\"of\":\"theta\",\"arm\":3,\"value\":0,\"direction\":\"up\"}"
#define EVENTS                                                                                     \
    "\"events\":[" RISES ",{\"of\":\"lambda\",\"arm\":1,\"value\":-20},{\"of\":\"distance\","      \
    "\"arm\":1,\"to\":3,\"value\":1},{\"of\":\"kinetic\",\"value\":15},{\"of\":\"y\",\"arm\":3,"   \
    "\"bound\":900}]"

TEST(members_pass_what_trajectories_pass_and_when) {
    OWN(test_reply, free) many = test_post(API_OP_ENSEMBLES, "{" TURNED ",\"states\":[{}," ONE
                                                             "],\"duration\":4," EVENTS "}");
    OWN(test_reply, free) rows =
        test_post(API_OP_ENSEMBLES, "{" TURNED ",\"states\":[{}," ONE
                                    "],\"duration\":4,\"rows\":\"events\"," EVENTS "}");
    OWN(test_reply, free) one = test_post(API_OP_TRAJECTORIES, "{" TURNED ",\"initial\":" ONE
                                                               ",\"times\":[0,4]," EVENTS "}");
    double worst = 0;
    int told = test_reply_count(&one, "/events"), all = test_reply_count(&rows, "/member"),
        first = 0, count[5] = {0};
    CHECK_INT(many.status, 200);
    CHECK_INT(rows.status, 200);
    CHECK(told > 10);
    while (first < all) {
        char at[40];
        snprintf(at, sizeof at, "/member/%d", first);
        if (test_reply_number(&rows, at) == 1) break;
        first++;
    }
    CHECK_INT(all - first, told);
    for (int i = 0; i < told; i++) {
        char a[60], b[60];
        snprintf(a, sizeof a, "/events/%d/event", i);
        int event = (int)test_reply_number(&one, a) - 1;
        snprintf(b, sizeof b, "/event/%d", first + i);
        CHECK_INT((int)test_reply_number(&rows, b) - 1, event);
        snprintf(a, sizeof a, "/events/%d/t", i);
        snprintf(b, sizeof b, "/t/%d", first + i);
        double t = test_reply_number(&one, a);
        worst = fmax(worst, fabs(t - test_reply_number(&rows, b)));
        for (int k = 0; k < 3; k++) {
            snprintf(a, sizeof a, "/events/%d/phid/%d", i, k);
            snprintf(b, sizeof b, "/phid/%d/%d", first + i, k);
            worst = fmax(worst, fabs(test_reply_number(&one, a) - test_reply_number(&rows, b)));
        }
        if (event < 0 || event > 4 || count[event]++) continue;
        snprintf(b, sizeof b, "/events/time/1/%d", event);
        worst = fmax(worst, fabs(t - test_reply_number(&many, b)));
        for (int k = 0; k < 3; k++) {
            snprintf(a, sizeof a, "/events/%d/phi/%d", i, k);
            snprintf(b, sizeof b, "/events/phi/1/%d/%d", event, k);
            worst = fmax(worst, fabs(test_reply_number(&one, a) - test_reply_number(&many, b)));
        }
    }
    for (int i = 0; i < 5; i++) {
        char at[60];
        snprintf(at, sizeof at, "/events/count/1/%d", i);
        CHECK_INT((int)test_reply_number(&many, at), count[i]);
    }
    CHECK_INT(count[4], 0);
    CHECK_RESIDUAL(worst, 1e-10, "passages of a member, beside those of a trajectory");
}

TEST(members_that_never_pass_say_so_and_a_stop_ends_the_others) {
    OWN(test_reply, free) reply =
        test_post(API_OP_ENSEMBLES, "{" TURNED ",\"states\":[{\"theta\":[0.01,0,0]}," ONE
                                    "],\"duration\":4,\"events\":[{\"of\":"
                                    "\"theta\",\"arm\":3,\"value\":0.3,\"stop\":2}]}");
    OWN(test_reply, free) csv = test_post_as(
        API_OP_ENSEMBLES,
        "{" TURNED ",\"states\":[{\"theta\":[0.01,0,0]}],\"duration\":4,\"events\":[{\"of\":"
        "\"theta\",\"arm\":3,\"value\":1,\"stop\":2}],\"observables\":[\"horizon\"]}",
        "text/csv", NULL);
    CHECK_INT(reply.status, 200);
    CHECK(test_reply_number(&reply, "/events/count/0/0") == 0);
    CHECK(isnan(test_reply_number(&reply, "/events/time/0/0")) &&
          isnan(test_reply_number(&reply, "/events/stopped/0")));
    CHECK(test_reply_number(&reply, "/events/count/1/0") == 2);
    double stopped = test_reply_number(&reply, "/events/stopped/1");
    CHECK(stopped > test_reply_number(&reply, "/events/time/1/0") && stopped < 4);
    // the end of the member is the second passage
    CHECK(fabs(test_reply_number(&reply, "/final/phi/1/2") + M_PI_2 - 0.3) < 1e-13);
    CHECK_INT(csv.status, 200);
    CHECK(strstr(csv.out.data,
                 "member,status,horizon,events_count_1,events_time_1,events_direction_1,"
                 "events_phi_1_1,") == csv.out.data);
    CHECK(strstr(csv.out.data, "\n0,0,4,0,,0,0,0,0,0,0,0,\n") != NULL);
}

/* the energy of a cart without friction is constant; its parts are not */
TEST(members_on_a_cart_have_conditions_too) {
    OWN(test_reply, free) reply = test_post(
        API_OP_ENSEMBLES,
        "{" CARRIED ",\"states\":[{\"theta\":[1,0.5],\"cart\":{\"x\":0.2}}],\"duration\":3,"
        "\"rows\":\"events\",\"events\":[{\"of\":\"kinetic\",\"value\":1},{\"of\":\"energy\","
        "\"value\":0},{\"of\":\"x\",\"arm\":1,\"value\":0.1}]}");
    CHECK_INT(reply.status, 200);
    int count = test_reply_count(&reply, "/t"), seen[3] = {0};
    double worst = 0x1p-60;
    for (int i = 0; i < count; i++) {
        double number[7];
        static const char *const names[][2] = {{"/event/", ""},  {"/phi/", "/0"},  {"/phi/", "/1"},
                                               {"/phid/", "/0"}, {"/phid/", "/1"}, {"/cart/x/", ""},
                                               {"/cart/v/", ""}};
        for (int j = 0; j < 7; j++) {
            char at[40];
            snprintf(at, sizeof at, "%s%d%s", names[j][0], i, names[j][1]);
            number[j] = test_reply_number(&reply, at);
        }
        double a = number[1], b = number[2], v = number[6];
        double vx = v - sin(a) * number[3], vy = cos(a) * number[3];
        double wx = vx - 0.5 * sin(b) * number[4], wy = vy + 0.5 * cos(b) * number[4];
        double kinetic = 1.5 * v * v + 0.5 * (vx * vx + vy * vy) + wx * wx + wy * wy;
        int event = (int)number[0] - 1;
        seen[event]++;
        if (event == 0) worst = fmax(worst, fabs(kinetic - 1));
        if (event == 2) worst = fmax(worst, fabs(number[5] + cos(a) - 0.1));
    }
    CHECK(seen[0] > 1 && !seen[1] && seen[2] > 0);
    CHECK_RESIDUAL(worst, 1e-13, "kinetic energies and places at members' passages");
}
