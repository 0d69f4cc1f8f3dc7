/* Tests of how fits end: frequencies that cannot be reached, bounds next to each other, values that
 * diverge, no degrees of freedom, motions too fast to compute. Leaves to others: data that can be
 * fitted (test_op_fits, core/fit/test_fit). Invariant: the minimum is known in closed form. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tests/api/post.h"
#include "tests/harness/test.h"

/* two arms with equal tips: exchanging the lengths keeps the frequencies, so these do not depend on
 * the difference of equal lengths to first order */
#define ALIKE "\"pendulum\":{\"length\":[0.5,0.4],\"mass\":[1,1],\"parent\":[0,1]}"
#define LENGTHS(bounds1, bounds2)                                                                  \
    "\"unknowns\":[{\"vary\":\"length\",\"arm\":1" bounds1                                         \
    "},{\"vary\":\"length\",\"arm\":2" bounds2 "}]"

static double value(const struct test_reply *reply, int j, const char *what) {
    char pointer[60];
    snprintf(pointer, sizeof pointer, "/unknowns/%d/%s", j, what);
    return test_reply_number(reply, pointer);
}

/* verdict: status and model */
static void check_says(const struct test_reply *reply, const char *verdict, const char *part) {
    const char *message = test_reply_text(reply, "/message");
    char said[40];
    CHECK_INT(reply->status, 200);
    snprintf(said, sizeof said, "%s %s", test_reply_text(reply, "/status"),
             test_reply_text(reply, "/model"));
    CHECK_TEXT(said, verdict);
    CHECK_SAYING(message && strstr(message, part), "%s", message ? message : "");
}

/* the length of both arms, in l g / (2 -+ sqrt 2) = 1 / omega^2, that comes closest to the
 * frequencies */
static double alike_length(double first, double second) {
    double a = sqrt(2 - sqrt(2)), b = sqrt(2 + sqrt(2));
    return 9.81 / pow(2 * M_PI * (a * first + b * second) / (a * a + b * b), 2);
}

TEST(fits_say_by_how_much_wanted_frequencies_cannot_be_had) {
    static const struct {
        double first, second;
        const char *bounds, *sigma, *status, *says;
    } tried[] = {
        {0.6, 1 / 0.7, "", "", "converged undecided",
         "mode 1 has 3.72558 rad/s, 1.18 % below 3.76991. There are as many unknowns"},
        {0.6, 1 / 0.7, ",\"low\":0.05,\"high\":5", "", "converged undecided", "1.18 % below"},
        {1, 1.05, "", "", "converged rejected", "no pendulum near the given start"},
        {1, 1.05, ",\"low\":0.05,\"high\":5", "", "converged rejected", "48.2 % below 6.28319"},
        {1, 1.05, "", ",\"sigma\":0.01", "converged rejected", "mode 1 has 3.25266"},
    };
    for (size_t i = 0; i < sizeof tried / sizeof *tried; i++) {
        char body[800];
        snprintf(body, sizeof body,
                 "{" ALIKE ",\"data\":{\"modes\":[{\"mode\":1,\"frequency\":%.17g%s},{\"mode\":2,"
                 "\"frequency\":%.17g%s}]}," LENGTHS("%s", "%s") "}",
                 tried[i].first, tried[i].sigma, tried[i].second, tried[i].sigma, tried[i].bounds,
                 tried[i].bounds);
        OWN(test_reply, free) reply = test_post(API_OP_FITS, body);
        check_says(&reply, tried[i].status, tried[i].says);
        double length = alike_length(tried[i].first, tried[i].second);
        for (int j = 0; j < 2; j++) {
            CHECK_SAYING(fabs(value(&reply, j, "value") - length) < 1e-6, "%zu: %.12g, %.12g", i,
                         value(&reply, j, "value"), length);
            // measured frequencies, to 0.01 Hz or rad/s, determine errors; required ones do not
            CHECK(isfinite(value(&reply, j, "error")) == (*tried[i].sigma != 0));
        }
        CHECK(strstr((const char *)reply.out.data, "\"at_bound\":true") == NULL);
        CHECK(strstr((const char *)reply.out.data, "\"unidentifiable\":[],\"not_told\":[]") !=
              NULL);
    }
}

/* a millionth of a length: if both bounds are next to each other, the better one is the answer */
TEST(fits_end_at_bounds_that_are_next_to_each_other) {
    OWN(test_reply, free) reply = test_post(
        API_OP_FITS,
        "{" ALIKE ",\"data\":{\"modes\":[{\"mode\":1,\"frequency\":0.6},{"
        "\"mode\":2,\"period\":0.7}]}," LENGTHS(",\"low\":0.499999,\"high\":0.500001",
                                                ",\"low\":0.399999,\"high\":0.400001") "}");
    check_says(&reply, "converged undecided", "5.33 % below 3.76991");
    // both frequencies are too low, and higher if either length is smaller
    CHECK(value(&reply, 0, "value") == 0.499999 && value(&reply, 1, "value") == 0.399999);
    CHECK(strstr((const char *)reply.out.data, "\"at_bound\":false") == NULL);
    test_reply_free(&reply);
    reply = test_post(API_OP_FITS,
                      "{" ALIKE ",\"data\":{\"modes\":[{\"mode\":1,\"frequency\":1},{\"mode\":2,"
                      "\"frequency\":1.05}]}," LENGTHS(",\"high\":0.500001,\"low\":0.5", "") "}");
    check_says(&reply, "converged rejected", "47.3 % below");
    CHECK(value(&reply, 0, "value") == 0.500001);
    CHECK(fabs(value(&reply, 1, "value") - 0.549076) < 1e-5);
}

