#include "api/op/samples.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tests/api/post.h"
#include "tests/harness/test.h"

#define BODY(members)                                                                              \
    "{\"pendulum\":{\"length\":[1,0.5],\"mass\":[1,2],\"parent\":[2,0]},\"initial\":{\"phi\":[0."  \
    "3,-1],\"phid\":[1,"                                                                           \
    "-2]},\"times\":{\"stop\":0.4,\"count\":5}" members "}"

TEST(the_default_output_is_phi_phid_lambda) {
    OWN(test_reply, free) reply = test_post_as(API_OP_TRAJECTORIES, BODY(""), "text/csv", NULL);
    CHECK_INT(reply.status, 200);
    CHECK(!strncmp(reply.out.data, "t,phi_1,phi_2,phid_1,phid_2,lambda_1,lambda_2\n", 46));
}

TEST(columns_are_in_the_order_asked_for) {
    OWN(test_reply, free) reply =
        test_post_as(API_OP_TRAJECTORIES,
                     BODY(",\"output\":[\"energy\",\"zd\",\"lambda\",\"theta\",\"z\",\"phid\","
                          "\"phidd\",\"phi\",\"thetad\"]"),
                     "text/csv", NULL);
    static const char header[] = "t,energy_kinetic,energy_potential,energy_total,zd_re_1,zd_re_2,"
                                 "zd_im_1,zd_im_2,lambda_1,lambda_2,theta_1,"
                                 "theta_2,z_re_1,z_re_2,z_im_1,z_im_2,phid_1,phid_2,phidd_1,phidd_"
                                 "2,phi_1,phi_2,thetad_1,thetad_2\n";
    CHECK_INT(reply.status, 200);
    CHECK_SAYING(!strncmp(reply.out.data, header, sizeof header - 1), "%.300s", reply.out.data);
}

/* the number of sample i and arm k, or of sample i if k < 0 */
static double at(const struct test_reply *reply, const char *name, int i, int k) {
    char pointer[60];
    snprintf(pointer, sizeof pointer, k < 0 ? "/%s/%d" : "/%s/%d/%d", name, i, k);
    return test_reply_number(reply, pointer);
}

TEST(every_output_fits_the_others) {
    OWN(test_reply, free) reply =
        test_post(API_OP_TRAJECTORIES, BODY(",\"output\":[\"phi\",\"phid\",\"phidd\",\"theta\","
                                            "\"thetad\",\"z\",\"zd\",\"lambda\",\"energy\"]"));
    double worst = 0, size = 0, moved = 0;
    CHECK_INT(reply.status, 200);
    for (int i = 0; i < 5; i++) {
        /* arm 2 is at the pivot and carries arm 1 */
        double phi = at(&reply, "phi", i, 1), rate = at(&reply, "phid", i, 1);
        worst = fmax(worst, fabs(at(&reply, "theta", i, 1) - phi - 3.14159265358979323846 / 2));
        worst = fmax(worst, fabs(at(&reply, "thetad", i, 1) - rate));
        worst = fmax(worst, fabs(at(&reply, "z/re", i, 1) - 0.5 * cos(phi)));
        worst = fmax(worst, fabs(at(&reply, "z/im", i, 1) - 0.5 * sin(phi)));
        worst = fmax(worst, fabs(at(&reply, "zd/re", i, 1) + 0.5 * rate * sin(phi)));
        worst = fmax(worst, fabs(at(&reply, "zd/im", i, 1) - 0.5 * rate * cos(phi)));
        double potential = 9.81 * (at(&reply, "z/im", i, 0) + 2 * at(&reply, "z/im", i, 1));
        double kinetic = 0;
        for (int k = 0; k < 2; k++)
            kinetic += (k + 1) / 2. *
                       (pow(at(&reply, "zd/re", i, k), 2) + pow(at(&reply, "zd/im", i, k), 2));
        worst = fmax(worst, fabs(at(&reply, "energy/potential", i, -1) - potential) / 10);
        worst = fmax(worst, fabs(at(&reply, "energy/kinetic", i, -1) - kinetic) / 10);
        worst = fmax(worst, fabs(at(&reply, "energy/total", i, -1) - kinetic - potential) / 10);
        size = fmax(size, fabs(at(&reply, "phidd", i, 0)) * fabs(at(&reply, "lambda", i, 0)));
        moved = fmax(moved, fabs(phi + 1));
    }
    CHECK_RESIDUAL(worst, 1e-14, "outputs against each other");
    CHECK(size > 0.1 && moved > 0.1);
}

TEST(a_block_has_room_that_suits_the_number_of_arms) {
    struct api_outputs outputs = {.count = 1, .output = {0}};
    static const struct {
        int n;
        long rows, cap;
    } cases[] = {{1, 1, 1}, {4, 501, 256}, {1000, 501, 16}, {100000, 501, 1}};
    for (int i = 0; i < 4; i++) {
        struct api_samples *samples;
        REQUIRE(!api_samples_new(&samples, &outputs, cases[i].n, cases[i].rows));
        CHECK_INT(samples->samples.cap, cases[i].cap);
        CHECK(samples->samples.phi && !samples->samples.rate && !samples->samples.force);
        api_samples_free(&samples);
        CHECK(!samples);
    }
}
