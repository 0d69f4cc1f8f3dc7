/* Trajectories of real pendulums against closed forms. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tests/api/post.h"
#include "tests/harness/requests.h"
#include "tests/harness/test.h"

static const double pi = 3.14159265358979323846;

/* the number of arm i at the last of `count` instants */
static double last(const struct test_reply *reply, const char *name, int count, int i) {
    char pointer[60];
    snprintf(pointer, sizeof pointer, "/%s/%d/%d", name, count - 1, i);
    return test_reply_number(reply, pointer);
}

TEST(a_pivot_that_accelerates_is_a_stronger_gravity_that_is_tilted) {
    static const double ax = 3, ay = 1, g = 9.81;
    double tilt = atan2(-(g + ay), -ax) + pi / 2, pull = hypot(ax, g + ay), gap = 0;
    char moved[400], tilted[400];
    snprintf(moved, sizeof moved,
             "{\"pendulum\":{\"length\":[1,0.7],\"mass\":[1,2],\"parent\":[0,1],\"pivot\":{"
             "\"acceleration\":[%.17g,%.17g]}},\"initial\":{\"phi\":[%.17g,%.17g]},"
             "\"times\":{\"stop\":3,\"count\":4}}",
             ax, ay, 0.2 + tilt, -1 + tilt);
    snprintf(tilted, sizeof tilted,
             "{\"pendulum\":{\"length\":[1,0.7],\"mass\":[1,2],\"parent\":[0,1],\"gravity\":%.17g},"
             "\"initial\":{\"phi\":[0.2,-1]},\"times\":{\"stop\":3,\"count\":4}}",
             pull);
    OWN(test_reply, free) a = test_post(API_OP_TRAJECTORIES, moved),
                          b = test_post(API_OP_TRAJECTORIES, tilted);
    CHECK_INT(a.status, 200);
    for (int i = 0; i < 2; i++) {
        gap = fmax(gap, fabs(last(&a, "phi", 4, i) - tilt - last(&b, "phi", 4, i)));
        gap = fmax(gap, fabs(last(&a, "phid", 4, i) - last(&b, "phid", 4, i)));
        gap = fmax(gap, fabs(last(&a, "lambda", 4, i) - last(&b, "lambda", 4, i)));
    }
    CHECK_RESIDUAL(gap, 1e-10, "an accelerated pivot and a tilted gravity");
    CHECK(test_reply_number(&a, "/stats/energy_drift") < 1e-11);
}

TEST(a_constant_torque_gives_what_it_turns_through) {
    OWN(test_reply, free) reply =
        test_post(API_OP_TRAJECTORIES,
                  "{\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1],\"torque\":[12,"
                  "-3]},\"times\":{\"stop\":4,\"count\":3},\"output\":[\"phi\",\"energy\","
                  "\"exchange\"]}");
    CHECK_INT(reply.status, 200);
    double first = last(&reply, "phi", 3, 0), second = last(&reply, "phi", 3, 1);
    double work = 12 * first - 3 * (second - first);
    CHECK(fabs(work) > 1);
    CHECK_RESIDUAL(fabs(test_reply_number(&reply, "/exchange/work/2") / work - 1), 1e-13,
                   "the work of a constant torque");
    CHECK_RESIDUAL(fabs(test_reply_number(&reply, "/energy/total/2") / work - 1), 1e-11,
                   "the energy that it gave");
    CHECK(test_reply_number(&reply, "/stats/energy_drift") < 1e-12);
    CHECK_INT(test_reply_count(&reply, "/warnings"), -1);
}

/* theta = a cos(w t), w^2 = 3 g / (2 l) */
TEST(a_bar_swings_as_a_uniform_bar_does) {
    static const char *const bars[] = {
        "\"rod\":[2]", "\"mass\":[0],\"body\":[{\"mass\":2,\"center\":0.4,\"inertia\":"
                       "0.10666666666666667}]"};
    double period = 2 * pi * sqrt(2 * 0.8 / (3 * 9.81)), gap = 0;
    for (int i = 0; i < 2; i++) {
        char body[400];
        snprintf(body, sizeof body,
                 "{\"pendulum\":{\"length\":[0.8],\"parent\":[0],%s},\"initial\":{\"theta\":[1e-5]}"
                 ",\"times\":[0,%.17g],\"output\":[\"theta\"]}",
                 bars[i], period / 3);
        OWN(test_reply, free) reply = test_post(API_OP_TRAJECTORIES, body);
        CHECK_INT(reply.status, 200);
        gap = fmax(gap, fabs(last(&reply, "theta", 2, 0) / 1e-5 + 0.5));
    }
    CHECK_RESIDUAL(gap, 1e-9, "a uniform bar's small swing");
}

