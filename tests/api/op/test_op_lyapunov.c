/* What is asked and answered. That the exponents are right: tests/core/ensemble/test_lyapunov.c. */
#include <math.h>
#include <string.h>

#include "tests/api/post.h"
#include "tests/harness/test.h"

#define DOUBLE                                                                                     \
    "\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1]},\"initial\":{\"theta\":[2,2." \
    "5]}"

TEST(lyapunov_answers_rows_that_end_with_the_duration) {
    struct test_reply reply = test_post(
        API_OP_LYAPUNOV, "{" DOUBLE ",\"duration\":20,\"samples\":150,\"count\":\"all\"}");
    CHECK_INT(reply.status, 200);
    CHECK_INT(test_reply_count(&reply, "/t"), 150);
    CHECK_INT(test_reply_count(&reply, "/exponents"), 150);
    CHECK_INT(test_reply_count(&reply, "/exponents/7"), 4);
    CHECK(test_reply_number(&reply, "/t/149") == 20 &&
          fabs(test_reply_number(&reply, "/t/74") - 10) < 1e-14);
    double first = test_reply_number(&reply, "/exponents/149/0"),
           last = test_reply_number(&reply, "/exponents/149/3");
    CHECK_SAYING(first > 1 && first < 4 && last < -1, "%g and %g", first, last);
    CHECK(test_reply_number(&reply, "/stats/steps") > 500 &&
          test_reply_number(&reply, "/stats/interval") > 0);
    test_reply_free(&reply);
}

TEST(lyapunov_of_few_samples_is_that_of_many_and_one_exponent_the_first_of_all) {
    struct test_reply many =
        test_post(API_OP_LYAPUNOV, "{" DOUBLE ",\"duration\":5,\"samples\":50,\"count\":4}");
    struct test_reply few = test_post(API_OP_LYAPUNOV, "{" DOUBLE ",\"duration\":5,\"samples\":1}");
    CHECK_INT(test_reply_count(&few, "/exponents/0"), 1);
    double off =
        test_reply_number(&few, "/exponents/0/0") - test_reply_number(&many, "/exponents/49/0");
    CHECK_RESIDUAL(fabs(off), 1e-7, "exponent of other intervals");
    test_reply_free(&many);
    test_reply_free(&few);
}

TEST(lyapunov_leaves_a_transient_out) {
    struct test_reply plain =
        test_post(API_OP_LYAPUNOV, "{" DOUBLE ",\"duration\":5,\"samples\":5}");
    struct test_reply late =
        test_post(API_OP_LYAPUNOV, "{" DOUBLE ",\"duration\":5,\"samples\":5,\"transient\":3}");
    CHECK(test_reply_number(&late, "/t/4") == 5);
    CHECK(fabs(test_reply_number(&late, "/exponents/0/0") -
               test_reply_number(&plain, "/exponents/0/0")) > 0.01);
    test_reply_free(&plain);
    test_reply_free(&late);
}

TEST(lyapunov_comes_in_every_representation) {
    struct test_reply reply = test_post_as(
        API_OP_LYAPUNOV, "{" DOUBLE ",\"duration\":1,\"samples\":2,\"count\":2,\"digits\":3}",
        "text/csv", NULL);
    CHECK_INT(reply.status, 200);
    CHECK(!strncmp(reply.out.data, "t,exponents_1,exponents_2,error_1,error_2\n0.5,", 46));
    test_reply_free(&reply);
}

TEST(lyapunov_requests_that_make_no_sense_are_refused) {
    CHECK_REFUSED(API_OP_LYAPUNOV, "{" DOUBLE "}", "/duration", "");
    CHECK_REFUSED(API_OP_LYAPUNOV, "{" DOUBLE ",\"duration\":-1}", "/duration", "got -1");
    CHECK_REFUSED(API_OP_LYAPUNOV, "{" DOUBLE ",\"duration\":1,\"count\":5}", "/count", "4");
    CHECK_REFUSED(API_OP_LYAPUNOV, "{" DOUBLE ",\"duration\":1,\"count\":\"some\"}", "/count",
                  "\"all\"");
    CHECK_REFUSED(API_OP_LYAPUNOV, "{" DOUBLE ",\"duration\":1,\"samples\":0}", "/samples", "0");
    CHECK_REFUSED(API_OP_LYAPUNOV, "{" DOUBLE ",\"duration\":1,\"transient\":-2}", "/transient",
                  "-2");
    CHECK_REFUSED(API_OP_LYAPUNOV, "{" DOUBLE ",\"duration\":1,\"sample\":1}", "/sample",
                  "did you mean \"samples\"");
}

TEST(lyapunov_of_too_many_steps_is_refused) {
    struct api_limits limits;
    api_limits_init(&limits);
    limits.steps = 1000;
    struct test_reply reply =
        test_post_as(API_OP_LYAPUNOV, "{" DOUBLE ",\"duration\":1000}", NULL, &limits);
    CHECK_INT(reply.status, 422);
    CHECK(strstr(reply.out.data, "max-steps") != NULL);
    test_reply_free(&reply);
    reply = test_post_as(API_OP_LYAPUNOV, "{" DOUBLE ",\"duration\":40,\"count\":\"all\"}", NULL,
                         &limits);
    CHECK_INT(reply.status, 422);
    CHECK(strstr(reply.out.data, "max-steps") != NULL);
    test_reply_free(&reply);
}
