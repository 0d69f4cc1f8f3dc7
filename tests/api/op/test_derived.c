/* Tests of the field `derivatives`: in every representation, against differences of requests, as a
 * part of a job, and errors with their pointers.
 * Leaves to others: the derivatives themselves (core/derivatives/test_derivatives).
 * Invariant: requests are texts as clients send them. */
#include "api/op/derived.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tests/api/post.h"
#include "tests/harness/test.h"

#define MOTION                                                                                     \
    "\"initial\":{\"theta\":[1,1.5],\"thetad\":[0.5,-1]},\"times\":{\"stop\":2,\"count\":4},"      \
    "\"output\":[\"phi\",\"phidd\",\"theta\",\"z\",\"lambda\",\"energy\",\"tip_force\"]"
#define BY                                                                                         \
    "\"derivatives\":[{\"vary\":\"length\",\"arm\":2},{\"vary\":\"damping\",\"arm\":1},"           \
    "{\"vary\":\"gravity\"},{\"vary\":\"torque_omega\",\"arm\":1}]"

/* a double pendulum with a damper and a drive, and the parameters of the derivatives */
static void body_of(char body[1000], const double x[4], const char *more) {
    snprintf(
        body, 1000,
        "{\"pendulum\":{\"arms\":[{\"name\":\"a\",\"length\":1,\"mass\":1,\"damping\":%.17g,"
        "\"torque\":{\"harmonics\":[{\"amplitude\":0.5,\"omega\":%.17g}]}},"
        "{\"name\":\"b\",\"parent\":\"a\",\"length\":%.17g,\"mass\":2}],\"gravity\":%.17g}," MOTION
        "%s%s}",
        x[1], x[3], x[0], x[2], *more ? "," : "", more);
}

/* the number at name/i/k/j; -1 omits an index */
static double number_at(const struct test_reply *reply, const char *name, int i, int k, int j) {
    char pointer[80], *at = stpcpy(stpcpy(pointer, "/"), name);
    const int index[3] = {i, k, j};
    for (int a = 0; a < 3; a++)
        if (index[a] >= 0) at += snprintf(at, 8, "/%d", index[a]);
    return test_reply_number(reply, pointer);
}

TEST(derivatives_of_requests_are_differences_of_requests) {
    static const char *const values[] = {"phi",  "phidd",  "theta",
                                         "z/im", "lambda", "tip_force/across"};
    static const char *const slopes[] = {"derivatives/phi",    "derivatives/phidd",
                                         "derivatives/theta",  "derivatives/z_im",
                                         "derivatives/lambda", "derivatives/tip_force_across"};
    const double middle[4] = {1.5, 0.1, 9.81, 3}, h = 1e-5;
    char body[1000];
    double worst = 0;
    body_of(body, middle, BY);
    OWN(test_reply, free) reply = test_post(API_OP_TRAJECTORIES, body);
    CHECK_INT(reply.status, 200);
    for (int j = 0; j < 4; j++) {
        struct test_reply side[2];
        for (int s = 0; s < 2; s++) {
            double x[4];
            memcpy(x, middle, sizeof x);
            x[j] += s ? h : -h;
            body_of(body, x, "");
            side[s] = test_post(API_OP_TRAJECTORIES, body);
            CHECK_INT(side[s].status, 200);
        }
        for (int q = 0; q < 6; q++)
            for (int i = 0; i < 4; i++)
                for (int k = 0; k < 2; k++) {
                    double high = number_at(&side[1], values[q], i, k, -1);
                    double want = (high - number_at(&side[0], values[q], i, k, -1)) / (2 * h);
                    double gap = fabs(number_at(&reply, slopes[q], i, k, j) - want);
                    worst = fmax(worst, gap / fmax(fabs(want), fmax(fabs(high), 1)));
                }
        double high = test_reply_number(&side[1], "/energy/total/3");
        double want = (high - test_reply_number(&side[0], "/energy/total/3")) / (2 * h);
        double got = number_at(&reply, "derivatives/energy_total", 3, j, -1);
        worst = fmax(worst, fabs(got - want) / fmax(fabs(want), fabs(high)));
        for (int s = 0; s < 2; s++) test_reply_free(&side[s]);
    }
    CHECK_RESIDUAL(worst, 1e-7, "derivatives of requests");
}

