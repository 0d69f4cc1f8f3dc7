/* Tests of starts of fits that are estimated from the data: positions without a start, the camera,
 * freed and fixed numbers, and the pointer of an error for a start without a motion.
 * Leaves to others: the fit itself (core/fit/test_fit), errors (laws/test_fit_errors).
 * Invariant: measurements come from a trajectory of this program, with noise of a fixed seed. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tests/api/post.h"
#include "tests/harness/test.h"

enum { ROWS = 60, BODY = 20000 };

/* A damped pendulum of 0.318 m released from 0.4 rad, measured as `what` says: its angle, or its
 * tip in pixels, 800 per metre, below (320, 100). The rest of the request follows `data`. */
static struct test_reply post_film(int places, double metre, const char *damping,
                                   const char *rest) {
    static char body[BODY];
    unsigned long long seed = 11;
    char *at = body;
    OWN(test_reply, free) film = test_post(
        API_OP_TRAJECTORIES,
        "{\"pendulum\":{\"length\":[0.318],\"mass\":[1],\"parent\":[0],\"damping\":[0.01]},"
        "\"initial\":{\"theta\":[0.4]},\"times\":{\"stop\":3,\"count\":60},\"output\":[\"theta\"]"
        "}");
    at += sprintf(at, "{\"pendulum\":{\"length\":[0.3],\"mass\":[1],\"parent\":[0]%s},\"data\":{",
                  damping);
    for (int s = -1; s <= places; s++) {
        at += sprintf(at, s < 0     ? "\"t\":["
                          : !places ? "{\"theta\":1,\"values\":["
                          : s       ? ",{\"y\":1,\"values\":["
                                    : "{\"x\":1,\"values\":[");
        for (int i = 0; i < ROWS; i++) {
            char pointer[2][30];
            snprintf(pointer[0], sizeof pointer[0], "/t/%d", i);
            snprintf(pointer[1], sizeof pointer[1], "/theta/%d/0", i);
            double theta = test_reply_number(&film, pointer[1]) + 0.002 * test_noise(&seed);
            double to = !places ? theta
                        : s     ? 100 / 800.0 - 0.318 * cos(theta)
                                : 320 / 800.0 + 0.318 * sin(theta);
            if (places && metre == 1) to -= s ? 100 / 800.0 : 320 / 800.0;
            if (s < 0) to = test_reply_number(&film, pointer[0]);
            at += sprintf(at, "%s%.9g", i ? "," : "", s < 0 || !places ? to : metre * to);
        }
        at += sprintf(at, s < 0 ? "],\"series\":[" : "]}");
    }
    sprintf(at, "]}%s}", rest);
    return test_post(API_OP_FITS, body);
}

static void check_value(const struct test_reply *reply, int j, const char *name, double truth) {
    char pointer[3][40];
    const char *fields[] = {"name", "value", "error"};
    for (int i = 0; i < 3; i++)
        snprintf(pointer[i], sizeof pointer[i], "/unknowns/%d/%s", j, fields[i]);
    const char *named = test_reply_text(reply, pointer[0]);
    double value = test_reply_number(reply, pointer[1]),
           error = test_reply_number(reply, pointer[2]);
    CHECK_SAYING(named && !strcmp(named, name), "%s", named ? named : "");
    CHECK_SAYING(fabs(value - truth) < 4 * error && error < 0.1 * fmax(fabs(truth), 1),
                 "%s: %g +- %g", name, value, error);
}

static void check_converged(const struct test_reply *reply) {
    const char *status = test_reply_text(reply, "/status"),
               *detail = test_reply_text(reply, "/detail");
    CHECK_SAYING(status && !strcmp(status, "converged"), "%s", detail ? detail : status);
}

static void check_text(const struct test_reply *reply, const char *pointer, const char *text) {
    const char *got = test_reply_text(reply, pointer);
    CHECK_SAYING(got && !strcmp(got, text), "%s: %s", pointer, got ? got : "nothing");
}

/* Fits of positions without `initial` used to start from a pendulum at rest, on which friction does
 * not act. */
