/* Tests of one run of a fit: accelerometers, light gates, amplitudes, periods, carts, cameras.
 * Leaves to others: angles, positions and rates (test_op_fits, test_fits_data).
 * Invariant: measurements come from trajectories of this program, with noise of fixed seeds. */
#include <complex.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tests/api/post.h"
#include "tests/harness/test.h"

enum { ROWS = 121, BODY = 60000 };

static double number(const struct test_reply *reply, const char *before, int i, const char *after) {
    char pointer[60];
    snprintf(pointer, sizeof pointer, "%s%d%s", before, i, after);
    return test_reply_number(reply, pointer);
}

/* the error of the unknown with this name in standard errors; infinite if there is none */
static double off(const struct test_reply *reply, const char *name, double truth) {
    for (int j = 0; j < test_reply_count(reply, "/unknowns"); j++) {
        char pointer[40];
        snprintf(pointer, sizeof pointer, "/unknowns/%d/name", j);
        if (!strcmp(test_reply_text(reply, pointer), name)) return test_reply_off(reply, j, truth);
    }
    return INFINITY;
}

static char *list(char *at, const double value[], int count) {
    for (int i = 0; i < count; i++) at += sprintf(at, "%s%.10g", i ? "," : "[", value[i]);
    return at + sprintf(at, "]");
}

#define ONE "{\"pendulum\":{\"length\":[0.5],\"mass\":[1],\"parent\":[0],\"damping\":[0.02]},"
#define SOUGHT "\"unknowns\":[{\"vary\":\"length\",\"arm\":1},{\"vary\":\"damping\",\"arm\":1}"

/* checks length and damping of a fit to one or two series */
static struct test_reply fitted(const char *request, const double t[], int rows,
                                const char *series[2], double *value[2]) {
    static char body[BODY];
    char *at = body + sprintf(body, "%s,\"data\":{\"t\":", request);
    at = list(at, t, rows);
    at += sprintf(at, ",\"series\":[");
    for (int s = 0; s < 2 && series[s]; s++) {
        at += sprintf(at, "%s{%s", s ? "," : "", series[s]);
        if (value[s]) at = list(at + sprintf(at, ",\"values\":"), value[s], rows);
        at += sprintf(at, "}");
    }
    sprintf(at, "]}}");
    struct test_reply reply = test_post(API_OP_FITS, body);
    CHECK_SAYING(reply.status == 200, "%s: %s", series[0], reply.out.data);
    CHECK_TEXT(test_reply_text(&reply, "/status"), "converged");
    CHECK_TEXT(test_reply_text(&reply, "/model"), "accepted");
    int cart = strstr(request, "cart") != NULL;
    CHECK_SAYING(off(&reply, "length of arm 1", cart ? 0.4 : 0.5) < 4 &&
                     off(&reply, "damping of arm 1", cart ? 0.002 : 0.02) < 4,
                 "%s: %s", series[0], reply.out.data);
    return reply;
}

#define GUESS "{\"pendulum\":{\"length\":[0.45],\"mass\":[1],\"parent\":[0]},"

/* an accelerometer 0.4 m from the pivot, with a constant error; one without gravity and a
 * gyroscope; a gyroscope with a late clock */
