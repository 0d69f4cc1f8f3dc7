/* Requests and answers. That the passages are correct is tested in test_section.c. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tests/api/post.h"
#include "tests/harness/requests.h"
#include "tests/harness/test.h"

#define DOUBLE                                                                                     \
    "\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1]},\"initial\":{\"theta\":[1,0." \
    "5]}"
#define NAMED                                                                                      \
    "\"pendulum\":{\"arms\":[{\"name\":\"low\",\"parent\":\"top\",\"length\":1,\"mass\":1},{"      \
    "\"name\":\"top\","                                                                            \
    "\"length\":1,"                                                                                \
    "\"mass\":1}]},\"initial\":{\"theta\":[0.5,1]}"

TEST(sections_answers_states_in_the_section_one_row_a_passage) {
    OWN(test_reply, free) reply = test_post(
        API_OP_SECTIONS,
        "{" DOUBLE ",\"duration\":20,\"section\":{\"arm\":1,\"theta\":0,\"direction\":\"both\"}}");
    CHECK_INT(reply.status, 200);
    int rows = test_reply_count(&reply, "/t");
    CHECK(rows > 10 && test_reply_count(&reply, "/phi") == rows &&
          test_reply_count(&reply, "/direction") == rows);
    CHECK(test_reply_number(&reply, "/stats/passages") == rows &&
          test_reply_number(&reply, "/stats/until") == 20);
    for (int i = 0; i < rows; i++) {
        char at[40];
        snprintf(at, sizeof at, "/phi/%d/0", i);
        CHECK(fabs(remainder(test_reply_number(&reply, at) + M_PI_2, 2 * M_PI)) < 1e-13);
        snprintf(at, sizeof at, "/phid/%d/0", i);
        double rate = test_reply_number(&reply, at);
        snprintf(at, sizeof at, "/direction/%d", i);
        CHECK(rate * test_reply_number(&reply, at) > 0);
    }
}

TEST(sections_arms_are_meant_by_name_and_angles_by_either_unit) {
    OWN(test_reply, free) number = test_post(
        API_OP_SECTIONS, "{" DOUBLE ",\"duration\":9,\"section\":{\"arm\":1,\"theta\":0.1}}");
    OWN(test_reply, free) name =
        test_post(API_OP_SECTIONS, "{" NAMED ",\"duration\":9,\"section\":{\"arm\":\"top\","
                                   "\"theta\":5.729577951308232,\"unit\":\"deg\"}}");
    CHECK_INT(name.status, 200);
    CHECK_INT(test_reply_count(&name, "/t"), test_reply_count(&number, "/t"));
    CHECK(test_reply_count(&name, "/t") > 2);
    CHECK(fabs(test_reply_number(&name, "/t/2") - test_reply_number(&number, "/t/2")) < 1e-12);
    /* the order of arms is the caller's */
    CHECK(fabs(test_reply_number(&name, "/phi/2/0") - test_reply_number(&number, "/phi/2/1")) <
          1e-11);
}

TEST(sections_end_at_their_count_and_may_be_empty) {
    struct test_reply few =
        test_post(API_OP_SECTIONS,
                  "{" DOUBLE ",\"duration\":1e6,\"count\":300,\"section\":{\"arm\":2,\"phi\":-1}}");
    CHECK_INT(test_reply_count(&few, "/t"), 300);
    CHECK(test_reply_number(&few, "/stats/until") == test_reply_number(&few, "/t/299"));
    test_reply_free(&few);
    OWN(test_reply, free) none = test_post(
        API_OP_SECTIONS,
        "{" DOUBLE ",\"duration\":5,\"section\":{\"arm\":1,\"theta\":180,\"unit\":\"deg\"}}");
    CHECK_INT(none.status, 200);
    CHECK_INT(test_reply_count(&none, "/t"), 0);
    CHECK_INT(test_reply_count(&none, "/phi"), 0);
}

