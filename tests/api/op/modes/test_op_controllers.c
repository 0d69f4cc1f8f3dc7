/* Controllers: requests, answers and refusals. That gains are correct is tested in
 * tests/core/control/test_loop.c and tests/rules/gains.py. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tests/api/post.h"
#include "tests/harness/test.h"

#define UPRIGHT                                                                                    \
    "\"pendulum\":{\"length\":[2],\"mass\":[3],\"parent\":[0],\"gravity\":10},"                    \
    "\"equilibrium\":{\"theta\":[180],\"unit\":\"deg\"},\"actuators\":{\"joints\":[1]},"           \
    "\"period\":0.1"

/* an upright rod: J x'' = m g l x + u, whose discretization has closed forms */
TEST(the_loop_of_an_upright_arm_is_the_textbooks) {
    double j = 3 * 2 * 2, w = sqrt(10.0 / 2), h = 0.1, gain = 1.5 * 3 * 10 * 2, rate = 40;
    double a[2][2] = {{cosh(w * h), sinh(w * h) / w}, {w * sinh(w * h), cosh(w * h)}};
    double b[2] = {(cosh(w * h) - 1) / (w * w * j), sinh(w * h) / (w * j)};
    char body[400], pointer[20];
    snprintf(body, sizeof body, "{" UPRIGHT ",\"gains\":[%.17g,%.17g]}", gain, rate);
    OWN(test_reply, free) reply = test_post(API_OP_CONTROLLERS, body);
    CHECK_INT(reply.status, 200);
    double trace = 0, product = 1, re[2], im[2];
    for (int i = 0; i < 2; i++) {
        for (int k = 0; k < 2; k++) {
            snprintf(pointer, sizeof pointer, "/A/%d/%d", i, k);
            CHECK(fabs(test_reply_number(&reply, pointer) - a[i][k]) < 1e-14);
        }
        snprintf(pointer, sizeof pointer, "/B/%d/0", i);
        CHECK(fabs(test_reply_number(&reply, pointer) - b[i]) < 1e-15);
        snprintf(pointer, sizeof pointer, "/multipliers/re/%d", i);
        re[i] = test_reply_number(&reply, pointer);
        snprintf(pointer, sizeof pointer, "/multipliers/im/%d", i);
        im[i] = test_reply_number(&reply, pointer);
        trace += a[i][i] - b[i] * (i ? rate : gain);
    }
    product = (a[0][0] - b[0] * gain) * (a[1][1] - b[1] * rate) -
              (a[0][1] - b[0] * rate) * (a[1][0] - b[1] * gain);
    CHECK(fabs(re[0] + re[1] - trace) < 1e-13);
    CHECK(fabs(re[0] * re[1] - im[0] * im[1] - product) < 1e-13);
    CHECK_INT((int)test_reply_number(&reply, "/stats/stable"), 1);
}

TEST(a_loop_that_is_unstable_says_its_multiplier) {
    OWN(test_reply, free) reply = test_post(API_OP_CONTROLLERS, "{" UPRIGHT ",\"gains\":[[1,1]]}");
    CHECK_INT(reply.status, 200);
    CHECK_INT((int)test_reply_number(&reply, "/stats/stable"), 0);
    CHECK_INT(test_reply_count(&reply, "/margins"), 0);
    const char *warning = test_reply_text(&reply, "/warnings/0");
    CHECK(warning && strstr(warning, "the loop is unstable: its largest multiplier is 1.2"));
}

TEST(an_angle_that_is_no_equilibrium_says_the_torque_that_would_hold_it) {
    static const char body[] = "{\"pendulum\":{\"length\":[2],\"mass\":[3],\"parent\":[0],"
                               "\"gravity\":10%s},\"equilibrium\":{\"theta\":[90],\"unit\":"
                               "\"deg\"},\"actuators\":{\"joints\":[1]},\"period\":0.1}";
    char text[300];
    snprintf(text, sizeof text, body, "");
    OWN(test_reply, free) reply = test_post(API_OP_CONTROLLERS, text);
    CHECK(test_reply_has_fault(&reply, "/equilibrium", "60 N m in the joint of arm 1"));
    test_reply_free(&reply);
    snprintf(text, sizeof text, body, ",\"torque\":[60]");
    reply = test_post(API_OP_CONTROLLERS, text);
    CHECK_INT((int)test_reply_number(&reply, "/stats/stable"), 1);
    CHECK(fabs(test_reply_number(&reply, "/control/0/law/feedback/reference/0") - M_PI_2) < 1e-15);
}

TEST(modes_that_no_actuator_reaches_are_named) {
    static const char body[] =
        "{\"pendulum\":{\"length\":[1,0.5,0.5],\"mass\":[1,2,2],\"parent\":[0,1,1],\"damping\":"
        "[0.1,%s,%s]},%s\"actuators\":{\"joints\":[1]},\"sensors\":{\"arms\":[1]},\"period\":0.1}";
    char text[400];
    snprintf(text, sizeof text, body, "0.1", "0.1", "");
    OWN(test_reply, free) reply = test_post(API_OP_CONTROLLERS, text);
    CHECK_INT(reply.status, 200);
    CHECK_INT(test_reply_count(&reply, "/unreachable"), 1);
    CHECK_INT(test_reply_count(&reply, "/unobservable"), 1);
    test_reply_free(&reply);
    snprintf(text, sizeof text, body, "0.1", "0.1",
             "\"equilibrium\":{\"theta\":[180,180,180],\"unit\":\"deg\"},");
    reply = test_post(API_OP_CONTROLLERS, text);
    CHECK_INT(reply.status, 422);
    CHECK(strstr(reply.out.data, "the actuators cannot control mode"));
}
