#include "api/read/tree_json.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/api/post.h"
#include "tests/harness/test.h"

#define TREE(members) "{\"pendulum\":{" members "}}"
#define ARMS(list) TREE("\"arms\":[" list "]")

static const char arms_body[] =
    ARMS("{\"name\":\"d\",\"parent\":\"b\",\"length\":1.25,\"mass\":0.1},"
         "{\"name\":\"a\",\"length\":2,\"mass\":1},"
         "{\"name\":\"b\",\"parent\":\"a\",\"length\":1.5,\"mass\":1},"
         "{\"name\":\"c\",\"parent\":\"b\",\"length\":0.75,\"mass\":1}");
static const char lists_body[] =
    TREE("\"length\":[1.25,2,1.5,0.75],\"mass\":[0.1,1,1,1],\"parent\":[3,0,2,3]");
static const char paper_body[] = TREE("\"L\":[1.25,2,1.5,0.75],\"m\":[0.1,1,1,1],"
                                      "\"S\":[[1,1,1,0],[0,1,0,0],[0,1,1,0],[0,1,1,1]]");

/* the answer from its lists on: what does not depend on the names of the arms */
static const char *from_lists(const struct test_reply *reply) {
    return strstr(reply->out.data, "\"parent\":[");
}

TEST(three_forms_of_a_tree_give_the_same_answer) {
    struct test_reply arms = test_post(API_OP_TREES, arms_body),
                      lists = test_post(API_OP_TREES, lists_body);
    struct test_reply paper = test_post(API_OP_TREES, paper_body);
    CHECK_INT(arms.status, 200);
    if (CHECK(from_lists(&arms) && from_lists(&lists)))
        CHECK_TEXT(from_lists(&arms), from_lists(&lists));
    CHECK_TEXT(paper.out.data, lists.out.data);
    CHECK_TEXT(test_reply_text(&arms, "/arms/0/parent"), "b");
    CHECK_TEXT(test_reply_text(&lists, "/arms/0/parent"), "3");
    test_reply_free(&arms);
    test_reply_free(&lists);
    test_reply_free(&paper);
}

TEST(an_answers_arms_are_a_request) {
    struct test_reply reply = test_post(API_OP_TREES, arms_body);
    char *arms = strstr(reply.out.data, "\"arms\":["),
         *end = strstr(reply.out.data, ",\"parent\":[");
    REQUIRE(arms && end);
    char body[2000];
    snprintf(body, sizeof body, "{\"pendulum\":{%.*s}}", (int)(end - arms), arms);
    struct test_reply again = test_post(API_OP_TREES, body);
    CHECK_TEXT(again.out.data, reply.out.data);
    test_reply_free(&reply);
    test_reply_free(&again);
}

TEST(arms_without_a_name_are_called_by_their_number) {
    struct test_reply reply =
        test_post(API_OP_TREES, ARMS("{\"length\":1,\"mass\":1},"
                                     "{\"length\":1,\"mass\":2,\"parent\":\"1\"},"
                                     "{\"length\":1,\"mass\":3,\"parent\":\"2\",\"name\":\"x\"}"));
    CHECK_INT(reply.status, 200);
    CHECK_TEXT(test_reply_text(&reply, "/arms/1/name"), "2");
    CHECK_TEXT(test_reply_text(&reply, "/arms/2/name"), "x");
    CHECK(test_reply_number(&reply, "/parent/2") == 2);
    CHECK(test_reply_number(&reply, "/subtree_mass/0") == 6);
    test_reply_free(&reply);
}

TEST(gravity_is_9_81_unless_given_and_may_be_any_finite_number) {
    struct test_reply usual = test_post(API_OP_TREES, lists_body);
    struct test_reply none =
        test_post(API_OP_TREES, TREE("\"L\":[1],\"m\":[1],\"S\":[[1]],\"gravity\":0"));
    struct test_reply up =
        test_post(API_OP_TREES, TREE("\"L\":[1],\"m\":[1],\"S\":[[1]],\"gravity\":-1.62"));
    CHECK(test_reply_number(&usual, "/gravity") == 9.81);
    CHECK(test_reply_number(&none, "/gravity") == 0);
    CHECK(test_reply_number(&up, "/gravity") == -1.62);
    test_reply_free(&usual);
    test_reply_free(&none);
    test_reply_free(&up);
    CHECK_REFUSED(API_OP_TREES, TREE("\"L\":[1],\"m\":[1],\"S\":[[1]],\"gravity\":\"moon\""),
                  "/pendulum/gravity", "must be a number, got the text \"moon\"");
}

