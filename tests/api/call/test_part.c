/* Tests of api/call/part, api/call/results and api/encode/encode_raw: an answer in parts equals the
 * direct answer. */
#include "api/call/part.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/call/call.h"
#include "api/call/digest.h"
#include "api/encode/encode_raw.h"
#include "tests/api/post.h"
#include "tests/harness/test.h"

enum { MOST_PARTS = 7 };

/* instants far apart and close together, so that parts end inside a step and between two
 * instants */
#define TRAJECTORY(how)                                                                            \
    "{\"pendulum\":{\"length\":[2,1.5,0.75],\"mass\":[1,1,1],\"parent\":[0,1,1]},\"initial\":{"    \
    "\"phi\":[0.5,1,-1]},"                                                                         \
    "\"times\":[0,0.001,0.002,0.003,0.4,0.401,0.402,1.5,1.501,2.9,2.901,2.902,3]," how "}"

/* requests for every kind of answer; each can be divided into at least `parts` parts */
static const struct {
    enum api_op_id op;
    const char *body;
    int parts, json_only;
} cases[] = {
    {API_OP_ENSEMBLES,
     "{\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1]},\"duration\":2,\"random\":{"
     "\"count\":60,\"seed\":5,\"draw\":[{\"vary\":\"theta\",\"arm\":1,\"distribution\":\"uniform\","
     "\"low\":-3,\"high\":3},{\"vary\":\"theta\",\"arm\":2,\"distribution\":\"uniform\",\"low\":-3,"
     "\"high\":3}]},\"observables\":[\"final\",\"first_flip\",\"flips\",\"energy_drift\"]}",
     7, 0},
    {API_OP_TRAJECTORIES,
     "{\"pendulum\":{\"length\":[2,1.5,0.75,1.25],\"mass\":[1,1,1,0.1],\"parent\":[0,1,2,2]},"
     "\"times\":{\"start\":0,\"stop\":2,\"step\":0.01},\"output\":[\"phi\",\"z\",\"lambda\","
     "\"energy\"]}",
     7, 0},
    {API_OP_TRAJECTORIES, TRAJECTORY("\"method\":\"ode23\",\"output\":[\"phi\",\"phidd\"]"), 7, 0},
    {API_OP_TRAJECTORIES, TRAJECTORY("\"method\":\"rkf45\""), 7, 0},
    {API_OP_TRAJECTORIES, TRAJECTORY("\"method\":\"rk8pd\",\"rtol\":1e-11"), 7, 0},
    {API_OP_TRAJECTORIES, TRAJECTORY("\"method\":\"msadams\""), 1, 0},
    {API_OP_TRAJECTORIES, TRAJECTORY("\"method\":\"symplectic\""), 7, 0},
    {API_OP_TRAJECTORIES, TRAJECTORY("\"method\":\"linear\""), 7, 0},
    {API_OP_TRAJECTORIES, TRAJECTORY("\"precision\":\"extended\",\"rtol\":1e-28"), 7, 0},
    {API_OP_TRAJECTORIES, TRAJECTORY("\"trust\":true"), 7, 0},
    {API_OP_TRAJECTORIES,
     TRAJECTORY("\"derivatives\":[{\"vary\":\"length\",\"arm\":1},{\"vary\":\"gravity\"}]"), 7, 0},
    {API_OP_FORCES,
     "{\"pendulum\":{\"length\":[2,1.5],\"mass\":[1,1],\"parent\":[0,1]},\"states\":[{\"phi\":[1,2]"
     "},{\"phi\":[0.5,0.25]}]}",
     1, 0},
    {API_OP_FORCES,
     "{\"pendulum\":{\"length\":[2,1.5],\"mass\":[1,1],\"parent\":[0,1]},\"state\":{\"phi\":[1,2]}"
     "}",
     1, 0},
    {API_OP_MODES,
     "{\"pendulum\":{\"length\":[2,1.5,1],\"mass\":[1,1,2],\"parent\":[0,1,1]},\"include\":[\"A\","
     "\"M\"],\"initial\":{\"phi\":[0,1,2]}}",
     1, 1},
    {API_OP_MODES, "{\"pendulum\":{\"length\":[2,1.5,1],\"mass\":[1,1,2],\"parent\":[0,1,1]}}", 1,
     0},
    {API_OP_MODES,
     "{\"pendulum\":{\"length\":[2,1.5,1],\"mass\":[1,1,2],\"parent\":[0,1,1]},\"about\":[\"down\","
     "\"up\",\"down\"],\"initial\":{\"phi\":[0,3,1]},\"digits\":9}",
     1, 0},
    {API_OP_LYAPUNOV,
     "{\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1]},\"duration\":5,\"samples\":"
     "150,\"count\":3}",
     1, 0},
    {API_OP_SECTIONS,
     "{\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1]},\"section\":{\"arm\":1,"
     "\"theta\":0},\"duration\":20}",
     1, 0},
    {API_OP_RESPONSE,
     "{\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1]},\"drive\":{\"pivot\":{"
     "\"x\":1}},\"omega\":{\"start\":0,\"stop\":9,\"count\":100}}",
     1, 0},
    {API_OP_ORBITS,
     "{\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1]},\"mode\":2,"
     "\"amplitude\":0.5,\"branch\":true,\"rows\":\"orbits\",\"points\":21}",
     7, 0},
    {API_OP_ORBITS,
     "{\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1]},\"mode\":2,\"amplitude\":2,"
     "\"branch\":true,\"points\":60,\"switch\":[1],\"rows\":\"bifurcations\"}",
     7, 0},
    {API_OP_ORBITS,
     "{\"pendulum\":{\"length\":[1],\"mass\":[1],\"parent\":[0],\"gravity\":1,\"damping\":[0.5],"
     "\"torque\":[{\"harmonics\":[{\"amplitude\":0.9,\"omega\":0.6666666666666666}]}]},"
     "\"settle\":50,\"branch\":{\"vary\":\"torque_amplitude\",\"arm\":1,\"to\":1.08},\"points\":30,"
     "\"switch\":[1,1],\"rows\":\"orbits\"}",
     7, 0},
    {API_OP_FITS,
     "{\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1]},\"data\":{\"t\":[0,0.1,0.2,"
     "0.3,0.4,0.5],\"series\":[{\"theta\":1,\"values\":[1,0.95,0.8,0.58,0.3,0]}]},\"unknowns\":[{"
     "\"vary\":\"length\",\"arm\":1},{\"vary\":\"theta\",\"arm\":1}]}",
     1, 1},
};
enum { CASES = sizeof cases / sizeof *cases };

