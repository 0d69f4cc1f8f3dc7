/* Tests of the hints for a wrong request of a fit: data in other units, with another zero, of other
 * arms, with wrong fixed numbers.
 * Leaves to others: correct requests (test_op_fits), the statistics (core/fit/test_fit_verdict).
 * Invariant: measurements come from a trajectory of this program, with noise of a fixed seed. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tests/api/post.h"
#include "tests/harness/test.h"

enum { ROWS = 121, BODY = 20000 };

/* the measured quantity: of one arm, or of two; the angle between these; a rate; an angle whose
 * first value is missing */
enum from { FIRST, SECOND, X, Y, BETWEEN, RATE, LOST };

#define ONE "\"pendulum\":{\"length\":[0.75],\"mass\":[1],\"parent\":[0]}"
#define HELD "\"pendulum\":{\"length\":[0.7],\"mass\":[1],\"parent\":[0]}"
#define TWO "\"pendulum\":{\"length\":[0.4,0.28],\"mass\":[0.3,0.2],\"parent\":[0,1]}"
#define START "{\"vary\":\"theta\",\"arm\":1},{\"vary\":\"thetad\",\"arm\":1}"
#define FRICTION "{\"vary\":\"damping\",\"arm\":1}," START
#define ALL ",\"unknowns\":[{\"vary\":\"length\",\"arm\":1}," FRICTION
#define BOTH ALL ",{\"vary\":\"theta\",\"arm\":2},{\"vary\":\"thetad\",\"arm\":2}]"
#define AWAY ",\"initial\":{\"theta\":[1.1]}"
#define CAMERA                                                                                     \
    AWAY ",\"camera\":{\"scale\":480,\"origin\":[290,190],\"unknown\":[\"scale\",\"rotation\","    \
         "\"origin\"]}"
#define DRY "\"friction\":{\"torque\":0.3,\"speed\":0.05}"

