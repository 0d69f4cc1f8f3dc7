/* Requests and answers. That the exponents are correct is tested in
 * tests/core/ensemble/test_lyapunov.c. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tests/api/post.h"
#include "tests/harness/test.h"

#define DOUBLE                                                                                     \
    "\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1]},\"initial\":{\"theta\":[2,2." \
    "5]}"

TEST(lyapunov_answers_rows_that_end_with_the_duration) {
    OWN(test_reply, free) reply = test_post(
        API_OP_LYAPUNOV, "{" DOUBLE ",\"duration\":20,\"samples\":150,\"count\":\"all\"}");
    CHECK_INT(reply.status, 200);
    CHECK_INT(test_reply_count(&reply, "/t"), 150);
    CHECK_INT(test_reply_count(&reply, "/exponents"), 150);
    CHECK_INT(test_reply_count(&reply, "/exponents/7"), 4);
    CHECK(test_reply_number(&reply, "/t/149") == 20 &&
          fabs(test_reply_number(&reply, "/t/74") - 10) < 1e-14);
    double first = test_reply_number(&reply, "/exponents/149/0"),
           last = test_reply_number(&reply, "/exponents/149/3");
    CHECK_SAYING(first > 1 && first < 4 && last < -1, "%g and %g", first, last);
    CHECK(test_reply_number(&reply, "/stats/steps") > 500 &&
          test_reply_number(&reply, "/stats/interval") > 0);
}

TEST(lyapunov_of_few_samples_is_that_of_many_and_one_exponent_the_first_of_all) {
    OWN(test_reply, free) many =
        test_post(API_OP_LYAPUNOV, "{" DOUBLE ",\"duration\":5,\"samples\":50,\"count\":4}");
    OWN(test_reply, free) few =
        test_post(API_OP_LYAPUNOV, "{" DOUBLE ",\"duration\":5,\"samples\":1}");
    CHECK_INT(test_reply_count(&few, "/exponents/0"), 1);
    double off =
        test_reply_number(&few, "/exponents/0/0") - test_reply_number(&many, "/exponents/49/0");
    CHECK_RESIDUAL(fabs(off), 1e-7, "exponent of other intervals");
}

TEST(lyapunov_leaves_a_transient_out) {
    OWN(test_reply, free) plain =
        test_post(API_OP_LYAPUNOV, "{" DOUBLE ",\"duration\":5,\"samples\":5}");
    OWN(test_reply, free) late =
        test_post(API_OP_LYAPUNOV, "{" DOUBLE ",\"duration\":5,\"samples\":5,\"transient\":3}");
    CHECK(test_reply_number(&late, "/t/4") == 5);
    CHECK(fabs(test_reply_number(&late, "/exponents/0/0") -
               test_reply_number(&plain, "/exponents/0/0")) > 0.01);
}

TEST(lyapunov_comes_in_every_representation) {
    OWN(test_reply, free) reply = test_post_as(
        API_OP_LYAPUNOV, "{" DOUBLE ",\"duration\":1,\"samples\":2,\"count\":2,\"digits\":3}",
        "text/csv", NULL);
    CHECK_INT(reply.status, 200);
    CHECK(!strncmp(reply.out.data, "t,exponents_1,exponents_2,error_1,error_2\n0.5,", 46));
}

TEST(lyapunov_of_too_many_steps_is_refused) {
    struct api_limits limits;
    api_limits_init(&limits);
    limits.steps = 1000;
    OWN(test_reply, free) reply =
        test_post_as(API_OP_LYAPUNOV, "{" DOUBLE ",\"duration\":1000}", NULL, &limits);
    CHECK_INT(reply.status, 422);
    CHECK(strstr(reply.out.data, "max-steps") != NULL);
    test_reply_free(&reply);
    reply = test_post_as(API_OP_LYAPUNOV, "{" DOUBLE ",\"duration\":40,\"count\":\"all\"}", NULL,
                         &limits);
    CHECK_INT(reply.status, 422);
    CHECK(strstr(reply.out.data, "max-steps") != NULL);
}

/* near equilibrium theta'' + c theta' + 9.81 theta = 0: if overdamped, the exponents are its two
 * roots, otherwise both are minus half of the damping */
TEST(lyapunov_of_a_damped_pendulum_at_rest_has_the_roots_of_its_equation) {
    OWN(test_reply, free) reply =
        test_post(API_OP_LYAPUNOV,
                  "{\"pendulum\":{\"length\":[0.5],\"mass\":[4],\"parent\":[0],\"gravity\":4.905,"
                  "\"damping\":[10]},\"initial\":{\"theta\":[0]},\"duration\":8,\"transient\":6,"
                  "\"count\":2,\"samples\":4}");
    double root = sqrt(25 - 9.81);
    CHECK_RESIDUAL(fabs(test_reply_number(&reply, "/exponents/3/0") + 5 - root), 1e-8,
                   "the slow root");
    CHECK_RESIDUAL(fabs(test_reply_number(&reply, "/exponents/3/1") + 5 + root), 1e-8,
                   "the fast root");
    test_reply_free(&reply);
    reply = test_post(API_OP_LYAPUNOV,
                      "{\"pendulum\":{\"length\":[0.5],\"mass\":[4],\"parent\":[0],"
                      "\"damping\":[0.3]},\"initial\":{\"theta\":[0]},\"duration\":400,"
                      "\"count\":2,\"samples\":1}");
    double first = test_reply_number(&reply, "/exponents/0/0"),
           second = test_reply_number(&reply, "/exponents/0/1");
    CHECK_RESIDUAL(fabs(first + second + 0.3), 1e-12, "their sum");
    CHECK_SAYING(fabs(first + 0.15) < 0.01, "%g", first);
}

