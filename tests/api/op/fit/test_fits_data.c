/* Tests of the measurements of fits: several runs of one pendulum, units of tables, terms that
 * start from 0.
 * Leaves to others: fits of one run (test_op_fits), the fit itself (core/fit/test_fit).
 * Invariant: measurements come from trajectories of this program, with noise of fixed seeds. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tests/api/post.h"
#include "tests/harness/test.h"

enum { ROWS = 60, BODY = 30000 };

#define ARMS                                                                                       \
    "{\"name\":\"a\",\"length\":%s,\"mass\":0.3%s},{\"parent\":\"a\",\"length\":0.28,\"mass\":0."  \
    "2}"

/* the angles of a released pendulum with friction */
static struct test_reply motion(const char *theta, double start, int rows) {
    char body[400];
    snprintf(body, sizeof body,
             "{\"pendulum\":{\"arms\":[" ARMS "]},\"initial\":{\"theta\":[%s]},\"times\":{"
             "\"start\":%g,\"stop\":%g,\"count\":%d},\"output\":[\"theta\"]}",
             "0.35", ",\"damping\":0.004", theta, start, start + 3, rows);
    struct test_reply reply = test_post(API_OP_TRAJECTORIES, body);
    CHECK_INT(reply.status, 200);
    return reply;
}

static double number(const struct test_reply *reply, const char *name, int i, int k) {
    char pointer[60];
    if (k < 0)
        snprintf(pointer, sizeof pointer, "/%s/%d", name, i);
    else
        snprintf(pointer, sizeof pointer, "/%s/%d/%d", name, i, k);
    return test_reply_number(reply, pointer);
}

/* a table of an arm's angle, or of both, with `unit` before each line */
static char *table(char *at, const struct test_reply *from, int rows, int arms, double unit,
                   const char *names, unsigned long long *seed) {
    at += sprintf(at, "%s\\n", names);
    for (int i = 0; i < rows; i++) {
        at += sprintf(at, "%.12g", number(from, "t", i, -1));
        for (int k = 0; k < arms; k++)
            at += sprintf(at, ",%.9g",
                          unit * (number(from, "theta", i, k) + 0.01 * test_noise(seed)));
        at += sprintf(at, "\\n");
    }
    return at;
}

#define REST                                                                                       \
    "{\"vary\":\"theta\",\"arm\":1},{\"vary\":\"theta\",\"arm\":2},{\"vary\":\"thetad\",\"arm\":"  \
    "1},{\"vary\":\"thetad\",\"arm\":2}"

/* A motion in which both arms were measured, as a list of series, and one of the first arm alone,
 * as a table; the fit adds a friction that the given pendulum lacks. */