/* whether a part of the case continues from the end of the previous one */
static int chained(int i) {
    return cases[i].op == API_OP_TRAJECTORIES || cases[i].op == API_OP_ORBITS;
}

static const char *const accepts[] = {"application/json",   "application/x-ndjson",
                                      "text/csv",           "application/octet-stream",
                                      "application/x-npz",  "application/vnd.apache.parquet",
                                      "application/x-hdf5", "application/x-matlab-data"};
enum { ACCEPTS = sizeof accepts / sizeof *accepts };

static struct api_request request_of(int i, const char *accept) {
    return (struct api_request){.op = cases[i].op,
                                .content_type = "application/json",
                                .accept = accept,
                                .body = cases[i].body,
                                .body_bytes = strlen(cases[i].body)};
}

/* the first parts of a case, one after the other, each from a copy of the exact bytes that the
 * previous one carried over */
static int compute_some(int i, long parts, long some, struct api_buffer *kept) {
    struct api_request request = request_of(i, NULL);
    struct api_limits limits;
    struct pend_error error;
    OWN(api_buffer, clear) carried = {0};
    OWN_MEMORY char *body = malloc(request.body_bytes + 1);
    if (!CHECK(body != NULL)) return 0;
    request.body = body;
    api_limits_init(&limits);
    api_buffer_init(&carried, 1 << 28);
    for (long p = 0; p < some; p++) {
        OWN(api_part, free) *part;
        int done = 0;
        strcpy(body, cases[i].body);
        if (!CHECK_SAYING(api_part_new(&part, &request, &limits, p, parts, &error) == PEND_OK, "%s",
                          error.text))
            break;
        /* it is read once per part: a second reading would find nothing */
        memset(body, 0, request.body_bytes);
        if (carried.bytes) {
            CHECK_SAYING(api_part_resume(part, carried.data, carried.bytes, &error) == PEND_OK,
                         "%s", error.text);
            api_buffer_clear(&carried);
        }
        size_t before = kept->bytes;
        while (!done)
            if (!CHECK_SAYING(api_part_run(part, kept, &done, &error) == PEND_OK, "%s", error.text))
                break;
        CHECK(kept->bytes > before);
        CHECK(api_part_carry(part, &carried) == PEND_OK);
        CHECK(!!carried.bytes == (chained(i) && p + 1 < parts));
    }
    return kept->bytes > 0;
}

