/* Tests of pendulums on a cart in sections and exponents: sections have the states of trajectories
 * at the same instants; exponents are the roots of the linear equations, and their sum is the loss
 * by friction.
 * Leaves to others: trees, trajectories and ensembles on a cart (test_op_trajectories_cart).
 * Invariant: references come from another operation or from a closed form. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tests/api/post.h"
#include "tests/harness/requests.h"
#include "tests/harness/test.h"

#define START "{\"phi\":[-1,0.5,-2],\"phid\":[0.3,0,1],\"cart\":{\"x\":0.1,\"v\":-0.4}}"

/* the largest difference of the rows of a section from those of a trajectory at its instants */
static double compared(const char *section, int *rows) {
    static const char *const column[] = {"phi", "phid", "cart/x", "cart/v"};
    char body[3000], at[60];
    double gap = 0;
    snprintf(body, sizeof body,
             "{" TEST_CART_TREE ",\"initial\":" START
             ",\"start\":2,\"duration\":9,\"rtol\":1e-15,\"section\":%s}",
             section);
    OWN(test_reply, free) found = test_post(API_OP_SECTIONS, body);
    CHECK_INT(found.status, 200);
    *rows = test_reply_count(&found, "/t");
    CHECK(*rows > 3 && *rows < 60);
    int used = snprintf(body, sizeof body,
                        "{" TEST_CART_TREE ",\"initial\":" START ",\"rtol\":1e-15,\"output\":["
                        "\"phi\",\"phid\",\"cart\"],\"times\":[2");
    for (int i = 0; i < *rows; i++) {
        snprintf(at, sizeof at, "/t/%d", i);
        used += snprintf(body + used, sizeof body - (size_t)used, ",%.17g",
                         test_reply_number(&found, at));
    }
    snprintf(body + used, sizeof body - (size_t)used, "]}");
    OWN(test_reply, free) want = test_post(API_OP_TRAJECTORIES, body);
    CHECK_INT(want.status, 200);
    for (int i = 0; i < *rows; i++)
        for (int c = 0; c < 8; c++) {
            const char *name = column[c < 6 ? c / 3 : c - 4];
            snprintf(at, sizeof at, c < 6 ? "/%s/%d/%d" : "/%s/%d", name, i, c % 3);
            double is = test_reply_number(&found, at);
            snprintf(at, sizeof at, c < 6 ? "/%s/%d/%d" : "/%s/%d", name, i + 1, c % 3);
            double off = fabs(is - test_reply_number(&want, at));
            if (!(off <= gap)) gap = off;
        }
    return gap;
}

TEST(sections_on_a_cart_have_the_states_of_trajectories_and_the_place_of_the_cart) {
    int rows;
    // the same steps, and so the same bits
    CHECK(compared("{\"period\":\"drive\",\"first\":0.25}", &rows) == 0);
    double gap = compared("{\"arm\":3,\"theta\":0.1,\"direction\":\"both\"}", &rows);
    CHECK_RESIDUAL(gap, 1e-12, "passages of an arm on a cart");
    OWN(test_reply, free) reply = test_post_as(
        API_OP_SECTIONS, "{" TEST_CART_TREE ",\"duration\":3,\"section\":{\"arm\":1,\"theta\":0}}",
        "text/csv", NULL);
    CHECK(strstr(reply.out.data,
                 "t,phi_1,phi_2,phi_3,phid_1,phid_2,phid_3,direction,cart_x,cart_v\n") != NULL);
}

/* The exponents of a pendulum at rest are the real parts of the roots of its linear equations; the
 * friction of this one suppresses all oscillation. */
TEST(exponents_on_a_cart_at_rest_are_the_roots_of_its_linear_equations) {
#define STIFF                                                                                      \
    "\"pendulum\":{\"length\":[0.5],\"mass\":[4],\"parent\":[0],\"damping\":[14],\"pivot\":{"      \
    "\"cart\":{\"mass\":3,\"angle\":0.3,\"damping\":60,\"stiffness\":50}}}"
    OWN(test_reply, free) modes = test_post(API_OP_MODES, "{" STIFF "}");
    OWN(test_reply, free) reply =
        test_post(API_OP_LYAPUNOV, "{" STIFF ",\"initial\":{\"theta\":[0],\"cart\":{\"x\":"
                                   "-0.40528}},\"duration\":20,\"transient\":30,\"count\":\"all\","
                                   "\"samples\":1}");
    CHECK_INT(reply.status, 200);
    double gap = 0;
    for (int i = 0; i < 4; i++) {
        char at[40];
        snprintf(at, sizeof at, "/omega/%d", i);
        CHECK(test_reply_number(&modes, at) == 0);
        snprintf(at, sizeof at, "/decay/%d", i);
        double decay = test_reply_number(&modes, at);
        snprintf(at, sizeof at, "/exponents/0/%d", i);
        gap = fmax(gap, fabs(decay + test_reply_number(&reply, at)) / decay);
    }
    CHECK_RESIDUAL(gap, 1e-9, "exponents of a cart at rest");
}

/* Exponents do not depend on the unit of length: a pendulum a thousand times as long, with friction
 * and gravity scaled accordingly. */
TEST(exponents_on_a_cart_do_not_depend_on_the_unit_of_length) {
    static const char *const form =
        "{\"pendulum\":{\"length\":[%g,%g],\"mass\":[1,1],\"parent\":[0,1],\"gravity\":%g,"
        "\"pivot\":{\"cart\":{\"mass\":1,\"damping\":0.2,\"force\":{\"harmonics\":[{"
        "\"amplitude\":%g,\"omega\":3}]}}}},\"initial\":{\"theta\":[2,1]},\"duration\":12,"
        "\"count\":2,\"samples\":1}";
    static const double length[] = {1, 1e-6, 1e5};
    double first[3];
    for (int i = 0; i < 3; i++) {
        char body[500];
        double l = length[i];
        snprintf(body, sizeof body, form, l, l, 9.81 * l, 5 * l);
        OWN(test_reply, free) reply = test_post(API_OP_LYAPUNOV, body);
        CHECK_INT(reply.status, 200);
        first[i] = test_reply_number(&reply, "/exponents/0/0");
    }
    CHECK_SAYING(first[0] > 0.5, "%g", first[0]);
    CHECK_RESIDUAL(fmax(fabs(first[1] - first[0]), fabs(first[2] - first[0])), 1e-7,
                   "exponents of other lengths");
}
