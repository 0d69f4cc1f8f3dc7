#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/api/post.h"
#include "tests/harness/test.h"

#define THREE "\"pendulum\":{\"length\":[0.7,1,0.9],\"mass\":[2,1,3],\"parent\":[2,0,2]}"

TEST(a_hanging_tree_at_rest_pulls_with_its_weight) {
    OWN(test_reply, free) reply =
        test_post(API_OP_FORCES, "{" THREE ",\"state\":{\"theta\":[0,0,0]}}");
    static const double weight[] = {2, 6, 3};
    CHECK_INT(reply.status, 200);
    for (int k = 0; k < 3; k++) {
        char pointer[60];
        snprintf(pointer, sizeof pointer, "/lambda/%d", k);
        CHECK(fabs(test_reply_number(&reply, pointer) + 9.81 * weight[k]) <=
              1e-14 * 9.81 * weight[k]);
        snprintf(pointer, sizeof pointer, "/phidd/%d", k);
        CHECK(fabs(test_reply_number(&reply, pointer)) < 1e-14);
    }
    CHECK(test_reply_number(&reply, "/energy/kinetic") == 0);
    CHECK(fabs(test_reply_number(&reply, "/energy/total") + 9.81 * (2 * 1.7 + 1 + 3 * 1.9)) <
          1e-13);
}

TEST(a_single_arm_obeys_its_formula) {
    double phi = -0.4, rate = 3, m = 1.5, l = 0.8, g = 1.62;
    OWN(test_reply, free) reply =
        test_post(API_OP_FORCES, "{\"pendulum\":{\"L\":[0.8],\"m\":[1.5],\"S\":[[1]],\"gravity\":1."
                                 "62},\"state\":{\"phi\":[-0.4],\"phid\":[3]}}");
    double gap =
        fabs(test_reply_number(&reply, "/lambda/0") - (-m * l * rate * rate + g * m * sin(phi)));
    gap = fmax(gap, fabs(test_reply_number(&reply, "/phidd/0") + g / l * cos(phi)));
    double acc = test_reply_number(&reply, "/phidd/0");
    gap = fmax(gap, fabs(test_reply_number(&reply, "/zdd/re/0") +
                         l * (acc * sin(phi) + rate * rate * cos(phi))));
    gap = fmax(gap, fabs(test_reply_number(&reply, "/zdd/im/0") -
                         l * (acc * cos(phi) - rate * rate * sin(phi))));
    gap = fmax(gap, fabs(test_reply_number(&reply, "/zd/im/0") - l * rate * cos(phi)));
    CHECK_RESIDUAL(gap, 1e-14, "single arm");
}

TEST(newtons_law_holds_at_every_tip) {
    OWN(test_reply, free) reply = test_post(
        API_OP_FORCES, "{" THREE ",\"state\":{\"phi\":[0.3,-1.2,2],\"phid\":[1,-2,0.5]}}");
    /* arm 1: m z'' = lambda u - i g m */
    double gap = fabs(2 * test_reply_number(&reply, "/zdd/re/0") -
                      test_reply_number(&reply, "/lambda/0") * cos(0.3));
    gap = fmax(gap, fabs(2 * test_reply_number(&reply, "/zdd/im/0") + 2 * 9.81 -
                         test_reply_number(&reply, "/lambda/0") * sin(0.3)));
    CHECK_RESIDUAL(gap, 1e-13, "m z'' = lambda u - i g m");
}

TEST(states_give_one_row_each_in_their_order) {
    enum { STATES = 200 };
    char *body = malloc(STATES * 60 + 200), *at = body;
    at += sprintf(at, "{" THREE ",\"states\":[");
    for (int i = 0; i < STATES; i++)
        at += sprintf(at, "%s{\"phi\":[%d,0.5,-1],\"phid\":[1,%d,0]}", i ? "," : "", i, i);
    strcpy(at, "]}");
    OWN(test_reply, free) many = test_post(API_OP_FORCES, body);
    CHECK_INT(many.status, 200);
    CHECK_INT(test_reply_count(&many, "/phidd"), STATES);
    CHECK_INT(test_reply_count(&many, "/energy/total"), STATES);
    for (int i = 0; i < STATES; i += 37) {
        char pointer[40];
        snprintf(body, 300, "{" THREE ",\"state\":{\"phi\":[%d,0.5,-1],\"phid\":[1,%d,0]}}", i, i);
        OWN(test_reply, free) one = test_post(API_OP_FORCES, body);
        for (int k = 0; k < 3; k++) {
            snprintf(pointer, sizeof pointer, "/lambda/%d/%d", i, k);
            double row = test_reply_number(&many, pointer);
            snprintf(pointer, sizeof pointer, "/lambda/%d", k);
            CHECK(row == test_reply_number(&one, pointer));
        }
    }
    free(body);
}