static int compute_parts(int i, long parts, struct api_buffer *kept) {
    return compute_some(i, parts, parts, kept);
}

/* returns bytes in pieces of random length */
struct pieces {
    const char *data;
    size_t bytes, at;
    unsigned long long *random;
    int here; /* the next piece is available */
};

static enum pend_status pieces_fetch(void *context, void *data, size_t cap, size_t *bytes,
                                     struct pend_error *error) {
    struct pieces *pieces = context;
    (void)error;
    CHECK(pieces->here);
    pieces->here = 0;
    size_t piece = 1 + (size_t)test_random_int(pieces->random,
                                               test_random_int(pieces->random, 2) ? 40 : 200000);
    if (piece > pieces->bytes - pieces->at) piece = pieces->bytes - pieces->at;
    if (piece > cap) piece = cap;
    if (piece) memcpy(data, pieces->data + pieces->at, piece);
    pieces->at += piece;
    *bytes = piece;
    return PEND_OK;
}

/* a piece may be on its way at the first query, and is available at the next */
static int pieces_ready(void *context) {
    struct pieces *pieces = context;
    int here = pieces->here || test_random_int(pieces->random, 2);
    pieces->here = 1;
    return here;
}

static void pieces_again(void *context) { ((struct pieces *)context)->at = 0; }

/* the answer to a request from stored parts, or a range of it, or its state while parts are
 * missing; returns its status */
static struct api_answer fetch_range(const struct api_request *request,
                                     const struct api_limits *limits, const char *data,
                                     size_t bytes, unsigned long long *random,
                                     const struct api_range *range, int partial,
                                     struct api_buffer *out) {
    struct pieces pieces = {data, bytes, 0, random, 0};
    struct api_source source = {pieces_fetch, pieces_again, &pieces, pieces_ready, partial};
    struct api_answer answer = {.status = 503};
    OWN(api_call, free) *call;
    if (api_call_new(&call, limits) != PEND_OK) return answer;
    enum api_progress progress = api_call_results(call, request, &source, out);
    if (progress == API_MORE && range) progress = api_call_range(call, *range, out);
    while (progress == API_MORE || progress == API_WAITS) {
        progress = api_call_run(call, out);
        /* it waits only if there is no piece, and the next query finds one */
        CHECK(progress != API_WAITS || pieces.here);
    }
    answer = api_call_answer(call);
    answer.columns = answer.file_name = answer.etag = NULL;
    return answer;
}

static struct api_answer fetch(const struct api_request *request, const struct api_limits *limits,
                               const char *data, size_t bytes, unsigned long long *random,
                               struct api_buffer *out) {
    return fetch_range(request, limits, data, bytes, random, NULL, 0, out);
}

/* the answer when a case is computed directly, in each requested form; returns their number */
static int answer_at_once(int i, struct test_reply whole[ACCEPTS]) {
    int forms = cases[i].json_only ? 1 : ACCEPTS;
    for (int a = 0; a < forms; a++) {
        struct api_request request = request_of(i, accepts[a]);
        whole[a] = test_send(&request, NULL);
        CHECK_INT(whole[a].status, 200);
    }
    return forms;
}

TEST(an_answer_from_parts_is_the_answer_at_once) {
    unsigned long long random = 11;
    struct api_limits limits;
    api_limits_init(&limits);
    for (int i = 0; i < CASES; i++) {
        struct test_reply whole[ACCEPTS];
        int forms = answer_at_once(i, whole);
        for (long parts = 1; parts <= cases[i].parts; parts += parts == 3 ? 4 : 1) {
            struct api_buffer kept, out;
            api_buffer_init(&kept, 1 << 28);
            if (!compute_parts(i, parts, &kept)) return;
            for (int a = 0; a < forms; a++) {
                struct api_request request = request_of(i, accepts[a]);
                api_buffer_init(&out, 1 << 28);
                struct api_answer head =
                    fetch(&request, &limits, kept.data, kept.bytes, &random, &out);
                CHECK_SAYING(out.bytes == whole[a].out.bytes &&
                                 !memcmp(out.data, whole[a].out.data, out.bytes),
                             "case %d as %s in %ld parts: %zu bytes, at once %zu", i, accepts[a],
                             parts, out.bytes, whole[a].out.bytes);
                CHECK(head.status == 200 && (head.length < 0 || (size_t)head.length == out.bytes));
                CHECK_TEXT(head.media_type, whole[a].media_type);
                api_buffer_clear(&out);
            }
            api_buffer_clear(&kept);
        }
        for (int a = 0; a < forms; a++) test_reply_free(&whole[a]);
    }
}

