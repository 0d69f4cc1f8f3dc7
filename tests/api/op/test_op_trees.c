#include <stdio.h>
#include <string.h>

#include "tests/api/post.h"
#include "tests/harness/test.h"

TEST(trees_answers_the_papers_matrices) {
    OWN(test_reply, free) reply = test_post(
        API_OP_TREES,
        "{\"pendulum\":{\"length\":[2,1.5,0.75,1.25],\"mass\":[1,1,1,0.1],\"parent\":[0,1,2,2]}}");
    CHECK_INT(reply.status, 200);
    CHECK_TEXT(reply.media_type, "application/json");
    static const char expected[] =
        "{\"n\":4,\"gravity\":9.81,\"length_total\":5.5,\"arms\":[{\"name\":\"1\",\"parent\":null,"
        "\"length\":2,\"mass\":1},{\"name\":\"2\",\"parent\":\"1\",\"length\":1.5,\"mass\":1},{"
        "\"name\":\"3\",\"parent\":\"2\",\"length\":0.75,\"mass\":1},{\"name\":\"4\","
        "\"parent\":\"2\",\"length\":1.25,\"mass\":0.1}],\"parent\":[0,1,2,2],\"depth\":[1,2,3,3],"
        "\"subtree_mass\":[3.1,2.1,1,0.1],\"S\":[[1,0,0,0],[1,1,0,0],[1,1,1,0],[1,1,0,1]],\"B\":[["
        "1,-1,0,0],[0,1,-1,-1],[0,0,1,0],[0,0,0,1]],\"stats\":{\"version\":\"";
    CHECK_SAYING(!strncmp(reply.out.data, expected, strlen(expected)), "%s", reply.out.data);
}

TEST(trees_keeps_the_callers_order_and_s_times_b_transposed_is_one) {
    OWN(test_reply, free) reply = test_post(
        API_OP_TREES,
        "{\"pendulum\":{\"length\":[1,2,3,4,5],\"mass\":[1,2,3,4,5],\"parent\":[4,0,2,2,4]}}");
    for (int i = 0; i < 5; i++)
        for (int j = 0; j < 5; j++) {
            double product = 0;
            for (int k = 0; k < 5; k++) {
                char s[60], b[60];
                snprintf(s, sizeof s, "/S/%d/%d", i, k);
                snprintf(b, sizeof b, "/B/%d/%d", j, k);
                product += test_reply_number(&reply, s) * test_reply_number(&reply, b);
            }
            CHECK(product == (i == j));
        }
    CHECK(test_reply_number(&reply, "/subtree_mass/3") == 10);
    CHECK(test_reply_number(&reply, "/arms/4/length") == 5);
}

TEST(trees_leaves_out_matrices_beyond_their_limit) {
    static const char body[] = "{\"pendulum\":{\"length\":[1,2],\"mass\":[1,2],\"parent\":[0,1]}}";
    struct api_limits limits;
    api_limits_init(&limits);
    limits.matrix_arms = 1;
    OWN(test_reply, free) reply = test_post_as(API_OP_TREES, body, NULL, &limits);
    CHECK_INT(reply.status, 200);
    CHECK(test_reply_count(&reply, "/S") == -1 && test_reply_count(&reply, "/B") == -1);
    CHECK_INT(test_reply_count(&reply, "/subtree_mass"), 2);
}

TEST(names_of_arms_come_back_as_they_were_given) {
    OWN(test_reply, free) reply =
        test_post(API_OP_TREES, "{\"pendulum\":{\"arms\":[{\"name\":\"\\\"\\u00e9\\n\\ud83d\\ude00 "
                                "/~\",\"length\":1,\"mass\":1}]}}");
    CHECK_INT(reply.status, 200);
    CHECK_TEXT(test_reply_text(&reply, "/arms/0/name"), "\"\xc3\xa9\n\xf0\x9f\x98\x80 /~");
}

TEST(trees_serves_json_only) {
    OWN(test_reply, free) reply = test_post_as(
        API_OP_TREES, "{\"pendulum\":{\"L\":[1],\"m\":[1],\"S\":[[1]]}}", "text/csv", NULL);
    CHECK_INT(reply.status, 406);
}
