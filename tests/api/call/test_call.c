#include "api/call/call.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/encode/encode.h"
#include "tests/api/post.h"
#include "tests/harness/test.h"

#define TREE                                                                                       \
    "\"pendulum\":{\"arms\":[{\"name\":\"a\",\"length\":1,\"mass\":1},{\"parent\":\"a\","          \
    "\"length\":1,\"mass\":2}]}"

static const char trajectory[] =
    "{" TREE ",\"initial\":{\"mode\":2,\"amplitude\":0.5},\"times\":{\"stop\":4,\"step\":"
    "0.002},\"output\":[\"phi\",\"z\",\"energy\",\"lambda\"]}";

/* a clock that the test sets, and that advances by a tick at each query */
struct clock {
    double time, tick;
};

static double clock_now(void *context) {
    struct clock *clock = context;
    return clock->time += clock->tick;
}

#define FIT(more, unknown, series)                                                                 \
    "{\"pendulum\":{\"length\":1,\"mass\":1,\"parent\":0},\"initial\":{\"theta\":0.1}" more        \
    ",\"unknowns\":[{\"vary\":\"length\",\"arm\":1" unknown                                        \
    "}],\"data\":{\"t\":[0,0.1,0.2],\"series\":[{" series ",\"values\":[-0.1,-0.09,-0.08]}]}}"

TEST(a_deprecated_name_means_what_the_new_one_means) {
    static const struct {
        enum api_op_id op;
        const char *body, *name[2]; /* @ is the field, by its name or its deprecated one */
    } row[] = {
        {API_OP_FORCES, "{" TREE ",\"@\":{\"theta\":[1,2]}}", {"initial", "state"}},
        {API_OP_SECTIONS,
         "{" TREE ",\"section\":{\"arm\":1,\"theta\":0},\"duration\":5,\"@\":3}",
         {"time", "start"}},
        {API_OP_LYAPUNOV, "{" TREE ",\"duration\":5,\"@\":3}", {"time", "start"}},
        {API_OP_ENSEMBLES, "{" TREE ",\"states\":[{}],\"duration\":1,\"@\":3}", {"time", "start"}},
        {API_OP_ORBITS,
         "{" TREE ",\"mode\":1,\"amplitude\":0.4,\"branch\":true,\"@\":4}",
         {"count", "points"}},
        {API_OP_FITS, FIT(",\"@\":-1", "", "\"of\":\"theta\",\"arm\":1"), {"time", "start"}},
        {API_OP_FITS, FIT("", ",\"@\":0.9", "\"theta\":1"), {"guess", "start"}},
        {API_OP_FITS, FIT("", "", "\"@\":1"), {"of\":\"theta\",\"arm", "theta"}}};
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        struct test_reply reply[2];
        const char *at = strchr(row[i].body, '@');
        for (int old = 0; old < 2; old++) {
            char body[600];
            snprintf(body, sizeof body, "%.*s%s%s", (int)(at - row[i].body), row[i].body,
                     row[i].name[old], at + 1);
            reply[old] = test_post(row[i].op, body);
            CHECK_SAYING(reply[old].status == 200, "%s: %.300s", body, reply[old].out.data);
            CHECK(strstr(reply[old].out.data, "\"version\":\"") != NULL);
        }
        CHECK_TEXT(reply[0].out.data, reply[1].out.data);
        for (int old = 0; old < 2; old++) test_reply_free(&reply[old]);
    }
}

/* the status and detail for the envelope of a request, with a valid body unless it has one */
static void check_envelope(struct api_request request, int status, const char *piece) {
    if (!request.body) {
        request.body = "{\"pendulum\":{\"L\":[1],\"m\":[1],\"S\":[[1]]}}";
        request.body_bytes = strlen(request.body);
    }
    OWN(test_reply, free) reply = test_send(&request, NULL);
    CHECK_INT(reply.status, status);
    CHECK_TEXT(reply.media_type, status == 200 ? "application/json" : "application/problem+json");
    CHECK_SAYING(strstr(reply.out.data, piece), "no \"%s\" in %s", piece, reply.out.data);
    if (status != 200) CHECK(test_reply_number(&reply, "/status") == status);
}