/* except JSON of orbits, which contains more than rows, at its end */
TEST(an_answer_of_the_first_parts_comes_in_every_form) {
    unsigned long long random = 13;
    struct api_limits limits;
    api_limits_init(&limits);
    for (int i = 0; i < CASES; i++) {
        for (long some = 0; some < cases[i].parts && cases[i].parts > 1; some += 3) {
            struct api_buffer kept, out;
            api_buffer_init(&kept, 1 << 28);
            if (some && !compute_some(i, cases[i].parts, some, &kept)) return;
            for (int a = 0; a < ACCEPTS; a++) {
                struct api_request request = request_of(i, accepts[a]);
                api_buffer_init(&out, 1 << 28);
                struct api_answer head =
                    fetch_range(&request, &limits, kept.data, kept.bytes, &random, NULL, 1, &out);
                int apart = !a && cases[i].op == API_OP_ORBITS;
                CHECK_SAYING(head.status == (apart ? 422 : 202),
                             "case %d as %s of %ld parts: status %d", i, accepts[a], some,
                             head.status);
                CHECK(a || apart || memmem(out.data, out.bytes, "\"rows_all\":", 11));
                api_buffer_clear(&out);
            }
            api_buffer_clear(&kept);
        }
    }
}

/* a range of an answer against the same bytes of the whole */
static void check_range(int i, const char *accept, const struct api_buffer *kept,
                        const struct api_buffer *whole, struct api_range range,
                        unsigned long long *random) {
    struct api_limits limits;
    OWN(api_buffer, clear) out;
    struct api_request request = request_of(i, accept);
    long long total = (long long)whole->bytes, first = range.first, last = range.last;
    if (first < 0) first = last < total ? total - last : 0, last = total - 1;
    if (last < 0 || last >= total) last = total - 1;
    api_limits_init(&limits);
    api_buffer_init(&out, 1 << 28);
    struct api_answer head =
        fetch_range(&request, &limits, kept->data, kept->bytes, random, &range, 0, &out);
    if (first <= last) {
        CHECK_INT(head.status, 206);
        CHECK(head.first == first && head.length == last - first + 1 &&
              (long long)out.bytes == head.length);
        CHECK_SAYING((long long)out.bytes == head.length &&
                         !memcmp(out.data, whole->data + first, out.bytes),
                     "case %d as %s, bytes %lld to %lld", i, accept, first, last);
    } else {
        CHECK_INT(head.status, 416);
        CHECK(out.bytes > 20 && !memcmp(out.data, "{\"type\"", 7));
    }
    CHECK_INT(head.total, total);
}

TEST(a_range_of_an_answer_is_those_bytes_of_it) {
    unsigned long long random = 17;
    for (int i = 0; i < CASES; i++) {
        OWN(api_buffer, clear) kept;
        api_buffer_init(&kept, 1 << 28);
        if (!compute_parts(i, cases[i].parts > 1 ? 3 : 1, &kept)) return;
        for (int a = 0; a < (cases[i].json_only ? 1 : ACCEPTS); a++) {
            struct api_request request = request_of(i, accepts[a]);
            struct api_limits limits;
            OWN(api_buffer, clear) whole;
            api_limits_init(&limits);
            api_buffer_init(&whole, 1 << 28);
            CHECK_INT(fetch(&request, &limits, kept.data, kept.bytes, &random, &whole).status, 200);
            long long total = (long long)whole.bytes, some = test_random_int(&random, (int)total);
            const struct api_range ranges[] = {
                {0, 0},     {0, -1},         {total - 1, -1}, {total - 1, total + 5},
                {-1, 1},    {-1, total + 9}, {-1, 0},         {total, -1},
                {some, -1}, {some, some},    {some / 2, some}};
            for (size_t r = 0; r < sizeof ranges / sizeof *ranges; r++)
                check_range(i, accepts[a], &kept, &whole, ranges[r], &random);
        }
    }
}

