#include "api/read/times_json.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/api/post.h"
#include "tests/harness/test.h"

#define BODY(times)                                                                                \
    "{\"pendulum\":{\"L\":[1],\"m\":[1],\"S\":[[1]]},\"output\":[\"phi\"],\"times\":" times "}"

/* reads times; returns the number of instants, and -1 if they are refused */
static long read_times(const char *text, double t[], long cap) {
    struct api_limits limits;
    OWN(api_problem, clear) problem;
    OWN(api_json, free) *document;
    OWN(api_times, clear) times = {0};
    api_limits_init(&limits);
    api_problem_init(&problem);
    if (api_json_new(&document, text, strlen(text), 9, &problem) != PEND_OK) return -2;
    struct api_value root = api_json_root(document);
    long count = -1;
    if (api_times_read(&times, &root, &limits, &problem) == PEND_OK) {
        count = times.times.count;
        for (long i = 0; i < count && i < cap; i++) t[i] = pend_times_at(&times.times, i);
    }
    return count;
}

TEST(the_papers_grid_has_501_instants_with_both_ends) {
    double t[501];
    REQUIRE(read_times("{\"start\":0,\"stop\":5,\"step\":0.01}", t, 501) == 501);
    CHECK(t[0] == 0 && t[500] == 5);
    for (int i = 0; i <= 500; i++) {
        char decimal[60];
        snprintf(decimal, sizeof decimal, "%d.%02d", i / 100, i % 100);
        CHECK_SAYING(t[i] == strtod(decimal, NULL), "instant %d is %.17g, not %s", i, t[i],
                     decimal);
    }
}

TEST(a_grid_by_its_step_ends_at_stop_or_before) {
    static const struct {
        const char *text;
        long count;
        double first, second, last;
    } good[] = {
        {"{\"start\":0,\"stop\":0.7,\"step\":0.1}", 8, 0, 0.1, 0.7},
        {"{\"start\":0,\"stop\":0.75,\"step\":0.1}", 8, 0, 0.1, 0.7},
        {"{\"stop\":1,\"step\":0.3}", 4, 0, 0.3, 0.9},
        {"{\"start\":1,\"stop\":2,\"step\":0.25}", 5, 1, 1.25, 2},
        {"{\"start\":0.1,\"stop\":0.7,\"step\":0.1}", 7, 0.1, 0.2, 0.7},
        {"{\"start\":-0.3,\"stop\":0.3,\"step\":0.1}", 7, -0.3, -0.2, 0.3},
        {"{\"start\":0,\"stop\":1,\"step\":0.3333333333}", 4, 0, 1. / 3, 1},
        {"{\"start\":0,\"stop\":1,\"step\":0.33333}", 4, 0, 0.33333, 0.99999},
        {"{\"start\":5,\"stop\":0,\"step\":2.5}", 3, 5, 2.5, 0},
        {"{\"start\":5,\"stop\":0,\"step\":-2.5}", 3, 5, 2.5, 0},
        {"{\"start\":1,\"stop\":0,\"step\":-0.3}", 4, 1, 0.7, 0.1},
        {"{\"start\":0,\"stop\":1e-3,\"step\":1e-6}", 1001, 0, 1e-6, 1e-3},
        {"{\"start\":0,\"stop\":1e6,\"step\":1e3}", 1001, 0, 1e3, 1e6},
        {"{\"start\":2,\"stop\":2,\"step\":1}", 1, 2, 2, 2},
    };
    for (size_t i = 0; i < sizeof good / sizeof *good; i++) {
        double t[1100] = {0};
        long count = read_times(good[i].text, t, 1100);
        CHECK_SAYING(count == good[i].count, "%s has %ld instants", good[i].text, count);
        if (count < 1) continue;
        CHECK_SAYING(t[0] == good[i].first, "%s begins at %.17g", good[i].text, t[0]);
        CHECK_SAYING(count < 2 || fabs(t[1] - good[i].second) <= 1e-15 * fabs(good[i].second),
                     "%s goes on at %.17g", good[i].text, t[1]);
        CHECK_SAYING(fabs(t[count - 1] - good[i].last) <= 3e-17 + 2e-16 * fabs(good[i].last),
                     "%s ends at %.17g", good[i].text, t[count - 1]);
    }
}

TEST(a_step_that_divides_within_rounding_gives_both_ends_exactly) {
    unsigned long long seed = 7;
    for (int i = 0; i < 2000; i++) {
        char text[160];
        double t[130], start = test_random(&seed) * 20 - 10, span = test_random(&seed) * 10 + 1;
        long steps = 1 + test_random_int(&seed, 120);
        snprintf(text, sizeof text, "{\"start\":%.17g,\"stop\":%.17g,\"step\":%.17g}", start,
                 start + span, span / (double)steps * (1 + 1e-10 * (test_random(&seed) - 0.5)));
        long count = read_times(text, t, 130);
        if (!CHECK_SAYING(count == steps + 1, "%s gives %ld instants, not %ld", text, count,
                          steps + 1))
            return;
        if (!CHECK_SAYING(t[0] == start && t[steps] == start + span, "%s goes from %.17g to %.17g",
                          text, t[0], t[steps]))
            return;
    }
}

TEST(a_grid_by_its_count_has_both_ends) {
    double t[11];
    CHECK_INT(read_times("{\"start\":0,\"stop\":1,\"count\":11}", t, 11), 11);
    CHECK(t[0] == 0 && t[3] == 0.3 && t[7] == 0.7 && t[10] == 1);
    CHECK_INT(read_times("{\"start\":3,\"stop\":-3,\"count\":2}", t, 11), 2);
    CHECK(t[0] == 3 && t[1] == -3);
    CHECK_INT(read_times("{\"start\":3,\"stop\":3,\"count\":1}", t, 11), 1);
    CHECK(t[0] == 3);
}

TEST(a_list_is_taken_as_it_is) {
    double t[4];
    CHECK_INT(read_times("[0,1e-3,0.5,20]", t, 4), 4);
    CHECK(t[0] == 0 && t[1] == 1e-3 && t[2] == 0.5 && t[3] == 20);
    CHECK_INT(read_times("[3,2,-1.5]", t, 4), 3);
    CHECK(t[2] == -1.5);
    CHECK_INT(read_times("[7]", t, 4), 1);
    CHECK(t[0] == 7);
}

TEST(a_list_longer_than_the_limit_is_refused_by_its_name) {
    struct api_limits limits;
    api_limits_init(&limits);
    limits.samples = 3;
    OWN(test_reply, free) reply =
        test_post_as(API_OP_TRAJECTORIES, BODY("[0,1,2,3]"), NULL, &limits);
    CHECK(test_reply_has_fault(&reply, "/times", "more than the limit max-samples of 3"));
}
