/* Requests and answers about responses. The numbers are tested in
 * tests/core/modes/test_response.c. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tests/api/post.h"
#include "tests/harness/requests.h"
#include "tests/harness/test.h"

#define ONE "\"pendulum\":{\"length\":[1],\"mass\":[2],\"parent\":[0],\"damping\":[0.4]}"
#define IDEAL "\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1]}"
#define SHAKEN ",\"drive\":{\"pivot\":{\"x\":0.01}}"
#define TURNED ",\"drive\":{\"torque\":{\"arm\":1,\"amplitude\":0.1}}"
#define DRIVEN                                                                                     \
    "\"pendulum\":{\"length\":[1],\"mass\":[2],\"parent\":[0],\"damping\":[0.4],\"torque\":[{"     \
    "\"constant\":1,\"harmonics\":[{\"amplitude\":0.3,\"omega\":2,\"phase\":1},{\"amplitude\":"    \
    "0.2,\"omega\":-5,\"phase\":1},{\"amplitude\":0.1,\"omega\":2}]}]}"

/* the textbook's arm of 1 m and 2 kg with a damper of 0.4 N m s in its joint */
static void arm_answer(double omega, double torque, double *amplitude, double *phase) {
    double stiff = 2 * 9.81 - 2 * omega * omega, damp = 0.4 * omega;
    *amplitude = torque / hypot(stiff, damp);
    *phase = -atan2(damp, stiff);
}

TEST(response_of_one_arm_is_the_textbooks) {
    static const double omega[] = {0, 1, 3, 3.13, 3.3, 30};
    OWN(test_reply, free) reply =
        test_post(API_OP_RESPONSE, "{" ONE TURNED ",\"omega\":[0,1,3,3.13,3.3,30],\"poles\":true}");
    CHECK_INT(reply.status, 200);
    for (int i = 0; i < 6; i++) {
        char at[40];
        double amplitude, phase;
        arm_answer(omega[i], 0.1, &amplitude, &phase);
        snprintf(at, sizeof at, "/phi/amplitude/%d/0", i);
        CHECK(fabs(test_reply_number(&reply, at) / amplitude - 1) < 1e-13);
        snprintf(at, sizeof at, "/phi/phase/%d/0", i);
        CHECK(fabs(test_reply_number(&reply, at) - phase) < 1e-13);
        snprintf(at, sizeof at, "/frequency/%d", i);
        CHECK(fabs(test_reply_number(&reply, at) - omega[i] / (2 * M_PI)) < 1e-15);
    }
    CHECK(fabs(test_reply_number(&reply, "/equilibrium/0") + M_PI_2) < 1e-15);
    CHECK(fabs(test_reply_number(&reply, "/poles/decay/0") - 0.1) < 1e-14);
    CHECK(test_reply_number(&reply, "/poles/growth/0") ==
          -test_reply_number(&reply, "/poles/decay/0"));
    CHECK(fabs(test_reply_number(&reply, "/poles/omega/0") - sqrt(9.81 - 0.01)) < 1e-13);
    CHECK(fabs(test_reply_number(&reply, "/poles/damping_ratio/0") - 0.1 / sqrt(9.81)) < 1e-14);
    CHECK(test_reply_number(&reply, "/stats/frequencies") == 6 &&
          test_reply_number(&reply, "/stats/stable") == 1 &&
          test_reply_count(&reply, "/warnings") < 1);
}

TEST(response_to_the_pendulums_own_drives_has_a_row_for_each_of_their_frequencies) {
    OWN(test_reply, free) reply = test_post(API_OP_RESPONSE, "{" DRIVEN "}");
    CHECK_INT(reply.status, 200);
    CHECK_INT(test_reply_count(&reply, "/omega"), 2);
    CHECK(test_reply_number(&reply, "/omega/0") == 2 && test_reply_number(&reply, "/omega/1") == 5);
    /* the constant torque changes the equilibrium, and with it the stiffness */
    double rest = asin(1 / (2 * 9.81)), stiff = 2 * 9.81 * cos(rest);
    CHECK(fabs(test_reply_number(&reply, "/equilibrium/0") - (rest - M_PI_2)) < 1e-14);
    double re = 0.3 * cos(1) + 0.1, im = 0.3 * sin(1);
    CHECK(fabs(test_reply_number(&reply, "/phi/amplitude/0/0") /
                   (hypot(re, im) / hypot(stiff - 8, 0.8)) -
               1) < 1e-13);
    CHECK(fabs(test_reply_number(&reply, "/phi/phase/0/0") - atan2(im, re) +
               atan2(0.8, stiff - 8)) < 1e-13);
    /* 0.2 cos(-5 t + 1) is 0.2 cos(5 t - 1) */
    CHECK(fabs(remainder(test_reply_number(&reply, "/phi/phase/1/0") + 1 + atan2(2, stiff - 50),
                         2 * M_PI)) < 1e-13);
    test_reply_free(&reply);
    /* at other frequencies all of them drive */
    reply = test_post(API_OP_RESPONSE, "{" DRIVEN ",\"omega\":[0]}");
    re += 0.2 * cos(1), im -= 0.2 * sin(1);
    CHECK(fabs(test_reply_number(&reply, "/phi/amplitude/0/0") / (hypot(re, im) / stiff) - 1) <
          1e-13);
}

