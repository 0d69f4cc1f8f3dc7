/* Requests and answers about the response of a pendulum on a cart. The numbers for many arms are
 * tested in tests/core/modes/test_response.c. */
#include <complex.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tests/api/post.h"
#include "tests/harness/requests.h"
#include "tests/harness/test.h"

#define CART                                                                                       \
    "\"pendulum\":{\"length\":[0.5],\"mass\":[2],\"parent\":[0],\"gravity\":8,\"pivot\":{"         \
    "\"cart\":"                                                                                    \
    "{\"mass\":3,\"damping\":0.7,\"stiffness\":20,\"force\":{\"constant\":5,\"harmonics\":[{"      \
    "\"amplitude\":0.01,\"omega\":2},{\"amplitude\":0.02,\"omega\":5}]}}}}"

/* amplitudes of the cart and of the arm, from the two equations of small swings */
static void wanted(double omega, double force, double complex x[2]) {
    double square = omega * omega, own = 8 - 0.5 * square;
    double complex stiff = 20 + I * omega * 0.7 - 5 * square;
    x[0] = force * own / (stiff * own - 2 * 0.5 * square * square);
    x[1] = force * square / (stiff * own - 2 * 0.5 * square * square);
}

static double complex answered(const struct test_reply *reply, const char *name, int row,
                               const char *rest) {
    char at[60];
    snprintf(at, sizeof at, "/%s/amplitude/%d%s", name, row, rest);
    double amplitude = test_reply_number(reply, at);
    snprintf(at, sizeof at, "/%s/phase/%d%s", name, row, rest);
    return amplitude * cexp(I * test_reply_number(reply, at));
}

TEST(response_on_a_cart_is_that_of_its_two_equations) {
    static const struct {
        const char *more;
        int rows;
        double omega[3], force[3];
    } cases[] = {
        // at 4 rad/s, the frequency of the arm alone, the cart is at rest
        {",\"drive\":{\"cart\":{\"amplitude\":0.1}},\"omega\":[0,4,6]",
         3,
         {0, 4, 6},
         {0.1, 0.1, 0.1}},
        {"", 2, {2, 5}, {0.01, 0.02}},
        {",\"omega\":[3]", 1, {3}, {0.03}},
    };
    double gap = 0;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char body[800];
        snprintf(body, sizeof body, "{" CART "%s,\"output\":[\"phi\",\"cart\"],\"poles\":true}",
                 cases[i].more);
        OWN(test_reply, free) reply = test_post(API_OP_RESPONSE, body);
        CHECK_INT(reply.status, 200);
        CHECK_INT(test_reply_count(&reply, "/omega"), cases[i].rows);
        for (int j = 0; j < cases[i].rows; j++) {
            double complex x[2];
            wanted(cases[i].omega[j], cases[i].force[j], x);
            gap = fmax(gap, cabs(answered(&reply, "cart", j, "") - x[0]) / cases[i].force[j]);
            gap = fmax(gap, cabs(answered(&reply, "phi", j, "/0") - x[1]) / cases[i].force[j]);
        }
        CHECK_RESIDUAL(fabs(test_reply_number(&reply, "/cart_equilibrium") - 0.25), 1e-15,
                       "where the cart rests");
        CHECK_INT(test_reply_count(&reply, "/equilibrium"), 1);
        CHECK_INT(test_reply_count(&reply, "/poles/decay"), 2);
    }
    CHECK_RESIDUAL(gap, 1e-14, "the cart and the arm, over the force");
}

TEST(response_on_a_cart_has_its_columns_and_refuses_a_shaken_pivot) {
    OWN(test_reply, free) reply = test_post_as(
        API_OP_RESPONSE, "{" TEST_CART_TREE ",\"output\":[\"cart\",\"phi\"]}", "text/csv", NULL);
    CHECK(!strncmp(reply.out.data, "omega,frequency,phi_amplitude_1,", 32));
    CHECK(strstr(reply.out.data,
                 ",phi_phase_3,cart_amplitude,cart_phase,equilibrium_1,equilibrium_2,equilibrium_3,"
                 "cart_equilibrium\n3,") != NULL);
}