TEST(derivatives_leave_the_motion_as_it_is) {
    const double x[4] = {1.5, 0.1, 9.81, 3};
    char body[1000];
    body_of(body, x, "");
    OWN(test_reply, free) plain = test_post(API_OP_TRAJECTORIES, body);
    body_of(body, x, BY);
    OWN(test_reply, free) reply = test_post(API_OP_TRAJECTORIES, body);
    for (int i = 0; i < 4; i++)
        for (int k = 0; k < 2; k++) {
            CHECK(number_at(&plain, "phi", i, k, -1) == number_at(&reply, "phi", i, k, -1));
            CHECK(number_at(&plain, "lambda", i, k, -1) == number_at(&reply, "lambda", i, k, -1));
        }
    CHECK_INT(test_reply_count(&reply, "/derivatives"), 11);
    CHECK_INT(test_reply_count(&reply, "/derivatives/phi/0/1"), 4);
}

#define DOUBLE "{\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1]},"
#define SHORT                                                                                      \
    DOUBLE "\"times\":[0,1],\"output\":[\"phi\",\"energy\"],\"derivatives\":[{\"vary\":"           \
           "\"gravity\"},{\"vary\":\"mass\",\"arm\":1},{\"vary\":\"mass\",\"arm\":2}]}"

TEST(derivatives_have_an_axis_in_every_representation) {
    static const struct {
        const char *accept, *text;
    } rows[] = {
        {"text/csv", "derivatives_phi_2_3,derivatives_energy_kinetic_1"},
        {"application/x-ndjson",
         "\"derivatives\":{\"phi\":[[0,0,0],[0,0,0]],\"energy_kinetic\":[0"},
        {"application/x-npz", "derivatives_phi.npy"},
        {"application/x-npz", "'shape': (2, 2, 3), }"},
        {"application/x-npz", "'shape': (2, 3), }"},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        OWN(test_reply, free) reply =
            test_post_as(API_OP_TRAJECTORIES, SHORT, rows[i].accept, NULL);
        CHECK_INT(reply.status, 200);
        CHECK_SAYING(memmem(reply.out.data, reply.out.bytes, rows[i].text, strlen(rows[i].text)),
                     "%s lacks %s", rows[i].accept, rows[i].text);
    }
    // by columns, the arms before the parameters: dimensions 2, 2, 3, then the numbers
    static const char sizes[] = {5, 0, 0, 0, 12, 0, 0, 0, 2, 0, 0, 0, 2, 0, 0, 0, 3, 0, 0, 0};
    OWN(test_reply, free) mat =
        test_post_as(API_OP_TRAJECTORIES, SHORT, "application/x-matlab-data", NULL);
    CHECK(memmem(mat.out.data, mat.out.bytes, sizes, sizeof sizes));
}

TEST(derivatives_of_forces_are_those_of_each_state) {
    static const char body[] =
        DOUBLE "\"states\":[{\"theta\":[1,2]},{\"theta\":[0.5,-1],\"thetad\":[1,2]}],"
               "\"derivatives\":[{\"vary\":\"theta\",\"arm\":1},{\"vary\":\"gravity\"}]}";
    OWN(test_reply, free) reply = test_post(API_OP_FORCES, body);
    CHECK_INT(reply.status, 200);
    CHECK_INT(test_reply_count(&reply, "/derivatives/zdd_re"), 2);
    // at rest accelerations are proportional to gravity
    for (int k = 0; k < 2; k++) {
        double slope = number_at(&reply, "derivatives/phidd", 0, k, 1);
        CHECK(fabs(slope * 9.81 - number_at(&reply, "phidd", 0, k, -1)) < 1e-13);
    }
    // dV/dtheta_1 = 2 m g l sin theta_1
    double slope = number_at(&reply, "derivatives/energy_potential", 1, 0, -1);
    CHECK(fabs(slope - 2 * 9.81 * sin(0.5)) < 1e-13);
}