TEST(states_in_modes_stand_beside_states_by_angles) {
    OWN(test_reply, free) reply =
        test_post(API_OP_FORCES, "{\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1]},"
                                 "\"states\":[{\"theta\":[0.01,0.0141421356]},{\"mode\":1,"
                                 "\"amplitude\":0.0141421356},{}]}");
    CHECK_INT(reply.status, 200);
    CHECK(fabs(test_reply_number(&reply, "/phidd/0/0") - test_reply_number(&reply, "/phidd/1/0")) <
          1e-8);
    CHECK(fabs(test_reply_number(&reply, "/phidd/1/0")) > 1e-3);
    CHECK(test_reply_number(&reply, "/z/re/2/1") == 2);
}

TEST(forces_as_csv_have_a_line_a_state) {
    OWN(test_reply, free) reply = test_post_as(API_OP_FORCES,
                                               "{\"pendulum\":{\"L\":[1],\"m\":[1],\"S\":[[1]]},"
                                               "\"states\":[{},{\"phi\":[1]}],\"digits\":3}",
                                               "text/csv", NULL);
    CHECK_TEXT(reply.out.data,
               "phidd_1,lambda_1,z_re_1,z_im_1,zd_re_1,zd_im_1,zdd_re_1,zdd_im_1,energy_kinetic,"
               "energy_potential,energy_total\n"
               "-9.81,0,1,0,-0.0,0,0,-9.81,0,0,0\n"
               "-5.3,8.25,0.54,0.841,-0.0,0,4.46,-2.86,0,8.25,8.25\n");
}

TEST(too_many_states_are_refused_by_the_limits_name) {
    struct api_limits limits;
    api_limits_init(&limits);
    limits.samples = 1;
    OWN(test_reply, free) reply =
        test_post_as(API_OP_FORCES, "{" THREE ",\"states\":[{},{}]}", NULL, &limits);
    CHECK(test_reply_has_fault(&reply, "/states",
                               "has 2 states, more than the limit max-samples of 1"));
    test_reply_free(&reply);
    limits.samples = 10;
    limits.answer_bytes = 500;
    reply = test_post_as(API_OP_FORCES, "{" THREE ",\"states\":[{},{}]}", NULL, &limits);
    CHECK(test_reply_has_fault(&reply, "", "more than the limit max-answer-bytes of 500"));
}

TEST(forces_that_overflow_end_as_a_problem_with_their_place) {
    OWN(test_reply, free) reply = test_post(
        API_OP_FORCES, "{" THREE ",\"states\":[{},{\"phi\":[0,0,0],\"phid\":[0,0,1e200]}]}");
    CHECK_INT(reply.status, 422);
    CHECK(strstr(test_reply_text(&reply, "/detail"), "in row 2 exceeds the range of a double"));
}

TEST(states_are_not_held_before_the_size_of_the_answer_is_known) {
    enum { ARMS = 1000, STATES = 5000 };
    char *body = malloc(ARMS * 16 + STATES * 3 + 200), *at = body;
    at += sprintf(at, "{\"pendulum\":{\"length\":[1");
    for (int i = 1; i < ARMS; i++) at += sprintf(at, ",1");
    at += sprintf(at, "],\"mass\":[1");
    for (int i = 1; i < ARMS; i++) at += sprintf(at, ",1");
    at += sprintf(at, "],\"parent\":[0");
    for (int i = 1; i < ARMS; i++) at += sprintf(at, ",%d", i);
    at += sprintf(at, "]},\"states\":[{\"phi\":[1]}");
    for (int i = 1; i < STATES; i++) at += sprintf(at, ",{}");
    strcpy(at, "]}");
    OWN(test_reply, free) reply = test_post(API_OP_FORCES, body);
    CHECK(test_reply_has_fault(&reply, "", "asks for 5000 states of 8003 numbers"));
    CHECK(test_reply_has_fault(&reply, "/states/0/phi", "must have 1000 numbers"));
    CHECK_INT(test_reply_faults(&reply), 2);
    free(body);
}