TEST(fits_of_places_begin_where_the_data_are_with_any_friction_from_none) {
    static const char *const terms[] = {"damping", "friction_torque", "drag", "drag_quadratic"};
    for (size_t i = 0; i < sizeof terms / sizeof *terms; i++) {
        char rest[200];
        snprintf(rest, sizeof rest,
                 ",\"unknowns\":[{\"vary\":\"length\",\"arm\":1},{\"vary\":\"theta\",\"arm\":1},"
                 "{\"vary\":\"%s\",\"arm\":1}]",
                 terms[i]);
        OWN(test_reply, free) reply = post_film(1, 1, "", rest);
        check_converged(&reply);
        if (!i) check_value(&reply, 0, "length of arm 1", 0.318);
        check_value(&reply, 1, "theta of arm 1", 0.4);
        check_text(&reply, "/freed/0", "thetad of arm 1");
    }
}

TEST(fits_take_a_camera_that_is_sought_from_the_data) {
    OWN(test_reply, free) reply = post_film(1, 800, ",\"damping\":[0.01]",
                                            ",\"camera\":{\"unknown\":[\"scale\",\"origin\"]},"
                                            "\"unknowns\":[{\"vary\":\"length\",\"arm\":1}]");
    check_converged(&reply);
    check_value(&reply, 0, "length of arm 1", 0.318);
    check_value(&reply, 2, "origin x of the camera", 320);
    check_value(&reply, 4, "theta of arm 1", 0.4);
    check_text(&reply, "/freed/1", "thetad of arm 1");
    check_text(&reply, "/fixed/3", "rotation of the camera");
}

/* A rate that was estimated from noisy angles and fixed made the length wrong by many standard
 * errors. */
TEST(fits_free_what_they_take_from_the_data_and_name_what_stays_fixed) {
#define SOUGHT ",\"unknowns\":[{\"vary\":\"length\",\"arm\":1},{\"vary\":\"theta\",\"arm\":1}]"
    OWN(test_reply, free) reply = post_film(0, 1, ",\"damping\":[0.01]", SOUGHT);
    check_converged(&reply);
    check_value(&reply, 0, "length of arm 1", 0.318);
    check_value(&reply, 2, "thetad of arm 1", 0);
    check_text(&reply, "/freed/0", "thetad of arm 1");
    check_text(&reply, "/fixed/0", "mass of arm 1");
    check_text(&reply, "/fixed/1", "damping of arm 1");
    check_text(&reply, "/fixed/2", "gravity");
    test_reply_free(&reply);
    reply = post_film(0, 1, ",\"damping\":[0.01]",
                      SOUGHT ",\"fixed\":[{\"vary\":\"thetad\",\"arm\":1,\"start\":0}]");
    check_converged(&reply);
    check_value(&reply, 0, "length of arm 1", 0.318);
    CHECK(!test_reply_text(&reply, "/freed/0"));
    check_text(&reply, "/fixed/3", "thetad of arm 1");
    CHECK(test_reply_number(&reply, "/request/initial/phid/0") == 0);
    test_reply_free(&reply);
    // an unknown cannot be fixed
    reply = post_film(0, 1, "", SOUGHT ",\"fixed\":[{\"vary\":\"theta\",\"arm\":1}]");
    CHECK_INT(reply.status, 422);
    check_text(&reply, "/errors/0/pointer", "/fixed/0");
}

/* Friction that stops an arm in 0.1 ms makes each motion take 7000 steps, where swings take 700. */
TEST(fits_compute_motions_whose_steps_friction_shortens) {
    OWN(test_reply, free) reply =
        post_film(0, 1, ",\"damping\":[0.02],\"friction\":[{\"torque\":1e-4,\"speed\":1e-7}]",
                  ",\"initial\":{\"theta\":[0.4]},\"unknowns\":[{\"vary\":\"length\",\"arm\":1},{"
                  "\"vary\":\"damping\",\"arm\":1}]");
    check_converged(&reply);
    check_value(&reply, 0, "length of arm 1", 0.318);
    check_value(&reply, 1, "damping of arm 1", 0.01);
}

TEST(fits_blame_a_start_from_which_there_is_no_motion) {
    OWN(test_reply, free) reply =
        post_film(0, 1, ",\"damping\":[1e14]",
                  ",\"initial\":{\"theta\":[1]},\"unknowns\":[{\"vary\":\"damping\",\"arm\":1}]");
    CHECK_INT(reply.status, 422);
    check_text(&reply, "/errors/0/pointer", "/initial");
}