/* two arms on a cart of this mass, on a rail of this direction, from this position */
static struct test_reply on_a_cart(enum api_op_id op, const double x[3], const char *more) {
    char body[1000];
    snprintf(
        body, sizeof body,
        "{\"pendulum\":{\"length\":[1,0.5],\"mass\":[1,2],\"parent\":[0,1],\"pivot\":{\"cart\":{"
        "\"mass\":%.17g,\"angle\":%.17g,\"stiffness\":20}}},\"%s\":{\"theta\":[1,-1],\"cart\":"
        "{\"x\":%.17g,\"v\":0.5}},%s}",
        x[0], x[1], op == API_OP_FORCES ? "state" : "initial", x[2], more);
    return test_post(op, body);
}

#define BY_CART                                                                                    \
    "\"derivatives\":[{\"vary\":\"mass\",\"arm\":\"cart\"},{\"vary\":\"cart_angle\"},"             \
    "{\"vary\":\"phi\",\"arm\":\"cart\"}]"

TEST(derivatives_on_a_cart_are_differences_of_requests) {
    static const struct {
        enum api_op_id op;
        const char *more, *value, *slope; /* whose numbers are text[/arm] */
    } rows[] = {
        {API_OP_TRAJECTORIES, "\"times\":[0,1],\"output\":[\"phi\",\"cart\",\"z\",\"energy\"]",
         "/phi/1/0", "/derivatives/phi/1/0"},
        {API_OP_TRAJECTORIES, "\"times\":[0,1],\"output\":[\"cart\"]", "/cart/x/1",
         "/derivatives/cart_x/1"},
        {API_OP_TRAJECTORIES, "\"times\":[0,1],\"output\":[\"cart\"]", "/cart/v/1",
         "/derivatives/cart_v/1"},
        {API_OP_TRAJECTORIES, "\"times\":[0,1],\"output\":[\"cart\"]", "/cart/reaction/1",
         "/derivatives/cart_reaction/1"},
        {API_OP_TRAJECTORIES, "\"times\":[0,1],\"output\":[\"z\"]", "/z/im/1/1",
         "/derivatives/z_im/1/1"},
        {API_OP_TRAJECTORIES, "\"times\":[0,1],\"output\":[\"energy\"]", "/energy/total/1",
         "/derivatives/energy_total/1"},
        {API_OP_FORCES, "\"time\":0", "/cart/acceleration", "/derivatives/cart_acceleration"},
        {API_OP_FORCES, "\"time\":0", "/zdd/re/1", "/derivatives/zdd_re/1"},
        {API_OP_FORCES, "\"time\":0", "/joint_force/across/0", "/derivatives/joint_force_across/0"},
    };
    const double middle[3] = {2, 0.2, 0.1}, h = 1e-5;
    double worst = 0;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        char more[300];
        snprintf(more, sizeof more, "%s," BY_CART, rows[i].more);
        OWN(test_reply, free) reply = on_a_cart(rows[i].op, middle, more);
        CHECK_SAYING(reply.status == 200, "%s", reply.out.data);
        for (int j = 0; j < 3; j++) {
            double side[2];
            char pointer[80];
            for (int s = 0; s < 2; s++) {
                double x[3] = {middle[0], middle[1], middle[2]};
                x[j] += s ? h : -h;
                OWN(test_reply, free) moved = on_a_cart(rows[i].op, x, rows[i].more);
                side[s] = test_reply_number(&moved, rows[i].value);
            }
            snprintf(pointer, sizeof pointer, "%s/%d", rows[i].slope, j);
            double want = (side[1] - side[0]) / (2 * h), got = test_reply_number(&reply, pointer);
            double gap = fabs(got - want) / fmax(1, fmax(fabs(want), fabs(side[0])));
            CHECK_SAYING(gap < 1e-8, "%s is %g, not %g", pointer, got, want);
            worst = fmax(worst, gap);
        }
    }
    CHECK(worst > 0);
}