TEST(the_envelope_is_checked_before_the_body) {
    static const char json[] = "application/json";
    check_envelope((struct api_request){.content_type = json}, 200, "\"n\":1");
    check_envelope((struct api_request){.content_type = json, .accept = "application/*;q=0.1"}, 200,
                   "\"n\":1");
    check_envelope((struct api_request){.content_type = json, .query = ""}, 200, "\"n\":1");
    check_envelope((struct api_request){0}, 415, "with Content-Type: application/json");
    check_envelope((struct api_request){.content_type = "text/plain"}, 415,
                   "application/json, not text/plain");
    check_envelope((struct api_request){.content_type = json, .accept = "text/html"}, 406,
                   "none of the representations served here: application/json");
    check_envelope((struct api_request){.content_type = json, .query = "pretty=1"}, 422,
                   "takes no query, got \\\"?pretty=1\\\"");
    check_envelope((struct api_request){.content_type = json, .query = "job_x=1"}, 422,
                   "got \\\"?job_x=1\\\": put it into the body");
    check_envelope((struct api_request){.content_type = "a", .accept = "b", .query = "c"}, 415, "");
}

TEST(json_is_answered_where_the_preferred_representation_cannot_carry_the_answer) {
    static const char events[] = "{\"pendulum\":{\"L\":[1],\"m\":[1],\"S\":[[1]]},\"times\":[0,1],"
                                 "\"events\":[{\"of\":\"theta\",\"arm\":1,\"value\":0}]}";
    static const char poles[] = "{\"pendulum\":{\"L\":[1],\"m\":[1],\"S\":[[1]]},\"poles\":true,"
                                "\"omega\":[1],\"drive\":{\"pivot\":{\"x\":1}}}";
    static const struct {
        enum api_op_id op;
        const char *body, *accept, *type;
    } rows[] = {
        {API_OP_TRAJECTORIES, events, "application/x-npz, application/json;q=0.5",
         "application/json"},
        {API_OP_TRAJECTORIES, events, "text/csv, */*;q=0.1", "application/json"},
        {API_OP_TRAJECTORIES, events, "application/x-npz", "application/problem+json"},
        {API_OP_RESPONSE, poles, "application/x-npz, application/json;q=0.5", "application/json"},
        {API_OP_RESPONSE, poles, "application/x-npz, application/json;q=0",
         "application/problem+json"},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        OWN(test_reply, free) reply = test_post_as(rows[i].op, rows[i].body, rows[i].accept, NULL);
        CHECK_TEXT(reply.media_type, rows[i].type);
        CHECK_INT(reply.status, strstr(rows[i].type, "problem") ? 422 : 200);
    }
}

