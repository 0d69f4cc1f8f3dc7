/* Tests of ensembles on a cart and of ensembles with their own starting time: rows, ends and flips
 * equal those of trajectories and sections with the same start.
 * Leaves to others: axes over the numbers of a cart (test_op_trajectories_cart).
 * Invariant: references come from another operation. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "tests/api/post.h"
#include "tests/harness/requests.h"
#include "tests/harness/test.h"

/* two arms side by side, of which both turn over, on a cart that a force drives */
#define DRIVEN                                                                                     \
    "\"pendulum\":{\"length\":[1,0.6],\"mass\":[1,0.8],\"parent\":[0,0],\"pivot\":{\"cart\":{"     \
    "\"mass\":1,\"angle\":0.1,\"damping\":0.1,\"force\":{\"harmonics\":[{\"amplitude\":12,"        \
    "\"omega\":3,\"phase\":1}]}}}}"
#define FAST "{\"theta\":[1.5,-1],\"thetad\":[6,-5],\"cart\":{\"x\":9,\"v\":1}}"

TEST(rows_of_members_on_a_cart_are_those_of_trajectories) {
    static const char *const column[] = {"cart/x", "cart/v"};
    OWN(test_reply, free) rows =
        test_post(API_OP_ENSEMBLES, "{" DRIVEN ",\"states\":[" FAST "],\"times\":[2,2.5,4],"
                                    "\"observables\":[\"trajectory\"],\"output\":[\"cart\","
                                    "\"theta\"],\"rtol\":1e-14}");
    OWN(test_reply, free) alone =
        test_post(API_OP_TRAJECTORIES, "{" DRIVEN ",\"initial\":" FAST ",\"times\":[2,2.5,4],"
                                       "\"output\":[\"cart\",\"theta\"],\"rtol\":1e-14}");
    CHECK_INT(rows.status, 200);
    double gap = 0;
    for (int i = 0; i < 3; i++)
        for (int c = 0; c < 4; c++) {
            char at[40];
            snprintf(at, sizeof at, c < 2 ? "/%s/%d" : "/%s/%d/%d", c < 2 ? column[c] : "theta", i,
                     c - 2);
            gap = fmax(gap, fabs(test_reply_number(&rows, at) - test_reply_number(&alone, at)));
        }
    CHECK_RESIDUAL(gap, 1e-12, "rows of a member on a cart");
    CHECK(test_reply_number(&rows, "/cart/x/0") == 9);
}

TEST(what_a_cart_was_drawn_to_begin_with_is_told) {
    OWN(test_reply, free) rows = test_post(
        API_OP_ENSEMBLES,
        "{" DRIVEN ",\"initial\":" FAST ",\"duration\":1,\"observables\":[\"start\","
        "\"parameters\"],\"grid\":[{\"vary\":\"mass\",\"arm\":\"cart\",\"start\":2,\"stop\":3,"
        "\"count\":2,\"with\":[{\"vary\":\"phi\",\"arm\":\"cart\",\"start\":4,\"stop\":5},{"
        "\"vary\":\"phid\",\"arm\":\"cart\",\"start\":6,\"stop\":7}]}]}");
    CHECK_INT(rows.status, 200);
    for (int i = 0; i < 2; i++) {
        static const char *const column[] = {"parameters/cart_mass", "start/cart_x",
                                             "start/cart_v"};
        for (int c = 0; c < 3; c++) {
            char at[40];
            snprintf(at, sizeof at, "/%s/%d", column[c], i);
            CHECK(test_reply_number(&rows, at) == 2 * (c + 1) + i);
        }
    }
    CHECK(test_reply_number(&rows, "/start/phid/1/1") == -5);
    CHECK(test_reply_number(&rows, "/parameters/gravity/1") == 9.81);
}

