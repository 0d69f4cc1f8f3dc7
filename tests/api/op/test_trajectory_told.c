/* What the stats of a trajectory say about its accuracy. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tests/api/post.h"
#include "tests/harness/test.h"

#define TWO "\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1]}"

TEST(a_linear_motion_tells_how_far_from_small_it_starts_and_no_digits_of_its_own) {
    OWN(test_reply, free) reply =
        test_post(API_OP_TRAJECTORIES, "{" TWO ",\"initial\":{\"theta\":[2,2.5]},\"times\":[0,5],"
                                       "\"method\":\"linear\"}");
    CHECK_INT(reply.status, 200);
    CHECK(!strstr(reply.out.data, "\"horizon\"") && !strstr(reply.out.data, "\"energy_drift\""));
    CHECK(strstr(reply.out.data, "this start is 2.5 rad from equilibrium") != NULL);
    test_reply_free(&reply);
    reply = test_post(API_OP_TRAJECTORIES, "{" TWO ",\"initial\":{\"theta\":[1e-4,0]},\"times\":[0,"
                                           "5],\"method\":\"linear\"}");
    CHECK(!strstr(reply.out.data, "\"warnings\""));
}

TEST(the_horizon_is_the_exact_comparison_where_there_is_one) {
    static const char *const methods[] = {"taylor", "rk8pd", "linear"};
    for (int i = 0; i < 3; i++) {
        char body[300];
        snprintf(body, sizeof body,
                 "{" TWO ",\"initial\":{\"theta\":[2,2.5]},\"times\":{\"stop\":20,\"step\":0.5},"
                 "\"method\":\"%s\",\"trust\":true}",
                 methods[i]);
        OWN(test_reply, free) reply = test_post(API_OP_TRAJECTORIES, body);
        CHECK_INT(reply.status, 200);
        double until = test_reply_number(&reply, "/stats/trust_until");
        CHECK(until < 20 && test_reply_number(&reply, "/stats/horizon") == until);
        CHECK(strstr(reply.out.data, "(compared)") != NULL);
    }
}

TEST(warnings_name_the_estimate_itself_and_what_the_method_takes) {
    static const char *const list[][2] = {{"taylor", "With a smaller rtol or precision extended"},
                                          {"symplectic", "Method taylor with precision"},
                                          {"rk8pd", "With a smaller rtol or method taylor"}};
    for (int i = 0; i < 3; i++) {
        char body[300];
        snprintf(body, sizeof body,
                 "{" TWO ",\"initial\":{\"theta\":[2,2.5]},\"times\":[0,50],\"method\":\"%s\"}",
                 list[i][0]);
        OWN(test_reply, free) reply = test_post(API_OP_TRAJECTORIES, body);
        CHECK(test_reply_number(&reply, "/stats/horizon") == 0);
        CHECK(strstr(reply.out.data, list[i][1]) && !strstr(reply.out.data, "beyond t = 0 s"));
    }
}

TEST(method_symplectic_keeps_the_digits_of_small_angles) {
    OWN(test_reply, free) reply =
        test_post(API_OP_TRAJECTORIES,
                  "{\"pendulum\":{\"length\":[1],\"mass\":[1],\"parent\":[0]},"
                  "\"initial\":{\"theta\":[1e-12]},\"times\":[0,3],\"output\":[\"theta\"],"
                  "\"method\":\"symplectic\"}");
    CHECK(test_reply_number(&reply, "/theta/0/0") == 1e-12);
    double swung = 1e12 * test_reply_number(&reply, "/theta/1/0");
    CHECK_SAYING(fabs(swung - cos(3 * sqrt(9.81))) < 1e-11, "%.17g", swung);
}
