/* Sampled controllers: closed forms of free joints, pendulums that are kept upright. Refusals:
 * tests/api/read/refused.txt.
 * Leaves to others: gains (test_op_controllers), an acrobot along a reference
 * (tests/rules/gains.py). */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/api/post.h"
#include "tests/harness/test.h"

enum { SAMPLES = 30, PARTS = 3 };

/* a free rod of inertia 0.05 */
#define FREE                                                                                       \
    "{\"pendulum\":{\"arms\":[{\"length\":0.5,\"mass\":0,\"rod\":0.6}],\"gravity\":0,\"control\":" \
    "[{\"joint\":1,\"law\":%s,\"period\":0.03,\"delay\":%d,\"limit\":[-0.25,0.25],\"quantize\":"   \
    "%g}]},\"initial\":{\"theta\":[1]},\"times\":{\"stop\":0.9,\"count\":91},"                     \
    "\"output\":[\"theta\",\"thetad\",\"control\"]}"

static double number_at(const struct test_reply *reply, const char *name, int row) {
    char pointer[40];
    snprintf(pointer, sizeof pointer, "/%s/%d/0", name, row);
    return test_reply_number(reply, pointer);
}

/* the largest deviation from the difference equation of a law */
static double free_gap(const char *law, int delay, double quantum, int pid) {
    const double inertia = 0.6 * 0.5 * 0.5 / 3, h = 0.03;
    double q = 1, w = 0, sum = 0, past[SAMPLES + 4] = {0}, worst = 0;
    char body[700];
    snprintf(body, sizeof body, FREE, law, delay, quantum);
    OWN(test_reply, free) reply = test_post(API_OP_TRAJECTORIES, body);
    CHECK_SAYING(reply.status == 200, "%s", reply.out.data);
    for (int i = 0; i < SAMPLES; i++) {
        double before = i ? past[i - 1 + 4] : 0;
        int limited = before != 0 && fabs(before) >= 0.25;
        if (pid && (!limited || before * (0.2 - q) < 0)) sum += (0.2 - q) * h;
        double u = pid ? 1.1 * (0.2 - q) + 0.5 * sum - 0.3 * w : -1.1 * (q - 0.2) - 0.3 * w;
        if (quantum > 0) u = quantum * round(u / quantum);
        past[i + 4] = fmin(fmax(u, -0.25), 0.25);
        u = past[i + 4 - delay];
        for (int part = 1; part <= PARTS; part++) {
            double y = h * part / PARTS;
            int row = i * PARTS + part;
            worst = fmax(
                worst, fabs(number_at(&reply, "theta", row) - q - w * y - u * y * y / inertia / 2));
            worst = fmax(worst, fabs(number_at(&reply, "thetad", row) - w - u * y / inertia));
            // at a sample's instant rounding decides which output a row has
            if (part < PARTS) worst = fmax(worst, fabs(number_at(&reply, "control", row) - u));
        }
        q += w * h + u * h * h / inertia / 2;
        w += u * h / inertia;
    }
    return worst;
}

TEST(sampled_feedback_on_a_free_joint_is_its_difference_equation) {
    static const char feedback[] = "{\"feedback\":{\"gains\":[1.1,0.3],\"reference\":[0.2,0]}}";
    static const char table[] =
        "{\"feedback\":{\"gains\":{\"t\":[0,5],\"value\":[[1.1,0.3],[1.1,0.3]]},\"reference\":{"
        "\"t\":[-1,0,1],\"value\":[[7,7],[0.2,0],[0.2,0]]}}}";
    static const char pid[] = "{\"pid\":{\"p\":1.1,\"i\":0.5,\"d\":0.3,\"reference\":0.2}}";
    double worst = 0;
    for (int delay = 0; delay < 4; delay++) {
        worst = fmax(worst, free_gap(feedback, delay, 0, 0));
        worst = fmax(worst, free_gap(feedback, delay, 0x1p-5, 0));
        worst = fmax(worst, free_gap(table, delay, 0, 0));
        worst = fmax(worst, free_gap(pid, delay, 0, 1));
    }
    CHECK_RESIDUAL(worst, 1e-12, "angles, rates and outputs of a free joint");
}