TEST(bytes_that_are_no_json_are_refused_with_their_place) {
    static const struct {
        const char *body, *piece;
    } bad[] = {
        {"", "JSON"},           {"{", "JSON"},
        {"nonsense", "JSON"},   {"{\"pendulum\":{}} x", "JSON"},
        {"[1e999]", "range"},   {"{\"a\":1,\"a\":2}", "twice"},
        {"[NaN]", "JSON"},      {"\xef\xbb\xbf{}", ""},
        {"{\"a\":01}", "JSON"}, {"{\"a\":\"\xff\"}", "UTF-8"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        OWN(test_reply, free) reply = test_post(API_OP_TREES, bad[i].body);
        CHECK_INT(reply.status, 400);
        CHECK_SAYING(test_reply_text(&reply, "/detail") &&
                         strstr(test_reply_text(&reply, "/detail"), bad[i].piece),
                     "%s gives %s", bad[i].body, reply.out.data);
    }
}

TEST(a_body_beyond_the_limit_is_too_large) {
    struct api_limits limits;
    api_limits_init(&limits);
    limits.body_bytes = 10;
    OWN(test_reply, free) reply = test_post_as(API_OP_TREES, "{\"pendulum\":{}}", NULL, &limits);
    CHECK_INT(reply.status, 413);
    CHECK(strstr(reply.out.data, "max-body-bytes of 10"));
}

/* runs a call to its end with a clock; returns the number of runs */
static int run_timed(struct clock *clock, struct api_buffer *out) {
    struct api_limits limits;
    struct api_call *call;
    struct api_request request = {.op = API_OP_TRAJECTORIES,
                                  .content_type = "application/json",
                                  .body = trajectory,
                                  .body_bytes = strlen(trajectory)};
    int runs = 0;
    api_limits_init(&limits);
    if (api_call_new(&call, &limits) != PEND_OK) return -1;
    if (clock) api_call_clock(call, clock_now, clock);
    enum api_progress progress = api_call_open(call, &request, out);
    CHECK_INT(progress, API_MORE);
    CHECK_INT((long long)out->bytes, 0);
    for (; progress == API_MORE; runs++) progress = api_call_run(call, out);
    CHECK_INT(api_call_answer(call).status, 200);
    CHECK(api_call_steps(call) > 0);
    CHECK_INT(api_call_run(call, out), API_DONE);
    api_call_free(&call);
    if (api_buffer_add(out, "", 1) != PEND_OK) return -1;
    return runs;
}

TEST(a_clock_cuts_the_work_but_does_not_change_the_answer) {
    OWN(api_buffer, clear) none, slow, fast;
    struct clock slow_clock = {0, 1}, fast_clock = {0, 1e-9};
    api_buffer_init(&none, 10000000);
    api_buffer_init(&slow, 10000000);
    api_buffer_init(&fast, 10000000);
    int none_runs = run_timed(NULL, &none), slow_runs = run_timed(&slow_clock, &slow);
    int fast_runs = run_timed(&fast_clock, &fast);
    CHECK(slow_runs > 2 && none_runs == slow_runs);
    CHECK_INT(fast_runs, 1 + (long long)fast.bytes / (1 << 18));
    CHECK(!strstr(none.data, "compute_seconds"));
    char *slow_seconds = strstr(slow.data, ",\"compute_seconds\":"),
         *fast_seconds = strstr(fast.data, ",\"compute_s");
    REQUIRE(slow_seconds && fast_seconds);
    CHECK(atof(slow_seconds + 19) >= slow_runs && atof(fast_seconds + 19) <= 1e-6);
    *slow_seconds = *fast_seconds = 0;
    CHECK_TEXT(slow.data, fast.data);
    CHECK(!strncmp(none.data, slow.data, strlen(slow.data)));
}

static int in_hurry(void *company) {
    ++*(int *)company;
    return 1;
}

TEST(a_hurried_call_comes_back_after_a_quarter_of_a_millisecond) {
    struct api_limits limits;
    struct api_request request = {.op = API_OP_TRAJECTORIES,
                                  .content_type = "application/json",
                                  .body = trajectory,
                                  .body_bytes = strlen(trajectory)};
    int runs[2] = {0}, asked = 0;
    api_limits_init(&limits);
    for (int hurried = 0; hurried < 2; hurried++) {
        struct clock clock = {0, 0.0003}; /* a tick after each piece */
        OWN(api_call, free) *call;
        OWN(api_buffer, clear) out;
        api_buffer_init(&out, 10000000);
        REQUIRE(api_call_new(&call, &limits) == PEND_OK);
        api_call_clock(call, clock_now, &clock);
        if (hurried) api_call_hurry(call, in_hurry, &asked);
        enum api_progress progress = api_call_open(call, &request, &out);
        for (; progress == API_MORE; runs[hurried]++) progress = api_call_run(call, &out);
        CHECK(progress == API_DONE);
    }
    CHECK_SAYING(runs[1] > runs[0] && runs[1] <= 4 * runs[0], "%d runs, %d in hurry", runs[0],
                 runs[1]);
    CHECK(asked >= runs[1] - 1 && asked <= runs[1]);
}

TEST(a_call_that_is_stopped_ends_as_a_problem_alone) {
    for (int runs = 0; runs < 3; runs++) {
        struct api_limits limits;
        OWN(api_call, free) *call;
        OWN(api_buffer, clear) out;
        struct api_request request = {.op = API_OP_TRAJECTORIES,
                                      .content_type = "application/json",
                                      .accept = "text/csv",
                                      .body = trajectory,
                                      .body_bytes = strlen(trajectory)};
        api_limits_init(&limits);
        api_buffer_init(&out, 10000000);
        CHECK(!api_buffer_text(&out, "before|"));
        REQUIRE(!api_call_new(&call, &limits));
        if (runs) CHECK_INT(api_call_open(call, &request, &out), API_MORE);
        if (runs > 1) CHECK_INT(api_call_run(call, &out), API_MORE);
        if (runs > 1) CHECK(out.bytes > 100);
        CHECK_INT(api_call_stop(call, 503, "the computation outran max-compute-seconds", &out),
                  API_DONE);
        CHECK_INT(api_call_answer(call).status, 503);
        CHECK_TEXT(api_call_answer(call).media_type, "application/problem+json");
        CHECK(!api_buffer_add(&out, "", 1));
        CHECK(!strncmp(out.data, "before|{\"type\":", 15) &&
              strstr(out.data, "outran max-compute-seconds"));
        CHECK_INT(api_call_run(call, &out), API_DONE);
    }
}

/* an opened call of the long trajectory, in a representation */
static struct api_call *open_as(const char *body, const char *accept,
                                const struct api_limits *limits, struct api_buffer *out) {
    struct api_call *call = NULL;
    struct api_request request = {.op = API_OP_TRAJECTORIES,
                                  .content_type = "application/json",
                                  .accept = accept,
                                  .body = body,
                                  .body_bytes = strlen(body)};
    if (api_call_new(&call, limits) != PEND_OK) return NULL;
    CHECK_INT(api_call_open(call, &request, out), API_MORE);
    return call;
}

TEST(an_answer_that_was_promised_comes_in_pieces_that_make_up_the_whole) {
    for (int f = 0; api_format_at(f); f++) {
        const char *accept = api_format_at(f)->media_type;
        if (api_format_at(f)->picture) continue;
        OWN(test_reply, free) whole = test_post_as(API_OP_TRAJECTORIES, trajectory, accept, NULL);
        struct api_limits limits;
        OWN(api_buffer, clear) out, sum;
        api_limits_init(&limits);
        api_buffer_init(&out, 10000000);
        api_buffer_init(&sum, 10000000);
        OWN(api_call, free) *call = open_as(trajectory, accept, &limits, &out);
        REQUIRE(call && api_call_streams(call));
        struct api_answer head = api_call_answer(call);
        CHECK_INT(head.status, 200);
        CHECK_TEXT(head.media_type, whole.media_type);
        CHECK(head.length == -1 || head.length == (long long)whole.out.bytes);
        CHECK(api_call_cost(call) > 0);
        api_call_promise(call);
        enum api_progress progress = API_MORE;
        int pieces = 0;
        while (progress == API_MORE) {
            progress = api_call_run(call, &out);
            pieces += out.bytes > 0;
            CHECK(!api_buffer_add(&sum, out.data, out.bytes));
            out.bytes = 0;
        }
        CHECK_INT(progress, API_DONE);
        CHECK(pieces > 1);
        CHECK(sum.bytes == whole.out.bytes && !memcmp(sum.data, whole.out.data, sum.bytes));
    }
}

TEST(what_fails_after_the_promise_is_broken_off) {
    for (int f = 0; api_format_at(f); f++) {
        const struct api_format *format = api_format_at(f);
        if (format->picture) continue;
        struct api_limits limits;
        OWN(api_buffer, clear) out;
        api_limits_init(&limits);
        api_buffer_init(&out, 10000000);
        OWN(api_call, free) *call = open_as(trajectory, format->media_type, &limits, &out);
        REQUIRE(call);
        api_call_promise(call);
        CHECK_INT(api_call_run(call, &out), API_MORE);
        size_t before = out.bytes;
        CHECK_INT(api_call_stop(call, 503, "no more", &out), API_BROKEN);
        CHECK_INT(api_call_answer(call).status, 200);
        CHECK(out.bytes >= before);
        CHECK_INT(out.bytes > before, format->problem_line);
        CHECK(!api_buffer_add(&out, "", 1));
        if (format->problem_line)
            CHECK(strstr(out.data + before, "{\"problem\":{\"type\":") &&
                  strstr(out.data + before, "no more"));
        CHECK_INT(api_call_run(call, &out), API_BROKEN);
        CHECK_INT(api_call_stop(call, 503, "no more", &out), API_BROKEN);
    }
}

TEST(a_computation_that_fails_after_the_promise_says_so_in_a_last_line) {
    struct api_limits limits;
    OWN(api_buffer, clear) out;
    api_limits_init(&limits);
    limits.steps = 100;
    api_buffer_init(&out, 10000000);
    OWN(api_call, free) *call = open_as("{" TREE ",\"times\":{\"stop\":90,\"step\":0.01}}",
                                        "application/x-ndjson", &limits, &out);
    REQUIRE(call);
    api_call_promise(call);
    enum api_progress progress = API_MORE;
    while (progress == API_MORE) progress = api_call_run(call, &out);
    CHECK_INT(progress, API_BROKEN);
    REQUIRE(!api_buffer_add(&out, "", 1));
    char *last = strstr(out.data, "{\"problem\":");
    REQUIRE(last && last > out.data);
    CHECK(last[-1] == '\n' && strstr(last, "max-steps") &&
          !strcmp(out.data + out.bytes - 3, "}\n"));
    int lines = 0;
    for (char *at = out.data; at < last; at = strchr(at, '\n') + 1, lines++)
        CHECK(!strncmp(at, "{\"t\":", 5));
    CHECK(lines > 10);
}

TEST(only_answers_that_are_held_have_a_size) {
    static const char body[] = "{" TREE ",\"times\":{\"stop\":9,\"count\":100000000}}";
    for (int f = 0; api_format_at(f); f++) {
        const struct api_format *format = api_format_at(f);
        if (format->picture) continue;
        struct api_limits limits;
        OWN(api_buffer, clear) out;
        OWN(api_call, free) *call;
        struct api_request request = {.op = API_OP_TRAJECTORIES,
                                      .content_type = "application/json",
                                      .accept = format->media_type,
                                      .body = body,
                                      .body_bytes = strlen(body)};
        api_limits_init(&limits);
        limits.samples = 1e9;
        if (format->most_bytes) limits.answer_bytes = 1e11;
        api_buffer_init(&out, 10000000);
        REQUIRE(!api_call_new(&call, &limits));
        CHECK_INT(api_call_open(call, &request, &out), format->block ? API_MORE : API_DONE);
        CHECK(!api_buffer_add(&out, "", 1));
        if (!format->block) {
            CHECK_INT(api_call_answer(call).status, 422);
            CHECK(strstr(out.data, format->most_bytes ? format->media_type
                                                      : "max-answer-bytes of 268435456"));
            CHECK_SAYING(strstr(out.data,
                                "application/x-ndjson, text/csv, application/octet-stream, "
                                "application/vnd.apache.parquet, application/x-hdf5\",") != NULL,
                         "%s", out.data);
        }
    }
}

/* the ETag of a trajectory's request */
static struct etag { char text[80]; } etag_of(const char *body, const char *accept) {
    struct etag etag;
    struct api_limits limits;
    OWN(api_buffer, clear) out;
    api_limits_init(&limits);
    api_buffer_init(&out, 10000000);
    OWN(api_call, free) *call = open_as(body, accept, &limits, &out);
    snprintf(etag.text, sizeof etag.text, "%s",
             call && api_call_etag(call) ? api_call_etag(call) : "none");
    CHECK_INT((long long)strlen(etag.text), 64);
    CHECK_TEXT(api_call_answer(call).etag, etag.text);
    return etag;
}

TEST(the_etag_depends_on_what_was_asked_and_not_on_how_it_was_written) {
    static const char *const same[] = {
        "{" TREE ",\"times\":[0,0.5,1],\"rtol\":1e-9}",
        "{\"rtol\":0.000000001,\"times\":[0.0,5e-1,1.00] , " TREE "}",
        "{\"rtol\":1E-9,\"t\\u0069mes\":[0.0,5e-1,1],\n\t" TREE "}",
    };
    static const char *const other[] = {
        "{" TREE ",\"times\":[0,0.5,1],\"rtol\":1.0000000000000002e-9}",
        "{" TREE ",\"times\":[0,1,0.5e1],\"rtol\":1e-9}",
        "{" TREE ",\"times\":[0,0.5,1],\"atol\":1e-9}",
        "{" TREE ",\"times\":[0,0.5,1],\"rtol\":1e-9,\"digits\":3}",
        "{" TREE ",\"times\":[0,0.5],\"rtol\":1e-9}",
        "{" TREE ",\"times\":[0,0.5,1],\"rtol\":1e-9,\"output\":[\"phi\",\"phid\"]}",
        "{" TREE ",\"times\":[0,0.5,1],\"rtol\":1e-9,\"output\":[\"phid\",\"phi\"]}",
        "{" TREE ",\"times\":[0,0.5,1],\"rtol\":1e-9,\"method\":\"rkf45\"}",
    };
    enum { SAME = sizeof same / sizeof *same, OTHER = sizeof other / sizeof *other };
    struct etag first = etag_of(same[0], NULL), seen[OTHER];
    for (int i = 1; i < SAME; i++) CHECK_TEXT(etag_of(same[i], NULL).text, first.text);
    for (int i = 0; i < OTHER; i++) {
        seen[i] = etag_of(other[i], NULL);
        CHECK_SAYING(strcmp(seen[i].text, first.text) != 0, "%s", other[i]);
        for (int j = 0; j < i; j++)
            CHECK_SAYING(strcmp(seen[i].text, seen[j].text) != 0, "%d and %d", i, j);
    }
    CHECK(strcmp(etag_of(same[0], "text/csv").text, first.text) != 0);
    CHECK_TEXT(etag_of(same[0], "*/*").text, first.text);
}

/* the digest of any request */
static struct etag digest_of(enum api_op_id op, const char *body) {
    struct etag digest = {"refused"};
    struct api_limits limits;
    OWN(api_buffer, clear) out;
    OWN(api_call, free) *call;
    struct api_request request = {
        .op = op, .content_type = "application/json", .body = body, .body_bytes = strlen(body)};
    api_limits_init(&limits);
    api_buffer_init(&out, 10000000);
    if (api_call_new(&call, &limits) != PEND_OK) return digest;
    if (CHECK_SAYING(api_call_open(call, &request, &out) == API_MORE, "%s", body))
        snprintf(digest.text, sizeof digest.text, "%s", api_call_etag(call));
    return digest;
}

#define ONE "\"pendulum\":{\"L\":[1],\"m\":[1],\"S\":[[1]]"

TEST(the_etag_is_the_same_with_defaults_written_out) {
    static const struct {
        enum api_op_id op;
        const char *plain, *usual,
            *other; /* without a field, with its default, with another value */
    } field[] = {
        {API_OP_TRAJECTORIES, "", "\"method\":\"taylor\"", "\"method\":\"rkf45\""},
        {API_OP_TRAJECTORIES, "", "\"precision\":\"double\"", "\"precision\":\"extended\""},
        {API_OP_TRAJECTORIES, "", "\"rtol\":1e-12", "\"rtol\":1e-9"},
        {API_OP_TRAJECTORIES, "", "\"atol\":0", "\"atol\":1e-11"},
        {API_OP_TRAJECTORIES, "\"method\":\"ode23\"", "\"method\":\"ode23\",\"rtol\":1e-3",
         "\"method\":\"ode23\",\"rtol\":1e-10"},
        {API_OP_TRAJECTORIES, "", "\"trust\":false", "\"trust\":true"},
        {API_OP_TRAJECTORIES, "", "\"output\":[\"phi\",\"phid\",\"lambda\"]",
         "\"output\":[\"phi\",\"phid\"]"},
        {API_OP_TRAJECTORIES, "", "\"output\":[\"phi\",\"phid\",\"lambda\"]",
         "\"output\":[\"phid\",\"phi\",\"lambda\"]"},
        {API_OP_TRAJECTORIES, "", "\"initial\":{}", "\"initial\":{\"theta\":[0]}"},
        {API_OP_TRAJECTORIES, "", "\"initial\":{\"phi\":[0],\"phid\":[0.0],\"unit\":\"rad\"}",
         "\"initial\":{\"phi\":[-0.0]}"},
        {API_OP_TRAJECTORIES, "\"initial\":{\"theta\":[0]}",
         "\"initial\":{\"theta\":[0],\"thetad\":[0]}",
         "\"initial\":{\"theta\":[0],\"thetad\":[1]}"},
        {API_OP_TRAJECTORIES, "\"initial\":{\"phi\":[1]}",
         "\"initial\":{\"phi\":[1],\"unit\":\"rad\"}",
         "\"initial\":{\"phi\":[1],\"unit\":\"deg\"}"},
        {API_OP_MODES, "", "\"select\":\"all\"", "\"select\":{\"slowest\":1}"},
        {API_OP_MODES, "", "\"vectors\":true", "\"vectors\":false"},
        {API_OP_MODES, "", "\"normalize\":\"first\"", "\"normalize\":\"mass\""},
        {API_OP_MODES, "\"vectors\":true", "\"normalize\":\"first\"", "\"initial\":{}"},
        {API_OP_FORCES, "\"state\":{\"phi\":[1]}",
         "\"state\":{\"phi\":[1],\"phid\":[0],\"unit\":\"rad\"}",
         "\"state\":{\"phi\":[1],\"phid\":[2]}"},
        {API_OP_FORCES, "\"states\":[{},{\"phi\":[1]}]", "\"states\":[{\"phi\":[0]},{\"phi\":[1]}]",
         "\"states\":[{\"phi\":[1]},{\"phi\":[1]}]"},
    };
    for (size_t i = 0; i < sizeof field / sizeof *field; i++) {
        const char *part[] = {field[i].plain, field[i].usual, field[i].other};
        const char *times =
            field[i].op == API_OP_TRAJECTORIES ? ",\"times\":{\"stop\":1,\"count\":3}" : "";
        struct etag digest[3];
        for (int k = 0; k < 3; k++) {
            char body[400];
            snprintf(body, sizeof body, "{" ONE "}%s%s%s}", times, *part[k] ? "," : "", part[k]);
            digest[k] = digest_of(field[i].op, body);
        }
        CHECK_SAYING(!strcmp(digest[0].text, digest[1].text), "%s is the default", field[i].usual);
        CHECK_SAYING(strcmp(digest[0].text, digest[2].text) != 0, "%s is none", field[i].other);
    }
    static const char start[] = "{" ONE "},\"times\":{\"start\":0,\"stop\":1,\"count\":3}}";
    static const char gravity[] = "{" ONE ",\"gravity\":9.81},\"times\":{\"stop\":1,\"count\":3}}";
    static const char moon[] = "{" ONE ",\"gravity\":1.62},\"times\":{\"stop\":1,\"count\":3}}";
    CHECK_TEXT(digest_of(API_OP_TRAJECTORIES, start).text,
               digest_of(API_OP_TRAJECTORIES, gravity).text);
    CHECK(strcmp(digest_of(API_OP_TRAJECTORIES, start).text,
                 digest_of(API_OP_TRAJECTORIES, moon).text) != 0);
}