TEST(a_plan_tells_parts_cost_and_digest_or_the_problem) {
    struct api_limits limits;
    struct api_plan plan, again;
    OWN(api_buffer, clear) out;
    api_limits_init(&limits);
    api_buffer_init(&out, 1 << 20);
    for (int i = 0; i < CASES; i++) {
        struct api_request request = request_of(i, "nothing/at-all");
        CHECK_INT(api_plan_read(&plan, &request, &limits, 1e-9, NULL, &out), 0);
        CHECK_SAYING(plan.parts >= cases[i].parts && plan.cost >= 0, "case %d: %ld parts", i,
                     plan.parts);
        CHECK_INT(plan.chained, chained(i) && plan.parts > 1);
        CHECK_INT(api_plan_read(&again, &request, &limits, 1e9, NULL, &out), 0);
        CHECK_INT(again.parts, 1);
        CHECK_TEXT(again.digest, plan.digest);
        CHECK(out.bytes == 0);
    }
    struct api_request bad = request_of(1, NULL);
    bad.body_bytes--;
    CHECK_INT(api_plan_read(&plan, &bad, &limits, 1, NULL, &out), 400);
    CHECK(out.bytes > 0 && !memcmp(out.data, "{\"type\"", 7));
    out.bytes = 0;
    struct api_request tree = {
        .op = API_OP_TREES, .content_type = "application/json", .body = "{}", .body_bytes = 2};
    CHECK_INT(api_plan_read(&plan, &tree, &limits, 1, NULL, &out), 422);
}

TEST(a_part_has_results_of_a_few_megabytes_however_quickly_they_are_computed) {
    static const struct {
        enum api_op_id op;
        const char *more;
        double bytes;
    } jobs[] = {{API_OP_ENSEMBLES,
                 "\"random\":{\"count\":10000,\"seed\":7,\"draw\":[{\"vary\":\"theta\",\"arm\":1,"
                 "\"distribution\":\"uniform\",\"low\":-3,\"high\":3}]},\"times\":{\"stop\":1,"
                 "\"count\":500},\"observables\":[\"trajectory\"],\"output\":[\"theta\"]",
                 10000.0 * 500 * 5 * 8},
                {API_OP_TRAJECTORIES,
                 "\"times\":{\"stop\":1,\"count\":5000000},\"output\":[\"phi\"]",
                 5000000.0 * 3 * 8}};
    for (size_t i = 0; i < sizeof jobs / sizeof *jobs; i++) {
        char body[500];
        struct api_limits limits;
        struct api_plan plan;
        OWN(api_buffer, clear) out;
        struct api_request request = {
            .op = jobs[i].op, .content_type = "application/json", .body = body};
        int bytes = snprintf(body, sizeof body,
                             "{\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1]},%s}",
                             jobs[i].more);
        request.body_bytes = (size_t)bytes;
        api_limits_init(&limits);
        api_buffer_init(&out, 1 << 20);
        CHECK_INT(api_plan_read(&plan, &request, &limits, 1e9, NULL, &out), 0);
        CHECK_SAYING(plan.kept <= 1 << 24 && plan.kept * (double)plan.parts == jobs[i].bytes,
                     "job %zu: %ld parts of %.0f bytes", i, plan.parts, plan.kept);
    }
}

TEST(a_job_is_the_same_whichever_engine_computes_it) {
    static const char body[] = "{\"pendulum\":{\"length\":[1],\"mass\":[1],\"parent\":[0]}}";
    struct api_limits limits;
    struct api_plan plan;
    OWN(api_buffer, clear) out;
    struct api_request request = {.op = API_OP_MODES,
                                  .content_type = "application/json",
                                  .body = body,
                                  .body_bytes = sizeof body - 1};
    api_limits_init(&limits);
    api_buffer_init(&out, 1 << 20);
    CHECK_INT(api_plan_read(&plan, &request, &limits, 1, NULL, &out), 0);
    /* the digest of these bytes, for any version of the sources */
    CHECK_TEXT(plan.digest, "e76ae203115218c53e13a1e22bd7b5ba6ce3116bf73dc8ae638c0dc421e32166");
}

