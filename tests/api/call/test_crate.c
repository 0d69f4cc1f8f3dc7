/* Tests of api/call/crate, api/call/crate_read and api/call/zip: a crate reads back as what was put
 * into it, and its results are those that its request gives. */
#include "api/call/crate.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/call/call.h"
#include "api/call/crate_read.h"
#include "api/call/part.h"
#include "api/call/zip.h"
#include "api/encode/encode_raw.h"
#include "tests/api/post.h"
#include "tests/harness/requests.h"
#include "tests/harness/test.h"

enum { MOST = 1 << 26 };

/* a clock that goes on by itself, so that parts have seconds to tell */
static double ticks(void *context) { return *(double *)context += 0.0001; }

/* all parts of a request, one behind the other, as a job keeps them */
static int compute_parts(const struct api_request *request, long parts, struct api_buffer *kept) {
    struct api_limits limits;
    struct pend_error error = {.text = ""};
    struct api_buffer carried;
    double clock = 0;
    int good = 1;
    api_limits_init(&limits);
    api_buffer_init(&carried, MOST);
    for (long p = 0; p < parts && good; p++) {
        struct api_part *part;
        int done = 0;
        good = api_part_new(&part, request, &limits, p, parts, &error) == PEND_OK;
        if (!good) break;
        api_part_clock(part, ticks, &clock);
        if (carried.bytes)
            good = api_part_resume(part, carried.data, carried.bytes, &error) == PEND_OK;
        carried.bytes = 0;
        while (good && !done) good = api_part_run(part, kept, &done, &error) == PEND_OK;
        good = good && api_part_carry(part, &carried) == PEND_OK;
        api_part_free(&part);
    }
    api_buffer_clear(&carried);
    return CHECK_SAYING(good, "%s: %s", request->body, error.text);
}

/* hands out kept parts in pieces of a few bytes and of many */
struct pieces {
    const struct api_buffer *kept;
    size_t at, number;
};

static enum pend_status pieces_fetch(void *context, void *data, size_t cap, size_t *bytes,
                                     struct pend_error *error) {
    struct pieces *pieces = context;
    size_t left = pieces->kept->bytes - pieces->at, piece = pieces->number++ % 3 ? 7 : 5000;
    (void)error;
    piece = piece < left ? piece : left;
    CHECK(piece <= cap);
    if (piece) memcpy(data, pieces->kept->data + pieces->at, piece);
    pieces->at += piece;
    *bytes = piece;
    return PEND_OK;
}

static void pieces_again(void *context) { ((struct pieces *)context)->at = 0; }

static struct api_cite cite_of(const struct api_request *request) {
    struct api_cite cite = {.id = "5yzah1f1xfh7br5x7b899d1hh3",
                            .operation = api_op_at(request->op)->name,
                            .title = "a \"title\"",
                            .version = "0.1.0+0123456789abcdef",
                            .origin = "http://localhost:1",
                            .created = 1000000,
                            .started = 2000000,
                            .finished = 3000000,
                            .request = request->body,
                            .request_bytes = request->body_bytes};
    CHECK(api_cite_digest(&cite) == PEND_OK);
    return cite;
}

/* the crate of a request's kept parts; the caller takes bytes away from `out` where it streams */
static enum api_progress write_crate(const struct api_request *request, const struct api_cite *cite,
                                     const struct api_buffer *kept, struct api_buffer *out) {
    struct pieces pieces = {.kept = kept};
    struct api_source source = {.fetch = pieces_fetch, .again = pieces_again, .context = &pieces};
    struct api_limits limits;
    struct api_call *call;
    enum api_progress progress = API_BROKEN;
    api_limits_init(&limits);
    if (api_crate_new(&source.crate, cite) != PEND_OK) return progress;
    if (api_call_new(&call, &limits) == PEND_OK) {
        progress = api_call_results(call, request, &source, out);
        CHECK(progress != API_MORE ||
              !strcmp(api_call_answer(call).media_type, api_crate_media_type));
        while (progress == API_MORE) progress = api_call_run(call, out);
        if (api_call_answer(call).status != 200) progress = API_BROKEN;
        api_call_free(&call);
    }
    api_crate_free(&source.crate);
    return progress;
}

/* a crate against the answer at once, which has no clock */
static void check_crate(const struct api_request *request, const struct api_buffer *kept) {
    struct test_reply whole = test_send(request, NULL);
    struct api_buffer out;
    struct api_crate_claim claim;
    struct pend_error error = {.text = ""};
    struct api_cite cite = cite_of(request);
    api_buffer_init(&out, MOST);
    CHECK_INT(whole.status, 200);
    if (CHECK(write_crate(request, &cite, kept, &out) == API_DONE) &&
        CHECK_SAYING(api_crate_read(&claim, out.data, out.bytes, &error) == PEND_OK, "%s",
                     error.text)) {
        CHECK(claim.request.op == request->op && claim.request.body_bytes == request->body_bytes);
        CHECK(!memcmp(claim.request.body, request->body, request->body_bytes));
        CHECK_TEXT(claim.request.accept, request->accept);
        CHECK_TEXT(claim.version, "0.1.0+0123456789abcdef");
        CHECK_SAYING(claim.results_bytes == whole.out.bytes &&
                         !memcmp(claim.results, whole.out.data, whole.out.bytes),
                     "%s as %s: %zu bytes, at once %zu", request->body, request->accept,
                     claim.results_bytes, whole.out.bytes);
    }
    api_buffer_clear(&out);
    test_reply_free(&whole);
}