/* heat is the lost energy: each method within its tolerance; those accurate to round-off may agree
 * in all digits */
TEST(every_method_knows_work_and_heat_and_the_balance_is_its_check) {
    static const struct {
        const char *method;
        double gap, drift;
    } of[] = {{"\"method\":\"rkf45\"", 1e-7, 1e-7},
              {"\"method\":\"rk8pd\"", 1e-7, 1e-7},
              {"\"method\":\"msadams\"", 1e-6, 1e-6},
              {"\"method\":\"radau\"", 1e-7, 1e-7},
              {"\"method\":\"ode23\",\"rtol\":1e-7", 1e-5, 1e-5},
              {"\"precision\":\"extended\"", 1e-9, 1e-14},
              {"\"rtol\":1e-15", 0, 1e-13}};
    double work = NAN, heat = NAN;
    for (int i = 6; i >= 0; i--) {
        char body[900];
        snprintf(body, sizeof body,
                 "{" TEST_REAL_TREE
                 ",\"initial\":{\"theta\":[1,2]},\"times\":{\"start\":1,\"stop\":"
                 "1.4,\"count\":9},\"output\":[\"exchange\"],%s}",
                 of[i].method);
        OWN(test_reply, free) reply = test_post(API_OP_TRAJECTORIES, body);
        CHECK_INT(reply.status, 200);
        double given = test_reply_number(&reply, "/exchange/work/7"),
               lost = test_reply_number(&reply, "/exchange/heat/7"),
               drift = test_reply_number(&reply, "/stats/energy_drift");
        if (i == 6) work = given, heat = lost;
        CHECK(test_reply_number(&reply, "/exchange/heat/0") == 0 && heat > 0.02 &&
              fabs(work) > 0.02);
        double gap = fmax(fabs(given / work - 1), fabs(lost / heat - 1));
        CHECK_SAYING(gap <= of[i].gap && drift < of[i].drift && (i >= 4 || gap > 0),
                     "%s: %g, drift %g", of[i].method, gap, drift);
    }
}

TEST(the_readmes_bar_stays_upside_down_on_its_shaken_pivot) {
    OWN(test_reply, free) reply = test_post(
        API_OP_TRAJECTORIES,
        "{\"pendulum\":{\"arms\":[{\"name\":\"bar\",\"length\":1,\"mass\":0,\"rod\":1,"
        "\"damping\":0.02}],\"pivot\":{\"y\":{\"harmonics\":[{\"amplitude\":0.05,\"omega\":100}]}}}"
        ",\"initial\":{\"theta\":[3]},\"times\":{\"stop\":10,\"step\":0.01},"
        "\"output\":[\"theta\",\"tip_force\",\"joint_force\",\"energy\",\"exchange\"]}");
    CHECK_INT(reply.status, 200);
    CHECK_INT(test_reply_count(&reply, "/theta"), 1001);
    for (int i = 0; i <= 1000; i += 10) {
        char pointer[40];
        snprintf(pointer, sizeof pointer, "/theta/%d/0", i);
        CHECK(fabs(test_reply_number(&reply, pointer) - 3.14159) < 0.3);
    }
    CHECK(test_reply_number(&reply, "/exchange/heat/1000") > 0);
    CHECK(test_reply_number(&reply, "/stats/energy_drift") < 1e-11);
}

/* if friction requires the steps, the answer says so and names the method that does not need them;
 * with that method, or if the motion itself requires the steps, it does not */
TEST(a_stiff_motion_is_told_which_method_suits_it) {
    static const struct {
        const char *damping, *how;
        int told;
    } cases[] = {{"1e5", "\"method\":\"taylor\"", 1},
                 {"1e5", "\"method\":\"radau\"", 0},
                 {"0.1", "\"method\":\"taylor\"", 0}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char body[400];
        snprintf(body, sizeof body,
                 "{\"pendulum\":{\"length\":[1],\"mass\":[1],\"parent\":[0],\"damping\":[%s]},"
                 "\"initial\":{\"theta\":[1]},\"times\":{\"stop\":4,\"count\":3},%s}",
                 cases[i].damping, cases[i].how);
        OWN(test_reply, free) reply = test_post(API_OP_TRAJECTORIES, body);
        CHECK_INT(reply.status, 200);
        CHECK_SAYING((strstr(reply.out.data, "steps of method radau") != NULL) == cases[i].told,
                     "%s: %s", body, reply.out.data);
    }
}
