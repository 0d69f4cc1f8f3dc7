/* Tests of laws fitted to trials: the period by an independent quadrature, lines and powers by
 * hand, and whether standard errors are correct.
 * Leaves to others: fits of motions (fit/test_op_fits).
 * Invariant: numbers are made up here. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tests/api/post.h"
#include "tests/harness/test.h"

enum { TRIALS = 12, SETS = 300 };

#define NEAR(got, want)                                                                            \
    CHECK_SAYING(fabs((got) - (want)) < 1e-12, "%.17g, not %.17g", got, (double)(want))

static const double gravity = 9.81;

/* 4 sqrt(l/g) times the integral of (1 - k^2 sin^2)^-1/2 over a quarter turn, k = sin(A / 2) */
static double period_of(double length, double amplitude) {
    double sum = 0, k = sin(amplitude / 2);
    for (int i = 0; i < 2000; i++) sum += 1 / sqrt(1 - pow(k * sin((i + 0.5) * M_PI / 4000), 2));
    return 4 * sqrt(length / gravity) * sum * M_PI / 4000;
}

/* trials of all lengths and amplitudes, with noise on the periods; their request */
static void trials_of(char *at, const char *head, double noise, unsigned long long *seed) {
    at += sprintf(at, "{%s\"trials\":[", head);
    for (int i = 0; i < TRIALS; i++) {
        double length = 0.2 + 0.15 * i, amplitude = 0.25 * (i % 11), normal = -6;
        for (int k = 0; k < 12; k++) normal += test_random(seed);
        at += sprintf(at, "%s{\"length\":%.17g,\"amplitude\":%.17g,\"period\":%.17g}", i ? "," : "",
                      length, amplitude, period_of(length, amplitude) + noise * normal);
    }
    sprintf(at, "]}");
}

TEST(gravity_follows_from_periods_of_any_amplitude) {
    char body[4000];
    unsigned long long seed = 1;
    trials_of(body, "", 0, &seed);
    OWN(test_reply, free) reply = test_post(API_OP_TRIALS, body);
    CHECK_SAYING(reply.status == 200, "%s", reply.out.data);
    NEAR(test_reply_number(&reply, "/unknowns/gravity/value"), gravity);
    CHECK_INT((int)test_reply_number(&reply, "/degrees_of_freedom"), TRIALS - 1);
    CHECK_INT(test_reply_count(&reply, "/trials"), TRIALS);
    for (int i = 0; i < TRIALS; i++) {
        char pointer[40];
        snprintf(pointer, sizeof pointer, "/trials/%d/residual", i);
        CHECK(fabs(test_reply_number(&reply, pointer)) < 1e-13);
    }
}

/* the mean of the squared deviations divided by errors is 1: with a sigma, and if the residuals
 * determine the error */
TEST(standard_errors_of_gravity_are_those_of_many_sets_of_trials) {
    unsigned long long seed = 7;
    for (int known = 0; known < 2; known++) {
        double sum = 0, chi = 0;
        for (int s = 0; s < SETS; s++) {
            char body[4000];
            trials_of(body, known ? "\"sigma\":0.01," : "", 0.01, &seed);
            OWN(test_reply, free) reply = test_post(API_OP_TRIALS, body);
            double off = test_reply_number(&reply, "/unknowns/gravity/value") - gravity;
            sum += pow(off / test_reply_number(&reply, "/unknowns/gravity/error"), 2) / SETS;
            if (known) chi += test_reply_number(&reply, "/chi_squared") / (TRIALS - 1) / SETS;
        }
        // the mean of 300 squares has an error of sqrt(2 / 300), with 11 degrees of freedom
        // somewhat more
        CHECK_SAYING(sum > 0.7 && sum < 1.5, "%d: %g", known, sum);
        if (known) CHECK_SAYING(chi > 0.85 && chi < 1.15, "%g", chi);
    }
}

/* y = 3, 5, 7.3 at 1, 2, 3: slope 2.15 +- 0.0866, intercept 0.8 +- 0.1871 by the normal equations;
 * at 4 it is 9.4 +- 0.1871 */