TEST(fits_of_several_runs_have_a_start_each) {
    static char body[BODY];
    unsigned long long seed = 4;
    OWN(test_reply, free) one = motion("1,0.5", 0, ROWS), other = motion("-0.7,0.9", 5, ROWS / 2);
    char *at = body + sprintf(body,
                              "{\"pendulum\":{\"arms\":[" ARMS "]},\"unknowns\":[{\"vary\":"
                              "\"length\",\"arm\":1},{\"vary\":\"damping\",\"arm\":1},{"
                              "\"vary\":\"theta\",\"arm\":1},{\"vary\":\"theta\",\"arm\":2,"
                              "\"run\":1}],\"data\":{\"runs\":[{\"initial\":{\"theta\":[0.95,"
                              "0.55]},\"t\":[",
                              "0.4", "");
    for (int i = 0; i < ROWS; i++)
        at += sprintf(at, "%s%.12g", i ? "," : "", number(&one, "t", i, -1));
    at += sprintf(at, "],\"series\":[");
    for (int k = 1; k >= 0; k--) {
        at += sprintf(at, "{\"theta\":%d,\"sigma\":0.01,\"values\":[", k + 1);
        for (int i = 0; i < ROWS; i++)
            at += sprintf(at, "%s%.9g", i ? "," : "",
                          number(&one, "theta", i, k) + 0.01 * test_noise(&seed));
        at += sprintf(at, "]}%s", k ? "," : "");
    }
    at += sprintf(at, "]},{\"initial\":{\"theta\":[-0.6,0.9]},\"sigma\":0.01,\"csv\":\"");
    at = table(at, &other, ROWS / 2, 1, 1, "t,theta_1", &seed);
    sprintf(at, "\"}]}}");
    OWN(test_reply, free) reply = test_post(API_OP_FITS, body);
    CHECK_SAYING(reply.status == 200, "%s", reply.out.data);
    CHECK_TEXT(test_reply_text(&reply, "/status"), "converged");
    const double truth[] = {0.35, 0.004, 1, -0.7, 0.5};
    CHECK_INT(test_reply_count(&reply, "/unknowns"), 5);
    for (int j = 0; j < 5; j++)
        CHECK_SAYING(test_reply_off(&reply, j, truth[j]) < 4, "unknown %d: %g", j,
                     test_reply_off(&reply, j, truth[j]));
    CHECK_TEXT(test_reply_text(&reply, "/unknowns/1/name"), "damping of arm 1");
    CHECK_TEXT(test_reply_text(&reply, "/unknowns/3/name"), "theta of arm 1 in run 2");
    CHECK_TEXT(test_reply_text(&reply, "/unknowns/4/name"), "theta of arm 2 in run 1");
    CHECK(fabs(test_reply_number(&reply, "/chi_squared_per_degree") - 1) < 0.4);
    CHECK_INT((int)test_reply_number(&reply, "/degrees_of_freedom"), 2 * ROWS + ROWS / 2 - 5);
    CHECK_INT(test_reply_count(&reply, "/runs"), 2);
    CHECK_INT(test_reply_count(&reply, "/runs/0/residuals"), ROWS);
    CHECK_INT(test_reply_count(&reply, "/runs/0/residuals/0"), 2);
    CHECK_INT(test_reply_count(&reply, "/runs/1/residuals"), ROWS / 2);
    CHECK_INT(test_reply_count(&reply, "/runs/1/residuals/0"), 1);
    CHECK(test_reply_number(&reply, "/runs/0/follows_until") == 3);
    CHECK(test_reply_number(&reply, "/runs/1/follows_until") == 8);
    CHECK(test_reply_number(&reply, "/runs/1/request/times/start") == 5);
    CHECK(fabs(test_reply_number(&reply, "/runs/1/request/initial/phi/0") + 0.7 + M_PI / 2) < 0.1);
    // each residual is at the position of its measurement
    CHECK(fabs(test_reply_number(&reply, "/runs/0/residuals/9/1")) < 6);
}

/* degrees by the name of a column, and by a field */
TEST(fits_take_angles_of_tables_in_degrees) {
    static char body[BODY];
    static const char *const names[] = {"t,theta_1 (deg),theta_2 [\u00b0]", "t,theta_1,theta_2",
                                        "t,theta_1 (rad),theta_2"};
    OWN(test_reply, free) from = motion("1,0.5", 0, ROWS);
    for (int i = 0; i < 3; i++) {
        unsigned long long seed = 4;
        char *at = body + sprintf(body,
                                  "{\"pendulum\":{\"arms\":[" ARMS
                                  "]},\"unknowns\":[{\"vary\":\"length\",\"arm\":1}," REST
                                  "],\"data\":{\"sigma\":%s%s,\"csv\":\"",
                                  "0.4", ",\"damping\":0.004", i == 1 ? "0.572957795" : "0.01",
                                  i == 1 ? ",\"unit\":\"deg\"" : "");
        at = table(at, &from, ROWS, 2, i == 2 ? 1 : 180 / M_PI, names[i], &seed);
        sprintf(at, "\"}}");
        // the standard deviation is in the unit of each
        if (i == 0) memcpy(strstr(body, "0.01,\"csv"), "0.57", 4);
        OWN(test_reply, free) reply = test_post(API_OP_FITS, body);
        CHECK_SAYING(reply.status == 200, "%s", reply.out.data);
        CHECK_TEXT(test_reply_text(&reply, "/status"), "converged");
        CHECK_SAYING(test_reply_off(&reply, 0, 0.35) < 4, "%d", i);
        CHECK(fabs(test_reply_number(&reply, "/chi_squared_per_degree") - 1) < 0.4);
    }
}