/* requests controllers; writes the list `control` of the answer to text */
static void design(const char *pendulum, const char *rest, char *text, size_t bytes) {
    char body[1200];
    snprintf(body, sizeof body, "{\"pendulum\":%s},%s}", pendulum, rest);
    OWN(test_reply, free) reply = test_post(API_OP_CONTROLLERS, body);
    CHECK_SAYING(reply.status == 200, "%s", reply.out.data);
    const char *from = strstr(reply.out.data, "\"control\":["),
               *to = from ? strstr(from, "}]") : NULL;
    if (CHECK(to)) snprintf(text, bytes, "%.*s", (int)(to + 2 - from), from);
}

/* the largest angle from upright, up to whole turns, in some rows */
static double tilt(const struct test_reply *reply, int arms, int from, int to) {
    double most = 0;
    for (int row = from; row < to; row++)
        for (int k = 0; k < arms; k++) {
            char pointer[40];
            snprintf(pointer, sizeof pointer, "/theta/%d/%d", row, k);
            most = fmax(most, fabs(remainder(test_reply_number(reply, pointer) - M_PI, 2 * M_PI)));
        }
    return most;
}

TEST(three_arms_on_a_cart_stay_upright_at_100_samples_a_second) {
    static const char tree[] =
        "{\"length\":[0.4,0.4,0.4],\"mass\":[0.3,0.3,0.3],\"parent\":[0,1,2],\"pivot\":{\"cart\":{"
        "\"mass\":1}}";
    for (int delay = 0; delay < 2; delay++) {
        char control[2000], body[3000];
        snprintf(body, sizeof body,
                 "\"equilibrium\":{\"theta\":[180,180,180],\"unit\":\"deg\"},\"actuators\":{"
                 "\"cart\":true},\"period\":0.01,\"delay\":%d",
                 delay);
        design(tree, body, control, sizeof control);
        snprintf(body, sizeof body,
                 "{\"pendulum\":%s,%s},\"initial\":{\"theta\":[182,182,182],\"unit\":\"deg\"},"
                 "\"times\":{\"stop\":20,\"count\":201},\"output\":[\"theta\",\"cart\"]}",
                 tree, control);
        OWN(test_reply, free) reply = test_post(API_OP_TRAJECTORIES, body);
        CHECK_INT(reply.status, 200);
        CHECK(tilt(&reply, 3, 0, 201) < 0.2);
        CHECK(tilt(&reply, 3, 190, 201) < 1e-9);
        CHECK(fabs(test_reply_number(&reply, "/cart/x/200")) < 1e-9);
    }
}

TEST(an_arm_on_a_cart_swings_up_from_hanging_and_is_caught_within_a_limit_of_force) {
    static const char tree[] =
        "{\"length\":[0.5],\"mass\":[0.2],\"parent\":[0],\"pivot\":{\"cart\":{\"mass\":0.5}}";
    char control[1000], feedback[1000], body[3000];
    design(tree,
           "\"equilibrium\":{\"theta\":[180],\"unit\":\"deg\"},\"actuators\":{\"cart\":true},"
           "\"period\":0.02",
           control, sizeof control);
    const char *from = strstr(control, "{\"feedback\""), *to = strstr(control, "},\"period\"");
    REQUIRE(from && to);
    snprintf(feedback, sizeof feedback, "%.*s", (int)(to + 1 - from), from);
    snprintf(body, sizeof body,
             "{\"pendulum\":%s,\"control\":[{\"cart\":true,\"law\":{\"swing_up\":{\"gain\":100,"
             "\"p\":1,\"d\":1,\"within\":{\"theta\":0.4,\"thetad\":3},\"then\":%s}},"
             "\"period\":0.02,\"limit\":[-5,5]}]},\"initial\":{\"theta\":[0.01]},\"times\":{"
             "\"stop\":20,\"count\":2001},\"output\":[\"theta\",\"control\",\"cart\"]}",
             tree, feedback);
    OWN(test_reply, free) reply = test_post(API_OP_TRAJECTORIES, body);
    CHECK_INT(reply.status, 200);
    CHECK(tilt(&reply, 1, 0, 20) > 3);
    CHECK(tilt(&reply, 1, 1900, 2001) < 1e-9);
    double most = 0;
    for (int row = 0; row < 2001; row++) most = fmax(most, fabs(number_at(&reply, "control", row)));
    CHECK(most == 5);
    CHECK(strstr(reply.out.data, "controller 1 is at a limit in "));
}
