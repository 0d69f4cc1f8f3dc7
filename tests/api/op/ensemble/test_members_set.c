#include <math.h>
#include <stdio.h>

#include "tests/api/post.h"
#include "tests/harness/test.h"

/* arm 2 of this one is at the pivot: stored order and the caller's differ */
#define TURNED                                                                                     \
    "\"pendulum\":{\"length\":[0.7,1,0.9],\"mass\":[2,1,3],\"parent\":[2,0,2],\"damping\":[0.1,0," \
    "0]}"

TEST(members_with_numbers_of_their_own_move_as_pendulums_that_have_them) {
    OWN(test_reply, free) many = test_post(
        API_OP_ENSEMBLES,
        "{" TURNED ",\"initial\":{\"theta\":[1,2,-1]},\"members\":[{},{\"initial\":{\"phi\":[0,1,"
        "2],\"phid\":[1,0,0]},\"length\":[1,2,3],\"gravity\":4},{\"mass\":[1,1,5],\"set\":[{"
        "\"vary\":\"damping\",\"arm\":3,\"value\":0.2},{\"vary\":\"theta\",\"arm\":1,\"value\":90,"
        "\"unit\":\"deg\"}]}],\"duration\":1,\"observables\":[\"parameters\",\"final\"]}");
    static const char *const alone[] = {
        "{" TURNED ",\"initial\":{\"theta\":[1,2,-1]},\"times\":[0,1]}",
        "{\"pendulum\":{\"length\":[1,2,3],\"mass\":[2,1,3],\"parent\":[2,0,2],\"damping\":[0.1,0,"
        "0],\"gravity\":4},\"initial\":{\"phi\":[0,1,2],\"phid\":[1,0,0]},\"times\":[0,1]}",
        "{\"pendulum\":{\"length\":[0.7,1,0.9],\"mass\":[1,1,5],\"parent\":[2,0,2],\"damping\":["
        "0.1,0,0.2]},\"initial\":{\"theta\":[1.5707963267948966,2,-1]},\"times\":[0,1]}"};
    double worst = 0;
    CHECK_SAYING(many.status == 200, "%.300s", many.out.data);
    for (int i = 0; i < 3; i++) {
        OWN(test_reply, free) one = test_post(API_OP_TRAJECTORIES, alone[i]);
        for (int k = 0; k < 3; k++) {
            char pointer[2][40];
            snprintf(pointer[0], 40, "/final/phi/%d/%d", i, k);
            snprintf(pointer[1], 40, "/phi/1/%d", k);
            worst = fmax(worst, fabs(test_reply_number(&many, pointer[0]) -
                                     test_reply_number(&one, pointer[1])));
        }
    }
    CHECK_RESIDUAL(worst, 1e-13, "members of a list against trajectories");
    CHECK(test_reply_number(&many, "/parameters/length/1/1") == 2);
    CHECK(test_reply_number(&many, "/parameters/length/2/1") == 1);
    CHECK(test_reply_number(&many, "/parameters/mass/2/2") == 5);
    CHECK(test_reply_number(&many, "/parameters/gravity/1") == 4);
    CHECK(test_reply_number(&many, "/parameters/varied/2/0") == 0.2);
    CHECK(test_reply_number(&many, "/parameters/varied/1/0") == 0);
    CHECK_INT(test_reply_count(&many, "/parameters/varied/0"), 1);
}

TEST(members_beyond_a_limit_are_refused_by_its_name) {
    struct api_limits limits;
    api_limits_init(&limits);
    limits.members = 2;
    OWN(test_reply, free) reply = test_post_as(
        API_OP_ENSEMBLES, "{" TURNED ",\"duration\":1,\"members\":[{},{},{}]}", NULL, &limits);
    CHECK(test_reply_has_fault(&reply, "/members", "max-members"));
    test_reply_free(&reply);
    // memory is refused before it is allocated
    api_limits_init(&limits);
    limits.answer_bytes = 3 * (4 * 3 + 2) * 8 - 1;
    reply = test_post_as(API_OP_ENSEMBLES, "{" TURNED ",\"duration\":1,\"members\":[{},{},{}]}",
                         NULL, &limits);
    CHECK(test_reply_has_fault(&reply, "/members", "starts that take 336 bytes"));
}