TEST(a_part_goes_on_from_what_is_its_own_and_from_nothing_else) {
    struct api_limits limits;
    OWN(api_part, free) *part;
    OWN(api_buffer, clear) kept, carried;
    struct pend_error error;
    struct api_request request = request_of(1, NULL), other = request_of(0, NULL);
    int done = 0;
    api_limits_init(&limits);
    api_buffer_init(&kept, 1 << 20);
    api_buffer_init(&carried, 1 << 20);
    REQUIRE(api_part_new(&part, &request, &limits, 0, 3, &error) == PEND_OK);
    while (!done) REQUIRE(api_part_run(part, &kept, &done, &error) == PEND_OK);
    CHECK(api_part_carry(part, &carried) == PEND_OK && carried.bytes > 100);
    CHECK_INT(api_part_resume(part, carried.data, carried.bytes, &error), PEND_INVALID);
    api_part_free(&part);
    /* without it, with less of it, with more, with another version's */
    for (int way = 0; way < 5; way++) {
        size_t bytes = carried.bytes - (way == 1) + (way == 2) - (way == 3 ? carried.bytes / 2 : 0);
        OWN_MEMORY char *copy = calloc(1, carried.bytes + 1);
        REQUIRE(copy && api_part_new(&part, &request, &limits, 1, 3, &error) == PEND_OK);
        memcpy(copy, carried.data, carried.bytes);
        copy[0] = (char)(copy[0] + (way == 4));
        if (way) {
            CHECK_INT(api_part_resume(part, copy, bytes, &error), PEND_INVALID);
            CHECK_SAYING(strstr(error.text, "submit the job again"), "%s", error.text);
        } else {
            CHECK_INT(api_part_run(part, &kept, &done, &error), PEND_INVALID);
            CHECK_SAYING(strstr(error.text, "the checkpoint of"), "%s", error.text);
        }
        api_part_free(&part);
    }
    /* with any byte of it altered, and as another part's */
    for (size_t at = 0; at <= carried.bytes; at++) {
        REQUIRE(api_part_new(&part, &request, &limits, at == carried.bytes ? 2 : 1, 3, &error) ==
                PEND_OK);
        if (at < carried.bytes) carried.data[at] = (char)~carried.data[at];
        CHECK_INT(api_part_resume(part, carried.data, carried.bytes, &error), PEND_INVALID);
        CHECK_SAYING(strstr(error.text, "damaged"), "%s", error.text);
        if (at < carried.bytes) carried.data[at] = (char)~carried.data[at];
        api_part_free(&part);
    }
    REQUIRE(api_part_new(&part, &request, &limits, 1, 3, &error) == PEND_OK);
    CHECK_SAYING(api_part_resume(part, carried.data, carried.bytes, &error) == PEND_OK, "%s",
                 error.text);
    api_part_free(&part);
    REQUIRE(api_part_new(&part, &other, &limits, 1, 3, &error) == PEND_OK);
    CHECK_INT(api_part_resume(part, carried.data, carried.bytes, &error), PEND_INVALID);
}

TEST(parts_that_were_damaged_are_refused_not_believed) {
    unsigned long long random = 3;
    struct api_limits limits;
    struct api_buffer kept, out;
    int refused = 0;
    api_limits_init(&limits);
    api_buffer_init(&kept, 1 << 28);
    if (!compute_parts(1, 1, &kept)) return;
    for (int round = 0; round < 300; round++) {
        struct api_request request = request_of(1, accepts[round % ACCEPTS]);
        size_t bytes = kept.bytes;
        api_buffer_init(&out, 1 << 28);
        OWN_MEMORY char *copy = malloc(bytes);
        REQUIRE(copy);
        memcpy(copy, kept.data, bytes);
        /* truncated, or some bits of a head changed */
        if (round % 2)
            bytes = (size_t)test_random_int(&random, (int)bytes);
        else
            copy[test_random_int(&random, 8)] ^= (char)(1 << test_random_int(&random, 8));
        struct api_answer answer = fetch(&request, &limits, copy, bytes, &random, &out);
        refused += answer.status == 500 && out.bytes > 0;
        api_buffer_clear(&out);
    }
    CHECK_INT(refused, 300);
    api_buffer_clear(&kept);
}

TEST(results_in_a_form_that_nobody_serves_or_that_is_too_large_are_refused) {
    unsigned long long random = 3;
    struct api_limits limits;
    OWN(api_buffer, clear) out;
    api_limits_init(&limits);
    api_buffer_init(&out, 1 << 20);
    struct api_request request = request_of(1, "text/html");
    CHECK_INT(fetch(&request, &limits, NULL, 0, &random, &out).status, 406);
    CHECK(out.bytes > 0);
    limits.answer_bytes = 1000;
    request.accept = "application/json";
    CHECK_INT(fetch(&request, &limits, NULL, 0, &random, &out).status, 422);
}

