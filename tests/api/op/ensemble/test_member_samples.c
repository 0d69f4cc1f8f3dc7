#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/api/post.h"
#include "tests/harness/test.h"

#define OUTPUT "\"output\":[\"phi\",\"phidd\",\"z\",\"zd\",\"energy\"]"
#define REST "\"times\":{\"start\":0.5,\"stop\":1.5,\"count\":5}," OUTPUT

/* the largest difference of a column of 5 rows of 3 arms (or none), relative to its largest number;
 * member: whose rows they are */
static double column_differs(const struct test_reply *many, int member,
                             const struct test_reply *one, const char *name, int arms) {
    double worst = 0, size = 0;
    for (int i = 0; i < 5; i++)
        for (int k = 0; k < (arms ? arms : 1); k++) {
            char at[2][60], arm[20] = "";
            if (arms) snprintf(arm, sizeof arm, "/%d", k);
            snprintf(at[0], 60, "/%s/%d%s", name, 5 * member + i, arm);
            snprintf(at[1], 60, "/%s/%d%s", name, i, arm);
            double x = test_reply_number(one, at[1]);
            worst = fmax(worst, fabs(test_reply_number(many, at[0]) - x));
            size = fmax(size, fabs(x));
        }
    CHECK(!isnan(worst) && size > 0);
    return worst / size;
}

static double rows_differ(const char *many_body, int members, const char *const alone[], int arms) {
    static const char *const names[] = {"phidd", "z/re", "z/im", "zd/re", "zd/im"};
    static const char *const energies[] = {"energy/kinetic", "energy/potential", "energy/total"};
    OWN(test_reply, free) many = test_post(API_OP_ENSEMBLES, many_body);
    double worst = 0;
    CHECK_SAYING(many.status == 200, "%.300s", many.out.data);
    for (int i = 0; i < members; i++) {
        OWN(test_reply, free) one = test_post(API_OP_TRAJECTORIES, alone[i]);
        CHECK_SAYING(one.status == 200, "%.300s", one.out.data);
        for (int c = 0; c < 5; c++)
            worst = fmax(worst, column_differs(&many, i, &one, names[c], arms));
        for (int c = 0; c < 3; c++)
            worst = fmax(worst, column_differs(&many, i, &one, energies[c], 0));
    }
    return worst;
}

TEST(outputs_of_members_are_those_of_trajectories_of_their_own_pendulums) {
    static const char *const alone[] = {
        "{\"pendulum\":{\"length\":[0.7,1,0.9],\"mass\":[2,1,3],\"parent\":[2,0,2]},"
        "\"initial\":{\"theta\":[1,2,-1]}," REST "}",
        "{\"pendulum\":{\"length\":[1,2,3],\"mass\":[1,1,5],\"parent\":[2,0,2],\"gravity\":4},"
        "\"initial\":{\"theta\":[1,2,-1]}," REST "}"};
    double worst =
        rows_differ("{\"pendulum\":{\"length\":[0.7,1,0.9],\"mass\":[2,1,3],\"parent\":[2,0,2]},"
                    "\"initial\":{\"theta\":[1,2,-1]},\"members\":[{},{\"length\":[1,2,3],\"mass\":"
                    "[1,1,5],\"gravity\":4}],\"observables\":[\"trajectory\"]," REST "}",
                    2, alone, 3);
    CHECK_RESIDUAL(worst, 1e-11, "outputs of ideal members");
#define REAL(damping)                                                                              \
    "\"pendulum\":{\"arms\":[{\"name\":\"a\",\"length\":1,\"mass\":1,\"rod\":0.5,"                 \
    "\"damping\":" damping                                                                         \
    ",\"stiffness\":2},{\"parent\":\"a\",\"length\":0.6,\"mass\":2}],\"pivot\":{\"x\":{"           \
    "\"harmonics\":[{\"amplitude\":0.1,\"omega\":5,\"phase\":1}]}}}"
    static const char *const real[] = {"{" REAL("0.1") ",\"initial\":{\"theta\":[1,2]}," REST "}",
                                       "{" REAL("0.4") ",\"initial\":{\"theta\":[1,2]}," REST "}"};
    worst = rows_differ("{" REAL("0.1") ",\"initial\":{\"theta\":[1,2]},\"grid\":[{\"vary\":"
                                        "\"damping\",\"arm\":1,\"start\":0.1,\"stop\":0.4,"
                                        "\"count\":2}],\"observables\":[\"trajectory\"]," REST "}",
                        2, real, 2);
    CHECK_RESIDUAL(worst, 1e-13, "outputs of real members");
#define CART                                                                                       \
    "\"pendulum\":{\"length\":[1,0.5],\"mass\":[1,2],\"parent\":[0,1],\"pivot\":{\"cart\":{"       \
    "\"mass\":2}}}"
    static const char *const cart[] = {"{" CART ",\"initial\":{\"theta\":[1,2]}," REST "}"};
    worst = rows_differ("{" CART ",\"states\":[{\"theta\":[1,2]}],\"observables\":[\"trajectory\"]"
                        "," REST "}",
                        1, cart, 2);
    CHECK_RESIDUAL(worst, 1e-11, "outputs of members on a cart");
}

TEST(accelerations_of_small_swings_keep_their_digits) {
#define SMALL "\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1]}"
    OWN(test_reply, free) many = test_post(
        API_OP_ENSEMBLES, "{" SMALL ",\"states\":[{\"theta\":[1e-9,2e-9]}],\"times\":[0,1,2,3,4],"
                          "\"observables\":[\"trajectory\"],\"output\":[\"phidd\"]}");
    OWN(test_reply, free) one =
        test_post(API_OP_TRAJECTORIES, "{" SMALL ",\"initial\":{\"theta\":[1e-9,2e-9]},\"times\":["
                                       "0,1,2,3,4],\"output\":[\"phidd\"]}");
    double worst = column_differs(&many, 0, &one, "phidd", 2);
    CHECK_RESIDUAL(worst, 1e-13, "accelerations of small swings, relative");
}
