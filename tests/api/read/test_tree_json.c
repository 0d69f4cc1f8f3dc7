#include "api/read/tree_json.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/api/post.h"
#include "tests/harness/test.h"

#define TREE(members) "{\"pendulum\":{" members "}}"
#define ARMS(list) TREE("\"arms\":[" list "]")

static const char arms_body[] =
    ARMS("{\"name\":\"d\",\"parent\":\"b\",\"length\":1.25,\"mass\":0.1},{\"name\":\"a\","
         "\"length\":2,\"mass\":1},{\"name\":\"b\",\"parent\":\"a\",\"length\":1.5,\"mass\":1},{"
         "\"name\":\"c\",\"parent\":\"b\",\"length\":0.75,\"mass\":1}");
static const char lists_body[] =
    TREE("\"length\":[1.25,2,1.5,0.75],\"mass\":[0.1,1,1,1],\"parent\":[3,0,2,3]");
static const char paper_body[] = TREE("\"L\":[1.25,2,1.5,0.75],\"m\":[0.1,1,1,1],\"S\":[[1,1,1,0],["
                                      "0,1,0,0],[0,1,1,0],[0,1,1,1]]");

/* the answer from its lists on, which do not depend on the names of the arms */
static const char *from_lists(const struct test_reply *reply) {
    return strstr(reply->out.data, "\"parent\":[");
}

TEST(three_forms_of_a_tree_give_the_same_answer) {
    OWN(test_reply, free) arms = test_post(API_OP_TREES, arms_body),
                          lists = test_post(API_OP_TREES, lists_body);
    OWN(test_reply, free) paper = test_post(API_OP_TREES, paper_body);
    CHECK_INT(arms.status, 200);
    if (CHECK(from_lists(&arms) && from_lists(&lists)))
        CHECK_TEXT(from_lists(&arms), from_lists(&lists));
    CHECK_TEXT(paper.out.data, lists.out.data);
    CHECK_TEXT(test_reply_text(&arms, "/arms/0/parent"), "b");
    CHECK_TEXT(test_reply_text(&lists, "/arms/0/parent"), "3");
}

TEST(an_answers_arms_are_a_request) {
    OWN(test_reply, free) reply = test_post(API_OP_TREES, arms_body);
    char *arms = strstr(reply.out.data, "\"arms\":["),
         *end = strstr(reply.out.data, ",\"parent\":[");
    REQUIRE(arms && end);
    char body[2000];
    snprintf(body, sizeof body, "{\"pendulum\":{%.*s}}", (int)(end - arms), arms);
    OWN(test_reply, free) again = test_post(API_OP_TREES, body);
    CHECK_TEXT(again.out.data, reply.out.data);
}

TEST(arms_without_a_name_are_called_by_their_number) {
    OWN(test_reply, free) reply =
        test_post(API_OP_TREES, ARMS("{\"length\":1,\"mass\":1},{\"length\":1,\"mass\":2,"
                                     "\"parent\":\"1\"},{\"length\":1,\"mass\":3,\"parent\":\"2\","
                                     "\"name\":\"x\"}"));
    CHECK_INT(reply.status, 200);
    CHECK_TEXT(test_reply_text(&reply, "/arms/1/name"), "2");
    CHECK_TEXT(test_reply_text(&reply, "/arms/2/name"), "x");
    CHECK(test_reply_number(&reply, "/parent/2") == 2);
    CHECK(test_reply_number(&reply, "/subtree_mass/0") == 6);
}

TEST(gravity_is_9_81_unless_given_and_may_be_any_finite_number) {
    OWN(test_reply, free) usual = test_post(API_OP_TREES, lists_body);
    OWN(test_reply, free) none =
        test_post(API_OP_TREES, TREE("\"L\":[1],\"m\":[1],\"S\":[[1]],\"gravity\":0"));
    OWN(test_reply, free) up =
        test_post(API_OP_TREES, TREE("\"L\":[1],\"m\":[1],\"S\":[[1]],\"gravity\":-1.62"));
    CHECK(test_reply_number(&usual, "/gravity") == 9.81);
    CHECK(test_reply_number(&none, "/gravity") == 0);
    CHECK(test_reply_number(&up, "/gravity") == -1.62);
}