/* the second frequency approaches the required one as the first tip grows without limit */
TEST(fits_say_what_goes_away_without_end) {
    OWN(test_reply, free) reply = test_post(
        API_OP_FITS,
        "{" ALIKE ",\"data\":{\"modes\":[{\"mode\":1,\"frequency\":1},{\"mode\":2,\"frequency\":"
        "1.05}]},\"unknowns\":[{\"vary\":\"mass\",\"arm\":1},{\"vary\":\"length\",\"arm\":2}]}");
    check_says(&reply, "no_minimum undecided",
               "keeps falling as mass of arm 1 grows or shrinks without limit");
}

/* a position 0.4243 m from the pivot, for an arm of 0.4 m: the residual has its direction */
TEST(fits_say_how_far_a_wanted_place_is) {
    OWN(test_reply, free) reply = test_post(
        API_OP_FITS,
        "{\"pendulum\":{\"length\":[0.4],\"mass\":[1],\"parent\":[0]},\"initial\":{\"theta\":[1]},"
        "\"start\":0,\"data\":{\"t\":[0.4],\"series\":[{\"x\":1,\"values\":[0.3]},{\"y\":1,"
        "\"values\":"
        "[-0.3]}]},\"unknowns\":[{\"vary\":\"theta\",\"arm\":1},{\"vary\":\"thetad\",\"arm\":1}]}");
    // 0.3 - 0.4 / sqrt 2
    check_says(&reply, "converged rejected", "of arm 1 at t = 0.4 s, 0.0172 off.");
}

#define MEASURED(sigma, more)                                                                      \
    "{\"pendulum\":{\"length\":[0.9],\"mass\":[1],\"parent\":[0]},\"data\":{\"t\":[0,0.3,0.6" more \
    "],\"series\":[{\"theta\":1" sigma ",\"values\":[0.5,0.33,-0.09"

TEST(fits_say_that_nothing_is_left_to_check_by) {
    static const char unknowns[] = "]}]},\"unknowns\":[{\"vary\":\"length\",\"arm\":1},{\"vary\":"
                                   "\"theta\",\"arm\":1},{\"vary\":\"thetad\",\"arm\":1}]}";
    static const struct {
        const char *data;
        int left, errors;
    } tried[] = {
        {MEASURED("", ""), 0, 0},
        {MEASURED(",\"sigma\":0.01", ""), 0, 1},
        {MEASURED("", ",0.9") ",-0.43", 1, 1},
    };
    for (size_t i = 0; i < sizeof tried / sizeof *tried; i++) {
        char body[800];
        snprintf(body, sizeof body, "%s%s", tried[i].data, unknowns);
        OWN(test_reply, free) reply = test_post(API_OP_FITS, body);
        const char *says = tried[i].left     ? "a minimum, with too few measurements to test"
                           : tried[i].errors ? "the fit cannot be checked"
                                             : "cannot be checked, and has no standard errors";
        check_says(&reply, "converged undecided", says);
        CHECK(tried[i].left || test_reply_number(&reply, "/degrees_of_freedom") == 0);
        CHECK(!tried[i].left || strstr(test_reply_text(&reply, "/message"), "check") == NULL);
        for (int j = 0; j < 3; j++) CHECK(isfinite(value(&reply, j, "error")) == tried[i].errors);
    }
}

TEST(fits_say_how_to_begin_where_the_motion_is_too_wild) {
    OWN(test_reply, free) reply = test_post(
        API_OP_FITS,
        "{\"pendulum\":{\"length\":[0.9,0.001],\"mass\":[1,1],\"parent\":[0,1]},\"initial\":{"
        "\"theta\":[0.5,0.5],\"thetad\":[0,1e6]},\"data\":{\"t\":[0,0.3,0.6],\"series\":[{"
        "\"theta\":1,\"values\":[0.5,0.33,-0.09]}]},"
        "\"unknowns\":[{\"vary\":\"length\",\"arm\":1}]}");
    const char *detail = test_reply_text(&reply, "/errors/0/detail");
    CHECK_INT(reply.status, 422);
    CHECK_SAYING(detail && strstr(detail, "too fast, too chaotic or too strongly damped") &&
                     strstr(detail, "lower rate"),
                 "%s", detail ? detail : "");
}