TEST(faults_of_the_arms_form_have_its_pointers) {
    static const struct {
        const char *body, *pointer, *piece;
    } bad[] = {
        {ARMS("{\"length\":1,\"mass\":-1}"), "/pendulum/arms/0/mass",
         "must be a finite number greater than 0, got -1"},
        {ARMS("{\"length\":0,\"mass\":1}"), "/pendulum/arms/0/length", "greater than 0, got 0"},
        {ARMS("{\"length\":\"2\",\"mass\":1}"), "/pendulum/arms/0/length",
         "must be a number, got the text \"2\""},
        {ARMS("{\"mass\":1}"), "/pendulum/arms/0/length", "is missing"},
        {ARMS("{\"length\":1,\"mass\":1,\"colour\":1}"), "/pendulum/arms/0/colour",
         "not a known field"},
        {ARMS("{\"length\":1,\"mass\":1,\"lenght\":1}"), "/pendulum/arms/0/lenght",
         "did you mean \"length\"?"},
        {ARMS("7"), "/pendulum/arms/0", "must be an object, got 7"},
        {ARMS("{\"length\":1,\"mass\":1,\"name\":\"\"}"), "/pendulum/arms/0/name",
         "must be a text that is not empty"},
        {ARMS("{\"length\":1,\"mass\":1,\"name\":3}"), "/pendulum/arms/0/name", "got 3"},
        {ARMS("{\"name\":\"left\",\"length\":1,\"mass\":1},{\"parent\":\"letf\",\"length\":1,"
              "\"mass\":1}"),
         "/pendulum/arms/1/parent", "got the text \"letf\"; did you mean \"left\"?"},
        {ARMS("{\"length\":1,\"mass\":1},{\"parent\":1,\"length\":1,\"mass\":1}"),
         "/pendulum/arms/1/parent", "must be the name of an arm, got 1; did you mean \"1\"?"},
        {ARMS("{\"length\":1,\"mass\":1,\"parent\":0}"), "/pendulum/arms/0/parent",
         "must be the name of an arm (left out or null at the pivot), got 0"},
        {ARMS("{\"name\":\"a\",\"length\":1,\"mass\":1},{\"name\":\"a\",\"parent\":\"a\","
              "\"length\":1,\"mass\":1}"),
         "/pendulum/arms/1/name", "arm 1 has this name already"},
        {ARMS(
             "{\"name\":\"2\",\"length\":1,\"mass\":1},{\"parent\":\"2\",\"length\":1,\"mass\":1}"),
         "/pendulum/arms/1/name",
         "arm 1 has this name already; an arm without a name has its number"},
        {ARMS("{\"length\":1,\"mass\":1},{\"length\":1,\"mass\":1}"), "/pendulum/arms/1/parent",
         "only one arm can hang at the pivot"},
        {ARMS("{\"length\":1,\"mass\":1},{\"length\":1,\"mass\":1,\"parent\":\"2\"}"),
         "/pendulum/arms/1/parent", "cannot hang on itself"},
        {ARMS(""), "/pendulum/arms", "a tree has at least one arm"},
        {TREE("\"arms\":{\"a\":1}"), "/pendulum/arms",
         "must be an array, one entry for each arm, got an object"},
        {TREE("\"arms\":7"), "/pendulum/arms", "must be an array, one entry for each arm, got 7"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        CHECK_REFUSED(API_OP_TREES, bad[i].body, bad[i].pointer, bad[i].piece);
}

TEST(faults_of_the_lists_have_their_pointers) {
    static const struct {
        const char *body, *pointer, *piece;
    } bad[] = {
        {TREE("\"length\":[1,1],\"mass\":[1,0],\"parent\":[0,1]"), "/pendulum/mass/1",
         "greater than 0, got 0"},
        {TREE("\"length\":[1,1],\"mass\":[1],\"parent\":[0,1]"), "/pendulum/mass",
         "must have 2 numbers, one for each arm, got 1"},
        {TREE("\"length\":[1,1],\"mass\":\"heavy\",\"parent\":[0,1]"), "/pendulum/mass",
         "must be an array of 2 numbers, got the text \"heavy\""},
        {TREE("\"length\":[1,null],\"mass\":[1,1],\"parent\":[0,1]"), "/pendulum/length/1",
         "must be a number, got null"},
        {TREE("\"length\":[1,1],\"mass\":[1,1]"), "/pendulum/parent", "is missing"},
        {TREE("\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,3]"), "/pendulum/parent/1",
         "must be 0 (the pivot) or the number of an arm, 1 to 2, got 3"},
        {TREE("\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,0.5]"), "/pendulum/parent/1",
         "got 0.5"},
        {TREE("\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,0]"), "/pendulum/parent/1",
         "only one arm can hang"},
        {TREE("\"length\":[1,1,1],\"mass\":[1,1,1],\"parent\":[0,3,2]"), "/pendulum/parent/1",
         "a cycle of 2 arms"},
        {TREE("\"length\":[1e308,1e308],\"mass\":[1,1],\"parent\":[0,1]"), "/pendulum/length",
         "must add up"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        CHECK_REFUSED(API_OP_TREES, bad[i].body, bad[i].pointer, bad[i].piece);
}

TEST(each_empty_list_is_a_fault_of_its_own) {
    struct test_reply reply = test_post(API_OP_TREES, TREE("\"length\":[],\"mass\":[]"));
    CHECK(test_reply_has_fault(&reply, "/pendulum/length", "at least one arm"));
    CHECK(test_reply_has_fault(&reply, "/pendulum/mass", "at least one arm"));
    CHECK(test_reply_has_fault(&reply, "/pendulum/parent", "is missing"));
    CHECK_INT(test_reply_faults(&reply), 3);
    test_reply_free(&reply);
}

TEST(faults_of_the_papers_form_have_its_pointers) {
    static const struct {
        const char *body, *pointer, *piece;
    } bad[] = {
        {TREE("\"L\":[1,1],\"m\":[1,-2],\"S\":[[1,0],[1,1]]"), "/pendulum/m/1",
         "greater than 0, got -2"},
        {TREE("\"L\":[1,1],\"m\":[1,1],\"S\":[[1,0],[1]]"), "/pendulum/S/1", "must have 2 numbers"},
        {TREE("\"L\":[1,1],\"m\":[1,1],\"S\":[[1,0]]"), "/pendulum/S",
         "must be an array of 2 rows of 2 numbers"},
        {TREE("\"L\":[1,1],\"m\":[1,1],\"S\":[1,0]"), "/pendulum/S/0",
         "must be an array of 2 numbers, got 1"},
        {TREE("\"L\":[1,1],\"m\":[1,1],\"S\":[[1,0],[2,1]]"), "/pendulum/S/1/0",
         "must be 0 or 1, got 2"},
        {TREE("\"L\":[1,1,1],\"m\":[1,1,1],\"S\":[[1,0,0],[1,1,0],[0,1,1]]"), "/pendulum/S/2/0",
         "must be 1"},
        {TREE("\"L\":[1],\"m\":[1],\"S\":[[0]]"), "/pendulum/S/0/0", "must be 1"},
        {TREE("\"L\":[1],\"m\":[1]"), "/pendulum/S", "is missing"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        struct test_reply reply = test_post(API_OP_TREES, bad[i].body);
        CHECK_INT(reply.status, 422);
        CHECK_SAYING(test_reply_has_fault(&reply, bad[i].pointer, bad[i].piece), "%s gives %s",
                     bad[i].body, reply.out.data);
        test_reply_free(&reply);
    }
}

TEST(one_form_and_nothing_else_describes_a_tree) {
    CHECK_REFUSED(API_OP_TREES, "{}", "/pendulum", "is missing");
    CHECK_REFUSED(API_OP_TREES, "{\"pendulum\":[1]}", "/pendulum",
                  "must be an object, got an array");
    CHECK_REFUSED(API_OP_TREES, "{\"pendulum\":{}}", "/pendulum", "must describe the arms");
}

TEST(fields_of_two_forms_do_not_mix) {
    CHECK_REFUSED(API_OP_TREES, TREE("\"length\":[1],\"mass\":[1],\"parent\":[0],\"S\":[[1]]"),
                  "/pendulum/S", "belongs to another form");
    CHECK_REFUSED(API_OP_TREES, TREE("\"L\":[1],\"m\":[1],\"S\":[[1]],\"Gravity\":2"),
                  "/pendulum/Gravity", "did you mean \"gravity\"?");
}

TEST(all_faults_of_a_tree_are_told_at_once) {
    struct test_reply reply =
        test_post(API_OP_TREES, "{\"extra\":1,\"pendulum\":{\"length\":[0,\"x\",1,1],\"mass\":[1,1,"
                                "-1,1],\"parent\":[0,9,0,4],"
                                "\"gravity\":null}}");
    CHECK_INT(reply.status, 422);
    CHECK(test_reply_has_fault(&reply, "/extra", "not a known field"));
    CHECK(test_reply_has_fault(&reply, "/pendulum/gravity", "got null"));
    CHECK(test_reply_has_fault(&reply, "/pendulum/length/0", "got 0"));
    CHECK(test_reply_has_fault(&reply, "/pendulum/length/1", "got the text"));
    CHECK(test_reply_has_fault(&reply, "/pendulum/mass/2", "got -1"));
    CHECK(test_reply_has_fault(&reply, "/pendulum/parent/1", "got 9"));
    CHECK(test_reply_has_fault(&reply, "/pendulum/parent/2", "only one arm"));
    CHECK(test_reply_has_fault(&reply, "/pendulum/parent/3", "cannot hang on itself"));
    CHECK_INT(test_reply_faults(&reply), 8);
    test_reply_free(&reply);
}

TEST(more_arms_than_the_limit_are_refused_by_its_name) {
    struct api_limits limits;
    api_limits_init(&limits);
    limits.arms = 3;
    struct test_reply reply = test_post_as(API_OP_TREES, lists_body, NULL, &limits);
    CHECK_INT(reply.status, 422);
    CHECK(
        test_reply_has_fault(&reply, "/pendulum", "has 4 arms, more than the limit max-arms of 3"));
    test_reply_free(&reply);
    limits.arms = 4;
    reply = test_post_as(API_OP_TREES, lists_body, NULL, &limits);
    CHECK_INT(reply.status, 200);
    test_reply_free(&reply);
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
    struct test_reply reply = test_post(API_OP_TREES, body);
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
    test_reply_free(&reply);
    free(body);
}
