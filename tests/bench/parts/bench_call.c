/* Whole requests without a socket: the paper's example, its parts, and the other operations.
 * Leaves to others: single numbers (bench_number), the integration alone (bench_trajectory), the
 * wire (load tests).
 * Invariant: every call is answered with 200. */
#include <math.h>
#include <string.h>

#include "api/call/call.h"
#include "api/encode/encode.h"
#include "tests/bench/parts/bench.h"

#define PAPER                                                                                      \
    "\"pendulum\":{\"L\":[2,1.5,0.75,1.25],\"m\":[1,1,1,0.1],\"S\":[[1,0,0,0],[1,1,0,0],[1,1,1,0]" \
    ",[1,1,0,1]]}"
#define TIMES "\"times\":{\"start\":0,\"stop\":5,\"step\":0.01}"

static void call(struct bench *bench, enum api_op_id op, const char *body, const char *accept,
                 int open_only) {
    struct api_limits limits;
    struct api_buffer out;
    struct api_request request = {.op = op,
                                  .content_type = "application/json",
                                  .accept = accept,
                                  .body = body,
                                  .body_bytes = strlen(body)};
    api_limits_init(&limits);
    while (bench_go(bench, 1)) {
        struct api_call *one;
        api_buffer_init(&out, (size_t)limits.answer_bytes);
        if (api_call_new(&one, &limits) != PEND_OK) bench_broken("out of memory");
        enum api_progress progress = api_call_open(one, &request, &out);
        while (!open_only && progress == API_MORE) progress = api_call_run(one, &out);
        if (progress == API_MORE ? !open_only : api_call_answer(one).status != 200)
            bench_broken("a refused request");
        api_call_free(&one);
        api_buffer_clear(&out);
    }
}

/* writes numbers like those of the example as text */
static void encode(struct bench *bench, const struct api_format *format, int digits) {
    enum { ROWS = 501, ARMS = 4 };
    static double t[ROWS], phi[ROWS * ARMS], rate[ROWS * ARMS];
    const double *const data[] = {t, phi, rate};
    struct api_table table = {.rows = ROWS, .digits = digits};
    struct api_buffer out;
    for (int i = 0; i < ROWS; i++) t[i] = i / 100.0;
    for (int i = 0; i < ROWS * ARMS; i++) phi[i] = 3 * sin(0.37 * i), rate[i] = 7 * cos(0.37 * i);
    api_table_add(&table, "t", NULL, 0);
    api_table_add(&table, "phi", NULL, ARMS);
    api_table_add(&table, "phid", NULL, ARMS);
    while (bench_go(bench, 1)) {
        struct api_writer *writer;
        api_buffer_init(&out, 1 << 20);
        if (api_writer_new(&writer, format, &table, &out) != PEND_OK ||
            api_writer_block(writer, ROWS, data, &out, NULL) != PEND_OK)
            bench_broken("a table that cannot be written");
        for (int done = 0; !done;)
            if (api_writer_finish(writer, NULL, &out, &done) != PEND_OK)
                bench_broken("a table without an end");
        api_writer_free(&writer);
        api_buffer_clear(&out);
    }
}

static const char example[] = "{" PAPER "," TIMES ",\"rtol\":1e-12,\"output\":[\"phi\",\"phid\"]}";

static const char example_6_digits[] =
    "{" PAPER "," TIMES ",\"rtol\":1e-12,\"digits\":6,\"output\":[\"phi\",\"phid\"]}";

BENCH(call_paper_json, "request") { call(bench, API_OP_TRAJECTORIES, example, NULL, 0); }
BENCH(call_paper_json_6_digits, "request") {
    call(bench, API_OP_TRAJECTORIES, example_6_digits, NULL, 0);
}
BENCH(call_paper_csv, "request") { call(bench, API_OP_TRAJECTORIES, example, "text/csv", 0); }
BENCH(call_paper_ndjson, "request") {
    call(bench, API_OP_TRAJECTORIES, example, "application/x-ndjson", 0);
}
BENCH(call_paper_octets, "request") {
    call(bench, API_OP_TRAJECTORIES, example, "application/octet-stream", 0);
}
BENCH(call_paper_npz, "request") {
    call(bench, API_OP_TRAJECTORIES, example, "application/x-npz", 0);
}
BENCH(call_paper_mat, "request") {
    call(bench, API_OP_TRAJECTORIES, example, "application/x-matlab-data", 0);
}
BENCH(call_paper_read_alone, "request") { call(bench, API_OP_TRAJECTORIES, example, NULL, 1); }
BENCH(call_paper_written_alone_json, "answer") { encode(bench, &api_format_json, 0); }
BENCH(call_paper_written_alone_json_6_digits, "answer") { encode(bench, &api_format_json, 6); }
BENCH(call_paper_written_alone_csv, "answer") { encode(bench, &api_format_csv, 0); }

BENCH(call_paper_with_forces_json, "request") {
    call(bench, API_OP_TRAJECTORIES, "{" PAPER "," TIMES ",\"rtol\":1e-12}", NULL, 0);
}

BENCH(call_trees, "request") { call(bench, API_OP_TREES, "{" PAPER "}", NULL, 0); }
BENCH(call_forces, "request") {
    call(bench, API_OP_FORCES, "{" PAPER ",\"state\":{\"phi\":[1,2,3,4]}}", NULL, 0);
}
BENCH(call_modes, "request") { call(bench, API_OP_MODES, "{" PAPER "}", NULL, 0); }
