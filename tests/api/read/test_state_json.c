#include "api/read/state_json.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tests/api/post.h"
#include "tests/harness/quad.h"
#include "tests/harness/test.h"

#define DOUBLE "\"pendulum\":{\"L\":[2,1],\"m\":[1,3],\"S\":[[1,0],[1,1]]}"
#define FORCES(state) "{" DOUBLE ",\"state\":" state "}"
#define START(state)                                                                               \
    "{" DOUBLE ",\"initial\":" state                                                               \
    ",\"times\":[0],\"output\":[\"phi\",\"phid\",\"theta\",\"thetad\"]}"

static const double pi = 3.14159265358979323846;

/* the state of arm i at the first instant */
static double at(const struct test_reply *reply, const char *name, int i) {
    char pointer[40];
    snprintf(pointer, sizeof pointer, "/%s/0/%d", name, i);
    return test_reply_number(reply, pointer);
}

TEST(a_state_left_out_is_at_rest_and_horizontal) {
    static const char *const bodies[] = {START("{}"), START("{\"unit\":\"deg\"}"),
                                         "{" DOUBLE
                                         ",\"times\":[0],\"output\":[\"phi\",\"phid\",\"theta\"]}"};
    for (int i = 0; i < 3; i++) {
        OWN(test_reply, free) reply = test_post(API_OP_TRAJECTORIES, bodies[i]);
        CHECK_INT(reply.status, 200);
        CHECK(at(&reply, "phi", 0) == 0 && at(&reply, "phi", 1) == 0);
        CHECK(at(&reply, "phid", 0) == 0 && at(&reply, "phid", 1) == 0);
        CHECK(at(&reply, "theta", 0) == pi / 2);
    }
}

TEST(phi_and_theta_give_the_same_state) {
    OWN(test_reply, free) phi =
        test_post(API_OP_TRAJECTORIES, START("{\"phi\":[0.5,-0.25],\"phid\":[1,2]}"));
    CHECK(at(&phi, "phi", 0) == 0.5 && at(&phi, "phi", 1) == -0.25);
    CHECK(at(&phi, "thetad", 0) == 1 && at(&phi, "phid", 1) == 2);
    CHECK(at(&phi, "theta", 0) == 0.5 + pi / 2);
    OWN(test_reply, free) theta =
        test_post(API_OP_TRAJECTORIES, START("{\"theta\":[0.5,0],\"thetad\":[1,2]}"));
    CHECK(at(&theta, "phi", 0) == 0.5 - pi / 2 && at(&theta, "phi", 1) == -pi / 2);
    CHECK(at(&theta, "theta", 1) == 0);
    CHECK(at(&theta, "phid", 0) == 1 && at(&theta, "phid", 1) == 2);
}

TEST(degrees_are_degrees_for_angles_and_velocities) {
    OWN(test_reply, free) reply = test_post(
        API_OP_TRAJECTORIES, START("{\"theta\":[90,-180],\"thetad\":[360,0],\"unit\":\"deg\"}"));
    CHECK(fabs(at(&reply, "phi", 0)) < 1e-15 && at(&reply, "phi", 1) == -1.5 * pi);
    CHECK(at(&reply, "phid", 0) == 2 * pi);
}

TEST(a_mode_starts_at_rest_with_its_amplitude) {
    OWN(test_reply, free) slow =
        test_post(API_OP_TRAJECTORIES, START("{\"mode\":1,\"amplitude\":0.1}"));
    OWN(test_reply, free) fast =
        test_post(API_OP_TRAJECTORIES, START("{\"mode\":2,\"amplitude\":-3,\"unit\":\"deg\"}"));
    double a = at(&slow, "theta", 0), b = at(&slow, "theta", 1);
    double c = at(&fast, "theta", 0), d = at(&fast, "theta", 1);
    CHECK(a * b > 0 && c * d < 0); /* in phase, and against each other */
    CHECK_RESIDUAL(fabs(fmax(fabs(a), fabs(b)) - 0.1), 1e-15, "amplitude");
    CHECK(fabs(fmax(fabs(c), fabs(d)) - 3 * pi / 180) < 1e-15);
    CHECK(at(&slow, "phid", 0) == 0 && at(&fast, "phid", 1) == 0);
}

TEST(a_start_in_a_mode_needs_gravity_and_few_arms) {
    struct api_limits limits;
    api_limits_init(&limits);
    limits.mode_arms = 1;
    OWN(test_reply, free) reply =
        test_post_as(API_OP_FORCES, FORCES("{\"mode\":1,\"amplitude\":1}"), NULL, &limits);
    CHECK(test_reply_has_fault(&reply, "/state/mode",
                               "takes at most 1 arms (the limit max-mode-arms)"));
}

TEST(a_state_is_checked_even_where_the_tree_is_faulty) {
    OWN(test_reply, free) reply = test_post(
        API_OP_FORCES,
        "{\"pendulum\":{\"L\":[1,-1],\"m\":[1,1],\"S\":[[1,0],[1,1]]},\"state\":{\"phi\":[1]}}");
    CHECK(test_reply_has_fault(&reply, "/pendulum/L/1", "got -1"));
    CHECK(test_reply_has_fault(&reply, "/state/phi", "must have 2 numbers"));
    CHECK_INT(test_reply_faults(&reply), 2);
}

/* theta = 2 is phi = 2 - pi/2, which is not a double: the sum of two doubles keeps 32 digits of it,
 * for degrees too */
TEST(a_single_state_keeps_what_rounding_leaves_of_it) {
    const test_quad half_turn = test_quad_read("3.14159265358979323846264338327950288");
    static const char *const bodies[] = {"{\"theta\":[2,-7.25],\"thetad\":[0.1,3]}",
                                         "{\"unit\":\"deg\",\"theta\":[2,-725],\"thetad\":[0.1,3]}",
                                         "{\"unit\":\"deg\",\"phi\":[2,-725],\"phid\":[0.1,3]}"};
    static const double angle[][2] = {{2, -7.25}, {2, -725}, {2, -725}}, rate[2] = {0.1, 3};
    for (int form = 0; form < 3; form++) {
        struct api_json *document;
        struct api_problem problem;
        struct api_tree tree = {.n = 2};
        struct api_states *states;
        struct api_limits limits;
        const double one[2] = {1, 1};
        const int chain[2] = {-1, 0};
        api_limits_init(&limits);
        api_problem_init(&problem);
        REQUIRE(pend_tree_new(&tree.tree, 2, one, one, chain, NULL) == PEND_OK);
        REQUIRE(api_states_new(&states, 1, 2) == PEND_OK);
        REQUIRE(api_json_new(&document, bodies[form], strlen(bodies[form]), 8, &problem) ==
                PEND_OK);
        struct api_value root = api_json_root(document);
        api_states_read(states, 0, &root, &tree, &limits, &problem);
        for (int k = 0; k < 2; k++) {
            test_quad turn = form ? half_turn / 180 : 1, from = form < 2 ? half_turn / 2 : 0;
            test_quad phi = (test_quad)states->phi[k] + states->phi_low[k];
            test_quad phid = (test_quad)states->rate[k] + states->rate_low[k];
            CHECK((double)test_quad_abs(phi - (turn * angle[form][k] - from)) < 1e-30);
            CHECK((double)test_quad_abs(phid - turn * rate[k]) < 1e-31);
            CHECK(states->phi_low[k] != 0);
        }
        api_json_free(&document);
        api_states_free(&states);
        pend_tree_free(&tree.tree);
    }
}