static const struct row {
    const char *request;
    struct {
        const char *name;
        enum from from;
        double by, plus;
    } series[2];
    int arms;
    double late, apart; /* factor of the instants */
    const char *verdict, *says;
} rows[] = {
    // correct
    {ONE ALL "]", {{"\"theta\":1", FIRST, 1, 0}}, 1, 0, 1, "converged accepted", "\"hints\":[]"},
    {TWO BOTH,
     {{"\"theta\":1", FIRST, 1, 0}, {"\"theta\":2", SECOND, 1, 0}},
     2,
     0,
     1,
     "converged accepted",
     "\"hints\":[]"},
    {HELD CAMERA ",\"unknowns\":[" FRICTION "]",
     {{"\"x\":1", X, 500, 300}, {"\"y\":1", Y, 500, 200}},
     1,
     0,
     1,
     "converged accepted",
     "\"hints\":[]"},
    // angles
    {ONE ALL "]", {{"\"theta\":1", FIRST, 57.29578, 0}}, 1, 0, 1, "", "are they in degrees? Then"},
    {ONE ALL "]",
     {{"\"theta\":1,\"unit\":\"deg\"", FIRST, 1, 0}},
     1,
     0,
     1,
     "converged rejected",
     "are they in rad, not degrees? Then"},
    {ONE ALL "]",
     {{"\"phi\":1", FIRST, 1, 0}},
     1,
     0,
     1,
     "",
     "are they theta instead of phi? They swing about 9"},
    {ONE ALL "]",
     {{"\"theta\":1,\"unit\":\"deg\"", FIRST, 57.29578, 89.7}},
     1,
     0,
     1,
     "",
     "They swing about 89."},
    {ONE ALL "]",
     {{"\"theta\":1", FIRST, 1, 0.08}},
     1,
     0,
     1,
     "converged rejected",
     "They swing about 4."},
    {TWO BOTH,
     {{"\"theta\":1", SECOND, 1, 0}, {"\"theta\":2", FIRST, 1, 0}},
     2,
     0,
     1,
     "converged rejected",
     "with arms 1 and 2 exchanged"},
    {TWO BOTH,
     {{"\"theta\":1", FIRST, 1, 0}, {"\"theta\":2", BETWEEN, 1, 0}},
     2,
     0,
     1,
     "converged rejected",
     "angles from the parent arm (\\\"joint\\\") instead of from the vertical"},
    {TWO BOTH,
     {{"\"theta\":1", FIRST, 1, 0}, {"\"joint\":2", SECOND, 1, 0}},
     2,
     0,
     1,
     "converged rejected",
     "angles from the vertical instead of from the parent arm"},
    {ONE ALL "]",
     {{"\"theta\":1", RATE, 1, 0}},
     1,
     0,
     1,
     "",
     "with angular velocities instead of angles"},
    {ONE ",\"initial\":{\"theta\":[1.2]},\"unknowns\":[{\"vary\":\"length\",\"arm\":1},{\"vary\":"
         "\"damping\",\"arm\":1}]",
     {{"\"theta\":1", FIRST, -1, 0}},
     1,
     0,
     1,
     "converged rejected",
     "with angles counted the other way round"},
    // single measurements
    {ONE ALL "]",
     {{"\"theta\":1", LOST, 1, 0}},
     1,
     0,
     1,
     "converged accepted",
     "the farthest in row 1:"},
    // positions
    {ONE ALL "]" AWAY,
     {{"\"x\":1", X, 1, 0}, {"\"y\":1", Y, -1, 0}},
     1,
     0,
     1,
     "",
     "with y upwards instead of downwards"},
    {ONE ALL "]" AWAY,
     {{"\"x\":1", Y, 1, 0}, {"\"y\":1", X, 1, 0}},
     1,
     0,
     1,
     "",
     "with x and y exchanged"},
    {ONE ALL "]" AWAY,
     {{"\"x\":1", X, 100, 0}, {"\"y\":1", Y, 100, 0}},
     1,
     0,
     1,
     "",
     "with scale of the camera as another unknown, here "},
    {HELD ",\"unknowns\":[" FRICTION "]" AWAY,
     {{"\"x\":1", X, 480, 0}, {"\"y\":1", Y, 480, 0}},
     1,
     0,
     1,
     "converged rejected",
     "with scale of the camera as another unknown, here 4"},
    {HELD CAMERA ",\"unknowns\":[" FRICTION "]",
     {{"\"x\":1", X, 500, 300}, {"\"y\":1", Y, 450, 200}},
     1,
     0,
     1,
     "converged rejected",
     "with stretch of the camera as another unknown, here -0.09"},
    // fixed numbers
    {"\"pendulum\":{\"length\":[0.7],\"mass\":[1],\"parent\":[0],\"gravity\":1.62},\"unknowns\":"
     "[" FRICTION "]",
     {{"\"theta\":1", FIRST, 1, 0}},
     1,
     0,
     1,
     "converged rejected",
     "with gravity as another unknown, here 9.8"},
    {"\"pendulum\":{\"length\":[0.35,0.28],\"mass\":[0.2,0.3],\"parent\":[0,1],\"damping\":[0.002,"
     "0]}" BOTH,
     {{"\"theta\":1", FIRST, 1, 0}, {"\"theta\":2", SECOND, 1, 0}},
     2,
     0,
     1,
     "converged rejected",
     "with mass of arm "},
    // friction, another motion
    {ONE ALL "]",
     {{"\"theta\":1", FIRST, 1, 0}},
     3,
     0,
     1,
     "converged rejected",
     "is the friction of another kind"},
    {ONE ALL "]", {{"\"theta\":1", SECOND, 1.6, 0}}, 2, 0, 1, "converged rejected", "\"hints\":[]"},
    // instants
    {ONE ALL "]",
     {{"\"theta\":1", FIRST, 1, 0}},
     1,
     0,
     1000,
     "",
     "are they in ms? They must be in s"},
    {ONE ALL "]", {{"\"theta\":1", FIRST, 1, 0}}, 1, 1764194430000., 1000, "", "are they in ms?"},
    {ONE ALL "]",
     {{"\"theta\":1", FIRST, 1, 0}},
     1,
     0,
     20,
     "converged accepted",
     "are instants in s, not in ms or frames"},
};

/* triangular noise of standard deviation 1 */
static struct test_reply motion(int arms) {
    static const char *const pendulum[] = {
        [1] = "\"arms\":[{\"length\":0.7,\"mass\":1,\"damping\":0.05}]},\"initial\":{\"theta\":[1."
              "2]}",
        [2] = "\"length\":[0.35,0.28],\"mass\":[0.3,0.2],\"parent\":[0,1],\"damping\":[0.002,0]},"
              "\"initial\":{\"theta\":[1,0.5]}",
        [3] = "\"arms\":[{\"length\":0.7,\"mass\":1," DRY "}]},\"initial\":{\"theta\":[1.2]}"};
    char body[400];
    snprintf(body, sizeof body,
             "{\"pendulum\":{%s,\"times\":{\"stop\":%d,\"count\":%d},\"output\":[\"theta\","
             "\"phid\",\"z\"]}",
             pendulum[arms], arms == 2 ? 3 : 6, ROWS);
    return test_post(API_OP_TRAJECTORIES, body);
}

static double measured(const struct test_reply *reply, enum from from, int i) {
    static const char *const names[] = {"theta", "theta", "z/re", "z/im", "", "phid", "theta"};
    char pointer[30];
    if (from == BETWEEN) return measured(reply, SECOND, i) - measured(reply, FIRST, i);
    if (from == LOST && i == 0) return 2.2;
    snprintf(pointer, sizeof pointer, "/%s/%d/%d", names[from], i, from == SECOND);
    return test_reply_number(reply, pointer);
}