TEST(fits_take_accelerations_and_gyroscopes_of_a_phone) {
    double t[ROWS], along[ROWS], across[ROWS], bare[ROWS], gyro[ROWS];
    unsigned long long seed = 3;
    OWN(test_reply, free) from = test_post(
        API_OP_TRAJECTORIES, ONE "\"initial\":{\"theta\":[0.6]},\"times\":{\"stop\":6,"
                                 "\"count\":121},\"output\":[\"theta\",\"phid\",\"phidd\"]}");
    for (int i = 0; i < ROWS; i++) {
        double theta = number(&from, "/theta/", i, "/0"), rate = number(&from, "/phid/", i, "/0");
        t[i] = number(&from, "/t/", i, "");
        bare[i] = -0.4 * rate * rate + 0.05 * test_noise(&seed);
        along[i] = bare[i] - 9.81 * cos(theta) + 0.3;
        across[i] =
            0.4 * number(&from, "/phidd/", i, "/0") + 9.81 * sin(theta) + 0.05 * test_noise(&seed);
        gyro[i] = rate + 0.02 * test_noise(&seed);
    }
    OWN(test_reply, free) reply =
        fitted(GUESS SOUGHT ",{\"vary\":\"bias_along\",\"arm\":1}]", t, ROWS,
               (const char *[2]){"\"along\":1,\"at\":0.4,\"sigma\":0.05",
                                 "\"across\":1,\"at\":0.4,\"sigma\":0.05"},
               (double *[2]){along, across});
    CHECK(off(&reply, "bias_along of arm 1", 0.3) < 4);
    test_reply_free(&reply);
    reply = fitted(GUESS SOUGHT "]", t, ROWS,
                   (const char *[2]){"\"along\":1,\"at\":0.4,\"gravity\":false", "\"thetad\":1"},
                   (double *[2]){bare, gyro});
    test_reply_free(&reply);
    for (int i = 0; i < ROWS; i++) t[i] += 0.1;
    reply = fitted(
        GUESS
        "\"initial\":{\"theta\":[0.6]},\"start\":0,\"camera\":{\"unknown\":[\"shift\"]}," SOUGHT
        "]",
        t, ROWS, (const char *[2]){"\"thetad\":1", NULL}, (double *[2]){gyro, NULL});
    CHECK(off(&reply, "length of arm 1", 0.5) < 4 && off(&reply, "shift of the camera", -0.1) < 4);
}

/* the instants of a light gate, amplitudes read from a scale, and a stopwatch */
TEST(fits_take_passages_amplitudes_and_periods) {
    double t[ROWS], turn[ROWS], wide[ROWS], period[ROWS];
    unsigned long long seed = 8;
    OWN(test_reply, free) gate = test_post(
        API_OP_TRAJECTORIES, ONE "\"initial\":{\"theta\":[1]},\"times\":{\"stop\":40,\"count\":2},"
                                 "\"events\":[{\"of\":\"theta\",\"arm\":1,\"value\":0}]}");
    int count = test_reply_count(&gate, "/events");
    REQUIRE(count > 40 && count < ROWS);
    for (int i = 0; i < count; i++)
        t[i] = number(&gate, "/events/", i, "/t") + 1e-3 * test_noise(&seed);
    OWN(test_reply, free) reply = fitted(
        GUESS
        "\"initial\":{\"theta\":[1]},\"start\":0,\"fixed\":[{\"vary\":\"theta\",\"arm\":1}]," SOUGHT
        "]",
        t, count, (const char *[2]){"\"passes\":1,\"sigma\":0.001", NULL},
        (double *[2]){NULL, NULL});
    CHECK(number(&reply, "/unknowns/", 0, "/error") < 1e-3);
    test_reply_free(&reply);
    OWN(test_reply, free) top = test_post(
        API_OP_TRAJECTORIES, ONE "\"initial\":{\"theta\":[1]},\"times\":{\"stop\":40,\"count\":2},"
                                 "\"events\":[{\"of\":\"thetad\",\"arm\":1,\"value\":0}]}");
    count = test_reply_count(&top, "/events") - 2;
    for (int i = 0; i < count; i++) {
        turn[i] = number(&top, "/events/", i + 1, "/t");
        period[i] = number(&top, "/events/", i + 2, "/t") - number(&top, "/events/", i, "/t") +
                    1e-3 * test_noise(&seed);
        wide[i] = fabs(number(&top, "/events/", i + 1, "/phi/0") + M_PI / 2) * 180 / M_PI +
                  0.2 * test_noise(&seed);
    }
    reply = fitted(GUESS SOUGHT "]", turn, count,
                   (const char *[2]){"\"period\":1", "\"amplitude\":1,\"unit\":\"deg\""},
                   (double *[2]){period, wide});
    CHECK_TEXT(test_reply_text(&reply, "/freed/0"), "theta of arm 1");
    CHECK_INT(test_reply_count(&reply, "/freed"), 1);
}