TEST(sections_come_in_every_representation_however_many_rows_there_are) {
    static const char *const accept[] = {
        "text/csv",          "application/x-ndjson",      "application/octet-stream",
        "application/x-npz", "application/x-matlab-data", "application/x-hdf5"};
    static const char *const theta[] = {"0", "3"};
    for (int empty = 0; empty < 2; empty++)
        for (int i = 0; i < 6; i++) {
            char body[300];
            snprintf(body, sizeof body,
                     "{" DOUBLE ",\"duration\":5,\"section\":{\"arm\":1,\"theta\":%s}}",
                     theta[empty]);
            OWN(test_reply, free) reply = test_post_as(API_OP_SECTIONS, body, accept[i], NULL);
            CHECK_INT(reply.status, 200);
            CHECK(!strncmp(reply.media_type, accept[i], strlen(accept[i])));
            if (!i) CHECK(!strncmp(reply.out.data, "t,phi_1,phi_2,phid_1,phid_2,direction\n", 38));
            if (i == 2) CHECK(reply.out.bytes % (6 * 8) == 0 && (reply.out.bytes == 0) == empty);
        }
}

TEST(sections_of_too_many_steps_are_refused) {
    struct api_limits limits;
    api_limits_init(&limits);
    limits.steps = 100;
    OWN(test_reply, free) reply = test_post_as(
        API_OP_SECTIONS, "{" DOUBLE ",\"duration\":1e4,\"section\":{\"arm\":1,\"theta\":0}}", NULL,
        &limits);
    CHECK_INT(reply.status, 422);
    CHECK(strstr(reply.out.data, "max-steps") != NULL);
}

TEST(sections_say_how_many_of_their_passages_hold) {
    OWN(test_reply, free) reply = test_post(
        API_OP_SECTIONS, "{\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1]},"
                         "\"initial\":{\"theta\":[2,2.5]},\"duration\":100,\"section\":{\"arm\":1,"
                         "\"theta\":0}}");
    double held = test_reply_number(&reply, "/stats/horizon"),
           holding = test_reply_number(&reply, "/stats/holding");
    CHECK_SAYING(held > 7 && held < 9.7, "%g", held); // the true value is 8.8 s
    CHECK(holding >= 1 && holding < test_reply_number(&reply, "/stats/passages"));
    CHECK(strstr(reply.out.data, "\"warnings\":[\"accuracy is lost before the end: after t = ") !=
          NULL);
    for (int i = 0; i < 2; i++) {
        char at[40];
        snprintf(at, sizeof at, "/t/%d", (int)holding - 1 + i);
        CHECK((test_reply_number(&reply, at) <= held) == !i);
    }
    test_reply_free(&reply);
    reply = test_post(API_OP_SECTIONS,
                      "{" DOUBLE ",\"duration\":3,\"section\":{\"arm\":1,\"theta\":0}}");
    CHECK(test_reply_number(&reply, "/stats/horizon") == 3 && !strstr(reply.out.data, "warnings"));
    CHECK(test_reply_number(&reply, "/stats/holding") ==
          test_reply_number(&reply, "/stats/passages"));
}

/* the driven pendulum of textbooks, in its own units */
#define DRIVEN                                                                                     \
    "\"pendulum\":{\"length\":[1],\"mass\":[1],\"parent\":[0],\"gravity\":1,\"damping\":[0.5],"    \
    "\"torque\":[{\"harmonics\":[{\"amplitude\":0.9,\"omega\":-2}]}]},\"initial\":{\"theta\":[0."  \
    "2]}"

