/* A call, a job's parts and its results while an allocation fails: each allocation in turn, for
 * every operation. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/call/call.h"
#include "api/call/part.h"
#include "tests/harness/requests.h"
#include "tests/harness/test.h"

enum { NO_FAULT = 1000000000, MOST_BYTES = 10000000 };

/* which allocation fails first, and which next: the first hundred, and then a fraction of the
 * following ones, because they repeat; with a sanitizer a fraction of these, of each request
 * others */
static long faults_first(int i, int for_good) { return 1 + (i + for_good) % TEST_STRIDE; }
static long faults_next(long count) { return count + (count < 100 ? 1 : count / 25) * TEST_STRIDE; }

static struct api_request faults_request(const struct test_request *one) {
    return (struct api_request){.op = one->op,
                                .argument = "double",
                                .content_type = "application/json",
                                .accept = one->accept,
                                .body = one->body,
                                .body_bytes = one->body ? strlen(one->body) : 0};
}

TEST(the_faults_reach_every_operation) {
    for (int op = 0; op < API_OP_COUNT; op++) {
        int there = 0;
        for (int i = 0; i < TEST_REQUESTS; i++) there |= (int)test_requests[i].op == op;
        CHECK_SAYING(there, "no request of %s", api_op_at((enum api_op_id)op)->name);
    }
}

/* --- calls --- */

/* makes a call while the count-th allocation fails; returns its status, 0 if no call could be made.
 * Only the call runs with failures: the answer is checked afterwards. */
static int faults_call(int i, long count, int for_good, struct api_buffer *out) {
    struct api_request request = faults_request(&test_requests[i]);
    struct api_limits limits;
    struct api_call *call;
    int status = 0;
    api_limits_init(&limits);
    test_alloc_fail(count, for_good);
    if (api_call_new(&call, &limits) == PEND_OK) {
        enum api_progress progress = api_call_open(call, &request, out);
        while (progress == API_MORE) progress = api_call_run(call, out);
        status = api_call_answer(call).status;
        api_call_free(&call);
    }
    test_alloc_faults_off();
    return status;
}

TEST(whichever_allocation_fails_a_call_ends_cleanly) {
    for (int i = 0; i < TEST_REQUESTS; i++)
        for (int for_good = 0; for_good < 2; for_good++) {
            struct api_buffer whole, out;
            api_buffer_init(&whole, MOST_BYTES);
            int usual = faults_call(i, NO_FAULT, 0, &whole), faults = 0;
            CHECK_SAYING(usual == 200 || (i == 2 && usual == 422), "request %d: %d %.*s", i, usual,
                         (int)whole.bytes, whole.data);
            for (long count = faults_first(i, for_good);; count = faults_next(count), faults++) {
                api_buffer_init(&out, MOST_BYTES);
                long before = test_alloc_count();
                int status = faults_call(i, count, for_good, &out),
                    reached = test_alloc_count() - before >= count;
                int same = out.bytes == whole.bytes && status == usual &&
                           !memcmp(out.data, whole.data, out.bytes);
                /* a failure is overcome, or gives a 503, or shortens the text of a refusal */
                int clean = same || status == 503 || status == 0 || (usual == 422 && status == 422);
                CHECK_SAYING(clean, "request %d, allocation %ld: %d %.*s", i, count, status,
                             (int)out.bytes, out.data);
                int whole_problem =
                    !out.bytes || (out.data[0] == '{' && out.data[out.bytes - 1] == '}');
                CHECK_SAYING(same || test_requests[i].accept || whole_problem,
                             "request %d, allocation %ld", i, count);
                api_buffer_clear(&out);
                if (!reached) break;
            }
            CHECK_SAYING(faults * TEST_STRIDE >= 3, "request %d met %d faults only", i, faults);
            api_buffer_clear(&whole);
        }
}

TEST(the_same_request_gives_the_same_bytes) {
    for (int i = 0; i < TEST_REQUESTS; i++) {
        OWN(api_buffer, clear) a, b;
        api_buffer_init(&a, MOST_BYTES);
        api_buffer_init(&b, MOST_BYTES);
        CHECK_INT(faults_call(i, NO_FAULT, 0, &a), faults_call(i, NO_FAULT, 0, &b));
        CHECK(a.bytes == b.bytes && !memcmp(a.data, b.data, a.bytes));
    }
}

/* --- jobs: the plan, two parts with what one carries over to the other, and the answer from
 * them --- */

/* What a job has stored, for parts computed one after the other. */
struct faults_job {
    struct api_buffer kept, carry, answer;
    size_t read; /* of the stored bytes */
    enum pend_status status;
    int http; /* for the plan, 0 if it is valid; then for the answer */
};

