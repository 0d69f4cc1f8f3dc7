/* Modes of many damped arms: requests and answers. The numbers are tested in
 * tests/core/modes/test_lossy.c. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tests/api/post.h"
#include "tests/harness/test.h"

/* the request for the modes of a chain of n arms with friction in every joint and drag per mass */
static struct test_reply chain(int n, double friction, double drag) {
    char body[1 << 15];
    int used = snprintf(body, sizeof body,
                        "{\"vectors\":false,\"pendulum\":{\"drag_per_mass\":%g,"
                        "\"gravity\":%d,\"length\":[1",
                        drag, n);
    for (int k = 1; k < n; k++) used += snprintf(body + used, sizeof body - (size_t)used, ",1");
    used += snprintf(body + used, sizeof body - (size_t)used, "],\"mass\":[1");
    for (int k = 1; k < n; k++) used += snprintf(body + used, sizeof body - (size_t)used, ",1");
    used += snprintf(body + used, sizeof body - (size_t)used, "],\"damping\":[%g", friction);
    for (int k = 1; k < n; k++)
        used += snprintf(body + used, sizeof body - (size_t)used, ",%g", friction);
    used += snprintf(body + used, sizeof body - (size_t)used, "],\"parent\":[0");
    for (int k = 1; k < n; k++) used += snprintf(body + used, sizeof body - (size_t)used, ",%d", k);
    snprintf(body + used, sizeof body - (size_t)used, "]}}");
    return test_post(API_OP_MODES, body);
}

/* Drag per mass gives every mode the same decay rate gamma, and omega^2 = omega_0^2 - gamma^2; for
 * a uniform chain of many arms omega_0^2 is g / l times half the square of a Bessel function's
 * zero. */
TEST(modes_of_many_arms_with_drag_per_mass_decay_alike) {
    enum { N = 120 };
    static const double zero = 2.404825557695773; /* of J_0, the first */
    OWN(test_reply, free) reply = chain(N, 0, 0.25);
    CHECK_INT(reply.status, 200);
    CHECK_INT(test_reply_count(&reply, "/omega"), N);
    double off = 0;
    for (int j = 0; j < N; j++) {
        char at[30];
        snprintf(at, sizeof at, "/decay/%d", j);
        off = fmax(off, fabs(test_reply_number(&reply, at) - 0.25));
    }
    CHECK_SAYING(off < 1e-12, "%g", off);
    // a hanging rope of length n with gravity n: omega = zero / 2
    double omega = hypot(test_reply_number(&reply, "/omega/0"), 0.25);
    CHECK_SAYING(fabs(omega / (zero / 2) - 1) < 0.01, "%g", omega);
}

TEST(modes_of_more_than_a_thousand_damped_arms_are_refused) {
    OWN(test_reply, free) reply = chain(1001, 0.1, 0);
    CHECK_INT(reply.status, 422);
    CHECK(test_reply_has_fault(&reply, "/pendulum", "at most 1000, or 2000 without friction"));
}

TEST(the_matrices_of_a_cart_with_an_upright_arm_are_the_textbooks) {
    OWN(test_reply, free) reply = test_post(
        API_OP_MODES, "{\"pendulum\":{\"length\":[0.5],\"mass\":[2],\"parent\":[0],\"gravity\":10,"
                      "\"damping\":[0.1],\"pivot\":{\"cart\":{\"mass\":3,\"damping\":1}}},"
                      "\"about\":[\"up\"],\"include\":[\"A\",\"M\",\"B\",\"C\",\"K\",\"S\"]}");
    static const struct {
        const char *row;
        double want[2];
    } rows[] = {{"/M/0", {0.5, -1}},       {"/M/1", {-1, 5}},       {"/C/0", {0.1, 0}},
                {"/C/1", {0, 1}},          {"/K/0", {-10, 0}},      {"/K/1", {0, 0}},
                {"/B/0", {1, 0}},          {"/B/1", {0, 1}},        {"/S/0", {1, 0}},
                {"/A/0", {-100.0 / 3, 0}}, {"/A/1", {-20.0 / 3, 0}}};
    CHECK_INT(reply.status, 200);
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
        for (int j = 0; j < 2; j++) {
            char pointer[20];
            snprintf(pointer, sizeof pointer, "%s/%d", rows[i].row, j);
            CHECK(fabs(test_reply_number(&reply, pointer) - rows[i].want[j]) < 1e-13);
        }
}
