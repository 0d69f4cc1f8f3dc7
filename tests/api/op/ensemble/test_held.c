#include "api/op/ensemble/held.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tests/api/post.h"
#include "tests/harness/test.h"

#define CART                                                                                       \
    "\"pendulum\":{\"arms\":[{\"name\":\"b\",\"parent\":\"a\",\"length\":0.7,\"mass\":0.2,"        \
    "\"torque\":1},{\"name\":\"a\",\"length\":1,\"rod\":0.1,\"damping\":0.01}],"                   \
    "\"pivot\":{\"cart\":{\"mass\":1,\"force\":1}}}"

enum { MEMBERS = 19, N = 3 };

/* a start and inputs of their own for each member: theta and rates of b and a, place and speed */
static void fill(double state[MEMBERS][2 * N + 1], double input[MEMBERS][N]) {
    for (int i = 0; i < MEMBERS; i++) {
        for (int j = 0; j <= 2 * N; j++) state[i][j] = sin(1 + i + 2.5 * j);
        for (int k = 0; k < N; k++) input[i][k] = k == 1 ? 0 : cos(i - 3.1 * k);
    }
}

TEST(held_steps_are_members_of_the_ensemble_with_these_torques) {
    static const char body[] =
        "{" CART ",\"states\":[{}],\"duration\":0.25,\"rtol\":1e-9,\"observables\":[\"final\"]}";
    double state[MEMBERS][2 * N + 1], input[MEMBERS][N], gap = 0;
    struct api_held *held = api_held_new(body, strlen(body));
    REQUIRE(held);
    fill(state, input);
    char text[8000];
    int at = snprintf(text, sizeof text,
                      "{" CART ",\"duration\":0.25,\"rtol\":1e-9,\"observables\":[\"final\","
                      "\"cart\"],\"members\":[");
    for (int i = 0; i < MEMBERS; i++)
        at += snprintf(text + at, sizeof text - (size_t)at,
                       "%s{\"initial\":{\"theta\":[%.17g,%.17g],\"thetad\":[%.17g,%.17g],\"cart\":{"
                       "\"x\":%.17g,\"v\":%.17g}},\"set\":[{\"vary\":\"torque\",\"arm\":\"b\","
                       "\"value\":%.17g},{\"vary\":\"torque\",\"arm\":\"cart\",\"value\":%.17g}]}",
                       i ? "," : "", state[i][0], state[i][1], state[i][2], state[i][3],
                       state[i][4], state[i][5], input[i][0], input[i][2]);
    snprintf(text + at, sizeof text - (size_t)at, "]}");
    struct test_reply reply = test_post(API_OP_ENSEMBLES, text);
    REQUIRE(reply.status == 200);
    /* in two goes */
    CHECK_INT(api_held_step(held, 8, state[0], input[0]), 0);
    CHECK_INT(api_held_step(held, MEMBERS - 8, state[8], input[8]), 0);
    CHECK(state[3][2 * N] == sin(4 + 5 * N) + 0.25);
    for (int i = 0; i < MEMBERS; i++)
        for (int k = 0; k < 2; k++) {
            char place[2][40];
            snprintf(place[0], sizeof *place, "/final/phi/%d/%d", i, k);
            snprintf(place[1], sizeof *place, "/final/phid/%d/%d", i, k);
            gap = fmax(gap, fabs(test_reply_number(&reply, place[0]) + M_PI_2 - state[i][k]));
            CHECK(test_reply_number(&reply, place[1]) == state[i][2 + k]);
            snprintf(place[0], sizeof *place, "/cart/%s/%d", k ? "v" : "x", i);
            CHECK(test_reply_number(&reply, place[0]) == state[i][4 + k]);
        }
    CHECK_RESIDUAL(gap, 1e-15, "theta against phi + pi / 2");
    test_reply_free(&reply);
    api_held_free(held);
}

TEST(held_steps_that_fail_are_not_numbers_and_leave_the_others_alone) {
    static const char body[] =
        "{\"pendulum\":{\"length\":[1],\"mass\":[1],\"parent\":[0],\"torque\":[1]},\"states\":[{}],"
        "\"duration\":0.1,\"rtol\":1e-9}";
    struct api_held *held = api_held_new(body, strlen(body));
    REQUIRE(held);
    double state[3][3] = {{0.1, 0, 0}, {0.1, 1e300, 0}, {0.1, 0, 0}}, input[3] = {1, 1, 1};
    CHECK_INT(api_held_step(held, 3, state[0], input), 1);
    CHECK(!memcmp(state[0], state[2], sizeof *state) && state[0][1] > 0);
    CHECK(isnan(state[1][0]));
    api_held_free(held);
}

TEST(held_steps_refuse_what_no_input_reaches_and_survive_without_memory) {
    static const char *const refused[] = {"{", "{}",
                                          ("{\"pendulum\":{\"length\":[1],\"mass\":[1],\"parent\":["
                                           "0]},\"states\":[{}],\"duration\":1}")};
    static const char body[] =
        "{\"pendulum\":{\"length\":[1],\"mass\":[1],\"parent\":[0],\"torque\":[1]},\"states\":[{}],"
        "\"duration\":1}";
    struct api_held *held = NULL;
    for (int i = 0; i < 3; i++) CHECK(!api_held_new(refused[i], strlen(refused[i])));
    api_held_free(NULL);
    long failing = 1;
    for (; !held && failing < 1000; failing++) {
        test_alloc_fail(failing, 1);
        held = api_held_new(body, strlen(body));
        test_alloc_faults_off();
    }
    CHECK_SAYING(held && failing > 5, "%ld allocations failed", failing - 1);
    api_held_free(held);
}