TEST(each_empty_list_is_a_fault_of_its_own) {
    OWN(test_reply, free) reply = test_post(API_OP_TREES, TREE("\"length\":[],\"mass\":[]"));
    CHECK(test_reply_has_fault(&reply, "/pendulum/length", "at least one arm"));
    CHECK(test_reply_has_fault(&reply, "/pendulum/mass", "at least one arm"));
    CHECK(test_reply_has_fault(&reply, "/pendulum/parent", "is missing"));
    CHECK_INT(test_reply_faults(&reply), 3);
}

TEST(all_faults_of_a_tree_are_told_at_once) {
    OWN(test_reply, free) reply =
        test_post(API_OP_TREES, "{\"extra\":1,\"pendulum\":{\"length\":[0,\"x\",1,1],\"mass\":[1,1,"
                                "-1,1],\"parent\":[0,9,0,4],\"gravity\":null}}");
    CHECK_INT(reply.status, 422);
    CHECK(test_reply_has_fault(&reply, "/extra", "not a known field"));
    CHECK(test_reply_has_fault(&reply, "/pendulum/gravity", "got null"));
    CHECK(test_reply_has_fault(&reply, "/pendulum/length/0", "got 0"));
    CHECK(test_reply_has_fault(&reply, "/pendulum/length/1", "got the text"));
    CHECK(test_reply_has_fault(&reply, "/pendulum/mass/2", "got -1"));
    CHECK(test_reply_has_fault(&reply, "/pendulum/parent/1", "got 9"));
    CHECK(test_reply_has_fault(&reply, "/pendulum/parent/2", "only one arm"));
    CHECK(test_reply_has_fault(&reply, "/pendulum/parent/3", "cannot hang from itself"));
    CHECK_INT(test_reply_faults(&reply), 8);
}

TEST(more_arms_than_the_limit_are_refused_by_its_name) {
    struct api_limits limits;
    api_limits_init(&limits);
    limits.arms = 3;
    OWN(test_reply, free) reply = test_post_as(API_OP_TREES, lists_body, NULL, &limits);
    CHECK_INT(reply.status, 422);
    CHECK(
        test_reply_has_fault(&reply, "/pendulum", "has 4 arms, more than the limit max-arms of 3"));
    test_reply_free(&reply);
    limits.arms = 4;
    reply = test_post_as(API_OP_TREES, lists_body, NULL, &limits);
    CHECK_INT(reply.status, 200);
}

/* a chain of named arms, listed from its end */
static char *long_chain(int n, const char *odd) {
    char *body = malloc((size_t)n * 80 + 100), *at = body;
    at += sprintf(at, "{\"pendulum\":{\"arms\":[");
    for (int i = n; i > 1; i--)
        at += sprintf(at, "{\"name\":\"arm %d\",\"parent\":\"%s %d\",\"length\":1,\"mass\":1},", i,
                      odd, i - 1);
    sprintf(at, "{\"name\":\"arm 1\",\"length\":1,\"mass\":1}]}}");
    return body;
}

TEST(five_thousand_named_arms_are_read) {
    char *body = long_chain(5000, "arm");
    OWN(test_reply, free) reply = test_post(API_OP_TREES, body);
    CHECK_INT(reply.status, 200);
    CHECK(test_reply_number(&reply, "/depth/0") == 5000);
    CHECK(test_reply_count(&reply, "/S") == -1); /* beyond max-matrix-arms */
    test_reply_free(&reply);
    free(body);
    body = long_chain(5000, "arn");
    reply = test_post(API_OP_TREES, body);
    CHECK_INT(reply.status, 422);
    CHECK_INT(test_reply_faults(&reply), API_PROBLEM_FAULTS);
    CHECK(test_reply_number(&reply, "/errors_omitted") == 4999 - API_PROBLEM_FAULTS);
    free(body);
}