/* a measurement with a sigma is not compared with one without, nor an angle with a position */
TEST(fits_name_no_farthest_row_of_what_cannot_be_compared) {
    static const char *const second[] = {"\"theta\":2,\"sigma\":0.001", "\"x\":2"};
    for (int s = 0; s < 2; s++) {
        static char body[2000];
        char *at = body + sprintf(body, "{\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],\"parent\":"
                                        "[0,1]},\"data\":{\"t\":[0");
        for (int i = 1; i < 30; i++) at += sprintf(at, ",%g", 0.1 * i);
        at += sprintf(at, "],\"series\":[{\"theta\":1,\"values\":[0.06");
        for (int i = 1; i < 30; i++) at += sprintf(at, ",%.6f", 0.05 * cos(2.397 * 0.1 * i));
        at += sprintf(at, "]},{%s,\"values\":[0.07", second[s]);
        for (int i = 1; i < 30; i++) at += sprintf(at, ",%.6f", sin(0.2 * i * i));
        sprintf(at, "]}]},\"initial\":{\"theta\":[0.05,0.07]},\"unknowns\":[{\"vary\":\"length\","
                    "\"arm\":1}]}");
        OWN(test_reply, free) reply = test_post(API_OP_FITS, body);
        CHECK_TEXT(test_reply_text(&reply, "/model"), "rejected");
        CHECK_SAYING(!strstr(test_reply_text(&reply, "/message"), "farthest"), "%s",
                     test_reply_text(&reply, "/message"));
    }
}

/* angles in a table without other numbers: of a swing or none, with row 30 shifted by whole
 * turns */
static struct test_reply swung(int swing, double turns) {
    static char body[4000];
    char *at = body + sprintf(body, "{\"pendulum\":{\"length\":[1],\"mass\":[1],\"parent\":[0]},"
                                    "\"data\":{\"csv\":\"t,theta\\n");
    for (int i = 0; i < 100; i++)
        at += sprintf(at, "%g,%.6f\\n", 0.05 * i,
                      (swing ? 0.1 * cos(sqrt(9.81) * 0.05 * i) : remainder(0.7 * i * i, 3)) +
                          (i == 30 ? turns * 2 * M_PI : 0));
    sprintf(at, "\"},\"unknowns\":[{\"vary\":\"length\",\"arm\":1},{\"vary\":\"theta\",\"arm\":1},"
                "{\"vary\":\"thetad\",\"arm\":1}]}");
    return test_post(API_OP_FITS, body);
}

/* whole turns are removed from residuals of angles, and from what they explain */
TEST(fits_that_follow_nothing_do_not_converge_as_one_angle_is_many_turns_off) {
    static const double turns[] = {0, 1, -40, 1000};
    for (size_t i = 0; i < sizeof turns / sizeof *turns; i++) {
        OWN(test_reply, free) reply = swung(1, turns[i]);
        // these are small swings, which are not exactly the pendulum's
        check_says(&reply, "converged rejected", "consecutive residuals are correlated");
        CHECK(fabs(value(&reply, 0, "value") - 1) < 0.01);
        test_reply_free(&reply);
        reply = swung(0, turns[i]);
        CHECK_SAYING(strcmp(test_reply_text(&reply, "/model"), "accepted") != 0, "%g", turns[i]);
        CHECK(test_reply_number(&reply, "/explained") < 0.5);
    }
}

/* a pendulum at rest determines its angle and its rate, and nothing else separately */
TEST(fits_to_data_at_rest_name_one_by_one_what_they_do_not_tell) {
    static char body[8000];
    char *at = body + sprintf(body, "{\"pendulum\":{\"length\":[1],\"mass\":[1],\"parent\":[0],"
                                    "\"damping\":[0.1]},\"initial\":{\"theta\":[0]},"
                                    "\"start\":0,\"data\":{\"t\":[0");
    for (int i = 1; i < 50; i++) at += sprintf(at, ",%g", 0.1 * i);
    at += sprintf(at, "],\"series\":[{\"theta\":1,\"sigma\":0.01,\"values\":[0");
    for (int i = 1; i < 50; i++) at += sprintf(at, ",0");
    sprintf(at,
            "]}]},\"unknowns\":[{\"vary\":\"length\",\"arm\":1},{\"vary\":\"damping\",\"arm\":1},"
            "{\"vary\":\"gravity\"}]}");
    OWN(test_reply, free) reply = test_post(API_OP_FITS, body);
    static const char *const names[] = {"length of arm 1", "damping of arm 1", "gravity"};
    CHECK_INT(reply.status, 200);
    CHECK_INT(test_reply_count(&reply, "/unidentifiable"), 3);
    for (int i = 0; i < 3; i++) {
        char pointer[32], said[80];
        snprintf(pointer, sizeof pointer, "/unidentifiable/%d", i);
        snprintf(said, sizeof said, "the data do not depend on %s", names[i]);
        CHECK_TEXT(test_reply_text(&reply, pointer), said);
    }
}