/* the rows of a section, and those of a trajectory at its instants; returns their number */
static int compared(const char *motion, const char *start, const char *section, double *gap) {
    char body[3000], at[40];
    snprintf(body, sizeof body, "{%s,\"start\":%s,\"duration\":20,\"rtol\":1e-15,\"section\":%s}",
             motion, start, section);
    OWN(test_reply, free) found = test_post(API_OP_SECTIONS, body);
    int rows = test_reply_count(&found, "/t"), arms = test_reply_count(&found, "/phi/0");
    int used =
        snprintf(body, sizeof body,
                 "{%s,\"rtol\":1e-15,\"output\":[\"phi\",\"phid\"],\"times\":[%s", motion, start);
    for (int i = 0; i < rows && i < 40; i++) {
        snprintf(at, sizeof at, "/t/%d", i);
        used += snprintf(body + used, sizeof body - (size_t)used, ",%.17g",
                         test_reply_number(&found, at));
    }
    snprintf(body + used, sizeof body - (size_t)used, "]}");
    OWN(test_reply, free) want = test_post(API_OP_TRAJECTORIES, body);
    CHECK_INT(found.status, 200);
    CHECK_INT(want.status, 200);
    *gap = 0;
    for (int i = 0; i < rows && i < 40; i++)
        for (int k = 0; k < 2 * arms; k++) {
            const char *what = k < arms ? "phi" : "phid";
            snprintf(at, sizeof at, "/%s/%d/%d", what, i, k % arms);
            double is = test_reply_number(&found, at);
            snprintf(at, sizeof at, "/%s/%d/%d", what, i + 1, k % arms);
            double off = fabs(is - test_reply_number(&want, at));
            if (!(off <= *gap)) *gap = off;
        }
    return rows;
}

TEST(sections_of_real_pendulums_have_the_states_of_trajectories_at_the_same_instants) {
    static const char *const real = TEST_REAL_TREE ",\"initial\":{\"theta\":[1,0.5]}";
    double gap;
    // the same steps, and so the same bits
    CHECK_INT(compared(DRIVEN, "1.5", "{\"period\":\"drive\",\"first\":0.25}", &gap), 6);
    CHECK(gap == 0);
    CHECK_INT(compared(real, "-3", "{\"period\":0.75}", &gap), 26);
    CHECK(gap == 0);
    int rows = compared(real, "2", "{\"arm\":2,\"theta\":0.1,\"direction\":\"both\"}", &gap);
    CHECK_SAYING(rows > 5 && rows < 60, "%d", rows);
    CHECK_RESIDUAL(gap, 1e-13, "passages of a real pendulum");
}

TEST(sections_tell_times_of_the_requests_own_and_no_direction_without_an_arm) {
    OWN(test_reply, free) reply = test_post(
        API_OP_SECTIONS,
        "{" DRIVEN ",\"start\":-7,\"duration\":9,\"section\":{\"period\":2,\"first\":-1e3}}");
    CHECK_INT(reply.status, 200);
    CHECK_INT(test_reply_count(&reply, "/t"), 5);
    for (int i = 0; i < 5; i++) {
        char at[20];
        snprintf(at, sizeof at, "/t/%d", i);
        CHECK(test_reply_number(&reply, at) == 2 * i - 6);
    }
    CHECK(test_reply_number(&reply, "/stats/until") == 2 &&
          test_reply_number(&reply, "/stats/horizon") == 2 &&
          test_reply_number(&reply, "/stats/holding") == 5);
    CHECK_INT(test_reply_count(&reply, "/direction"), -1);
    test_reply_free(&reply);
    reply =
        test_post_as(API_OP_SECTIONS,
                     "{" DRIVEN ",\"duration\":1e6,\"count\":3,\"section\":{\"period\":\"drive\"}}",
                     "text/csv", NULL);
    CHECK(!strncmp(reply.out.data, "t,phi_1,phid_1\n3.14159265358979", 31));
    int lines = 0;
    for (const char *at = reply.out.data; *at; at++) lines += *at == '\n';
    CHECK_INT(lines, 4);
}

TEST(sections_of_an_ideal_pendulum_may_be_stroboscopic_too) {
    double gap;
    CHECK_INT(compared(DOUBLE, "5", "{\"period\":0.5}", &gap), 40);
    CHECK(gap == 0);
}
