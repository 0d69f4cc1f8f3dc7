#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tests/api/post.h"
#include "tests/harness/test.h"

#define TWO "\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1]}"

/* random members as plain doubles */
static struct test_reply drawn(long first, int count) {
    char body[600];
    snprintf(body, sizeof body,
             "{" TWO ",\"random\":{\"count\":%d,\"seed\":7,\"first\":%ld,\"draw\":[{\"vary\":"
             "\"theta\",\"arm\":2,\"distribution\":\"normal\",\"mean\":1,\"deviation\":2},{"
             "\"vary\":\"length\",\"arm\":1,\"distribution\":\"uniform\",\"low\":1,\"high\":2}]},"
             "\"duration\":0.5,\"observables\":[\"start\",\"parameters\",\"final\"]}",
             count, first);
    return test_post_as(API_OP_ENSEMBLES, body, "application/octet-stream", NULL);
}

TEST(shards_of_random_members_join_to_the_same_whole) {
    struct test_reply whole = drawn(0, 50), parts[] = {drawn(0, 13), drawn(13, 30), drawn(43, 7)};
    size_t at = 0;
    for (int i = 0; i < 3; i++) {
        CHECK(at + parts[i].out.bytes <= whole.out.bytes &&
              !memcmp(whole.out.data + at, parts[i].out.data, parts[i].out.bytes));
        at += parts[i].out.bytes;
        test_reply_free(&parts[i]);
    }
    CHECK_INT((int)at, (int)whole.out.bytes);
    test_reply_free(&whole);
    // numbers that need 64 bits are different members
    OWN(test_reply, free) far = drawn(9007194959773696, 2), near = drawn(4294967296 - 1, 2);
    double number[2];
    memcpy(&number[0], far.out.data, sizeof number[0]);
    memcpy(&number[1], near.out.data, sizeof number[1]);
    CHECK(number[0] == 9007194959773696 && number[1] == 4294967295);
    CHECK(memcmp(far.out.data + 16, near.out.data + 16, 16) != 0);
}

TEST(several_numbers_go_along_one_axis) {
    OWN(test_reply, free) reply = test_post(
        API_OP_ENSEMBLES,
        "{" TWO ",\"grid\":[{\"vary\":\"theta\",\"arm\":1,\"start\":0,\"stop\":90,\"unit\":\"deg\","
        "\"count\":4,\"with\":[{\"vary\":\"theta\",\"arm\":2,\"start\":1,\"stop\":-2},{\"vary\":"
        "\"mass\",\"arm\":2,\"start\":1,\"stop\":1000,\"scale\":\"log\"}]},{\"vary\":\"gravity\","
        "\"start\":5,\"stop\":6,\"count\":2}],\"duration\":0.1,\"observables\":[\"start\","
        "\"parameters\"]}");
    CHECK_SAYING(reply.status == 200, "%.300s", reply.out.data);
    CHECK_INT(test_reply_count(&reply, "/member"), 8);
    for (int i = 0; i < 8; i++) {
        int j = i % 4;
        char at[4][40];
        snprintf(at[0], 40, "/start/phi/%d/0", i);
        snprintf(at[1], 40, "/start/phi/%d/1", i);
        snprintf(at[2], 40, "/parameters/mass/%d/1", i);
        snprintf(at[3], 40, "/parameters/gravity/%d", i);
        CHECK(fabs(test_reply_number(&reply, at[0]) + M_PI_2 - j * M_PI / 6) < 1e-15);
        CHECK(fabs(test_reply_number(&reply, at[1]) + M_PI_2 - (1 - j)) < 1e-15);
        CHECK(fabs(test_reply_number(&reply, at[2]) / pow(10, j) - 1) < 1e-14);
        CHECK(test_reply_number(&reply, at[3]) == (i < 4 ? 5 : 6));
    }
}

TEST(a_grid_with_tied_paths_is_drawn_as_one_of_two_axes) {
    OWN(test_reply, free) reply = test_post_as(
        API_OP_ENSEMBLES,
        "{" TWO ",\"grid\":[{\"vary\":\"theta\",\"arm\":1,\"start\":0,\"stop\":3,\"count\":4,"
        "\"with\":[{\"vary\":\"theta\",\"arm\":2,\"start\":0,\"stop\":3}]},{\"vary\":\"gravity\","
        "\"start\":5,\"stop\":6,\"count\":2}],\"duration\":1,\"observables\":[\"first_flip\"]}",
        "image/png", NULL);
    CHECK_INT(reply.status, 200);
    // width and height
    CHECK(reply.out.bytes > 24 && reply.out.data[19] == 4 && reply.out.data[23] == 2);
}