/* Drag per mass acts equally on every pair of directions: exponents form pairs symmetric about
 * minus the drag (Dressler, Phys. Rev. A 38, 1988) */
TEST(lyapunov_exponents_of_drag_per_mass_are_pairs_around_it) {
    OWN(test_reply, free) reply =
        test_post(API_OP_LYAPUNOV,
                  "{\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1],"
                  "\"drag_per_mass\":0.05,\"pivot\":{\"y\":{\"harmonics\":[{\"amplitude\":0.3,"
                  "\"omega\":7}]}}},\"initial\":{\"theta\":[2,2.5]},\"start\":3,\"duration\":60,"
                  "\"count\":\"all\",\"samples\":1}");
    double of[4];
    for (int i = 0; i < 4; i++) {
        char at[30];
        snprintf(at, sizeof at, "/exponents/0/%d", i);
        of[i] = test_reply_number(&reply, at);
    }
    // volumes are in angles and rates, not momenta: up to the logarithm of the determinant of the
    // mass matrix, which is between 1 and 2, divided by the time
    CHECK_RESIDUAL(fabs(of[0] + of[1] + of[2] + of[3] + 0.2), 1.2e-2, "the sum of all four");
    CHECK_SAYING(of[0] > 0.5 && fabs(of[0] + of[3] + 0.1) < 0.05, "%g and %g", of[0], of[3]);
}

TEST(lyapunov_of_a_driven_pendulum_begins_at_its_start_and_agrees_with_the_ensembles) {
#define DRIVEN                                                                                     \
    "\"pendulum\":{\"length\":[1],\"mass\":[1],\"parent\":[0],\"gravity\":1,\"damping\":[0.5],"    \
    "\"torque\":[{\"harmonics\":[{\"amplitude\":1.5,\"omega\":0.6666666666666666}]}]}"
    static const char *const start[] = {"0", "4"};
    double exponent[2];
    for (int i = 0; i < 2; i++) {
        char body[500];
        snprintf(body, sizeof body,
                 "{" DRIVEN ",\"initial\":{\"theta\":[0.2]},\"start\":%s,\"duration\":100,"
                 "\"samples\":1}",
                 start[i]);
        OWN(test_reply, free) reply = test_post(API_OP_LYAPUNOV, body);
        CHECK_INT(reply.status, 200);
        exponent[i] = test_reply_number(&reply, "/exponents/0/0");
    }
    CHECK(fabs(exponent[0] - exponent[1]) > 1e-4);
    OWN(test_reply, free) reply =
        test_post(API_OP_ENSEMBLES, "{" DRIVEN ",\"states\":[{\"theta\":[0.2]}],\"duration\":100,"
                                    "\"observables\":[\"lyapunov\"]}");
    double member = test_reply_number(&reply, "/lyapunov/0");
    CHECK_SAYING(fabs(member - exponent[0]) < 0.05 && exponent[0] > 0.05, "%g and %g", member,
                 exponent[0]);
}

/* a spring that is much faster than the swing: neighbours are measured by its frequency */
TEST(lyapunov_of_stiff_springs_takes_no_shorter_pieces) {
    OWN(test_reply, free) reply = test_post(
        API_OP_LYAPUNOV, "{\"pendulum\":{\"length\":[1,0.1],\"mass\":[1,0.1],\"parent\":[0,1],"
                         "\"stiffness\":[0,100]},\"initial\":{\"theta\":[1,0.9]},"
                         "\"duration\":10,\"count\":\"all\",\"samples\":1}");
    double sum = 0;
    for (int i = 0; i < 4; i++) {
        char at[30];
        snprintf(at, sizeof at, "/exponents/0/%d", i);
        sum += test_reply_number(&reply, at);
    }
    CHECK_RESIDUAL(fabs(sum), 5e-5, "exponents of a stiff spring");
    CHECK_SAYING(test_reply_number(&reply, "/stats/steps") < 45000, "%g",
                 test_reply_number(&reply, "/stats/steps"));
}

TEST(lyapunov_warns_of_a_start_at_an_unstable_equilibrium) {
    static const char *const start[] = {"180", "0"};
    for (int i = 0; i < 2; i++) {
        char body[300];
        snprintf(body, sizeof body,
                 "{\"pendulum\":{\"length\":[1],\"mass\":[1],\"parent\":[0]},\"initial\":{"
                 "\"theta\":[%s],\"unit\":\"deg\"},\"duration\":20}",
                 start[i]);
        OWN(test_reply, free) reply = test_post(API_OP_LYAPUNOV, body);
        CHECK_INT(reply.status, 200);
        double horizon = test_reply_number(&reply, "/stats/horizon");
        CHECK(i ? horizon == 20 : horizon > 5 && horizon < 10);
        CHECK((strstr(reply.out.data, "an unstable equilibrium") == NULL) == i);
    }
}
