#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/api/post.h"
#include "tests/harness/test.h"

/* arm 2 of this one is at the pivot: stored order and the caller's differ */
#define TURNED                                                                                     \
    "\"pendulum\":{\"length\":[0.7,1,0.9],\"mass\":[2,1,3],\"parent\":[2,0,2],\"damping\":[0.1,0," \
    "0]}"

TEST(members_with_numbers_of_their_own_move_as_pendulums_that_have_them) {
    struct test_reply many = test_post(
        API_OP_ENSEMBLES,
        "{" TURNED ",\"initial\":{\"theta\":[1,2,-1]},\"members\":["
        "{},{\"initial\":{\"phi\":[0,1,2],\"phid\":[1,0,0]},\"length\":[1,2,3],\"gravity\":4},"
        "{\"mass\":[1,1,5],\"set\":[{\"vary\":\"damping\",\"arm\":3,\"value\":0.2},"
        "{\"vary\":\"theta\",\"arm\":1,\"value\":90,\"unit\":\"deg\"}]}],"
        "\"duration\":1,\"observables\":[\"parameters\",\"final\"]}");
    static const char *const alone[] = {
        "{" TURNED ",\"initial\":{\"theta\":[1,2,-1]},\"times\":[0,1]}",
        "{\"pendulum\":{\"length\":[1,2,3],\"mass\":[2,1,3],\"parent\":[2,0,2],\"damping\":[0.1,0,"
        "0],\"gravity\":4},\"initial\":{\"phi\":[0,1,2],\"phid\":[1,0,0]},\"times\":[0,1]}",
        "{\"pendulum\":{\"length\":[0.7,1,0.9],\"mass\":[1,1,5],\"parent\":[2,0,2],\"damping\":["
        "0.1,0,0.2]},\"initial\":{\"theta\":[1.5707963267948966,2,-1]},\"times\":[0,1]}"};
    double worst = 0;
    CHECK_SAYING(many.status == 200, "%.300s", many.out.data);
    for (int i = 0; i < 3; i++) {
        struct test_reply one = test_post(API_OP_TRAJECTORIES, alone[i]);
        for (int k = 0; k < 3; k++) {
            char pointer[2][40];
            snprintf(pointer[0], 40, "/final/phi/%d/%d", i, k);
            snprintf(pointer[1], 40, "/phi/1/%d", k);
            worst = fmax(worst, fabs(test_reply_number(&many, pointer[0]) -
                                     test_reply_number(&one, pointer[1])));
        }
        test_reply_free(&one);
    }
    CHECK_RESIDUAL(worst, 1e-13, "members of a list against trajectories");
    CHECK(test_reply_number(&many, "/parameters/length/1/1") == 2);
    CHECK(test_reply_number(&many, "/parameters/length/2/1") == 1);
    CHECK(test_reply_number(&many, "/parameters/mass/2/2") == 5);
    CHECK(test_reply_number(&many, "/parameters/gravity/1") == 4);
    CHECK(test_reply_number(&many, "/parameters/varied/2/0") == 0.2);
    CHECK(test_reply_number(&many, "/parameters/varied/1/0") == 0);
    CHECK_INT(test_reply_count(&many, "/parameters/varied/0"), 1);
    test_reply_free(&many);
}

TEST(members_of_a_list_are_refused_at_their_own_place) {
    static const struct {
        const char *members, *pointer, *piece;
    } bad[] = {
        {"[]", "/members", "at least one member"},
        {"{}", "/members", "at least one member"},
        {"[{},7,{}]", "/members/1", "must be an object"},
        {"[{\"lenght\":[1,1,1]}]", "/members/0/lenght", "did you mean \"length\""},
        {"[{},{\"length\":[1,1]}]", "/members/1/length", "must have 3 numbers"},
        {"[{\"mass\":[1,-1,1]}]", "/members/0/mass/1", "greater than 0"},
        {"[{\"set\":{}}]", "/members/0/set", "must be an array"},
        {"[{\"set\":[{\"vary\":\"damping\",\"arm\":1}]}]", "/members/0/set/0/value", "is missing"},
        {"[{\"set\":[{\"vary\":\"damping\",\"arm\":1,\"value\":-1}]}]", "/members/0/set/0/value",
         "got -1"},
        {"[{\"set\":[{\"vary\":\"mass\",\"arm\":1,\"value\":1,\"unit\":\"deg\"}]}]",
         "/members/0/set/0/unit", "leave it out"},
        {"[{\"set\":[{\"vary\":\"rod\",\"arm\":1,\"value\":1}]}]", "/members/0/set/0/vary",
         "the pendulum has not"},
        {"[{\"set\":[{\"vary\":\"phi\",\"arm\":4,\"value\":1}]}]", "/members/0/set/0/arm",
         "from 1 to 3"},
        {"[{\"initial\":{\"phi\":[1]}}]", "/members/0/initial/phi", "must have 3 numbers"},
        {"[{\"energy\":\"x\"}]", "/members/0/energy", "must be"},
        {"[{}],\"grid\":[]", "/grid", "does not go together with \"members\""},
        {"[{}],\"initial\":{\"phi\":[1]}", "/initial/phi", "must have 3 numbers"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        char body[700];
        snprintf(body, sizeof body, "{" TURNED ",\"duration\":1,\"members\":%s}", bad[i].members);
        CHECK_REFUSED(API_OP_ENSEMBLES, body, bad[i].pointer, bad[i].piece);
    }
    struct api_limits limits;
    api_limits_init(&limits);
    limits.members = 2;
    struct test_reply reply = test_post_as(
        API_OP_ENSEMBLES, "{" TURNED ",\"duration\":1,\"members\":[{},{},{}]}", NULL, &limits);
    CHECK(test_reply_has_fault(&reply, "/members", "max-members"));
    test_reply_free(&reply);
    // memory is refused before it is taken
    api_limits_init(&limits);
    limits.answer_bytes = 3 * (4 * 3 + 2) * 8 - 1;
    reply = test_post_as(API_OP_ENSEMBLES, "{" TURNED ",\"duration\":1,\"members\":[{},{},{}]}",
                         NULL, &limits);
    CHECK(test_reply_has_fault(&reply, "/members", "starts that take 336 bytes"));
    test_reply_free(&reply);
}

/* behind a fault a number that an ideal pendulum has not was checked as if it were there */
TEST(members_survive_a_number_that_is_not_there_behind_a_fault) {
    CHECK_REFUSED(API_OP_ENSEMBLES,
                  "{\"pendulum\":{\"length\":[1],\"mass\":[1],\"parent\":[0]},\"initial\":{\"phi\":"
                  "[1]},\"duration\":1,\"members\":[{\"set\":[{\"vary\":\"damping\","
                  "\"arm\":1,\"value\":1},{\"vary\":\"damping\",\"arm\":1,\"value\":1}]}]}",
                  "/members/0/set/0/vary", "the pendulum has not");
}