/* a cart that a measured force drives */
TEST(fits_find_a_cart_that_a_measured_force_drives) {
    static char body[BODY], force[4000];
    double t[ROWS], angle[ROWS], place[ROWS];
    unsigned long long seed = 4;
    char *at = force + sprintf(force, "\"force\":{\"table\":{\"hold\":\"linear\",\"t\":[0");
    for (int i = 1; i <= 60; i++) at += sprintf(at, ",%g", 0.1 * i);
    at += sprintf(at, "],\"value\":[0");
    for (int i = 1; i <= 60; i++) at += sprintf(at, ",%.6g", 2 * sin(0.3 * i) + sin(0.71 * i));
    sprintf(at, "]}}");
    snprintf(body, sizeof body,
             "{\"pendulum\":{\"arms\":[{\"length\":0.4,\"mass\":0.2,\"damping\":0.002}],\"pivot\":{"
             "\"cart\":{\"mass\":1,\"damping\":0.3,%s}}},\"initial\":{\"theta\":[0.3]},\"times\":{"
             "\"stop\":6,\"count\":121},\"output\":[\"theta\",\"cart\"]}",
             force);
    OWN(test_reply, free) from = test_post(API_OP_TRAJECTORIES, body);
    for (int i = 0; i < ROWS; i++) {
        t[i] = number(&from, "/t/", i, "");
        angle[i] = number(&from, "/theta/", i, "/0") + 0.005 * test_noise(&seed);
        place[i] = number(&from, "/cart/x/", i, "") + 0.002 * test_noise(&seed);
    }
    snprintf(
        body, sizeof body,
        "{\"pendulum\":{\"arms\":[{\"length\":0.45,\"mass\":0.2,\"damping\":0.001}],\"pivot\":{"
        "\"cart\":{\"mass\":0.8,\"damping\":0.2,%s}}}," SOUGHT
        ",{\"vary\":\"mass\",\"arm\":\"cart\"},{\"vary\":\"damping\",\"arm\":\"cart\"}]",
        force);
    static char request[BODY];
    memcpy(request, body, sizeof request);
    OWN(test_reply, free) reply =
        fitted(request, t, ROWS, (const char *[2]){"\"theta\":1", "\"cart\":true"},
               (double *[2]){angle, place});
    CHECK(off(&reply, "mass of the cart", 1) < 4 && off(&reply, "damping of the cart", 0.3) < 4);
    CHECK(off(&reply, "phi of the cart", 0) < 4 && off(&reply, "phid of the cart", 0) < 4);
    CHECK(fabs(test_reply_number(&reply, "/request/initial/cart/x")) < 0.01);
    CHECK(fabs(test_reply_number(&reply, "/request/pendulum/pivot/cart/mass") - 1) < 0.02);
}

/* a tip seen by a camera with tilt, stretch and lens distortion */
TEST(fits_find_tilt_stretch_and_distortion_of_a_camera) {
    static const struct {
        const char *unknown, *name;
        double tilt[2], stretch, bent, truth;
    } tried[] = {{"tilt", "tilt y of the camera", {0.08, -0.1}, 0, 0, -0.1},
                 {"stretch", "stretch of the camera", {0, 0}, 0.05, 0, 0.05},
                 {"distortion", "distortion of the camera", {0, 0}, 0, -0.05, -0.05}};
    double t[ROWS], x[ROWS], y[ROWS];
    OWN(test_reply, free) from = test_post(
        API_OP_TRAJECTORIES,
        ONE "\"initial\":{\"theta\":[1]},\"times\":{\"stop\":6,\"count\":121},\"output\":[\"z\"]}");
    for (size_t k = 0; k < sizeof tried / sizeof *tried; k++) {
        unsigned long long seed = 6;
        char request[400];
        for (int i = 0; i < ROWS; i++) {
            double re = number(&from, "/z/re/", i, "/0");
            double up = (1 + tried[k].stretch) * number(&from, "/z/im/", i, "/0");
            double near = 1 + tried[k].tilt[0] * re + tried[k].tilt[1] * up;
            double complex d = 300 + I * 200 + 800 * cexp(I * 0.05) * (re + I * up) / near - 350;
            // distorted by that fraction at 350 from the center
            d *= 1 + tried[k].bent * pow(cabs(d) / 350, 2);
            t[i] = number(&from, "/t/", i, "");
            x[i] = 350 + creal(d) + 0.3 * test_noise(&seed),
            y[i] = cimag(d) + 0.3 * test_noise(&seed);
        }
        snprintf(request, sizeof request,
                 GUESS
                 "\"camera\":{\"scale\":800,\"origin\":[300,190],\"center\":[350,0],\"unknown\":["
                 "\"rotation\",\"origin\",\"%s\"]}," SOUGHT "]",
                 tried[k].unknown);
        OWN(test_reply, free) reply =
            fitted(request, t, ROWS, (const char *[2]){"\"x\":1", "\"y\":1"}, (double *[2]){x, y});
        double by =
            tried[k].bent == 0 ? 1 : pow(test_reply_number(&reply, "/camera/reach") / 350, 2);
        CHECK_SAYING(off(&reply, tried[k].name, by * tried[k].truth) < 4, "%s: %s", tried[k].name,
                     reply.out.data);
    }
}