TEST(forces_of_a_mode_that_is_beyond_all_numbers_are_a_problem) {
    static const char *const length[] = {"4e-324,1.5,0.75", "4e-324,4e-324,4e-324",
                                         "1e308,1e308,1e308"};
    static const char *const normalize[] = {"first", "mass", "max"};
    for (int i = 0; i < 3; i++) {
        char body[300];
        for (int k = 1; k <= 3; k++) {
            snprintf(body, sizeof body,
                     "{\"pendulum\":{\"length\":[%s],\"mass\":[1,1,1],\"parent\":[0,1,2]},"
                     "\"state\":{\"mode\":%d,\"amplitude\":1}}",
                     length[i], k);
            OWN(test_reply, free) reply = test_post(API_OP_FORCES, body);
            CHECK_SAYING(reply.status == 200 || reply.status == 422, "%d for %s", reply.status,
                         body);
            test_reply_free(&reply);
            snprintf(body, sizeof body,
                     "{\"pendulum\":{\"length\":[%s],\"mass\":[1,1,1],\"parent\":[0,1,2]},"
                     "\"normalize\":\"%s\"}",
                     length[i], normalize[k - 1]);
            reply = test_post(API_OP_MODES, body);
            CHECK_SAYING(reply.status == 200 || reply.status == 422, "%d for %s", reply.status,
                         body);
        }
    }
}

/* angles that differ by whole turns are one state; the remainders are from a reference of 60
 * digits */
TEST(forces_of_huge_angles_are_those_of_their_rests) {
    static const struct {
        const char *huge, *rest;
    } start[] = {{"1e15,1", "2.1096981170701126,1"},
                 {"1e22,1", "-1.0201773925590870,1"},
                 {"1,-1e300", "1,2.1838724841522326"}};
    for (size_t i = 0; i < sizeof start / sizeof *start; i++) {
        const char *states[] = {start[i].huge, start[i].rest};
        struct test_reply reply[2];
        for (int j = 0; j < 2; j++) {
            char body[200];
            snprintf(body, sizeof body,
                     "{\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1]},\"state\":{"
                     "\"phi\":[%s],\"phid\":[1,2]}}",
                     states[j]);
            reply[j] = test_post(API_OP_FORCES, body);
            CHECK_INT(reply[j].status, 200);
        }
        static const char *const numbers[] = {"/phidd/0", "/phidd/1", "/lambda/0", "/lambda/1",
                                              "/energy/total"};
        for (int k = 0; k < 5; k++) {
            double got = test_reply_number(&reply[0], numbers[k]),
                   want = test_reply_number(&reply[1], numbers[k]);
            CHECK_SAYING(fabs(got - want) <= 1e-14 * (1 + fabs(want)), "%s of %s: %.17g, not %.17g",
                         numbers[k], states[0], got, want);
        }
        test_reply_free(&reply[0]);
        test_reply_free(&reply[1]);
    }
}

/* a bar of 2 kg on a joint with friction, driven; a body off the axis hangs on its middle */
#define REAL                                                                                       \
    "\"pendulum\":{\"arms\":["                                                                     \
    "{\"name\":\"a\",\"length\":1,\"mass\":0,\"rod\":2,\"damping\":0.4},"                          \
    "{\"name\":\"b\",\"parent\":\"a\",\"length\":0.5,\"at\":0.5,"                                  \
    "\"body\":{\"mass\":1,\"center\":[0.2,0.1],\"inertia\":0.02}}],"                               \
    "\"pivot\":{\"y\":{\"harmonics\":[{\"amplitude\":0.1,\"omega\":3}]}}}"