/* Angles of a double pendulum, 10 ms apart except for `lost` rows after the third, as "t" and
 * "series" at `at`; returns their end. */
static char *film_angles(char *at, const char *start, int rows, int lost,
                         unsigned long long *seed) {
    char body[300];
    snprintf(body, sizeof body,
             "{\"pendulum\":{\"length\":[0.17,0.2],\"mass\":[0.1,0.08],\"parent\":[0,1],"
             "\"damping\":[1e-4,4e-5]},\"initial\":{%s},\"times\":{\"stop\":%g,\"count\":%d},"
             "\"output\":[\"theta\"]}",
             start, 0.01 * (rows - 1), rows);
    OWN(test_reply, free) film = test_post(API_OP_TRAJECTORIES, body);
    at += sprintf(at, "\"t\":[");
    for (int i = 0; i < rows; i += i == 2 ? lost + 1 : 1)
        at += sprintf(at, "%s%.9g", i ? "," : "", 0.01 * i);
    at += sprintf(at, "],\"series\":[");
    for (int k = 0; k < 2; k++) {
        at += sprintf(at, "%s{\"theta\":%d,\"values\":[", k ? "," : "", k + 1);
        for (int i = 0; i < rows; i += i == 2 ? lost + 1 : 1) {
            char pointer[40];
            snprintf(pointer, sizeof pointer, "/theta/%d/%d", i, k);
            double theta = test_reply_number(&film, pointer) + 0.004 * test_noise(seed);
            at += sprintf(at, "%s%.6f", i ? "," : "", theta);
        }
        at += sprintf(at, "]}");
    }
    return at + sprintf(at, "]");
}

static const char spinning[] =
    "{\"pendulum\":{\"length\":[0.16,0.2],\"mass\":[0.1,0.09],\"parent\":[0,1],\"damping\":[1e-4,"
    "4e-5]},\"unknowns\":[{\"vary\":\"length\",\"arm\":1},{\"vary\":\"mass\",\"arm\":2}";

/* A double pendulum whose second arm spins backwards, a third of a radian per row: started with the
 * mean rate of five rows, or where it turns in the other direction, the fit ended at a motion with
 * other turns. */
TEST(fits_find_the_motion_whose_whole_turns_are_those_of_the_data) {
    static char body[BODY];
    static const char *const starts[] = {"", ",\"start\":17"};
    for (int s = 0; s < 2; s++) {
        unsigned long long seed = 5;
        char *at = body + sprintf(body, "%s,{\"vary\":\"thetad\",\"arm\":2%s}],\"data\":{",
                                  spinning, starts[s]);
        at = film_angles(at, "\"theta\":[0.4,1.2],\"thetad\":[-18,-35]", 61, 0, &seed);
        sprintf(at, "}}");
        OWN(test_reply, free) reply = test_post(API_OP_FITS, body);
        check_converged(&reply);
        check_value(&reply, 0, "length of arm 1", 0.17);
        check_value(&reply, 2, "thetad of arm 2", -35);
        CHECK(test_reply_number(&reply, "/explained") > 0.9999);
    }
}

/* One of two runs spins, and rows are missing: fitted together from the start, they end with 89 %
 * explained. */
TEST(spinning_arms_are_found_in_one_of_two_runs) {
    static char body[BODY];
    unsigned long long seed = 7;
    char *at = body + sprintf(body, "%s],\"data\":{\"runs\":[{", spinning);
    at = film_angles(at, "\"theta\":[1,1.2]", 80, 0, &seed);
    at += sprintf(at, "},{");
    at = film_angles(at, "\"theta\":[2,0],\"thetad\":[12,12]", 64, 4, &seed);
    sprintf(at, "}]}}");
    OWN(test_reply, free) reply = test_post(API_OP_FITS, body);
    check_converged(&reply);
    check_value(&reply, 0, "length of arm 1", 0.17);
    check_value(&reply, 1, "mass of arm 2", 0.08);
    CHECK(test_reply_number(&reply, "/explained") > 0.9999);
}