TEST(members_begin_at_the_start_that_a_request_gives) {
    char body[900];
    for (int i = 0; i < 2; i++) {
        const char *start = i ? "-1.25" : "7";
        snprintf(body, sizeof body,
                 "{" DRIVEN ",\"states\":[" FAST "],\"start\":%s,\"duration\":2,\"observables\":["
                 "\"final\",\"cart\",\"energy_drift\",\"horizon\"],\"rtol\":1e-14}",
                 start);
        OWN(test_reply, free) one = test_post(API_OP_ENSEMBLES, body);
        CHECK_INT(one.status, 200);
        snprintf(body, sizeof body,
                 "{" DRIVEN ",\"initial\":" FAST ",\"times\":{\"start\":%s,\"stop\":%.17g,"
                 "\"count\":2},\"output\":[\"cart\",\"phi\",\"phid\"],\"rtol\":1e-14}",
                 start, atof(start) + 2);
        OWN(test_reply, free) alone = test_post(API_OP_TRAJECTORIES, body);
        double gap = 0;
        for (int c = 0; c < 6; c++) {
            static const char *const names[][2] = {
                {"/final/phi/0/0", "/phi/1/0"},   {"/final/phi/0/1", "/phi/1/1"},
                {"/final/phid/0/0", "/phid/1/0"}, {"/final/phid/0/1", "/phid/1/1"},
                {"/cart/x/0", "/cart/x/1"},       {"/cart/v/0", "/cart/v/1"}};
            gap = fmax(gap, fabs(test_reply_number(&one, names[c][0]) -
                                 test_reply_number(&alone, names[c][1])));
        }
        CHECK_RESIDUAL(gap, 1e-12, "the end of a member");
        CHECK(test_reply_number(&one, "/energy_drift/0") < 1e-11);
        // times count from the start
        CHECK(test_reply_number(&one, "/horizon/0") == 2);
    }
}

/* An arm on a cart turns over where it passes the upright section; the cart's position, pi / 2 m
 * where an arm's angle would be upright, does not matter. */
TEST(flips_on_a_cart_are_passages_of_the_upright_section) {
    struct test_reply flips =
        test_post(API_OP_ENSEMBLES, "{" DRIVEN ",\"states\":[" FAST "],\"start\":2,\"duration\":9,"
                                    "\"observables\":[\"first_flip\",\"flip_time\",\"flips\"]}");
    CHECK_INT(flips.status, 200);
    double first = INFINITY;
    int arm = 0;
    for (int k = 0; k < 2; k++) {
        char body[900], at[40];
        snprintf(body, sizeof body,
                 "{" DRIVEN ",\"initial\":" FAST ",\"start\":2,\"duration\":9,\"section\":{\"arm\":"
                 "%d,\"theta\":180,\"unit\":\"deg\",\"direction\":\"both\"}}",
                 k + 1);
        OWN(test_reply, free) passages = test_post(API_OP_SECTIONS, body);
        snprintf(at, sizeof at, "/flips/0/%d", k);
        CHECK_INT(test_reply_count(&passages, "/t"), (int)test_reply_number(&flips, at));
        double t = test_reply_number(&passages, "/t/0") - 2;
        snprintf(at, sizeof at, "/flip_time/0/%d", k);
        CHECK(fabs(test_reply_number(&flips, at) - t) < 1e-12);
        if (t < first) first = t, arm = k + 1;
    }
    CHECK(fabs(test_reply_number(&flips, "/first_flip/time/0") - first) < 1e-10);
    CHECK_INT((int)test_reply_number(&flips, "/first_flip/arm/0"), arm);
    test_reply_free(&flips);
    // everything requested is known once both arms have turned over
    OWN(test_reply, free) times = test_post(API_OP_ENSEMBLES, "{" DRIVEN ",\"states\":[" FAST
                                                              "],\"start\":2,\"duration\":2e3,"
                                                              "\"observables\":[\"flip_time\"]}");
    CHECK_INT(times.status, 200);
    CHECK(test_reply_number(&times, "/flip_time/0/1") > 0);
}