static void faults_job_init(struct faults_job *job) {
    *job = (struct faults_job){.status = PEND_OK};
    api_buffer_init(&job->kept, MOST_BYTES);
    api_buffer_init(&job->carry, MOST_BYTES);
    api_buffer_init(&job->answer, MOST_BYTES);
}

static void faults_job_clear(struct faults_job *job) {
    api_buffer_clear(&job->kept);
    api_buffer_clear(&job->carry);
    api_buffer_clear(&job->answer);
}

static enum pend_status faults_part(struct faults_job *job, const struct api_request *request,
                                    const struct api_limits *limits, long number, long parts) {
    struct pend_error error = {.text = ""};
    OWN(api_part, free) *part;
    int done = 0;
    enum pend_status status = api_part_new(&part, request, limits, number, parts, &error);
    if (status != PEND_OK) return part ? PEND_BUG : status;
    if (job->carry.bytes) status = api_part_resume(part, job->carry.data, job->carry.bytes, &error);
    job->carry.bytes = 0;
    while (status == PEND_OK && !done) status = api_part_run(part, &job->kept, &done, &error);
    if (status == PEND_OK) status = api_part_carry(part, &job->carry);
    return status;
}

static enum pend_status faults_fetch(void *context, void *data, size_t cap, size_t *bytes,
                                     struct pend_error *error) {
    struct faults_job *job = context;
    (void)error;
    *bytes = job->kept.bytes - job->read < cap ? job->kept.bytes - job->read : cap;
    if (*bytes) memcpy(data, job->kept.data + job->read, *bytes);
    job->read += *bytes;
    return PEND_OK;
}

static void faults_again(void *context) { ((struct faults_job *)context)->read = 0; }

static void faults_answer(struct faults_job *job, const struct api_request *request,
                          const struct api_limits *limits) {
    struct api_source source = {faults_fetch, faults_again, job, NULL, 0};
    OWN(api_call, free) *call;
    job->http = 503;
    if (api_call_new(&call, limits) != PEND_OK) return;
    enum api_progress progress = api_call_results(call, request, &source, &job->answer);
    while (progress == API_MORE) progress = api_call_run(call, &job->answer);
    job->http = api_call_answer(call).status;
}

static void faults_run(struct faults_job *job, int i, long count, int for_good) {
    struct api_request request = faults_request(&test_requests[i]);
    struct api_limits limits;
    struct api_plan plan;
    OWN(api_buffer, clear) body;
    api_limits_init(&limits);
    api_buffer_init(&body, MOST_BYTES);
    test_alloc_fail(count, for_good);
    job->http = api_plan_read(&plan, &request, &limits, 1e-5, &body, &job->answer);
    if (!job->http) {
        request.body = body.data;
        request.body_bytes = body.bytes;
        long parts = plan.parts < 2 ? plan.parts : 2;
        for (long part = 0; part < parts && job->status == PEND_OK; part++)
            job->status = faults_part(job, &request, &limits, part, parts);
        if (job->status == PEND_OK) faults_answer(job, &request, &limits);
    }
    test_alloc_faults_off();
}

TEST(whichever_allocation_fails_a_job_is_computed_or_fails_for_want_of_memory) {
    int jobs = 0;
    for (int i = 0; i < TEST_REQUESTS; i++) {
        if (!api_op_at(test_requests[i].op)->table) continue;
        jobs++;
        for (int for_good = 0; for_good < 2; for_good++) {
            OWN(faults_job, clear) whole;
            int over = 0;
            faults_job_init(&whole);
            faults_run(&whole, i, NO_FAULT, 0);
            CHECK_SAYING(whole.http == 200, "request %d: %d %d %.*s", i, whole.http, whole.status,
                         (int)whole.answer.bytes, whole.answer.data);
            for (long count = faults_first(i, for_good); !over; count = faults_next(count)) {
                OWN(faults_job, clear) job;
                faults_job_init(&job);
                long before = test_alloc_count();
                faults_run(&job, i, count, for_good);
                over = test_alloc_count() - before < count;
                int same = job.http == 200 && job.answer.bytes == whole.answer.bytes &&
                           !memcmp(job.answer.data, whole.answer.data, job.answer.bytes);
                CHECK_SAYING(same || job.http == 503 || job.status == PEND_NO_MEMORY,
                             "request %d, allocation %ld: %d, %d %.*s", i, count, job.http,
                             job.status, (int)job.answer.bytes, job.answer.data);
            }
        }
    }
    CHECK(jobs > 10);
}