TEST(response_of_tips_tells_what_passes_from_a_shaken_pivot) {
    OWN(test_reply, free) reply = test_post(
        API_OP_RESPONSE,
        "{" IDEAL ",\"drive\":{\"pivot\":{\"direction\":30,\"unit\":\"deg\",\"amplitude\":0.01}},"
        "\"omega\":{\"start\":0.01,\"stop\":1000,\"count\":6,\"scale\":\"logarithmic\"},"
        "\"output\":[\"z\",\"transmissibility\",\"lambda\",\"joint_force\",\"tip_force\",\"phi\"]"
        "}");
    CHECK_INT(reply.status, 200);
    CHECK(test_reply_number(&reply, "/omega/0") == 0.01 &&
          fabs(test_reply_number(&reply, "/omega/2") - 1) < 1e-15 &&
          test_reply_number(&reply, "/omega/5") == 1000);
    /* at low frequencies everything moves with the pivot; at high ones the second arm's tip stays
     * at rest, except for its height, which arms that hang keep: sin^2 of the direction remains */
    CHECK(fabs(test_reply_number(&reply, "/transmissibility/0/1") - 1) < 1e-4);
    CHECK(fabs(test_reply_number(&reply, "/transmissibility/5/1") - 0.25) < 1e-4);
    CHECK(fabs(test_reply_number(&reply, "/z/y_amplitude/3/0") - 0.005) < 1e-15);
    /* both masses move up and down with the pivot: 2 m w^2 a, opposite to the motion */
    CHECK(fabs(test_reply_number(&reply, "/joint_force/along_amplitude/2/0") - 2 * 0.005) < 1e-15);
    CHECK(test_reply_number(&reply, "/tip_force/along_amplitude/2/1") ==
          test_reply_number(&reply, "/lambda/amplitude/2/1"));
}

TEST(response_comes_in_every_representation) {
    static const char *const accept[] = {"text/csv", "application/x-ndjson",
                                         "application/octet-stream", "application/x-npz",
                                         "application/x-matlab-data"};
    for (int i = 0; i < 5; i++) {
        OWN(test_reply, free) reply = test_post_as(
            API_OP_RESPONSE, "{" IDEAL SHAKEN ",\"omega\":{\"start\":0,\"stop\":2,\"count\":20}}",
            accept[i], NULL);
        CHECK_INT(reply.status, 200);
        CHECK(!strncmp(reply.media_type, accept[i], strlen(accept[i])));
        if (!i)
            CHECK(!strncmp(reply.out.data,
                           "omega,frequency,phi_amplitude_1,phi_amplitude_2,phi_phase_1,", 60));
        if (i == 1) CHECK(strstr(reply.out.data, "{\"omega\":0,\"frequency\":0,\"phi\":{") != NULL);
        if (i == 2) CHECK_INT((long long)reply.out.bytes, 20 * 8 * 8);
    }
}

/* g = 4 and an arm of 1 m: the mode is exactly 2 rad/s; without gravity there is no restoring
 * force */
TEST(response_that_is_not_finite_is_none_and_told) {
    OWN(test_reply, free) reply = test_post(
        API_OP_RESPONSE, "{\"pendulum\":{\"length\":[1],\"mass\":[1],\"parent\":[0],\"gravity\":4},"
                         "\"drive\":{\"pivot\":{\"x\":1}},\"omega\":[1,2,3],\"output\":[\"phi\","
                         "\"transmissibility\"]}");
    CHECK_INT(reply.status, 200);
    CHECK(strstr(reply.out.data, "\"amplitude\":[[") && strstr(reply.out.data, "],[null],["));
    CHECK(test_reply_number(&reply, "/phi/phase/1/0") == 0 &&
          test_reply_number(&reply, "/stats/unknown") == 1);
    CHECK(strstr(reply.out.data, "at 1 of the frequencies the amplitude is not finite") != NULL);
    test_reply_free(&reply);
    reply = test_post_as(API_OP_RESPONSE,
                         "{\"pendulum\":{\"length\":[1],\"mass\":[1],\"parent\":[0],\"gravity\":0},"
                         "\"drive\":{\"torque\":{\"arm\":1}},\"omega\":[0,1]}",
                         "application/octet-stream", NULL);
    CHECK_INT(reply.status, 200);
    double none = 0;
    memcpy(&none, reply.out.data + 2 * 8, sizeof none);
    CHECK(isnan(none));
}