#define ONE "{\"pendulum\":{\"length\":[1],\"mass\":[1],\"parent\":[0]},"
#define LENGTH "\"unknowns\":[{\"vary\":\"length\",\"arm\":1}]"
#define RUN "{\"t\":[0,1,2],\"series\":[{\"theta\":1,\"values\":[1,0,-1]}]}"

/* an amount that each run may use alone, but not both */
TEST(fits_count_the_memory_of_all_runs_together) {
    struct api_limits limits;
    api_limits_init(&limits);
    for (int enough = 0; enough < 2; enough++) {
        // the parsed runs, and the table of both with the memory to sort it
        limits.answer_bytes = 2 * 8 * 3 * 3 - 1 + enough * (1 + 8 * 6 * 3 + 6 * (32 + 4 + 8));
        OWN(test_reply, free) reply = test_post_as(
            API_OP_FITS, ONE LENGTH ",\"data\":{\"runs\":[" RUN "," RUN "]}}", NULL, &limits);
        CHECK_INT(reply.status, enough ? 200 : 422);
        CHECK(enough || test_reply_has_fault(&reply, "/data/runs/1", "take 144 bytes"));
    }
}

/* a drive and the air, kept in their places beside the new terms */
TEST(fits_look_for_terms_from_nothing) {
    OWN(test_reply, free) reply = test_post(
        API_OP_FITS,
        "{\"pendulum\":{\"length\":[1],\"mass\":[1],\"parent\":[0],\"drag_per_mass\":0.1,"
        "\"torque\":[{\"constant\":0.2,\"harmonics\":[{\"amplitude\":0.5,\"omega\":2}]}]},"
        "\"data\":{\"t\":[0,0.5,1,1.5],\"series\":[{\"theta\":1,\"values\":[1,0,-0.8,-0.1]}]},"
        "\"unknowns\":[{\"vary\":\"damping\",\"arm\":1},{\"vary\":\"torque_omega\",\"arm\":1,"
        "\"low\":1.9,\"high\":2.1}],\"iterations\":3}");
    CHECK_SAYING(reply.status == 200, "%s", reply.out.data);
    CHECK(test_reply_number(&reply, "/request/pendulum/drag_per_mass") == 0.1);
    CHECK(test_reply_number(&reply, "/request/pendulum/arms/0/torque/constant") == 0.2);
    CHECK(test_reply_number(&reply, "/request/pendulum/arms/0/torque/harmonics/0/amplitude") ==
          0.5);
    double omega = test_reply_number(&reply, "/request/pendulum/arms/0/torque/harmonics/0/omega");
    CHECK(omega == test_reply_number(&reply, "/unknowns/1/value") && omega > 1.8 && omega < 2.2);
    CHECK(test_reply_number(&reply, "/unknowns/0/value") >= 0);
}

TEST(a_table_says_nothing_of_arms_of_a_pendulum_that_cannot_be_read) {
    static const char *const heads[] = {"t,theta", "t,theta_1", "t,x,y", "t,phi_9 (px),theta"};
    for (size_t i = 0; i < sizeof heads / sizeof *heads; i++) {
        char body[300];
        snprintf(body, sizeof body,
                 "{\"pendulum\":{},\"data\":{\"csv\":\"%s\\n0,1,2\\n\"},\"unknowns\":[{\"vary\":"
                 "\"gravity\"}]}",
                 heads[i]);
        OWN(test_reply, free) reply = test_post(API_OP_FITS, body);
        CHECK_INT(reply.status, 422);
        CHECK_TEXT(test_reply_text(&reply, "/errors/0/pointer"), "/pendulum");
        CHECK(!test_reply_text(&reply, "/errors/1/pointer"));
    }
}

/* decimal commas, an error for each angle, the last instant twice and a note at the end, as one
 * table */