/* a film and a gyroscope that began 3 s earlier or later, which is two swings; what no clock can
 * tell */
TEST(shifts_of_clocks_are_found_with_their_errors) {
    static const char *const film_and_gyro[2] = {"\"theta\":1,\"sigma\":0.01",
                                                 "\"thetad\":1,\"sigma\":0.02"};
    static const char *const refused[][2] = {
        {"{\"vary\":\"shift\"}", "missing"},
        {"{\"vary\":\"shift\",\"series\":3}", "must be a whole number from 1 to 2"},
        {"{\"vary\":\"shift\",\"series\":[2,2]}", "has a shift already"},
        {"{\"vary\":\"shift\",\"series\":1,\"arm\":1}", "is not a known field"}};
    double t[ROWS], film[ROWS], gyro[ROWS], *value[2] = {film, gyro};
    struct test_reply from =
        test_post(API_OP_TRAJECTORIES, ONE "\"initial\":{\"theta\":[0.6]},\"times\":{\"stop\":12,"
                                           "\"count\":241},\"output\":[\"theta\",\"phid\"]}");
    for (int first = 0; first <= 120; first += 120) {
        unsigned long long seed = 5;
        for (int i = 0; i < ROWS; i++) {
            t[i] = number(&from, "/t/", i, "");
            film[i] = number(&from, "/theta/", 60 + i, "/0") + 0.01 * test_noise(&seed);
            gyro[i] = number(&from, "/phid/", first + i, "/0") + 0.02 * test_noise(&seed);
        }
        struct test_reply reply = fitted(GUESS SOUGHT ",{\"vary\":\"shift\",\"series\":2}]", t,
                                         ROWS, (const char **)film_and_gyro, value);
        CHECK_SAYING(off(&reply, "shift of series 2", 0.05 * (first - 60)) < 4, "%s",
                     reply.out.data);
        CHECK_INT(test_reply_count(&reply, "/unidentifiable"), 0);
        CHECK(!strstr(reply.out.data, "may be"));
        test_reply_free(&reply);
    }
    struct test_reply both = fitted(GUESS SOUGHT ",{\"vary\":\"shift\",\"series\":1},"
                                                 "{\"vary\":\"shift\",\"series\":2}]",
                                    t, ROWS, (const char **)film_and_gyro, value);
    CHECK(strstr(test_reply_text(&both, "/unidentifiable/0"), "shift of series 1") != NULL);
    test_reply_free(&both);
    // a rough gyroscope does not tell which of the swings it sees
    unsigned long long seed = 9;
    for (int i = 0; i < ROWS; i++)
        gyro[i] = number(&from, "/phid/", 60 + i, "/0") + 0.4 * test_noise(&seed);
    struct test_reply rough =
        fitted(GUESS SOUGHT ",{\"vary\":\"shift\",\"series\":2}]", t, ROWS,
               (const char *[2]){film_and_gyro[0], "\"thetad\":1,\"sigma\":0.4"}, value);
    CHECK(strstr(test_reply_text(&rough, "/hints/0"), "shift of series 2 may be") != NULL);
    test_reply_free(&rough);
    for (size_t i = 0; i < sizeof refused / sizeof *refused; i++) {
        char body[600];
        snprintf(body, sizeof body,
                 GUESS
                 "\"data\":{\"t\":[0,1],\"series\":[{\"theta\":1,\"values\":[0,1]},{\"thetad\":1,"
                 "\"values\":[0,1]}]},\"unknowns\":[%s]}",
                 refused[i][0]);
        struct test_reply reply = test_post(API_OP_FITS, body);
        CHECK_SAYING(reply.status == 422 && strstr(reply.out.data, refused[i][1]), "%s: %s",
                     refused[i][0], reply.out.data);
        test_reply_free(&reply);
    }
    test_reply_free(&from);
}
