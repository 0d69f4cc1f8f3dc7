/* Tests of POST /v1/fits for a throw: as many requirements as unknowns, which are met.
 * Leaves to others: fits to measurements, required modes (test_op_fits).
 * Invariant: the returned start is tested by POST /v1/trajectories. */
#include <math.h>
#include <stdio.h>

#include "tests/api/post.h"
#include "tests/harness/test.h"

static double motion_at(const struct test_reply *reply, const char *name, int i, int k) {
    char pointer[60];
    snprintf(pointer, sizeof pointer, "/%s/%d/%d", name, i, k);
    return test_reply_number(reply, pointer);
}

#define THROWN "\"pendulum\":{\"length\":[0.4,0.3],\"mass\":[1,1],\"parent\":[0,1]},\"initial\":"

/* as many requirements as unknowns, which are met exactly, with or without a sigma */
static void passes(const char *sigmas, const char *sigma) {
    char body[800];
    snprintf(body, sizeof body,
             "{" THROWN "{\"theta\":[1,1]},\"start\":0,\"data\":{\"t\":[0.4,0.8],\"series\":["
             "{\"x\":2,%s\"values\":[0.1,-0.4]},{\"y\":2,%s\"values\":[-0.65,-0.5]}]},"
             "\"unknowns\":[{\"vary\":\"theta\",\"arm\":1},{\"vary\":\"theta\",\"arm\":2},"
             "{\"vary\":\"thetad\",\"arm\":1},{\"vary\":\"thetad\",\"arm\":2}]}",
             sigmas, sigma);
    OWN(test_reply, free) reply = test_post(API_OP_FITS, body);
    CHECK_INT(reply.status, 200);
    CHECK_TEXT(test_reply_text(&reply, "/status"), "converged");
    double start[4];
    for (int j = 0; j < 4; j++) {
        char pointer[30];
        snprintf(pointer, sizeof pointer, "/unknowns/%d/value", j);
        start[j] = test_reply_number(&reply, pointer);
    }
    snprintf(body, sizeof body,
             "{" THROWN "{\"theta\":[%.17g,%.17g],\"thetad\":[%.17g,%.17g]},"
             "\"times\":{\"stop\":0.8,\"count\":3},\"output\":[\"z\"]}",
             start[0], start[1], start[2], start[3]);
    OWN(test_reply, free) thrown = test_post(API_OP_TRAJECTORIES, body);
    const double wanted[] = {0.1, -0.65, -0.4, -0.5};
    for (int i = 0; i < 4; i++) {
        double gap = motion_at(&thrown, i % 2 ? "z/im" : "z/re", 1 + i / 2, 1) - wanted[i];
        CHECK_SAYING(fabs(gap) < 1e-5, "coordinate %d is missed by %g m", i, gap);
    }
}

TEST(fits_find_a_throw_that_passes_through_points) {
    passes("\"sigma\":[0.001,0.002],", "\"sigma\":0.001,");
    passes("", "");
    // one point: the mean of one coordinate is no scale for a miss
    OWN(test_reply, free) reply = test_post(
        API_OP_FITS,
        "{" THROWN "{\"theta\":[0.5,0.5]},\"start\":0,\"data\":{\"t\":[0.5],\"series\":["
        "{\"x\":2,\"values\":[0.3]},{\"y\":2,\"values\":[-0.4]}]},\"unknowns\":[{\"vary\":"
        "\"thetad\",\"arm\":1},{\"vary\":\"thetad\",\"arm\":2}]}");
    CHECK_TEXT(test_reply_text(&reply, "/status"), "converged");
}