TEST(forces_of_a_real_pendulum_hold_what_hangs_on_them) {
    // at rest the pivot carries both weights and the force of its own acceleration
    struct test_reply reply =
        test_post(API_OP_FORCES, "{" REAL ",\"state\":{\"theta\":[0,0]},\"time\":0}");
    CHECK_INT(reply.status, 200);
    CHECK_INT(test_reply_count(&reply, "/joint_force/along"), 2);
    double lift = -0.9, along = test_reply_number(&reply, "/joint_force/along/0");
    double z = test_reply_number(&reply, "/zdd/im/0");
    // arm a and the joint of b move up and down with the pivot
    CHECK(fabs(z - lift) < 1e-12);
    double center = test_reply_number(&reply, "/phidd/1");
    double pull = 2 * (9.81 + lift) + 1 * (9.81 + lift + 0.1 * center);
    CHECK_SAYING(fabs(along + pull) < 1e-12 * pull, "%.17g is not %.17g", -along, pull);
    // there is no mass at the tip of a bar
    CHECK(test_reply_number(&reply, "/lambda/0") == 0);
    CHECK(test_reply_number(&reply, "/tip_force/across/0") == 0);
    test_reply_free(&reply);
    OWN(test_reply, free) ideal =
        test_post(API_OP_FORCES, "{" THREE ",\"state\":{\"theta\":[0.1,0,0]},\"time\":3}");
    CHECK_INT(ideal.status, 200);
    CHECK_INT(test_reply_count(&ideal, "/joint_force/along"), -1);
}

/* requests for an ideal pendulum, a real one, and one on a cart */
static const struct {
    const char *pendulum, *by, *state[2];
} alone[] = {
    {"{\"length\":[1,0.5],\"mass\":[1,2],\"parent\":[0,1]}",
     "{\"vary\":\"phi\",\"arm\":1},{\"vary\":\"length\",\"arm\":2}",
     {"{\"theta\":[1,2]}", "{\"theta\":[0.3,-1],\"thetad\":[2,1]}"}},
    {"{\"length\":[1,0.5],\"mass\":[1,2],\"parent\":[0,1],\"stiffness\":[3,0],\"rest\":[0.5,null]}",
     "{\"vary\":\"phi\",\"arm\":1},{\"vary\":\"stiffness\",\"arm\":1}",
     {"{\"theta\":[1,2]}", "{\"theta\":[7.3,-1],\"thetad\":[2,1]}"}},
    {"{\"length\":[1,0.5],\"mass\":[1,2],\"parent\":[0,1],\"pivot\":{\"cart\":{\"mass\":2}}}",
     "{\"vary\":\"phi\",\"arm\":1},{\"vary\":\"length\",\"arm\":2}",
     {"{\"theta\":[1,2],\"cart\":{\"x\":0.5}}",
      "{\"theta\":[0.3,-1],\"thetad\":[2,1],\"cart\":{\"x\":-3,\"v\":1}}"}},
};

TEST(states_and_their_derivatives_are_those_of_each_alone) {
    static const char *const name[] = {"phidd", "lambda", "derivatives/phidd", "derivatives/lambda",
                                       "derivatives/z_re"};
    for (size_t i = 0; i < sizeof alone / sizeof *alone; i++) {
        struct test_reply reply[3];
        for (int j = 0; j < 3; j++) {
            char body[600], states[200];
            snprintf(states, sizeof states, "\"states\":[%s,%s]", alone[i].state[0],
                     alone[i].state[1]);
            if (j < 2) snprintf(states, sizeof states, "\"state\":%s", alone[i].state[j]);
            snprintf(body, sizeof body, "{\"pendulum\":%s,\"derivatives\":[%s],%s}",
                     alone[i].pendulum, alone[i].by, states);
            reply[j] = test_post(API_OP_FORCES, body);
            CHECK_INT(reply[j].status, 200);
        }
        // numbers of a row: an arm, or an arm and a parameter
        for (int k = 0; k < 5 * 2 * 4; k++) {
            int which = k / 8, row = k / 4 % 2, arm = k / 2 % 2;
            char many[60], one[60], by[8] = "";
            if (which >= 2) snprintf(by, sizeof by, "/%d", k % 2);
            snprintf(many, sizeof many, "/%s/%d/%d%s", name[which], row, arm, by);
            snprintf(one, sizeof one, "/%s/%d%s", name[which], arm, by);
            double got = test_reply_number(&reply[2], many),
                   want = test_reply_number(&reply[row], one);
            CHECK_SAYING(got == want, "%s: %.17g, alone %.17g", many, got, want);
        }
        for (int j = 0; j < 3; j++) test_reply_free(&reply[j]);
    }
}