TEST(allocation_faults_leave_nothing_behind_in_parts_and_results) {
    struct api_limits limits;
    int good = 0;
    api_limits_init(&limits);
    for (long count = 1; !good && count < 2000; count++) {
        struct api_request request = request_of(0, "text/csv");
        struct api_answer answer = {.status = 0};
        OWN(api_buffer, clear) kept, out;
        OWN(api_part, free) *part;
        struct pend_error error;
        unsigned long long random = 1;
        int done = 0;
        api_buffer_init(&kept, 1 << 28);
        api_buffer_init(&out, 1 << 28);
        test_alloc_fail(count, 1);
        enum pend_status status = api_part_new(&part, &request, &limits, 0, 1, &error);
        while (status == PEND_OK && !done) status = api_part_run(part, &kept, &done, &error);
        if (status == PEND_OK)
            answer = fetch(&request, &limits, kept.data, kept.bytes, &random, &out);
        test_alloc_faults_off();
        good = answer.status == 200;
        if (status != PEND_OK)
            CHECK_INT(status, PEND_NO_MEMORY);
        else
            CHECK(answer.status == 200 || answer.status == 503);
    }
    CHECK(good);
}

/* a number of orbits that no search can have found, with a valid seal: it is refused, and not
 * counted up to */
TEST(a_part_believes_no_number_of_orbits_beyond_what_was_asked_for) {
    for (int i = 0; i < CASES; i++) {
        struct api_limits limits;
        OWN(api_part, free) *part = NULL;
        OWN(api_buffer, clear) kept = {0}, carried = {0};
        struct pend_error error;
        struct api_request request = request_of(i, NULL);
        struct api_plan plan;
        int done = 0;
        if (cases[i].op != API_OP_ORBITS) continue;
        api_limits_init(&limits);
        api_buffer_init(&kept, 1 << 20);
        api_buffer_init(&carried, 1 << 20);
        CHECK_INT(api_plan_read(&plan, &request, &limits, 1, NULL, &kept), 0);
        REQUIRE(api_part_new(&part, &request, &limits, 0, 3, &error) == PEND_OK);
        while (!done) REQUIRE(api_part_run(part, &kept, &done, &error) == PEND_OK);
        REQUIRE(api_part_carry(part, &carried) == PEND_OK);
        api_part_free(&part);
        /* after the version of the checkpoint */
        long count = 1L << 52;
        size_t held = carried.bytes - API_SEAL_BYTES;
        char place[API_DIGEST_BYTES + 24];
        unsigned char seal[API_SEAL_BYTES];
        (void)snprintf(place, sizeof place, "%s/3", plan.digest);
        api_seal(seal, place, 1, carried.data, held);
        REQUIRE(!memcmp(seal, carried.data + held, sizeof seal));
        memcpy(carried.data + sizeof(int), &count, sizeof count);
        api_seal((unsigned char *)carried.data + held, place, 1, carried.data, held);
        REQUIRE(api_part_new(&part, &request, &limits, 1, 3, &error) == PEND_OK);
        CHECK_INT(api_part_resume(part, carried.data, carried.bytes, &error), PEND_INVALID);
    }
}

/* the request that a job stores: blanks and order are normalized, the meaning is the same, and it
 * is never longer */