TEST(the_results_of_a_crate_are_the_answer_that_its_request_gives) {
    int crates = 0, timed = 0;
    for (size_t i = 0; i < sizeof test_requests / sizeof *test_requests; i++) {
        const struct test_request *asked = &test_requests[i];
        const char *accept = asked->accept ? asked->accept : "application/json";
        if (!asked->body || !api_op_at(asked->op)->table) continue;
        struct api_request request = {.op = asked->op,
                                      .content_type = "application/json",
                                      .accept = accept,
                                      .body = asked->body,
                                      .body_bytes = strlen(asked->body)};
        struct test_reply whole = test_send(&request, NULL);
        struct api_limits limits;
        struct api_plan plan;
        struct api_buffer kept, problem;
        api_limits_init(&limits);
        api_buffer_init(&kept, MOST);
        api_buffer_init(&problem, MOST);
        int good =
            whole.status == 200 && !api_plan_read(&plan, &request, &limits, 1e-9, NULL, &problem);
        if (good && compute_parts(&request, plan.parts < 3 ? plan.parts : 3, &kept)) {
            check_crate(&request, &kept);
            timed += memmem(kept.data, kept.bytes, "compute_seconds", 15) != NULL;
            crates++;
        }
        api_buffer_clear(&kept);
        api_buffer_clear(&problem);
        test_reply_free(&whole);
    }
    CHECK_SAYING(crates > 40 && timed > 20, "%d crates, %d of them with seconds", crates, timed);
}

static const char motion[] =
    "{\"pendulum\":{\"length\":[1,1],\"mass\":[1,1],\"parent\":[0,1]},\"times\":[0,0.5,1]}";

/* a crate, and the parts that it is made of */
static void make_crate(struct api_request *request, struct api_buffer *kept,
                       struct api_buffer *out) {
    *request = (struct api_request){.op = API_OP_TRAJECTORIES,
                                    .content_type = "application/json",
                                    .accept = "text/csv",
                                    .body = motion,
                                    .body_bytes = sizeof motion - 1};
    api_buffer_init(kept, MOST);
    api_buffer_init(out, MOST);
    if (!compute_parts(request, 1, kept)) return;
    struct api_cite cite = cite_of(request);
    CHECK(write_crate(request, &cite, kept, out) == API_DONE);
}

TEST(allocation_faults_leave_nothing_behind_in_crates) {
    struct api_request request;
    struct api_buffer kept, out;
    int good = 0;
    make_crate(&request, &kept, &out);
    struct api_cite cite = cite_of(&request);
    for (long count = 1; !good && count < 2000; count++) {
        struct api_crate_claim claim;
        struct pend_error error = {.text = ""};
        api_buffer_clear(&out);
        api_buffer_init(&out, MOST);
        test_alloc_fail(count, 1);
        enum api_progress progress = write_crate(&request, &cite, &kept, &out);
        enum pend_status status = PEND_OK;
        if (progress == API_DONE) status = api_crate_read(&claim, out.data, out.bytes, &error);
        test_alloc_faults_off();
        good = progress == API_DONE && status == PEND_OK;
        CHECK(good || progress != API_DONE || status == PEND_NO_MEMORY);
    }
    CHECK(good);
    api_buffer_clear(&kept);
    api_buffer_clear(&out);
}

TEST(a_crate_that_was_cut_or_changed_anywhere_is_refused_or_told) {
    struct api_request request;
    struct api_buffer kept, out;
    struct api_crate_claim claim;
    struct pend_error error = {.text = ""};
    make_crate(&request, &kept, &out);
    CHECK(api_crate_read(&claim, out.data, out.bytes, &error) == PEND_OK);
    char digest[API_DIGEST_BYTES];
    memcpy(digest, claim.digest, sizeof digest);
    for (size_t bytes = 0; bytes < out.bytes; bytes++) {
        /* a copy of just these bytes, so that a sanitizer sees who reads further */
        char *copy = malloc(bytes + !bytes);
        if (!CHECK(copy != NULL)) break;
        memcpy(copy, out.data, bytes);
        CHECK(api_crate_read(&claim, copy, bytes, &error) == PEND_INVALID && error.text[0]);
        free(copy);
    }
    for (size_t at = 0; at < out.bytes; at++) {
        char *byte = (char *)out.data + at, was = *byte;
        *byte ^= 0x20;
        /* what still reads has the same request and the same results */
        if (api_crate_read(&claim, out.data, out.bytes, &error) == PEND_OK)
            CHECK_SAYING(!strcmp(claim.digest, digest) &&
                             claim.request.body_bytes == request.body_bytes &&
                             !memcmp(claim.request.body, motion, sizeof motion - 1),
                         "byte %zu", at);
        *byte = was;
    }
    api_buffer_clear(&kept);
    api_buffer_clear(&out);
}