TEST(a_line_and_a_power_follow_from_the_normal_equations) {
    OWN(test_reply, free) reply =
        test_post(API_OP_TRIALS, "{\"law\":\"line\",\"x\":\"mass\",\"y\":\"period\",\"trials\":[{"
                                 "\"mass\":1,\"period\":3},{\"mass\":2,\"period\":5},{\"mass\":3,"
                                 "\"period\":7.3},{\"mass\":4,\"period\":null},{\"mass\":5}]}");
    CHECK_SAYING(reply.status == 200, "%s", reply.out.data);
    NEAR(test_reply_number(&reply, "/unknowns/slope/value"), 2.15);
    NEAR(test_reply_number(&reply, "/unknowns/slope/error"), 0.15 / sqrt(3));
    NEAR(test_reply_number(&reply, "/unknowns/intercept/value"), 0.8);
    NEAR(test_reply_number(&reply, "/unknowns/intercept/error"), 0.15 / sqrt(3) * sqrt(14.0 / 3));
    NEAR(test_reply_number(&reply, "/trials/3/fitted"), 9.4);
    NEAR(test_reply_number(&reply, "/trials/3/error"), 0.15 / sqrt(3) * sqrt(14.0 / 3));
    CHECK(isnan(test_reply_number(&reply, "/trials/3/residual")));
    CHECK_INT((int)test_reply_number(&reply, "/degrees_of_freedom"), 1);
    test_reply_free(&reply);
    reply = test_post(API_OP_TRIALS,
                      "{\"law\":\"power\",\"sigma\":0.02,\"trials\":[{\"length\":1,\"period\":2},{"
                      "\"length\":4,\"period\":4},{\"length\":9,\"period\":6}]}");
    CHECK_SAYING(reply.status == 200, "%s", reply.out.data);
    NEAR(test_reply_number(&reply, "/unknowns/exponent/value"), 0.5);
    NEAR(test_reply_number(&reply, "/unknowns/factor/value"), 2);
    CHECK(test_reply_number(&reply, "/unknowns/factor/error") > 0.01);
    CHECK(test_reply_number(&reply, "/chi_squared") < 1e-20);
}

TEST(trials_that_tell_nothing_are_refused_and_two_points_have_no_error) {
    struct test_reply reply =
        test_post(API_OP_TRIALS, "{\"unit\":\"deg\",\"trials\":[{\"length\":1,\"period\":2,"
                                 "\"amplitude\":5}]}");
    CHECK(test_reply_number(&reply, "/unknowns/gravity/value") > 9.8);
    CHECK(isnan(test_reply_number(&reply, "/unknowns/gravity/error")));
    test_reply_free(&reply);
    static const struct {
        const char *body, *pointer, *says;
    } refused[] = {
        {"{}", "/trials", "1 to 5000 trials"},
        {"{\"trials\":[{\"period\":2}]}", "/trials/0", "needs length"},
        {"{\"trials\":[{\"length\":1,\"period\":0}]}", "/trials/0", "above 0"},
        {"{\"trials\":[{\"length\":1,\"width\":0}]}", "/trials/0/width", "not a known"},
        {"{\"trials\":[{\"length\":1,\"period\":1,\"amplitude\":4}]}", "/trials/0/amplitude",
         "3.14"},
        {"{\"law\":\"line\",\"trials\":[{\"length\":1,\"period\":2}]}", "/trials",
         "differ in length"},
        {"{\"trials\":[{\"length\":1}]}", "/trials", "trials with period"},
        {"{\"x\":\"mass\",\"trials\":[{\"mass\":1,\"period\":2}]}", "/law", "length"},
        {"{\"law\":\"cubic\",\"trials\":[{\"length\":1,\"period\":2}]}", "/law", "line"},
    };
    for (size_t i = 0; i < sizeof refused / sizeof *refused; i++)
        CHECK_REFUSED(API_OP_TRIALS, refused[i].body, refused[i].pointer, refused[i].says);
}