TEST(a_request_is_kept_without_its_padding) {
    static char padded[70000];
    struct api_limits limits;
    api_limits_init(&limits);
    for (int i = 0; i < CASES; i++) {
        struct api_request request = request_of(i, NULL);
        OWN(api_buffer, clear) body, again, out;
        struct api_plan plan, same;
        size_t bytes = 0;
        /* blanks after each colon and comma outside of texts; no text of the cases has one */
        for (const char *at = cases[i].body; *at; at++) {
            padded[bytes++] = *at;
            for (int k = 0; k < 100 && strchr(":,", *at); k++) padded[bytes++] = " \n\t"[k % 3];
        }
        request.body = padded;
        request.body_bytes = bytes;
        api_buffer_init(&body, bytes);
        api_buffer_init(&again, bytes);
        api_buffer_init(&out, 1 << 20);
        CHECK_INT(api_plan_read(&plan, &request, &limits, 1, &body, &out), 0);
        CHECK_SAYING(body.bytes <= strlen(cases[i].body) + 8, "%zu bytes of %zu", body.bytes,
                     strlen(cases[i].body));
        request.body = body.data;
        request.body_bytes = body.bytes;
        CHECK_INT(api_plan_read(&same, &request, &limits, 1, &again, &out), 0);
        CHECK_TEXT(same.digest, plan.digest);
        CHECK(again.bytes == body.bytes && !memcmp(again.data, body.data, body.bytes));
    }
    /* numbers that are spelt shorter than their normal form stay as they are */
    struct api_request request = request_of(0, NULL);
    OWN(api_buffer, clear) body, out;
    struct api_plan plan;
    api_buffer_init(&body, request.body_bytes);
    api_buffer_init(&out, 1 << 20);
    CHECK_INT(api_plan_read(&plan, &request, &limits, 1, &body, &out), 0);
    CHECK(body.bytes <= request.body_bytes);
}

/* the bodies of all records of one kind, or of all others */
static void bodies_of(const struct api_buffer *raw, int rows, struct api_buffer *out) {
    enum api_raw kind;
    for (size_t at = 0, bytes; at < raw->bytes; at += API_RAW_HEAD + bytes) {
        REQUIRE(api_raw_head(raw->data + at, &kind, &bytes));
        if ((kind == API_RAW_ROWS) == rows)
            CHECK(api_buffer_add(out, raw->data + at + API_RAW_HEAD, bytes) == PEND_OK);
    }
}

/* moves the rows of a whole case into a file, and back */
static void file_and_back(int i) {
    struct api_request request = request_of(i, NULL);
    struct api_limits limits;
    struct pend_error error;
    struct api_buffer raw, file, again, before, after;
    struct api_buffer *const all[] = {&raw, &file, &again, &before, &after};
    struct api_part *part;
    struct api_raw_file said;
    int done = 0;
    for (size_t b = 0; b < sizeof all / sizeof *all; b++) api_buffer_init(all[b], 1 << 28);
    api_limits_init(&limits);
    REQUIRE(api_part_new(&part, &request, &limits, 0, 1, &error) == PEND_OK);
    while (!done) REQUIRE(api_part_run(part, &raw, &done, &error) == PEND_OK);
    bodies_of(&raw, 1, &before);
    bodies_of(&raw, 0, &before);
    enum pend_status filed = api_part_file(part, &raw, &file);
    CHECK_SAYING(filed == PEND_OK, "case %d: %s", i, pend_status_text(filed));
    api_part_free(&part);
    REQUIRE(api_raw_file_get(raw.data, raw.bytes, &said));
    CHECK(said.bytes == file.bytes && file.bytes > 8);
    CHECK(api_raw_from_parquet(file.data, &said, &again) == PEND_OK);
    bodies_of(&again, 1, &after);
    memmove(raw.data, raw.data + API_RAW_FILE_BYTES, raw.bytes -= API_RAW_FILE_BYTES);
    bodies_of(&raw, 0, &after);
    CHECK_SAYING(before.bytes == after.bytes && !memcmp(before.data, after.data, after.bytes),
                 "case %d: %zu bytes, then %zu", i, before.bytes, after.bytes);
    /* any other bytes are refused or give rows, and are read within their bounds */
    unsigned long long random = 7;
    for (int k = 0; k < 60; k++) {
        size_t bytes = (size_t)test_random_int(&random, (long)file.bytes);
        char *copy = malloc(bytes + 1);
        REQUIRE(copy != NULL);
        memcpy(copy, file.data, bytes);
        if (bytes) copy[test_random_int(&random, (long)bytes)] ^= 1;
        struct api_raw_file wrong = said;
        wrong.bytes = bytes;
        wrong.rows += k % 3 ? 0 : 1000000 * k;
        wrong.width += k % 5 ? 0 : k * 10000;
        again.bytes = 0;
        enum pend_status status = api_raw_from_parquet(copy, &wrong, &again);
        CHECK(status == PEND_OK || status == PEND_BUG || status == PEND_LIMIT);
        free(copy);
    }
    for (size_t b = 0; b < sizeof all / sizeof *all; b++) api_buffer_clear(all[b]);
}

TEST(rows_of_parts_go_through_parquet_files_unchanged) {
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) file_and_back((int)i);
}