static uint64_t whole_at(const char *at, int bytes) {
    uint64_t x = 0;
    while (bytes-- > 0) x = x << 8 | (unsigned char)at[bytes];
    return x;
}

TEST(an_archive_of_more_than_4_gib_places_its_files_by_zip64) {
    static const uint64_t most = UINT64_C(0xffffffff), far = UINT64_C(5) << 30;
    static const char some[1 << 16];
    struct api_zip zip = {0};
    struct api_buffer out;
    api_buffer_init(&out, MOST);
    CHECK(api_zip_begin(&zip, "large", &out) == PEND_OK);
    api_zip_pass(&zip, some, sizeof some);
    /* what a program would have sent meanwhile */
    zip.written += far;
    zip.file[0].bytes += far;
    CHECK(api_zip_close(&zip, &out) == PEND_OK && api_zip_add(&zip, "b", "x", 1, &out) == PEND_OK);
    uint64_t begin = zip.written;
    size_t at = out.bytes;
    CHECK(api_zip_end(&zip, &out) == PEND_OK);
    const char *row = (const char *)out.data + at;
    CHECK(whole_at(row, 4) == 0x02014b50 && whole_at(row + 20, 4) == most &&
          whole_at(row + 24, 4) == most && whole_at(row + 42, 4) == 0);
    CHECK(whole_at(row + 46 + 5, 2) == 1 && whole_at(row + 46 + 5 + 2, 2) == 16 &&
          whole_at(row + 46 + 5 + 4, 8) == far + sizeof some);
    row += 46 + 5 + 20;
    CHECK(whole_at(row, 4) == 0x02014b50 && whole_at(row + 20, 4) == 1 &&
          whole_at(row + 42, 4) == most);
    CHECK(whole_at(row + 46 + 1 + 2, 2) == 8 && whole_at(row + 46 + 1 + 4, 8) > far);
    row += 46 + 1 + 12;
    CHECK(whole_at(row, 4) == 0x06064b50 && whole_at(row + 48, 8) == begin);
    CHECK(whole_at(row + 56, 4) == 0x07064b50 &&
          whole_at(row + 56 + 8, 8) == zip.written - 56 - 20 - 22);
    CHECK(whole_at(row + 76, 4) == 0x06054b50 && whole_at(row + 76 + 16, 4) == most);
    api_buffer_clear(&out);
}

TEST(seconds_are_left_out_of_json_wherever_its_pieces_end) {
    static const char json[] = "{\"name\":\"a,\\\"compute_seconds\\\":1\",\"stats\":{\"n\":1,,"
                               "\"compute_seconds\":1.5e-3,\"compute_second\":2}}",
                      left[] = "{\"name\":\"a,\\\"compute_seconds\\\":1\",\"stats\":{\"n\":1,,"
                               "\"compute_second\":2}}";
    struct api_request request = {.body = "{}", .body_bytes = 2, .op = API_OP_FITS};
    struct api_table table = {.count = 1, .column = {{.name = "x"}}, .rows = 1};
    struct api_cite cite = cite_of(&request);
    for (size_t cut = 1; cut < sizeof json - 1; cut++) {
        struct api_crate *crate;
        struct api_results *results = NULL;
        struct api_source source = {.partial = 0};
        struct pend_error error = {.text = ""};
        struct api_buffer out;
        char record[sizeof json + 2 * API_RAW_HEAD];
        int done = 0;
        api_buffer_init(&out, MOST);
        api_raw_head_put(record, API_RAW_JSON, cut);
        memcpy(record + API_RAW_HEAD, json, cut);
        api_raw_head_put(record + API_RAW_HEAD + cut, API_RAW_JSON, sizeof json - 1 - cut);
        memcpy(record + 2 * API_RAW_HEAD + cut, json + cut, sizeof json - 1 - cut);
        REQUIRE(api_crate_new(&crate, &cite) == PEND_OK);
        source.crate = crate;
        CHECK(api_results_new(&results, &api_format_json, &table, 1, 0, &source, &out, &error) ==
              PEND_OK);
        size_t before = out.bytes;
        CHECK(api_results_feed(results, record, sizeof json - 1 + 2 * API_RAW_HEAD, &out) ==
              PEND_OK);
        CHECK(out.bytes - before == sizeof left - 1 &&
              !memcmp(out.data + before, left, sizeof left - 1));
        CHECK(api_results_end(results, &out, &done) == PEND_OK && done);
        api_results_free(&results);
        api_crate_free(&crate);
        api_buffer_clear(&out);
    }
}