TEST(response_warns_of_what_is_not_small_and_of_what_does_not_stand) {
    OWN(test_reply, free) reply =
        test_post(API_OP_RESPONSE, "{" ONE ",\"drive\":{\"torque\":{\"arm\":1,\"amplitude\":5}},"
                                   "\"initial\":{\"theta\":[3.1]},\"omega\":[1]}");
    CHECK_INT(reply.status, 200);
    CHECK(fabs(test_reply_number(&reply, "/equilibrium/0") - M_PI_2) < 1e-14);
    CHECK(test_reply_number(&reply, "/stats/stable") == 0);
    CHECK(strstr(reply.out.data, "the equilibrium is unstable") != NULL);
    test_reply_free(&reply);
    reply = test_post(API_OP_RESPONSE,
                      "{" ONE ",\"drive\":{\"torque\":{\"arm\":1,\"amplitude\":9}},\"omega\":[1]}");
    CHECK(strstr(reply.out.data, "an arm swings by 0.511 rad at omega = 1 rad/s") != NULL);
    CHECK(!strstr(reply.out.data, "dry friction"));
    test_reply_free(&reply);
    // the linear part of dry friction limits the arm to nearly the friction's speed
    reply = test_post(API_OP_RESPONSE, "{\"pendulum\":{\"length\":[1],\"mass\":[1],\"parent\":[0],"
                                       "\"friction\":[{\"torque\":1,\"speed\":0.01}]},"
                                       "\"drive\":{\"pivot\":{\"x\":1}},\"omega\":[0.01,1]}");
    CHECK(strstr(reply.out.data, "at omega = 1 rad/s a joint or a tip moves at 0.996 times the "
                                 "speed below which its dry friction") != NULL);
    test_reply_free(&reply);
    // a tip in air, above and below the speed of its drag
    for (int slow = 0; slow < 2; slow++) {
        char body[400];
        snprintf(body, sizeof body,
                 "{\"pendulum\":{\"length\":[1],\"mass\":[1],\"parent\":[0],"
                 "\"drag\":[{\"quadratic\":0.01,\"speed\":0.05}]},"
                 "\"drive\":{\"pivot\":{\"x\":%g}},\"omega\":[%g]}",
                 slow ? 0.01 : 0.09, slow ? 0.3 : 1.0);
        reply = test_post(API_OP_RESPONSE, body);
        CHECK_INT(reply.status, 200);
        CHECK_INT(strstr(reply.out.data, "quadratic drag is linear") == NULL, slow);
        if (!slow) test_reply_free(&reply);
    }
}

TEST(response_that_makes_no_sense_is_refused) {
#define AT(omega) "{" IDEAL SHAKEN ",\"omega\":" omega "}"
    OWN(test_reply, free) reply =
        test_post_as(API_OP_RESPONSE, AT("[1],\"poles\":true"), "text/csv", NULL);
    CHECK(test_reply_has_fault(&reply, "/poles", "only in application/json"));
}

TEST(response_of_a_thousand_arms_has_no_poles_and_one_of_too_many_numbers_no_answer) {
    static char body[20000];
    char *at = body + sprintf(body, "{\"pendulum\":{\"length\":[1");
    for (int i = 1; i < 1000; i++) at += sprintf(at, ",1");
    at += sprintf(at, "],\"mass\":[1");
    for (int i = 1; i < 1000; i++) at += sprintf(at, ",1");
    at += sprintf(at, "],\"parent\":[0");
    for (int i = 1; i < 1000; i++) at += sprintf(at, ",%d", i);
    at += sprintf(at, "]}" SHAKEN ",\"digits\":3,");
    sprintf(at, "\"omega\":[1,2],\"poles\":true}");
    OWN(test_reply, free) reply = test_post(API_OP_RESPONSE, body);
    CHECK(test_reply_has_fault(&reply, "/poles", "at most 100 arms"));
    test_reply_free(&reply);
    sprintf(at, "\"omega\":{\"start\":0,\"stop\":1,\"count\":100000}}");
    reply = test_post(API_OP_RESPONSE, body);
    CHECK(test_reply_has_fault(&reply, "/omega", "max-answer-bytes"));
    test_reply_free(&reply);
    sprintf(at, "\"omega\":{\"start\":0,\"stop\":1,\"count\":100}}");
    reply = test_post(API_OP_RESPONSE, body);
    CHECK_INT(reply.status, 200);
    CHECK_INT(test_reply_count(&reply, "/phi/amplitude/99"), 1000);
}
