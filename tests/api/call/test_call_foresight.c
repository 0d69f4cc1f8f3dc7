/* A computation that cannot end within its limits is refused at its start, and one that can is
 * not. */
#include <stdio.h>
#include <string.h>

#include "api/call/call.h"
#include "tests/harness/test.h"

#define DOUBLE                                                                                     \
    "\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1]},\"initial\":{\"theta\":[2,2." \
    "5]}"

/* a clock that advances by a millisecond at each query: a piece of work takes one or two */
static double foresight_now(void *context) { return *(double *)context += 0.001; }

/* runs a request to its end with a clock; returns its status, steps and message */
static int foresight_run(enum api_op_id op, const char *body, const struct api_limits *limits,
                         long *steps, struct api_buffer *out) {
    struct api_request request = {.op = op,
                                  .content_type = "application/json",
                                  .accept = "application/json",
                                  .body = body,
                                  .body_bytes = strlen(body)};
    OWN(api_call, free) *call;
    double clock = 0;
    api_buffer_init(out, 1 << 24);
    if (!CHECK(api_call_new(&call, limits) == PEND_OK)) return 0;
    api_call_clock(call, foresight_now, &clock);
    enum api_progress progress = api_call_open(call, &request, out);
    while (progress == API_MORE) progress = api_call_run(call, out);
    int status = api_call_answer(call).status;
    *steps = api_call_steps(call);
    CHECK(api_buffer_add(out, "", 1) == PEND_OK);
    return status;
}

static const char *const foresight_how[] = {
    "\"method\":\"taylor\"",      "\"method\":\"ode23\"",
    "\"method\":\"rkf45\"",       "\"method\":\"rk8pd\"",
    "\"method\":\"msadams\"",     "\"method\":\"symplectic\",\"step\":0.01",
    "\"precision\":\"extended\"", "\"trust\":true"};
enum { HOW = sizeof foresight_how / sizeof *foresight_how };

/* how long a hopeless computation took before it was refused */
static void foresight_hopeless(enum api_op_id op, const char *rest, const char *name) {
    struct api_limits limits;
    OWN(api_buffer, clear) out;
    char body[512];
    long steps = 0;
    api_limits_init(&limits);
    limits.steps = 5000000;
    limits.compute_seconds = 3600;
    snprintf(body, sizeof body, "{" DOUBLE ",%s}", rest);
    CHECK_INT(foresight_run(op, body, &limits, &steps, &out), 422);
    CHECK_SAYING(steps <= 500000, "%s: %ld of 5000000 steps were taken", rest, steps);
    CHECK_SAYING(strstr(out.data, name) && strstr(out.data, "respond-async"), "%s: %s", rest,
                 out.data);
}

TEST(what_takes_far_too_many_steps_is_refused_as_it_begins) {
    char rest[256];
    for (int i = 0; i < HOW; i++) {
        snprintf(rest, sizeof rest, "\"times\":{\"stop\":1e9,\"count\":5},%s", foresight_how[i]);
        foresight_hopeless(API_OP_TRAJECTORIES, rest, "max-steps");
    }
    foresight_hopeless(API_OP_SECTIONS,
                       "\"duration\":1e9,\"count\":1500000,\"section\":{\"arm\":1,\"theta\":0}",
                       "max-steps");
    foresight_hopeless(API_OP_LYAPUNOV, "\"duration\":390000,\"count\":4", "max-steps");
}

TEST(what_takes_far_too_long_is_refused_as_it_begins) {
    struct api_limits limits;
    OWN(api_buffer, clear) out;
    long steps = 0;
    api_limits_init(&limits);
    limits.compute_seconds = 1;
    CHECK_INT(foresight_run(API_OP_TRAJECTORIES,
                            "{" DOUBLE ",\"times\":{\"stop\":2e6,\"count\":5}}", &limits, &steps,
                            &out),
              422);
    CHECK(strstr(out.data, "max-compute-seconds") != NULL);
    CHECK_SAYING(steps < 4000000, "%ld steps were taken", steps);
}