TEST(derivatives_that_would_be_too_large_are_refused_before_they_run) {
    enum { MANY = 1000 };
    static char body[100000];
    char *at = body + sprintf(body, "{\"pendulum\":{\"length\":[1],\"mass\":[1],\"parent\":[0]},"
                                    "\"times\":{\"stop\":1,\"count\":1000000},\"derivatives\":[");
    for (int i = 0; i < MANY; i++) at += sprintf(at, "%s{\"vary\":\"gravity\"}", i ? "," : "");
    strcpy(at, "]}");
    OWN(test_reply, free) reply = test_post(API_OP_TRAJECTORIES, body);
    CHECK_INT(reply.status, 422);
    CHECK(test_reply_has_fault(&reply, "/times", "max-answer-bytes"));
}

/* eight derivatives of chains that hang at -1, -0.7 .. rad for 5 s, as in tests/bench/parts: the
 * shortest measured times, motion included */
TEST(derivatives_are_estimated_within_a_factor_of_four_of_what_was_measured) {
    static const struct {
        int arms;
        double seconds;
    } measured[] = {{1, 39e-6}, {2, 135e-6}, {3, 233e-6}, {4, 369e-6}, {8, 1.7e-3}, {16, 6.1e-3}};
    for (size_t i = 0; i < sizeof measured / sizeof *measured; i++) {
        double phi[16], rate[16] = {0};
        int n = measured[i].arms;
        char body[2000], *at = body + sprintf(body, "{\"pendulum\":{\"length\":[1");
        struct api_limits limits;
        OWN(api_call, free) *call;
        OWN(api_buffer, clear) out;
        api_limits_init(&limits);
        for (int k = 0; k < n; k++) phi[k] = -1 + 0.3 * k, rate[k] = 0.2;
        for (int k = 1; k < n; k++) at = stpcpy(at, ",1");
        at = stpcpy(at, "],\"mass\":[1");
        for (int k = 1; k < n; k++) at = stpcpy(at, ",1");
        at = stpcpy(at, "],\"parent\":[0");
        for (int k = 1; k < n; k++) at += sprintf(at, ",%d", k);
        at = stpcpy(at, "]},\"initial\":{\"phi\":[");
        for (int k = 0; k < n; k++) at += sprintf(at, "%s%.15g", k ? "," : "", phi[k]);
        at = stpcpy(at, "],\"phid\":[");
        for (int k = 0; k < n; k++) at += sprintf(at, "%s%.15g", k ? "," : "", rate[k]);
        at = stpcpy(at, "]},\"times\":[0,5],\"derivatives\":[");
        for (int k = 0; k < 8; k++)
            at += sprintf(at, "%s{\"vary\":\"phi\",\"arm\":%d}", k ? "," : "", k % n + 1);
        at = stpcpy(at, "]}");
        struct api_request request = {.op = API_OP_TRAJECTORIES,
                                      .content_type = "application/json",
                                      .body = body,
                                      .body_bytes = (size_t)(at - body)};
        api_buffer_init(&out, 1 << 20);
        REQUIRE(api_call_new(&call, &limits) == PEND_OK);
        CHECK_INT(api_call_open(call, &request, &out), API_MORE);
        double ratio = api_call_cost(call) / measured[i].seconds;
        CHECK_SAYING(ratio > 0.25 && ratio < 4, "%d arms: %g of what was measured", n, ratio);
    }
}