static struct test_reply asked(const struct row *row, const struct test_reply *from) {
    static char body[BODY];
    unsigned long long seed = 5;
    char *at = body + sprintf(body, "{%s,\"data\":{\"t\":[", row->request);
    for (int i = 0; i < ROWS; i++)
        at += sprintf(at, "%s%.12g", i ? "," : "",
                      row->late + row->apart * (row->arms == 2 ? 0.025 : 0.05) * i);
    at += sprintf(at, "],\"series\":[");
    for (int s = 0; s < 2 && row->series[s].name; s++) {
        at += sprintf(at, "%s{%s,\"values\":[", s ? "," : "", row->series[s].name);
        for (int i = 0; i < ROWS; i++)
            at += sprintf(at, "%s%.9g", i ? "," : "",
                          row->series[s].by * (measured(from, row->series[s].from, i) +
                                               0.005 * test_noise(&seed)) +
                              row->series[s].plus);
        at += sprintf(at, "]}");
    }
    sprintf(at, "]}}");
    return test_post(API_OP_FITS, body);
}

TEST(wrong_requests_of_fits_are_told_what_helps) {
    struct test_reply from[4];
    for (int arms = 1; arms < 4; arms++) from[arms] = motion(arms);
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        OWN(test_reply, free) reply = asked(&rows[i], &from[rows[i].arms]);
        char verdict[40] = "";
        if (*rows[i].verdict)
            snprintf(verdict, sizeof verdict, "%s %s", test_reply_text(&reply, "/status"),
                     test_reply_text(&reply, "/model"));
        CHECK_TEXT(verdict, rows[i].verdict);
        CHECK_SAYING(strstr((const char *)reply.out.data, rows[i].says), "%zu: %s: %.9000s", i,
                     rows[i].says, (const char *)reply.out.data);
    }
    for (int arms = 1; arms < 4; arms++) test_reply_free(&from[arms]);
}

/* Both tips of bars, seen by a rotated camera, fitted as point masses with an upright camera: it
 * explains half of the variance at best, and no text says that the motion follows. */
TEST(fits_that_explain_half_do_not_follow) {
    static char body[BODY];
    OWN(test_reply, free) from = test_post(
        API_OP_TRAJECTORIES,
        "{\"pendulum\":{\"arms\":[{\"name\":\"a\",\"length\":0.1,\"mass\":0.01,\"rod\":1},{"
        "\"parent\":\"a\",\"length\":0.07,\"mass\":0.01,\"rod\":0.6}]},\"initial\":{\"theta\":[-3,"
        "-2.9]},\"times\":{\"stop\":1.2,\"count\":121},\"output\":[\"z\"]}");
    char *at =
        body + sprintf(body,
                       "{\"pendulum\":{\"length\":[0.1,0.07],\"mass\":[1,1],\"parent\":[0,1]},"
                       "\"initial\":{\"theta\":[-3,-2.9]},\"camera\":{\"scale\":3000,\"unknown\":["
                       "\"scale\",\"origin\"]},\"iterations\":60,\"data\":{\"t\":[0");
    for (int i = 1; i < ROWS; i++) at += sprintf(at, ",%g", 0.01 * i);
    at += sprintf(at, "],\"series\":[");
    for (int s = 0; s < 4; s++) {
        at += sprintf(at, "%s{\"%s\":%d,\"values\":[", s ? "," : "", s % 2 ? "y" : "x", s / 2 + 1);
        for (int i = 0; i < ROWS; i++) {
            char re[30], im[30];
            snprintf(re, sizeof re, "/z/re/%d/%d", i, s / 2);
            snprintf(im, sizeof im, "/z/im/%d/%d", i, s / 2);
            double x = test_reply_number(&from, re), y = test_reply_number(&from, im);
            at += sprintf(at, "%s%.5g", i ? "," : "",
                          3300 * (s % 2 ? 0.8 * x + 0.6 * y : 0.6 * -y + 0.8 * x));
        }
        at += sprintf(at, "]}");
    }
    sprintf(at, "]},\"unknowns\":[" START
                ",{\"vary\":\"theta\",\"arm\":2},{\"vary\":\"thetad\",\"arm\":2},{"
                "\"vary\":\"mass\",\"arm\":2}]}");
    OWN(test_reply, free) reply = test_post(API_OP_FITS, body);
    CHECK_INT(reply.status, 200);
    CHECK(test_reply_number(&reply, "/explained") < 0.9);
    CHECK(strcmp(test_reply_text(&reply, "/model"), "accepted") != 0);
    CHECK(strstr(test_reply_text(&reply, "/message"), "follows") == NULL);
    CHECK(isnan(test_reply_number(&reply, "/follows_until")));
    CHECK(isnan(test_reply_number(&reply, "/unknowns/4/error")));
}