/* a branch with many folds, which the estimate takes for a short one */
TEST(orbits_that_take_far_too_long_are_refused_as_they_begin) {
    struct api_limits limits;
    OWN(api_buffer, clear) out;
    long steps = 0;
    api_limits_init(&limits);
    limits.compute_seconds = 1;
    CHECK_INT(foresight_run(
                  API_OP_ORBITS,
                  "{\"pendulum\":{\"length\":[1,1,1,1,1,1],\"mass\":[1,1,1,1,1,1],\"parent\":[0,"
                  "1,2,3,4,5]},\"mode\":1,\"amplitude\":2.2,\"branch\":true,\"points\":3000}",
                  &limits, &steps, &out),
              422);
    CHECK_SAYING(strstr(out.data, "would take about") != NULL, "%.200s", out.data);
}

/* by the estimate alone; the suggestions are those of the request */
TEST(what_would_take_far_longer_than_it_may_is_not_begun) {
#define STIFF(method)                                                                              \
    "{\"pendulum\":{\"length\":[1],\"mass\":[1],\"parent\":[0],\"damping\":[1e7]},"                \
    "\"initial\":{\"theta\":[1]},\"times\":{\"stop\":10,\"count\":5},\"method\":\"" method "\"}"
    static const struct {
        const char *body, *way;
    } cases[] = {
        {"{" DOUBLE ",\"times\":{\"stop\":1e7,\"count\":5}}", "shorter time or a looser tolerance"},
        {"{" DOUBLE ",\"times\":{\"stop\":1e7,\"count\":5},\"method\":\"symplectic\"}",
         "a longer step"},
        {STIFF("taylor"), "radau"},
        {STIFF("rkf45"), "radau"}};
    struct api_limits limits;
    struct api_buffer out;
    api_limits_init(&limits);
    limits.compute_seconds = 1;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        long steps = -1;
        CHECK_INT(foresight_run(API_OP_TRAJECTORIES, cases[i].body, &limits, &steps, &out), 422);
        CHECK_INT(steps, 0);
        CHECK_SAYING(strstr(out.data, "(estimated)") && strstr(out.data, "max-compute-seconds") &&
                         strstr(out.data, "respond-async") && strstr(out.data, cases[i].way),
                     "%s", out.data);
        api_buffer_clear(&out);
    }
    long steps = 0;
    CHECK_INT(foresight_run(API_OP_TRAJECTORIES, STIFF("radau"), &limits, &steps, &out), 200);
    CHECK_SAYING(steps > 0 && steps < 100, "%ld steps", steps);
    api_buffer_clear(&out);
#undef STIFF
}

TEST(what_takes_just_as_many_steps_as_it_may_is_not_refused) {
    unsigned long long random = 3;
    struct api_limits limits;
    struct api_buffer out;
    char body[1024];
    for (int i = 0; i < HOW; i++) {
        int n = 1 + test_random_int(&random, 5);
        long steps = 0;
        char *at = body + sprintf(body, "{\"pendulum\":{\"length\":[");
        for (int k = 0; k < n; k++)
            at += sprintf(at, "%s%.3g", k ? "," : "", 0.1 + 2 * test_random(&random));
        at += sprintf(at, "],\"mass\":[");
        for (int k = 0; k < n; k++)
            at += sprintf(at, "%s%.3g", k ? "," : "", 0.1 + 2 * test_random(&random));
        at += sprintf(at, "],\"parent\":[");
        for (int k = 0; k < n; k++)
            at += sprintf(at, "%s%d", k ? "," : "", k ? 1 + test_random_int(&random, k) : 0);
        at += sprintf(at, "]},\"initial\":{\"theta\":[");
        for (int k = 0; k < n; k++)
            at += sprintf(at, "%s%.3g", k ? "," : "", 6 * test_random(&random) - 3);
        sprintf(at, "]},\"times\":{\"stop\":%d,\"count\":5},%s}", i >= 6 ? 8 : 30,
                foresight_how[i]);
        api_limits_init(&limits);
        limits.compute_seconds = 3600;
        CHECK_INT(foresight_run(API_OP_TRAJECTORIES, body, &limits, &steps, &out), 200);
        api_buffer_clear(&out);
        /* a comparison with 32 digits counts its own steps */
        limits.steps = (double)steps * (i == HOW - 1 ? 10 : 1);
        int status = foresight_run(API_OP_TRAJECTORIES, body, &limits, &steps, &out);
        CHECK_SAYING(status == 200, "%d, %s: %s", status, foresight_how[i], out.data);
        api_buffer_clear(&out);
    }
}