TEST(fits_read_a_table_as_it_was_saved_and_say_what_they_took) {
    OWN(test_reply, free) reply =
        test_post(API_OP_FITS, ONE LENGTH
                  ",\"data\":{\"csv\":\"Zeit (s);Winkel (\\u00b0);sigma;Bild\\n0,0;10,0;0,5;1\\n"
                  "0,5;-0,1;0,5;2\\n1,0;-10,1;0,5;3\\n1,5;0,1;0,6;4\\n1,5;0,1;0,6;4\\nEnde\\n\"}}");
    CHECK_SAYING(reply.status == 200, "%s", reply.out.data);
    CHECK_INT((int)test_reply_number(&reply, "/tables/0/rows"), 4);
    CHECK_INT((int)test_reply_number(&reply, "/tables/0/repeated"), 1);
    CHECK_INT((int)test_reply_number(&reply, "/tables/0/passed_over"), 1);
    CHECK_TEXT(test_reply_text(&reply, "/tables/0/columns/0/is"), "t");
    CHECK_TEXT(test_reply_text(&reply, "/tables/0/columns/1/is"), "theta 1");
    CHECK_TEXT(test_reply_text(&reply, "/tables/0/columns/2/is"), "sigma theta 1");
    CHECK_TEXT(test_reply_text(&reply, "/tables/0/columns/3/is"), "");
    // with errors of half a degree chi-squared is known
    CHECK(test_reply_number(&reply, "/chi_squared") < 10);
    CHECK_INT(test_reply_count(&reply, "/residuals"), 4);
    CHECK_TEXT(test_reply_text(&reply, "/model"), "accepted");
    test_reply_free(&reply);
    // if each arm has a line of its own, two rows of one instant are two measurements
    reply = test_post(API_OP_FITS,
                      "{\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1]}," LENGTH
                      ",\"initial\":{\"theta\":[0.1,0.1]},\"data\":{\"csv\":\"t;theta_1;theta_2\\n"
                      "0;1,234;\\n0;;1,234\\n1;-1,234;\\n1;;1,234\\n\"}}");
    CHECK_INT((int)test_reply_number(&reply, "/tables/0/rows"), 4);
    const char *why = test_reply_text(&reply, "/tables/0/suggestions/0");
    CHECK(why && strstr(why, "decimal mark"));
}

/* series of both arms from instruments without a zero of their own: an angle with another zero, a
 * gyroscope with a bias, an angle between the arms */
static void instruments(char *body, const struct test_reply *from, const char *data, int gyro,
                        int joint, const char *unknowns) {
    unsigned long long seed = 9;
    char *at = body + sprintf(body,
                              "{\"pendulum\":{\"arms\":[" ARMS "]},\"unknowns\":[{\"vary\":"
                              "\"length\",\"arm\":1}%s],\"data\":{\"sigma\":0.01,\"csv\":\"%s",
                              "0.37", ",\"damping\":0.004", unknowns, data);
    for (int i = 0; i < ROWS; i++) {
        double one = number(from, gyro ? "phid" : "theta", i, 0), two = number(from, "theta", i, 1);
        at += sprintf(at, "\\n%.12g,%.9g,%.9g", number(from, "t", i, -1),
                      one + (gyro ? -0.2 : 1.3) + 0.01 * test_noise(&seed),
                      two - (joint ? number(from, "theta", i, 0) : 0) + 0.01 * test_noise(&seed));
    }
    sprintf(at, "\\n\"}}");
}

