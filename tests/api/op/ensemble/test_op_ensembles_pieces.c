/* Tests of ensembles of motions in pieces: controllers side by side, joints that stick or hit one
 * by one, members that settle.
 * Leaves to others: one motion in pieces (test_op_pieces), refusals (refused.txt).
 * Invariant: references come from trajectories. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tests/api/post.h"
#include "tests/harness/test.h"

enum { MEMBERS = 11 };

/* an arm on a cart that is caught upright from some starts, by samples and with a limited output */
#define CAUGHT                                                                                     \
    "\"pendulum\":{\"arms\":[{\"length\":0.5,\"mass\":0.2}],\"pivot\":{\"cart\":{\"mass\":0.5}},"  \
    "\"control\":[{\"cart\":true,\"period\":0.02,\"limit\":[-20,20],\"delay\":0,\"law\":{"         \
    "\"feedback\":{\"gains\":[39.4,8.4,-11.5,-8.75],\"reference\":[3.141592653589793,0,0,0]}}}]}"
/* two arms, of which one sticks and one also hits */
#define STUCK                                                                                      \
    "\"pendulum\":{\"arms\":[{\"name\":\"a\",\"length\":0.5,\"mass\":0.2,\"friction\":{"           \
    "\"torque\":0.02}},{\"parent\":\"a\",\"length\":0.5,\"mass\":0.2,\"friction\":{\"torque\":"    \
    "0.01},\"stop\":{\"min\":-1,\"max\":1,\"restitution\":0.6}}]}"

/* the start of a member as JSON */
static const char *start_of(int arms, int i, char text[80]) {
    double theta = arms == 1 ? 2.2 + 0.2 * i : 0.2 * i;
    snprintf(text, 80,
             arms == 1 ? "{\"theta\":[%.17g],\"thetad\":[%.17g]}" : "{\"theta\":[%.17g,%.17g]}",
             theta, arms == 1 ? i - 5.0 : theta + 0.5);
    return text;
}

/* the members' rows, from the last member to the first on request */
static struct test_reply members(const char *pendulum, int arms, int back, const char *rest) {
    static char body[4000];
    char text[80];
    int used = snprintf(body, sizeof body, "{%s,\"states\":[", pendulum);
    for (int i = 0; i < MEMBERS; i++)
        used += snprintf(body + used, sizeof body - (size_t)used, "%s%s", i ? "," : "",
                         start_of(arms, back ? MEMBERS - 1 - i : i, text));
    snprintf(body + used, sizeof body - (size_t)used, "],%s}", rest);
    struct test_reply reply = test_post(API_OP_ENSEMBLES, body);
    CHECK_SAYING(reply.status == 200, "%s", reply.out.data);
    return reply;
}

static struct test_reply trajectory(const char *pendulum, int arms, int i, const char *rest) {
    char body[2000], text[80];
    snprintf(body, sizeof body, "{%s,\"initial\":%s,%s}", pendulum, start_of(arms, i, text), rest);
    return test_post(API_OP_TRAJECTORIES, body);
}

static double at(const struct test_reply *reply, const char *name, int i, int k) {
    char pointer[60];
    snprintf(pointer, sizeof pointer, k < 0 ? "/%s/%d" : "/%s/%d/%d", name, i, k);
    return test_reply_number(reply, pointer);
}

TEST(controlled_members_end_and_settle_as_trajectories_do) {
    static const char ask[] = "\"duration\":6,\"observables\":[\"final\",\"settled\","
                              "\"energy_drift\"],\"within\":0.05";
    OWN(test_reply, free) all = members(CAUGHT, 1, 0, ask), back = members(CAUGHT, 1, 1, ask);
    double gap = 0, drift = 0;
    int caught = 0;
    for (int i = 0; i < MEMBERS; i++) {
        OWN(test_reply, free) one = trajectory(CAUGHT, 1, i,
                                               "\"times\":{\"stop\":6,\"step\":0.02},\"output\":["
                                               "\"theta\",\"phid\"]");
        double size = 1 + fabs(at(&all, "final/phi", i, 0)), since = 0;
        double settled = at(&all, "settled", i, -1);
        gap = fmax(gap,
                   fabs(at(&one, "theta", 300, 0) - M_PI_2 - at(&all, "final/phi", i, 0)) / size);
        drift = fmax(drift, at(&all, "energy_drift", i, -1));
        for (int row = 0; row <= 300; row++)
            if (fabs(remainder(at(&one, "theta", row, 0) - M_PI, 2 * M_PI)) > 0.05)
                since = 0.02 * (row + 1);
        if (since <= 0.9 * 6)
            CHECK(fabs(settled - since) < 1e-12), caught++;
        else
            CHECK(isnan(settled));
        CHECK(at(&back, "final/phi", MEMBERS - 1 - i, 0) == at(&all, "final/phi", i, 0));
    }
    CHECK(caught > 2 && caught < MEMBERS - 2);
    CHECK_RESIDUAL(gap, 1e-12, "controlled members beside trajectories");
    CHECK_RESIDUAL(drift, 1e-14, "their balance of energy");
}

/* one by one through the same loop: the same bits */
TEST(members_that_stick_and_hit_are_those_of_trajectories) {
    struct test_reply all = members(STUCK, 2, 0,
                                    "\"duration\":4,\"observables\":[\"final\",\"energy_drift\"],"
                                    "\"events\":[{\"of\":\"theta\",\"arm\":1,\"value\":0}]");
    struct test_reply rows = members(STUCK, 2, 1,
                                     "\"times\":[0,2,4],\"observables\":[\"trajectory\"],"
                                     "\"output\":[\"theta\",\"phid\",\"lambda\"]");
    double drift = 0;
    for (int i = 0; i < MEMBERS; i++) {
        OWN(test_reply, free) one = trajectory(STUCK, 2, i,
                                               "\"times\":[0,2,4],\"output\":[\"theta\",\"phi\","
                                               "\"phid\",\"lambda\"],\"events\":[{\"of\":\"theta\","
                                               "\"arm\":1,\"value\":0}]");
        int row = 3 * (MEMBERS - 1 - i) + 2;
        for (int k = 0; k < 2; k++) {
            CHECK(at(&all, "final/phi", i, k) == at(&one, "phi", 2, k));
            CHECK(at(&all, "final/phid", i, k) == at(&one, "phid", 2, k));
            CHECK(at(&rows, "theta", row, k) == at(&one, "theta", 2, k));
            CHECK(fabs(at(&rows, "lambda", row, k) - at(&one, "lambda", 2, k)) < 1e-13);
        }
        CHECK_INT((int)at(&all, "events/count", i, 0), test_reply_count(&one, "/events"));
        drift = fmax(drift, at(&all, "energy_drift", i, -1));
    }
    CHECK_RESIDUAL(drift, 1e-13, "balance of work, heat and energy");
    test_reply_free(&all);
    test_reply_free(&rows);
    OWN(test_reply, free) beyond =
        test_post(API_OP_ENSEMBLES, "{" STUCK ",\"states\":[{},{\"theta\":[0,1.5]}],"
                                    "\"duration\":1}");
    CHECK(at(&beyond, "status", 0, -1) == 0 && at(&beyond, "status", 1, -1) == 4);
}
