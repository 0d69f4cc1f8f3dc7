#include "api/read/rules_json.h"

#include <math.h>
#include <string.h>

#include "tests/api/post.h"
#include "tests/harness/test.h"

TEST(tables_are_read_and_written_back) {
    OWN(test_reply, free) reply = test_post(
        API_OP_TREES,
        "{\"pendulum\":{\"arms\":[{\"length\":1,\"mass\":1,\"torque\":{\"constant\":2,\"table\":{"
        "\"t\":[0,0.5],\"value\":[3,4],\"hold\":\"linear\",\"outside\":\"zero\"}}}],"
        "\"pivot\":{\"cart\":{\"mass\":1,\"force\":{\"table\":{\"t\":[1],\"value\":[7],"
        "\"hold\":\"zero\"}}}}}}");
    CHECK_INT(reply.status, 200);
    CHECK(test_reply_number(&reply, "/arms/0/torque/constant") == 2);
    CHECK(test_reply_number(&reply, "/arms/0/torque/table/t/1") == 0.5);
    CHECK(test_reply_number(&reply, "/arms/0/torque/table/value/1") == 4);
    CHECK_TEXT(test_reply_text(&reply, "/arms/0/torque/table/hold"), "linear");
    CHECK_TEXT(test_reply_text(&reply, "/arms/0/torque/table/outside"), "zero");
    CHECK(test_reply_number(&reply, "/pivot/cart/force/table/value/0") == 7);
    CHECK_TEXT(test_reply_text(&reply, "/pivot/cart/force/table/hold"), "zero");
    CHECK(!test_reply_text(&reply, "/pivot/cart/force/table/outside"));
}

/* a cart of 2 kg with an arm, pushed by 2 N for half a second and pulled for another */
TEST(a_table_of_force_drives_a_cart) {
    OWN(test_reply, free) reply = test_post(
        API_OP_TRAJECTORIES,
        "{\"pendulum\":{\"gravity\":0,\"arms\":[{\"length\":1,\"mass\":1e-9}],\"pivot\":{\"cart\":{"
        "\"mass\":2,\"force\":{\"table\":{\"t\":[0,0.5,1],\"value\":[2,-2,0],\"hold\":\"zero\"}}}}"
        "},\"times\":[0,0.5,1],\"output\":[\"cart\"]}");
    CHECK_INT(reply.status, 200);
    CHECK_RESIDUAL(fabs(test_reply_number(&reply, "/cart/x/1") - 0.125), 2e-10, "pushed");
    CHECK_RESIDUAL(fabs(test_reply_number(&reply, "/cart/x/2") - 0.25), 4e-10, "and pulled");
}

TEST(motions_end_with_their_tables) {
    OWN(test_reply, free) reply =
        test_post(API_OP_TRAJECTORIES,
                  "{\"pendulum\":{\"arms\":[{\"length\":1,\"mass\":1,\"torque\":{\"table\":{\"t\":["
                  "0,1],\"value\":[1,2],\"hold\":\"zero\"}}}]},\"times\":[0,2]}");
    CHECK(reply.status == 422 && strstr(reply.out.data, "extend the table"));
}