TEST(fits_find_zeros_and_biases_from_angles_rates_and_angles_between_arms) {
    static char body[BODY];
    static const struct {
        const char *data, *unknowns, *name;
        int gyro, joint;
        double truth;
    } tried[] = {
        {"t,theta_1,theta_2", ",{\"vary\":\"zero\",\"arm\":1}", "zero of arm 1", 0, 0, 1.3},
        {"t,gyro_1 (rad/s),theta_2", ",{\"vary\":\"bias\",\"arm\":1}", "bias of arm 1", 1, 0, -0.2},
        {"t,theta_1,joint_2", ",{\"vary\":\"zero\",\"arm\":1}", "zero of arm 1", 0, 1, 1.3},
    };
    struct test_reply from =
        test_post(API_OP_TRAJECTORIES,
                  "{\"pendulum\":{\"arms\":[{\"name\":\"a\",\"length\":0.35,\"mass\":0.3,"
                  "\"damping\":0.004},{\"parent\":\"a\",\"length\":0.28,\"mass\":0.2}]},"
                  "\"initial\":{\"theta\":[0.6,0.3]},\"times\":{\"start\":0,\"stop\":3,"
                  "\"count\":60},\"output\":[\"theta\",\"phid\"]}");
    CHECK_INT(from.status, 200);
    for (size_t i = 0; i < sizeof tried / sizeof *tried; i++) {
        instruments(body, &from, tried[i].data, tried[i].gyro, tried[i].joint, tried[i].unknowns);
        OWN(test_reply, free) reply = test_post(API_OP_FITS, body);
        CHECK_SAYING(reply.status == 200, "%s", reply.out.data);
        CHECK_TEXT(test_reply_text(&reply, "/status"), "converged");
        CHECK_TEXT(test_reply_text(&reply, "/model"), "accepted");
        CHECK_TEXT(test_reply_text(&reply, "/unknowns/1/name"), tried[i].name);
        CHECK_SAYING(test_reply_off(&reply, 0, 0.35) < 4 &&
                         test_reply_off(&reply, 1, tried[i].truth) < 4,
                     "%zu: %g and %g errors off", i, test_reply_off(&reply, 0, 0.35),
                     test_reply_off(&reply, 1, tried[i].truth));
        CHECK(test_reply_number(&reply, "/unknowns/1/error") < 0.02);
    }
    test_reply_free(&from);
    CHECK_REFUSED(API_OP_FITS,
                  ONE "\"unknowns\":[{\"vary\":\"bias\",\"arm\":1}],\"data\":{\"t\":[0,1],"
                      "\"series\":[{\"theta\":1,\"values\":[1,2]}]}}",
                  "/unknowns/0/vary", "angular velocities");
}

/* pixels below a pivot at 300, 200, with y downwards; a gyroscope alone */
TEST(fits_turn_y_over_and_begin_with_rates_alone) {
    static char body[BODY];
    OWN(test_reply, free) from =
        test_post(API_OP_TRAJECTORIES,
                  "{\"pendulum\":{\"length\":[0.5],\"mass\":[1],\"parent\":[0],\"damping\":[0.02]},"
                  "\"initial\":{\"theta\":[0.8]},\"times\":{\"start\":0,\"stop\":6,\"count\":90},"
                  "\"output\":[\"z\",\"phid\"]}");
    CHECK_INT(from.status, 200);
    for (int gyro = 0; gyro < 2; gyro++) {
        unsigned long long seed = 2;
        char *at = body + sprintf(body,
                                  "{\"pendulum\":{\"length\":[0.4],\"mass\":[1],\"parent\":[0],"
                                  "\"damping\":[0.01]},%s\"unknowns\":[{\"vary\":\"length\","
                                  "\"arm\":1},{\"vary\":\"damping\",\"arm\":1}],\"data\":{%s"
                                  "\"csv\":\"%s",
                                  gyro ? ""
                                       : "\"camera\":{\"scale\":900,\"down\":true,\"unknown\":["
                                         "\"origin\"]},",
                                  gyro ? "" : "\"sigma\":1,", gyro ? "t,Gyro z (rad/s)" : "t,x,y");
        for (int i = 0; i < 90; i++) {
            at += sprintf(at, "\\n%.12g", number(&from, "t", i, -1));
            if (gyro)
                at += sprintf(at, ",%.9g", number(&from, "phid", i, 0) + 0.02 * test_noise(&seed));
            else
                at += sprintf(at, ",%.4f,%.4f",
                              300 + 900 * number(&from, "z/re", i, 0) + test_noise(&seed),
                              200 - 900 * number(&from, "z/im", i, 0) + test_noise(&seed));
        }
        sprintf(at, "\\n\"}}");
        OWN(test_reply, free) reply = test_post(API_OP_FITS, body);
        CHECK_SAYING(reply.status == 200, "%s", reply.out.data);
        CHECK_TEXT(test_reply_text(&reply, "/status"), "converged");
        CHECK_SAYING(test_reply_off(&reply, 0, 0.5) < 4 && test_reply_off(&reply, 1, 0.02) < 4,
                     "%d: %g, %g", gyro, test_reply_off(&reply, 0, 0.5),
                     test_reply_off(&reply, 1, 0.02));
        CHECK(test_reply_number(&reply, "/unknowns/0/error") < 0.01);
    }
}
